//! What known instrument noise does to the slopes.

use super::{Edges, HeightMap, filter};
use crate::error::{Error, Result};
use serde::Serialize;

/// Slopes of a map with and without the noise of its instrument.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopeNoise {
    /// Standard deviation of the height noise of one sample \[m\].
    #[serde(rename = "noise_m")]
    pub noise: f64,
    /// Root-mean-square gradient as measured, by forward differences.
    #[serde(rename = "Sdq")]
    pub sdq: f64,
    /// Root-mean-square gradient with the noise's variance taken off; 0 where noise explains everything.
    #[serde(rename = "Sdq_corrected")]
    pub corrected: f64,
    /// Slope variance as measured, along x and y.
    pub slope_variance: [f64; 2],
    /// Slope variance that the noise makes, along x and y.
    pub noise_variance: [f64; 2],
    /// Share of the slope variance that is noise; above 1 the noise is overestimated.
    pub share: f64,
}

impl std::fmt::Display for SlopeNoise {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "noise of {} nm is {:.2} % of the slope variance (Sdq {:.5}, without it {:.5})",
            // Two roundings, so that 1 nm given in metres does not print as 1.0000000000000002 nm.
            (self.noise * 1e15).round() * 1e-6,
            100.0 * self.share,
            self.sdq,
            self.corrected
        )
    }
}

/// `Sdq_corrected^2 = Sdq^2 - 2 sigma^2 / dx^2 - 2 sigma^2 / dy^2`: white height noise `sigma` \[m\] taken off the variance
/// of forward differences.
///
/// Slopes are those of the facets (two triangles a cell). After an S-filter the noise is no longer white: give its cut-off
/// \[m\], and the share of the noise that passes it is taken off instead.
///
/// # Errors
/// `Error::Parameter` if `sigma` is negative or not finite.
pub fn slope_noise(map: &HeightMap, sigma: f64, s_filter: Option<f64>) -> Result<SlopeNoise> {
    if !(sigma >= 0.0 && sigma.is_finite()) {
        return Err(Error::parameter(
            format!("a noise of {sigma} m is no standard deviation"),
            "give --noise a length such as 1nm",
        ));
    }
    let (mean_square, slope_variance) = slopes(map);
    let noise_variance = variance_of_noise(sigma, [map.pitch_x, map.pitch_y], s_filter);
    let (total, noisy) = (slope_variance[0] + slope_variance[1], noise_variance[0] + noise_variance[1]);
    Ok(SlopeNoise {
        noise: sigma,
        sdq: mean_square.sqrt(),
        corrected: (mean_square - noisy).max(0.0).sqrt(),
        slope_variance,
        noise_variance,
        share: if noisy == 0.0 { 0.0 } else { noisy / total },
    })
}

/// `2 (C(0) - C(d)) / d^2` along x and y: slope variance that white height noise `sigma` \[m\] makes in forward differences
/// over the pitch `d` \[m\]; `C` is the autocovariance of the noise, `2 sigma^2 / d^2` without filter.
pub fn variance_of_noise(sigma: f64, pitch: [f64; 2], s_filter: Option<f64>) -> [f64; 2] {
    // Autocovariance along one axis at 0 and 1 pitches, per unit variance, of noise that passed the filter.
    let covariance = |d: f64| match s_filter {
        None => [1.0, 0.0],
        Some(cut_off) => {
            const NODES: usize = 4096;
            let mut sums = [0.0; 2];
            for k in 0..NODES {
                // Midpoints of the frequencies from 0 to Nyquist's, in cycles per sample.
                let f = (k as f64 + 0.5) / (2 * NODES) as f64;
                let power = filter::transmission(cut_off, f / d).powi(2);
                sums[0] += power;
                sums[1] += power * (std::f64::consts::TAU * f).cos();
            }
            sums.map(|s| s / NODES as f64)
        }
    };
    let c = pitch.map(covariance);
    [0, 1].map(|k| 2.0 * sigma * sigma * c[1 - k][0] * (c[k][0] - c[k][1]) / (pitch[k] * pitch[k]))
}

/// Mean squared gradient and slope variances over all facets.
fn slopes(map: &HeightMap) -> (f64, [f64; 2]) {
    let (rows, columns) = map.heights.dim();
    let (cell_rows, cell_columns) =
        if map.edges == Edges::Periodic { (rows, columns) } else { (rows - 1, columns - 1) };
    let (mut n, mut sums, mut squares) = (0.0, [0.0; 2], [0.0; 2]);
    for r in 0..cell_rows {
        let (top, bottom) = (map.heights.row(r), map.heights.row((r + 1) % rows));
        // Sums of a row first: a map of millions of facets loses no digits.
        let (mut row_n, mut row_sums, mut row_squares) = (0.0, [0.0; 2], [0.0; 2]);
        for c in 0..cell_columns {
            let next = if c + 1 == columns { 0 } else { c + 1 };
            let [a, b, low_a, low_b] = [top[c], top[next], bottom[c], bottom[next]].map(f64::from);
            for [p, q] in [[low_b - low_a, a - low_a], [b - a, b - low_b]] {
                if (p + q).is_finite() {
                    row_n += 1.0;
                    row_sums = [row_sums[0] + p, row_sums[1] + q];
                    row_squares = [row_squares[0] + p * p, row_squares[1] + q * q];
                }
            }
        }
        n += row_n;
        sums = [sums[0] + row_sums[0], sums[1] + row_sums[1]];
        squares = [squares[0] + row_squares[0], squares[1] + row_squares[1]];
    }
    let pitch = [map.pitch_x, map.pitch_y];
    let count = f64::max(n, 1.0);
    let square = [0, 1].map(|k| squares[k] / (count * pitch[k] * pitch[k]));
    let variance = [0, 1].map(|k| (square[k] - (sums[k] / (count * pitch[k])).powi(2)).max(0.0));
    (square[0] + square[1], variance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use ndarray::Array2;

    const PITCH: [f64; 2] = [0.4e-6, 0.7e-6];

    fn noisy(sigma: f64, wave: f64) -> HeightMap {
        let heights = Array2::from_shape_fn((400, 600), |(r, c)| {
            let noise = sigma * CounterRng::new(9, 0, (r * 600 + c) as u64).normal_pair()[0];
            (noise + wave * (std::f64::consts::TAU * c as f64 / 100.0).sin()) as f32
        });
        let [pitch_x, pitch_y] = PITCH;
        HeightMap { heights, pitch_x, pitch_y, edges: Edges::Periodic, removed_slopes: [0.0; 2] }
    }

    #[test]
    fn pure_noise_explains_itself_and_a_wave_is_what_remains() {
        let sigma = 1e-9;
        let pure = slope_noise(&noisy(sigma, 0.0), sigma, None).unwrap();
        // 240000 samples: the variance is known to 0.3 %.
        assert!((pure.share - 1.0).abs() < 0.012, "{pure:?}");
        for (variance, d) in pure.slope_variance.iter().zip(PITCH) {
            assert!((variance / (2.0 * sigma * sigma / (d * d)) - 1.0).abs() < 0.015);
        }
        // Forward differences of a sin(k x) have the variance 2 (a / d)^2 sin^2(k d / 2).
        let wave = 40e-9;
        let found = slope_noise(&noisy(sigma, wave), sigma, None).unwrap();
        let truth = 2f64.sqrt() * wave / PITCH[0] * (std::f64::consts::PI / 100.0).sin();
        assert!((found.corrected / truth - 1.0).abs() < 0.01, "{found:?}, {truth}");
        // Noise 2 sigma^2 (1 / dx^2 + 1 / dy^2) = 1.66e-5, wave 1.97e-5.
        assert!((found.share - 0.457).abs() < 0.01);
        assert!(slope_noise(&noisy(sigma, wave), -1.0, None).is_err());
        assert_eq!(slope_noise(&noisy(0.0, 0.0), 0.0, None).unwrap().share, 0.0);
    }

    #[test]
    fn noise_after_an_s_filter_is_what_the_filter_leaves_of_it() {
        let (sigma, cut_off) = (1e-9, 3e-6);
        let mut map = noisy(sigma, 0.0);
        filter::gaussian(&mut map, cut_off, filter::Pass::Long).unwrap();
        let found = slope_noise(&map, sigma, Some(cut_off)).unwrap();
        assert!((found.share - 1.0).abs() < 0.03, "{found:?}");
        // A vanishing cut-off lets everything pass.
        let [x, y] = variance_of_noise(sigma, PITCH, Some(1e-12));
        let [a, b] = variance_of_noise(sigma, PITCH, None);
        assert!((x / a - 1.0).abs() < 1e-6 && (y / b - 1.0).abs() < 1e-6);
    }
}
