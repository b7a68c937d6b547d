//! One map lit by one wave: its mirror beam and its lobe at any `v_z`.

use super::slices::Slices;
use super::slots::Slots;
use super::{Coherent, Spectrum, Wave, WaveDensity, Window, Windows, beckmann_spizzichino};
use crate::facets::SlopeStatistics;
use crate::heightmap::{HeightMap, parameters};
use crate::scatter::cells::HalfVectorCells;
use rayon::prelude::*;

/// Groups into which the speckles are dealt for the standard error.
const REPLICATES: usize = 16;

/// Side of the patches of bins that are dealt together: neighbours within a Hann window's width share their speckle.
const PATCH: usize = 3;

/// A map, a wave, and the windows through which it is seen.
pub struct WaveField<'a> {
    map: &'a HeightMap,
    wave: Wave,
    windows: Windows,
    /// Relative wave numbers over which is averaged.
    band: Vec<f64>,
    sq: f64,
    /// Correlation length of the Gaussian surface with the same Sq and the same core of the slope distribution \[m\].
    correlation_length: f64,
    /// Area of the map \[m^2\].
    area: f64,
}

impl<'a> WaveField<'a> {
    /// Chooses the windows.
    pub fn new(map: &'a HeightMap, statistics: &SlopeStatistics, wave: Wave) -> Self {
        let sq = parameters::sq(map);
        let slope = statistics.core * (statistics.axes[0] * statistics.axes[1].max(0.02 * statistics.axes[0])).sqrt();
        let measured = (1.0 - map.missing_fraction()) * map.heights.len() as f64;
        WaveField {
            map,
            wave,
            windows: Windows::choose(map),
            band: wave.band_members(sq),
            sq,
            correlation_length: if slope > 0.0 { std::f64::consts::SQRT_2 * sq / slope } else { 0.0 },
            area: measured * map.pitch_x * map.pitch_y,
        }
    }

    /// The light.
    pub fn wave(&self) -> Wave {
        self.wave
    }

    /// The parts of the map that are averaged.
    pub fn windows(&self) -> &Windows {
        &self.windows
    }

    /// `v_z = k (cos_i + cos_o)` [1/m].
    pub fn v_z(&self, cos_i: f64, cos_o: f64) -> f64 {
        self.wave.wave_number() * (cos_i + cos_o)
    }

    /// The mirror beam at one `v_z`, zero if it does not stand out from the speckle.
    pub fn coherent(&self, v_z: f64) -> Coherent {
        let g = (v_z * self.sq).powi(2);
        let speckle = beckmann_spizzichino(g, self.correlation_length, 0.0) / self.area;
        Coherent::measure(self.map, v_z).if_significant(speckle)
    }

    /// Share of the light in the mirror beam and its relative standard error, averaged over the band.
    pub fn mirror_share(&self, v_z: f64) -> (f64, f64) {
        let n = self.band.len() as f64;
        self.band
            .iter()
            .map(|b| self.coherent(v_z * b))
            .fold((0.0, 0.0), |(share, error), c| (share + c.share() / n, error + c.relative_error / n))
    }

    /// The slices that incident angles with cosines from `lowest` to `highest` meet.
    pub fn slices(&self, [lowest, highest]: [f64; 2]) -> Slices {
        Slices::spanning(self.v_z(lowest, 0.0), self.v_z(highest, 1.0))
    }

    /// Relative wave numbers over which the band is averaged.
    pub fn band(&self) -> &[f64] {
        &self.band
    }

    /// Power through one window at one `v_z`, the mirror beam `coherent` taken out.
    pub fn spectrum(&self, window: &Window, v_z: f64, coherent: &Coherent) -> Spectrum {
        let mut spectrum = Spectrum::measure(self.map, window, v_z, coherent.mean);
        if self.windows.periodic && coherent.share() > 0.0 {
            spectrum.fill_mirror_direction();
        }
        spectrum
    }

    /// Power through every window at one `v_z`, with the incoherent share and each window's part of the whole.
    pub fn spectra(&self, v_z: f64) -> (f64, Vec<(Spectrum, f64)>) {
        let coherent = self.coherent(v_z);
        let total: f64 = self.windows.list.iter().map(|w| w.weight).sum();
        let spectra = self
            .windows
            .list
            .par_iter()
            .map(|window| (self.spectrum(window, v_z, &coherent), window.weight / total))
            .collect();
        ((1.0 - coherent.share()).max(0.0), spectra)
    }

    /// Standard deviation of the core of the lobe at `v_z`, in units of the principal slopes: the tenth of the incoherent light
    /// nearest to the centre lies within 0.459 of it if the lobe is a Gaussian. At least one bin wide.
    pub fn lobe_core(&self, v_z: f64, statistics: &SlopeStatistics, isotropic: bool) -> f64 {
        let axes = principal(statistics, isotropic);
        let (centre, (sin, cos)) =
            if isotropic { ([0.0; 2], (0.0, 1.0)) } else { (statistics.mean, statistics.axis_angle.sin_cos()) };
        let spectrum = averaged(self.spectra(v_z).1);
        let [columns, rows] = spectrum.size;
        let bin = spectrum.bin()[0].max(spectrum.bin()[1]);
        let mut nearest: Vec<(f64, f64)> = (0..rows * columns)
            .map(|k| {
                let (p, q) = spectrum.slope(k / columns, k % columns);
                let (p, q) = (p - centre[0], q - centre[1]);
                let radius = ((cos * p + sin * q) / axes[0]).hypot((cos * q - sin * p) / axes[1]);
                (radius, f64::from(spectrum.energy[k]))
            })
            .collect();
        let least = bin / axes[0];
        let total: f64 = nearest.iter().map(|b| b.1).sum();
        let tenth = if total > 0.0 { radius_holding(&mut nearest, 0.1 * total) } else { None };
        tenth.map_or(1.0, |radius| radius / 0.459).max(least)
    }

    /// `T` over the cells for every `v_z` that an incident angle with cosine from `lowest` to `highest` meets.
    ///
    /// `progress` is called with the share done.
    pub fn density(
        &self,
        cells: &HalfVectorCells,
        isotropic: bool,
        [lowest, highest]: [f64; 2],
        progress: &(dyn Fn(f64) + Sync),
    ) -> WaveDensity {
        let slots = Slots::new(cells, isotropic);
        let slices = self.slices([lowest, highest]);
        // Where the standard error is taken: specular at 60 deg, or the nearest there is.
        let middle = slices.nearest(self.v_z(0.5, 0.5));
        let mut density = WaveDensity::new(self.wave, slices);
        for slice in 0..slices.count() {
            let v_z = slices.v_z(slice);
            let mut sum = vec![0.0; cells.len()];
            let mut incoherent = 0.0;
            for (member, relative) in self.band.iter().enumerate() {
                let (share, spectra) = self.spectra(v_z * relative);
                if slice == middle && member == 0 {
                    let groups = REPLICATES.div_ceil(spectra.len());
                    for (w, (spectrum, _)) in spectra.iter().enumerate() {
                        let counted = slots.count(spectrum, groups, |r, c| deal(w, r / PATCH, c / PATCH, groups));
                        density.replicates.extend(counted.chunks(slots.len()).map(|group| slots.density(group)));
                    }
                }
                let energy = slots.count(&averaged(spectra), 1, |_, _| 0);
                sum.iter_mut().zip(slots.density(&energy)).for_each(|(t, d)| *t += share * d);
                incoherent += share;
                progress((slice as f64 + (member + 1) as f64 / self.band.len() as f64) / slices.count() as f64);
            }
            if incoherent > 0.0 {
                sum.iter_mut().for_each(|t| *t /= incoherent);
            }
            density.push(sum, incoherent / self.band.len() as f64);
        }
        density
    }
}

/// Radius of the bin with which the energy of all nearer ones exceeds `wanted`: by halving the list, never sorting it whole.
fn radius_holding(mut bins: &mut [(f64, f64)], mut wanted: f64) -> Option<f64> {
    while bins.len() > 1 {
        let middle = bins.len() / 2;
        bins.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0));
        let nearer: f64 = bins[..middle].iter().map(|b| b.1).sum();
        let (near, far) = bins.split_at_mut(middle);
        if nearer > wanted {
            bins = near;
        } else {
            wanted -= nearer;
            bins = far;
        }
    }
    bins.first().map(|b| b.0)
}

/// Mean of equally large spectra with their parts of the whole.
fn averaged(spectra: Vec<(Spectrum, f64)>) -> Spectrum {
    let mut spectra = spectra.into_iter();
    let (mut mean, part) = spectra.next().expect("`Windows::choose` leaves a window");
    mean.energy.iter_mut().for_each(|e| *e *= part as f32);
    for (spectrum, part) in spectra {
        mean.energy.iter_mut().zip(&spectrum.energy).for_each(|(m, e)| *m += part as f32 * e);
    }
    mean
}

/// Principal slopes, the second not thinner than a fiftieth of the first, nor either zero.
pub(super) fn principal(statistics: &SlopeStatistics, isotropic: bool) -> [f64; 2] {
    let [a, b] = if isotropic { [statistics.sdq / std::f64::consts::SQRT_2; 2] } else { statistics.axes };
    let a = a.max(1e-9);
    [a, b.max(0.02 * a)]
}

/// Group of a patch of bins: as good as drawn, but always the same.
fn deal(window: usize, row: usize, column: usize, groups: usize) -> usize {
    let mut x = (row as u64) << 32 | (column as u64) << 8 | window as u64;
    x = (x ^ (x >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    x = (x ^ (x >> 33)).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
    ((x ^ (x >> 33)) % groups as u64) as usize
}
