//! The lobe of a wave straight into any detectors: every bin of the power spectrum goes where its slope sends it.

use super::count::Direction;
use super::detectors::Detectors;
use super::facing::facing;
use super::kirchhoff::{Slices, Spectrum, WaveField};
use super::ratio::Ratio;
use super::tally::Tally;
use crate::facets::distribution::Hiding;
use crate::math::{Estimate, direction, half_vector, reflect};
use crate::optics::Material;
use glam::DVec3;
use rayon::prelude::*;

/// Energies held at once while windows are counted: 128 MB.
const MOST_HELD: usize = 1 << 24;

/// From so many windows on their scatter is the standard error; fewer are cut into `GROUPS` sets of bins.
const ENOUGH_WINDOWS: usize = 4;
const GROUPS: usize = 16;

/// Variance of a detector's sum against that of `GROUPS` sets to which its bins are dealt by lot. Speckle powers scatter like
/// exponentials, whose mean square is twice their variance; bins of a Hann window correlate with their neighbours, by 4/9
/// and 1/36 along each axis.
const DEALT_PERIODIC: f64 = 0.5;
const DEALT_HANN: f64 = 0.5 * (1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)) * (1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0));

/// Variance of the mean over half overlapping Hann windows against that over as many independent ones: each has four
/// neighbours whose powers correlate by 1/36 (Welch, IEEE Trans. Audio Electroacoust. 15, 70, 1967).
const OVERLAP: f64 = 1.0 + 4.0 / 36.0;

/// A bin is cut so fine that a detector is at least so many of its pieces wide, up to 4 x 4 of them; near the mirror
/// direction, where all light may lie in a few bins, 8 x 8.
const PIECES: f64 = 8.0;
const MOST_PIECES: usize = 4;
const CENTRAL: f64 = 8.0;
const CENTRAL_PIECES: usize = 8;

/// Fractional part of the golden ratio: its multiples fill the circle of azimuths.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// What the detectors of one wave calculation have in common.
pub(super) struct WaveCount<'a> {
    pub field: &'a WaveField<'a>,
    pub detectors: &'a dyn Detectors,
    pub material: Material,
    pub hiding: &'a Hiding,
    /// Average over the azimuth of the source.
    pub averaged: bool,
    /// Cosines of the smallest and the largest incident angle.
    pub range: [f64; 2],
}

/// One incident direction and the places of its source.
struct Source {
    wi: DVec3,
    points: Vec<(DVec3, f64)>,
    /// Square root of the projected solid angle per detector.
    widths: Vec<f64>,
    /// The least of them.
    narrowest: f64,
}

/// Energies of one window or group: the lobe per detector, and what escaped before the material took its part.
#[derive(Clone)]
struct Lobe {
    energy: Vec<f64>,
    escaping: f64,
}

/// One of the slices, and where it counts.
struct Slice<'a> {
    all: &'a Slices,
    number: usize,
    v_z: f64,
    support: [f64; 2],
}

/// A piece of a bin on its way.
struct Sent {
    group: u32,
    detector: u32,
    reflected: f32,
    escaping: f32,
}

impl WaveCount<'_> {
    /// `E_k = integral over the detector of G R(beta) T / (4 cos_theta_i cos^4(theta_h)) dw`, the mirror beam `G R |m|^2` in the
    /// detector of its direction; `T` of [`super::kirchhoff`], each bin of it at the `v_z` of its own exit direction.
    ///
    /// `G`, what is lost and how too much light is taken back: as [`super::kirchhoff::WaveDensity::tally`].
    pub fn run(&self, directions: &[(f64, f64)], progress: &dyn Fn(f64)) -> Vec<Direction> {
        let windows = &self.field.windows().list;
        let groups = if windows.len() < ENOUGH_WINDOWS { GROUPS } else { 1 };
        let at_once = (MOST_HELD / (groups * self.detectors.len())).max(1);
        let slices = self.field.slices(self.range);
        let chunks = directions.len().div_ceil(at_once) as f64;
        let mut found = Vec::with_capacity(directions.len());
        for (chunk, directions) in directions.chunks(at_once).enumerate() {
            let share = |done: f64| progress((chunk as f64 + done) / chunks);
            found.extend(self.run_some(directions, &slices, groups, &share));
        }
        found
    }

    fn run_some(
        &self,
        directions: &[(f64, f64)],
        slices: &Slices,
        groups: usize,
        progress: &dyn Fn(f64),
    ) -> Vec<Direction> {
        let windows = &self.field.windows().list;
        let sources: Vec<Source> = directions.iter().map(|&(theta_i, phi_i)| self.source(theta_i, phi_i)).collect();
        let coherent: Vec<_> = (0..slices.count())
            .map(|s| self.field.band().iter().map(|b| self.field.coherent(slices.v_z(s) * b)).collect::<Vec<_>>())
            .collect();
        let n = self.detectors.len();
        let none = Lobe { energy: vec![0.0; n], escaping: 0.0 };
        let mut sums = vec![none.clone(); sources.len()];
        // Per slice, what the windows hold of the incoherent light.
        let mut held = vec![0.0; slices.count()];
        let mut scatter: Vec<Ratio> = sources.iter().map(|_| Ratio::new(n)).collect();
        let total: f64 = windows.iter().map(|w| w.weight).sum();
        for (w, window) in windows.iter().enumerate() {
            let mut parts = vec![vec![none.clone(); groups]; sources.len()];
            for (s, members) in coherent.iter().enumerate() {
                let slice = Slice { all: slices, number: s, v_z: slices.v_z(s), support: slices.support(s) };
                for (relative, coherent) in self.field.band().iter().zip(members) {
                    let spectrum = self.field.spectrum(window, slice.v_z * relative, coherent);
                    held[s] += window.weight / total * spectrum.energy.iter().map(|&e| f64::from(e)).sum::<f64>();
                    for (source, parts) in sources.iter().zip(&mut parts) {
                        self.deal(&spectrum, source, &slice, parts);
                    }
                }
                let done = w as f64 + (s + 1) as f64 / coherent.len() as f64;
                progress(done / windows.len() as f64);
            }
            let weight = window.weight / (total * self.field.band().len() as f64);
            for ((parts, sum), scatter) in parts.iter().zip(&mut sums).zip(&mut scatter) {
                for part in parts {
                    let energy: Vec<f64> = part.energy.iter().map(|e| e * weight).collect();
                    sum.energy.iter_mut().zip(&energy).for_each(|(sum, e)| *sum += e);
                    sum.escaping += part.escaping * weight;
                    scatter.add(&energy, energy.iter().sum(), window.weight / (total * groups as f64));
                }
            }
        }
        let whole = directions.iter().zip(sources).zip(sums).zip(scatter);
        whole
            .map(|(((&at, source), mut sum), scatter)| {
                // A taper weighs some places more than others, and a weak mirror beam stands out from the speckle at some slices
                // only; the light is all that the beam does not have.
                let v_z = self.field.v_z(source.wi.z, source.wi.z);
                let joined = |(s, held): (usize, &f64)| slices.weight(s, v_z) * (v_z / slices.v_z(s)).powi(2) * held;
                let held: f64 = held.iter().enumerate().map(joined).sum();
                let wanted = (1.0 - self.field.mirror_share(v_z).0) * self.field.band().len() as f64;
                let level = if held > 0.0 { wanted / held } else { 1.0 };
                sum.energy.iter_mut().for_each(|e| *e *= level);
                sum.escaping *= level;
                self.finish(at, &source, sum, &scatter, groups)
            })
            .collect()
    }

    fn source(&self, theta_i: f64, phi_i: f64) -> Source {
        let wi = direction(theta_i, phi_i);
        let width = |k: usize| self.detectors.projected_solid_angle(k, wi).sqrt();
        let widths: Vec<f64> = (0..self.detectors.len()).map(width).collect();
        let narrowest = widths.iter().copied().filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
        Source { wi, points: self.field.wave().source_points(wi), widths, narrowest }
    }

    /// Sends the bins of one slice to the detectors, each weighed by the slice's part in the value at its exit direction.
    fn deal(&self, spectrum: &Spectrum, source: &Source, slice: &Slice, parts: &mut [Lobe]) {
        let [columns, rows] = spectrum.size;
        let dealt: Vec<Vec<Sent>> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let mut found = Vec::new();
                for column in 0..columns {
                    if spectrum.energy[row * columns + column] > 0.0 {
                        self.deal_bin(spectrum, [row, column], source, slice, parts.len(), &mut found);
                    }
                }
                found
            })
            .collect();
        for sent in dealt.into_iter().flatten() {
            let part = &mut parts[sent.group as usize];
            part.energy[sent.detector as usize] += f64::from(sent.reflected);
            part.escaping += f64::from(sent.escaping);
        }
    }

    fn deal_bin(
        &self,
        spectrum: &Spectrum,
        [row, column]: [usize; 2],
        source: &Source,
        slice: &Slice,
        groups: usize,
        found: &mut Vec<Sent>,
    ) {
        let (p0, q0) = spectrum.slope(row, column);
        let [wide, high] = spectrum.bin();
        let bin = row * spectrum.size[0] + column;
        // Speckles stay where they are in slope, whatever the slice.
        let stretch = self.field.v_z(source.wi.z, source.wi.z) / spectrum.v_z;
        let group = group([p0 / wide, q0 / high].map(|x| (x * stretch).round() as i64), groups);
        let central = (p0 / wide).abs().max((q0 / high).abs()) <= CENTRAL;
        let side = if central { CENTRAL_PIECES } else { self.pieces(source, p0, q0, wide.max(high)) };
        let offset = |k: usize| (k as f64 + 0.5) / side as f64 - 0.5;
        let energy = f64::from(spectrum.energy[bin]) / (side * side) as f64;
        for piece in 0..side * side {
            let (mut p, mut q) = (p0 + wide * offset(piece % side), q0 + high * offset(piece / side));
            if self.averaged {
                let turn = ((bin * CENTRAL_PIECES * CENTRAL_PIECES + piece) as f64 * GOLDEN).fract();
                let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
                (p, q) = (cos * p - sin * q, sin * p + cos * q);
            }
            for &(wi, part) in &source.points {
                self.send(energy * part, [p, q], wi, source, slice, group, found);
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn send(
        &self,
        energy: f64,
        [p, q]: [f64; 2],
        wi: DVec3,
        source: &Source,
        slice: &Slice,
        group: usize,
        found: &mut Vec<Sent>,
    ) {
        // v_z = k (cos_i + cos_o) = 2 k cos(beta) cos(theta_h).
        let v_z = 2.0 * self.field.wave().wave_number() * (wi.z - p * wi.x - q * wi.y) / (1.0 + p * p + q * q);
        if !(v_z > slice.support[0] && v_z < slice.support[1]) {
            return;
        }
        let Some(f) = facing(p, q, wi).filter(|f| f.wo.z > 0.0) else { return };
        // The incoherent share over v_z^2 is what is joined: level for smooth surfaces, a power for rough ones.
        let joined = slice.all.weight(slice.number, v_z) * (v_z / slice.v_z).powi(2);
        let escaping = energy * joined * f.weight * self.hiding.visible(wi.z, f.wo.z);
        found.push(Sent {
            group: group as u32,
            detector: self.detectors.index(source.wi, f.wo) as u32,
            reflected: (escaping * self.material.reflectance(f.cos_beta)) as f32,
            escaping: escaping as f32,
        });
    }

    /// Pieces along each side of a bin at a slope.
    fn pieces(&self, source: &Source, p: f64, q: f64, bin: f64) -> usize {
        // dOmega_p = 4 cos(beta) cos(theta_r) cos^3(theta_h) dp dq.
        if 2.0 * PIECES * bin <= source.narrowest {
            return 1;
        }
        let Some(f) = facing(p, q, source.wi).filter(|f| f.wo.z > 0.0) else { return 1 };
        let jacobian = 4.0 * f.cos_beta * f.wo.z * half_vector(source.wi, f.wo).z.powi(3);
        let width = source.widths[self.detectors.index(source.wi, f.wo)] / jacobian.sqrt();
        ((PIECES * bin / width).ceil() as usize).clamp(1, MOST_PIECES)
    }

    fn finish(&self, at: (f64, f64), source: &Source, lobe: Lobe, scatter: &Ratio, groups: usize) -> Direction {
        let (cos, n) = (source.wi.z, self.detectors.len());
        let (mirror, mirror_error) = self.field.mirror_share(self.field.v_z(cos, cos));
        let beam = mirror * self.hiding.visible(cos, cos);
        let reflectance = self.material.reflectance(cos);
        let scale = 1.0 / (lobe.escaping / (1.0 - beam).max(f64::MIN_POSITIVE)).max(1.0);
        // Joining slices by a cubic can take a little too much where there is next to nothing; the others give it back.
        let [all, above] = [|e: &f64| *e, |e: &f64| e.max(0.0)].map(|f| lobe.energy.iter().map(f).sum::<f64>());
        let kept = if above > 0.0 { scale * all.max(0.0) / above } else { 0.0 };
        let variance = match (groups, self.field.windows().periodic) {
            (1, _) => OVERLAP,
            (_, true) => DEALT_PERIODIC,
            (_, false) => DEALT_HANN,
        };
        // What the mirror beam gains is taken from the lobe.
        let gain = mirror / (1.0 - mirror).max(1e-9);
        let error = |k: usize, core: f64, lobe: f64| {
            let of_lobe = variance.sqrt() * scale * scatter.standard_error(k, lobe).unwrap_or(0.0);
            if mirror > 0.0 { of_lobe.hypot((core - scale * lobe * gain) * mirror_error) } else { of_lobe }
        };
        let mut core = vec![0.0; n];
        for &(wi, part) in &source.points {
            core[self.detectors.index(source.wi, reflect(wi, DVec3::Z))] += part * beam * reflectance;
        }
        let estimate = |k: usize| {
            let value = core[k] + kept * lobe.energy[k].max(0.0);
            Estimate { value, standard_error: error(k, core[k], lobe.energy[k]) }
        };
        let share: Vec<Estimate> = (0..n).map(estimate).collect();
        let mut tally = Tally::new(n);
        tally.energy = share.iter().map(|e| e.value).collect();
        tally.by_bounce = tally.energy.iter().map(|&e| [e, 0.0, 0.0]).collect();
        let (escaped, core): (f64, f64) = (tally.energy.iter().sum(), core.iter().sum());
        tally.bounces[0] = escaped;
        tally.incident = 1.0;
        tally.absorbed = (beam + scale * lobe.escaping - escaped).max(0.0);
        tally.lost = (1.0 - tally.absorbed - escaped).max(0.0);
        tally.shadowed = self.hiding.lambda(cos);
        let albedo = Estimate { value: escaped, standard_error: error(n, core, all) };
        let projected_solid_angle = source.widths.iter().map(|w| w * w).collect();
        Direction { theta_i: at.0, phi_i: at.1, tally, albedo, share, projected_solid_angle }
    }
}

/// Set of a bin: as good as drawn by lot, but always the same.
fn group([column, row]: [i64; 2], groups: usize) -> usize {
    if groups == 1 {
        return 0;
    }
    let mut x = (column as u64) << 32 ^ (row as u64 & 0xFFFF_FFFF);
    x = (x ^ (x >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    x = (x ^ (x >> 33)).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
    ((x ^ (x >> 33)) % groups as u64) as usize
}
