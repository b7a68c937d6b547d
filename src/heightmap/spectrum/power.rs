//! Power spectral density of the heights, averaged over directions, and over wavelengths.

use super::real_transform::{HalfSpectrum, signed};
use crate::heightmap::parameters::Heights;
use crate::heightmap::{Edges, HeightMap};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// One ring of the frequency plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialBin {
    /// Mean spatial frequency of the ring \[1/m\].
    pub frequency: f64,
    /// Two-sided two-dimensional power spectral density, averaged over the ring \[m^4\].
    pub psd: f64,
    /// Area of the ring that the sampling covers \[1/m^2\].
    pub area: f64,
}

/// `PSD(fx, fy) = |sum w h exp(-2 pi i (fx x + fy y))|^2 dx dy / sum w^2` \[m^4\], two-sided in both frequencies:
/// its integral over the plane of frequencies is Sq^2.
///
/// A map that is not periodic is windowed (`w` = Hann along both axes, which kills the jump from one border to the
/// other); missing points have the mean height. What window and gaps take from the variance is put back by one factor, so
/// that the integral is exactly Sq^2 of the map (Parseval). Source: ISO 25178-2:2012, 3.2.9 (Fourier transform of the
/// scale-limited surface); Elson and Bennett, Appl. Opt. 34, 201 (1995) for normalisation and window.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// Rings from the lowest frequency outwards, as wide as the coarser frequency step; the mean height is not in it.
    pub radial: Vec<RadialBin>,
    /// Share of the power per degree of direction of the wave vector, 0 to 180 deg from +x.
    pub angular: Vec<f64>,
    /// Bandwidth \[1/m\]: one over the longer side, and one over two pitches (the finer axis).
    pub bandwidth: [f64; 2],
    /// Whether a window was used.
    pub windowed: bool,
}

/// Frequencies below this many steps are left out of the direction: a handful of waves says little about it.
const LOWEST_FOR_DIRECTION: f64 = 3.0;

#[derive(Default)]
struct Share {
    rings: Vec<[f64; 3]>,
    angular: Vec<f64>,
}

impl Spectrum {
    /// By Fourier transform along rows and columns, in the memory of the map. A flat map has no power anywhere.
    pub fn measure(map: &HeightMap) -> Self {
        Self::about(map, &Heights::measure(map))
    }

    /// As [`Spectrum::measure`] for heights already known.
    pub(crate) fn about(map: &HeightMap, heights: &Heights) -> Self {
        let (rows, columns) = map.heights.dim();
        let windowed = map.edges != Edges::Periodic;
        let window = |n: usize| -> Vec<f64> {
            // The window is symmetric about the middle of the map and nowhere zero.
            let hann = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
            (0..n).map(|k| if windowed { hann(k) } else { 1.0 }).collect()
        };
        let (wx, wy) = (window(columns), window(rows));
        let scale = if heights.sq > 0.0 { 1.0 / heights.sq } else { 0.0 };
        // The mean under the window, so that the wave of no frequency leaks nothing into its neighbours.
        let (mut weights, mut sum) = (0.0, 0.0);
        for (row, wy) in map.heights.outer_iter().zip(&wy) {
            for (&h, wx) in row.iter().zip(&wx).filter(|(h, _)| !h.is_nan()) {
                weights += wx * wy;
                sum += wx * wy * f64::from(h);
            }
        }
        let mean = if weights > 0.0 { sum / weights } else { 0.0 };
        let half = HalfSpectrum::of_rows(rows, columns, rows, |r, row| {
            for ((value, &h), w) in row.iter_mut().zip(map.heights.row(r)).zip(&wx) {
                *value = if h.is_nan() { 0.0 } else { w * wy[r] * (f64::from(h) - mean) * scale };
            }
        });
        let step = [1.0 / (columns as f64 * map.pitch_x), 1.0 / (rows as f64 * map.pitch_y)];
        let ring = step[0].max(step[1]);
        let highest = (0.5 / map.pitch_x).hypot(0.5 / map.pitch_y);
        let count = (highest / ring).round() as usize + 1;
        let shares: Vec<Share> = half.fold_columns(|l, column, share: &mut Share| {
            share.rings.resize(count, [0.0; 3]);
            share.angular.resize(180, 0.0);
            let (fx, weight) = (l as f64 * step[0], half.multiplicity(l));
            for (k, value) in column.iter().enumerate() {
                // Rows go down, y goes up.
                let fy = -signed(k, rows) * step[1];
                let f = fx.hypot(fy);
                if f == 0.0 {
                    continue;
                }
                let power = weight * value.norm_sqr();
                let bin = &mut share.rings[((f / ring).round() as usize).min(count - 1)];
                bin[0] += weight;
                bin[1] += weight * f;
                bin[2] += power;
                if f >= LOWEST_FOR_DIRECTION * ring {
                    spread(&mut share.angular, fy.atan2(fx), 0.5 * ring / f, power);
                }
            }
        });
        let mut rings = vec![[0.0; 3]; count];
        let mut angular = vec![0.0; 180];
        for share in &shares {
            for (ring, part) in rings.iter_mut().zip(&share.rings) {
                ring.iter_mut().zip(part).for_each(|(r, p)| *r += p);
            }
            angular.iter_mut().zip(&share.angular).for_each(|(a, p)| *a += p);
        }
        let cell = step[0] * step[1];
        let total: f64 = rings.iter().map(|r| r[2]).sum();
        // Power per cell to m^4, with the integral at Sq^2.
        let density = if total > 0.0 { heights.sq.powi(2) / (total * cell) } else { 0.0 };
        let radial = rings
            .into_iter()
            .filter(|r| r[0] > 0.0)
            .map(|[n, f, power]| RadialBin { frequency: f / n, psd: power / n * density, area: n * cell })
            .collect();
        let all: f64 = angular.iter().sum();
        if all > 0.0 {
            angular.iter_mut().for_each(|a| *a /= all);
        }
        let finest = map.pitch_x.min(map.pitch_y);
        Spectrum { radial, angular, bandwidth: [step[0].min(step[1]), 0.5 / finest], windowed }
    }

    /// `sum psd area` \[m^2\]: Sq^2.
    pub fn integral(&self) -> f64 {
        self.radial.iter().map(|b| b.psd * b.area).sum()
    }

    /// Direction of the lay from +x \[rad\], in (-90, 90] deg: at right angles to the waves that carry most power.
    /// `None` for a flat map.
    pub fn lay(&self) -> Option<f64> {
        let n = self.angular.len();
        let smooth = |k: usize| -> f64 {
            // Five degrees together: the peak of a single one would be the luck of few waves.
            (0..5).map(|i| [1.0, 2.0, 3.0, 2.0, 1.0][i] * self.angular[(k + n + i - 2) % n]).sum()
        };
        let (peak, power) = (0..n).map(|k| (k, smooth(k))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        if power <= 0.0 {
            return None;
        }
        // Vertex of the parabola through the peak and its neighbours.
        let (before, after) = (smooth((peak + n - 1) % n), smooth((peak + 1) % n));
        let bend = before - 2.0 * power + after;
        let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        let wave = (peak as f64 + 0.5 + shift).to_radians();
        // In steps of half turns to (-90, 90] deg.
        let lay = wave + FRAC_PI_2;
        Some(lay - PI * ((lay - FRAC_PI_2) / PI).ceil())
    }
}

/// Adds `power` over `direction +- half_width` \[rad\] to bins of one degree over half a turn: a wave of low frequency
/// stands for a wide wedge, and would show as a spike at its own angle.
fn spread(bins: &mut [f64], direction: f64, half_width: f64, power: f64) {
    let n = bins.len() as f64;
    let per_bin = n / PI;
    let (low, high) = ((direction - half_width) * per_bin, (direction + half_width) * per_bin);
    let density = power / (high - low);
    let mut at = low;
    while at < high {
        let end = (at.floor() + 1.0).min(high);
        bins[at.floor().rem_euclid(n) as usize % bins.len()] += density * (end - at);
        at = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{level, synth};
    use ndarray::Array2;

    fn rough(edges: Edges) -> HeightMap {
        let grid = synth::Grid { width: 240, height: 150, pitch: [1e-6, 1.5e-6] };
        let surface = synth::Gaussian { sq: 1e-7, acl: 9e-6, seed: 4, exact: true };
        level::keep_tilt(&synth::gaussian(grid, surface).unwrap(), edges)
    }

    /// Parseval: the integral is Sq^2, whatever the window, gaps or sampling.
    #[test]
    fn the_integral_is_the_variance() {
        for edges in [Edges::Open, Edges::Periodic] {
            let mut map = rough(edges);
            for gaps in [false, true] {
                if gaps {
                    (0..800).for_each(|k| map.heights[[20 + k / 20, 30 + k % 20]] = f32::NAN);
                }
                let sq = Heights::measure(&map).sq;
                let s = Spectrum::measure(&map);
                assert!((s.integral() / (sq * sq) - 1.0).abs() < 1e-9);
                // The rings cover the plane of frequencies but for the mean height.
                let area: f64 = s.radial.iter().map(|b| b.area).sum();
                let plane = 1.0 / (map.pitch_x * map.pitch_y);
                assert!((area / plane - 1.0 + 1.0 / (240.0 * 150.0)).abs() < 1e-9);
            }
        }
    }

    /// Gaussian ACF: `PSD(f) = pi Sq^2 acl^2 exp(-(pi f acl)^2)`, on the ring averages of a map with fixed amplitudes.
    #[test]
    fn a_gaussian_surface_has_its_spectrum() {
        let (sq, acl) = (1e-7, 9e-6);
        let s = Spectrum::measure(&rough(Edges::Periodic));
        // The wave of no frequency is left out, so the others carry its share.
        let share = PI * acl * acl / (240e-6 * 225e-6);
        for bin in s.radial.iter().skip(3).take(15) {
            let expected = PI * sq * sq * acl * acl * (-(PI * bin.frequency * acl).powi(2)).exp() / (1.0 - share);
            // A ring is as wide as a tenth of the bend of the curve.
            assert!((bin.psd / expected - 1.0).abs() < 0.05, "{bin:?} {expected}");
        }
        let windowed = Spectrum::measure(&rough(Edges::Open));
        assert!(windowed.windowed && !s.windowed);
        let share_below = |s: &Spectrum| {
            s.radial.iter().filter(|b| b.frequency < 0.05e6).map(|b| b.psd * b.area).sum::<f64>() / s.integral()
        };
        assert!((share_below(&windowed) - share_below(&s)).abs() < 0.05);
    }

    #[test]
    fn the_lay_is_along_the_grooves() {
        for degrees in [0.0, 10.0, 47.0, 90.0, -30.0f64] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let heights = Array2::from_shape_fn((180, 200), |(r, c)| {
                let (x, y) = (c as f64 * 1e-6, -(r as f64) * 1.3e-6);
                // Distance across a groove that runs along `degrees`.
                (1e-7 * ((y * cos - x * sin) * TAU / 8e-6).sin()) as f32
            });
            let map =
                HeightMap { heights, pitch_x: 1e-6, pitch_y: 1.3e-6, edges: Edges::Open, removed_slopes: [0.0; 2] };
            let lay = Spectrum::measure(&map).lay().unwrap().to_degrees();
            let off = (lay - degrees + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() < 1.0 && lay > -90.0 && lay <= 90.0, "{degrees}: {lay}");
        }
        let flat = HeightMap { heights: Array2::zeros((9, 9)), ..rough(Edges::Open) };
        assert_eq!(Spectrum::measure(&flat).lay(), None);
    }
}
