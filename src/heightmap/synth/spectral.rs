//! Rough surfaces with a given autocorrelation: sums of plane waves of random phase.

use super::{Grid, check_grid, map_of, micrometres};
use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::math::{fft, random::CounterRng};
use ndarray::Array2;
use rayon::prelude::*;
use rustfft::{FftDirection, num_complex::Complex};

/// An isotropic Gaussian surface, periodic in both directions.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian {
    /// Root-mean-square height \[m\]; 0 gives a flat map.
    pub sq: f64,
    /// Autocorrelation length \[m\]: the ACF falls to 1/e there.
    pub acl: f64,
    /// Seed of the random phases (and amplitudes).
    pub seed: u64,
    /// Fixed spectral amplitudes: only the phases are random, so Sq and Sdq of this one map equal those
    /// of the ensemble. Without it amplitudes scatter as in a true Gaussian process.
    pub exact: bool,
}

/// How the autocorrelation falls with `t`, the lag in units of the autocorrelation length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decay {
    /// `exp(-t^2)`: smooth, with a slope variance of `2 Sq^2 / acl^2` per axis.
    Gaussian,
    /// `exp(-t)`: no rms slope; `s(d)^2 = 2 Sq^2 (1 - exp(-d / acl)) / d^2` grows with ever finer sampling.
    Exponential,
}

/// A random surface with normally distributed heights, periodic in both directions.
#[derive(Debug, Clone, Copy)]
pub struct Rough {
    /// Root-mean-square height \[m\]; 0 gives a flat map.
    pub sq: f64,
    /// Autocorrelation lengths \[m\] along the two principal directions.
    pub acl: [f64; 2],
    /// Direction of the first from +x \[rad\].
    pub angle: f64,
    /// Shape of the autocorrelation.
    pub decay: Decay,
    /// Seed of the random phases (and amplitudes).
    pub seed: u64,
    /// As [`Gaussian::exact`].
    pub exact: bool,
}

/// `<h(0) h(r)> = Sq^2 exp(-r^2 / acl^2)`, heights normally distributed; slope variance `2 Sq^2 / acl^2` per axis.
///
/// Sum of plane waves with `|a_k|^2` proportional to `exp(-k^2 acl^2 / 4)` (spectral method, Shinozuka and
/// Deodatis 1996), by inverse FFT. The wave of infinite length is left out, which raises the slope variance by
/// `1 / (1 - pi acl^2 / area)` at equal Sq. Same options, same heights, for any number of threads.
///
/// # Errors
/// `Error::Parameter` for fewer than 2 x 2 samples, non-positive pitch or correlation length, negative Sq,
/// or a correlation length the grid cannot hold (below one pitch, or above half the map).
pub fn gaussian(grid: Grid, surface: Gaussian) -> Result<RawMap> {
    let Gaussian { sq, acl, seed, exact } = surface;
    check(grid, sq, [acl, acl])?;
    let power = |r: usize, c: usize| {
        let [kx, ky] = wave_vector(grid, r, c);
        (-(kx * kx + ky * ky) * acl * acl / 4.0).exp()
    };
    waves(grid, sq, seed, exact, power)
}

/// `<h(0) h(r)> = Sq^2 D(t)`, `t^2 = (u / acl_1)^2 + (v / acl_2)^2` with `u`, `v` the components of `r` along and across
/// the direction `angle`; `D` as [`Decay`] says. Heights normally distributed.
///
/// The power of every wave is the discrete Fourier transform of the autocorrelation on the periodic grid (circulant
/// embedding, Dietrich and Newsam 1997), so that it holds at every lag of the grid, however rough the surface is between
/// the samples. The wave of infinite length is left out: with its share `f` of the power the autocorrelation is
/// `(D - f) / (1 - f)`.
///
/// # Errors
/// As [`gaussian`], for either length; also for an angle that is not finite.
pub fn rough(grid: Grid, surface: Rough) -> Result<RawMap> {
    let Rough { sq, acl, angle, decay, seed, exact } = surface;
    check(grid, sq, acl)?;
    if !angle.is_finite() {
        return Err(Error::parameter(format!("{angle} is not an angle"), "give --angle in degrees"));
    }
    let (w, h) = (grid.width, grid.height);
    let (sin, cos) = angle.sin_cos();
    let correlation = |x: f64, y: f64| {
        let t2 = ((x * cos + y * sin) / acl[0]).powi(2) + ((y * cos - x * sin) / acl[1]).powi(2);
        match decay {
            Decay::Gaussian => (-t2).exp(),
            Decay::Exponential => (-t2.sqrt()).exp(),
        }
    };
    let mut table = vec![Complex::default(); w * h];
    table.par_chunks_mut(w).enumerate().for_each(|(r, row)| {
        let [_, y] = lag(grid, r, 0);
        for (c, value) in row.iter_mut().enumerate() {
            let [x, _] = lag(grid, 0, c);
            // Half of a side is as far to the left as to the right; the table must not prefer one.
            let mirrored = |x: f64, y: f64| 0.5 * (correlation(x, y) + correlation(x, -y));
            let ambiguous = 2 * r == h || 2 * c == w;
            value.re = if ambiguous { mirrored(x, y) } else { correlation(x, y) };
        }
    });
    fft::transform(&mut table, h, w, FftDirection::Forward);
    // A length near half the map makes some powers slightly negative; no wave has that.
    waves(grid, sq, seed, exact, |r, c| table[r * w + c].re.max(0.0))
}

fn check(grid: Grid, sq: f64, acl: [f64; 2]) -> Result<()> {
    check_grid(grid)?;
    if !(sq >= 0.0 && sq.is_finite()) {
        return Err(Error::parameter(format!("Sq {sq} m is not a height"), "give --sq 0 or more, with a unit"));
    }
    let size = [grid.width as f64 * grid.pitch[0], grid.height as f64 * grid.pitch[1]];
    let coarse = grid.pitch[0].max(grid.pitch[1]);
    // A flat map has no correlation to hold.
    match acl.into_iter().find(|acl| sq > 0.0 && !(*acl >= coarse && 2.0 * acl <= size[0].min(size[1]))) {
        Some(acl) => Err(Error::parameter(
            format!(
                "the autocorrelation length {} does not fit a map of {} x {} at pitch {}",
                micrometres(acl),
                micrometres(size[0]),
                micrometres(size[1]),
                micrometres(coarse)
            ),
            "choose --acl between one pitch and half the map, better 4 pitches to 1/30 of the map",
        )),
        None => Ok(()),
    }
}

/// Index of `n` as a signed number of periods or samples.
fn signed(k: usize, n: usize) -> f64 {
    if 2 * k > n { k as f64 - n as f64 } else { k as f64 }
}

/// Wave numbers along the columns and down the rows \[rad/m\].
fn wave_vector(grid: Grid, r: usize, c: usize) -> [f64; 2] {
    let frequency = |k: usize, n: usize, length: f64| std::f64::consts::TAU * signed(k, n) / length;
    let size = [grid.width as f64 * grid.pitch[0], grid.height as f64 * grid.pitch[1]];
    [frequency(c, grid.width, size[0]), frequency(r, grid.height, size[1])]
}

/// Shortest lag on the periodic grid \[m\]; rows go down, y goes up.
fn lag(grid: Grid, r: usize, c: usize) -> [f64; 2] {
    [signed(c, grid.width) * grid.pitch[0], -signed(r, grid.height) * grid.pitch[1]]
}

/// Sum of waves whose mean squared amplitudes are proportional to `power(row, column)`, all but the first.
fn waves(grid: Grid, sq: f64, seed: u64, exact: bool, power: impl Fn(usize, usize) -> f64 + Sync) -> Result<RawMap> {
    let (w, h) = (grid.width, grid.height);
    if sq == 0.0 {
        return Ok(map_of(grid, Array2::zeros((h, w))));
    }
    let power = |r: usize, c: usize| if r == 0 && c == 0 { 0.0 } else { power(r, c) };
    let total: f64 = (0..h).map(|r| (0..w).map(|c| power(r, c)).sum::<f64>()).sum();
    let mut spectrum = vec![Complex::default(); w * h];
    spectrum.par_chunks_mut(w).enumerate().for_each(|(r, row)| {
        for (c, value) in row.iter_mut().enumerate() {
            let p = power(r, c);
            // Below this a wave is smaller than rounding; skipping it keeps the generator cheap.
            if p < 1e-34 {
                continue;
            }
            let (own, partner) = (r * w + c, (h - r) % h * w + (w - c) % w);
            let amplitude = sq * (p / total).sqrt();
            // Both members of a conjugate pair draw from the smaller index, so that the heights are real.
            let mut rng = CounterRng::new(seed, 0, own.min(partner) as u64);
            let wave = if exact {
                Complex::from_polar(1.0, std::f64::consts::TAU * rng.uniform())
            } else {
                let [a, b] = rng.normal_pair();
                Complex::new(a, b) / std::f64::consts::SQRT_2
            };
            *value = amplitude
                * match own.cmp(&partner) {
                    std::cmp::Ordering::Less => wave,
                    std::cmp::Ordering::Greater => wave.conj(),
                    std::cmp::Ordering::Equal => Complex::new(wave.re.signum(), 0.0),
                };
        }
    });
    fft::transform(&mut spectrum, h, w, FftDirection::Inverse);
    let heights = Array2::from_shape_fn((h, w), |(r, c)| spectrum[r * w + c].re);
    Ok(map_of(grid, heights))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { width: 384, height: 256, pitch: [0.5e-6, 0.75e-6] };

    /// Height variance and the ACF at one lag along each axis, against the defining formula.
    #[test]
    fn exact_map_has_the_autocorrelation_it_was_asked_for() {
        let surface = Gaussian { sq: 0.2e-6, acl: 6e-6, seed: 3, exact: true };
        let map = gaussian(GRID, surface).unwrap();
        let h = &map.heights;
        let n = h.len() as f64;
        let correlation = |dr: usize, dc: usize| {
            h.indexed_iter().map(|((r, c), v)| v * h[[(r + dr) % GRID.height, (c + dc) % GRID.width]]).sum::<f64>() / n
        };
        assert!((correlation(0, 0).sqrt() / surface.sq - 1.0).abs() < 1e-9);
        // The wave of infinite length is left out (a map has no mean height), which takes the share
        // f = pi acl^2 / area off the ACF at every lag.
        let f = std::f64::consts::PI * surface.acl.powi(2) / (192e-6 * 192e-6);
        let expected = |x: f64| surface.sq.powi(2) * ((-(x / surface.acl).powi(2)).exp() - f) / (1.0 - f);
        assert!((correlation(0, 10) - expected(5e-6)).abs() < 1e-9 * surface.sq.powi(2));
        assert!((correlation(8, 0) - expected(6e-6)).abs() < 1e-9 * surface.sq.powi(2));
    }

    fn correlation(map: &RawMap, down: usize, right: usize) -> f64 {
        let (rows, columns) = map.heights.dim();
        let pairs = map.heights.indexed_iter();
        let products = pairs.map(|((r, c), v)| v * map.heights[[(r + down) % rows, (c + right) % columns]]);
        products.sum::<f64>() / map.heights.len() as f64
    }

    /// The autocorrelation at lags of the grid, less the share of the wave that is left out: exponential and turned
    /// anisotropic, on pixels that are not square.
    #[test]
    fn every_autocorrelation_is_met_at_the_lags_of_the_grid() {
        let sq = 1e-7;
        for (decay, acl, degrees) in [
            (Decay::Exponential, [5e-6, 5e-6], 0.0),
            (Decay::Gaussian, [20e-6, 4e-6], 30.0),
            (Decay::Gaussian, [4e-6, 12e-6], -75.0),
            (Decay::Exponential, [15e-6, 3e-6], 60.0f64),
        ] {
            let angle = degrees.to_radians();
            let map = rough(GRID, Rough { sq, acl, angle, decay, seed: 5, exact: true }).unwrap();
            let expected = |x: f64, y: f64| {
                let (sin, cos) = angle.sin_cos();
                let t = ((x * cos + y * sin) / acl[0]).hypot((y * cos - x * sin) / acl[1]);
                if decay == Decay::Gaussian { (-t * t).exp() } else { (-t).exp() }
            };
            // Share of the left-out wave: the mean of the autocorrelation over the periodic map.
            let lags = (0..GRID.height).flat_map(|r| (0..GRID.width).map(move |c| (r, c)));
            let total: f64 = lags.map(|(r, c)| expected(lag(GRID, 0, c)[0], lag(GRID, r, 0)[1])).sum();
            let f = total / (GRID.width * GRID.height) as f64;
            assert!((correlation(&map, 0, 0).sqrt() / sq - 1.0).abs() < 1e-9);
            for (down, right) in [(0, 1), (1, 0), (3, 5), (GRID.height - 3, 5), (0, 12)] {
                let [x, y] = [lag(GRID, 0, right)[0], lag(GRID, down, 0)[1]];
                let found = correlation(&map, down, right) / (sq * sq);
                let known = (expected(x, y) - f) / (1.0 - f);
                // Clipped powers and the two-fold lags at half the map shift the whole by a little.
                assert!((found - known).abs() < 2e-3, "{decay:?} {degrees} {down} {right}: {found} {known}");
            }
        }
    }

    /// Slope variance per principal axis: `2 Sq^2 / acl^2`, with the factor of forward differences.
    #[test]
    fn anisotropic_slopes() {
        let grid = Grid { width: 512, height: 512, pitch: [0.5e-6; 2] };
        let surface = Rough { sq: 1e-7, acl: [6e-6, 12e-6], angle: 0.0, decay: Decay::Gaussian, seed: 1, exact: true };
        let map = rough(grid, surface).unwrap();
        for (k, (down, right)) in [(0, 1), (1, 0)].into_iter().enumerate() {
            let found = 2.0 * (correlation(&map, 0, 0) - correlation(&map, down, right)) / 0.25e-12;
            let x2 = (0.5e-6 / surface.acl[k]).powi(2);
            let expected = 2.0 * 1e-14 / surface.acl[k].powi(2) * (1.0 - (-x2).exp()) / x2;
            let f = std::f64::consts::PI * surface.acl[0] * surface.acl[1] / (256e-6f64 * 256e-6);
            assert!((found * (1.0 - f) / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }

    /// Where both say the same they make the same surface, up to what lies between the grid's waves.
    #[test]
    fn the_isotropic_case_agrees_with_the_older_generator() {
        let surface = Gaussian { sq: 1e-7, acl: 6e-6, seed: 9, exact: true };
        let acl = [6e-6, 6e-6];
        let old = gaussian(GRID, surface).unwrap();
        let new =
            rough(GRID, Rough { sq: 1e-7, acl, angle: 0.3, decay: Decay::Gaussian, seed: 9, exact: true }).unwrap();
        for (a, b) in old.heights.iter().zip(&new.heights) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn random_amplitudes_average_to_the_same_variance() {
        let variances: Vec<f64> = (0..24)
            .map(|seed| {
                let surface = Gaussian { sq: 1e-6, acl: 4e-6, seed, exact: false };
                let map = gaussian(Grid { width: 64, height: 64, pitch: [1e-6; 2] }, surface).unwrap();
                map.heights.iter().map(|v| v * v).sum::<f64>() / map.heights.len() as f64 * 1e12
            })
            .collect();
        let e = crate::math::Estimate::from_repeats(&variances);
        assert!(e.standard_error > 0.0 && (e.value - 1.0).abs() < 4.0 * e.standard_error, "{e:?}");
    }

    #[test]
    fn refuses_what_it_cannot_make() {
        let good = Gaussian { sq: 1e-6, acl: 6e-6, seed: 0, exact: false };
        assert!(gaussian(GRID, Gaussian { acl: 1e-7, ..good }).is_err());
        assert!(gaussian(GRID, Gaussian { acl: 1e-3, ..good }).is_err());
        assert!(gaussian(GRID, Gaussian { sq: f64::NAN, ..good }).is_err());
        assert!(gaussian(Grid { width: 1, ..GRID }, good).is_err());
    }
}
