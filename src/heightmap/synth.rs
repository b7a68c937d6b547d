//! Height maps from a formula: the calibration artefacts of the whole chain.

use super::RawMap;
use crate::error::{Error, Result};
use crate::math::{fft, random::CounterRng};
use ndarray::Array2;
use rayon::prelude::*;
use rustfft::{FftDirection, num_complex::Complex};

/// Grid and sampling of a synthetic map.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Samples along x.
    pub width: usize,
    /// Samples along y.
    pub height: usize,
    /// Sampling distance along x and y [m].
    pub pitch: [f64; 2],
}

/// An isotropic Gaussian surface, periodic in both directions.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian {
    /// Root-mean-square height [m]; 0 gives a flat map.
    pub sq: f64,
    /// Autocorrelation length [m]: the ACF falls to 1/e there.
    pub acl: f64,
    /// Seed of the random phases (and amplitudes).
    pub seed: u64,
    /// Fixed spectral amplitudes: only the phases are random, so Sq and Sdq of this one map equal those
    /// of the ensemble. Without it amplitudes scatter as in a true Gaussian process.
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
    check_grid(grid)?;
    let Gaussian { sq, acl, seed, exact } = surface;
    if !(sq >= 0.0 && sq.is_finite()) {
        return Err(Error::parameter(format!("Sq {sq} m is not a height"), "give --sq 0 or more, with a unit"));
    }
    let (w, h) = (grid.width, grid.height);
    if sq == 0.0 {
        return Ok(map_of(grid, Array2::zeros((h, w))));
    }
    let size = [w as f64 * grid.pitch[0], h as f64 * grid.pitch[1]];
    let coarse = grid.pitch[0].max(grid.pitch[1]);
    if !(acl >= coarse && 2.0 * acl <= size[0].min(size[1])) {
        return Err(Error::parameter(
            format!(
                "the autocorrelation length {acl} m does not fit a map of {} x {} m at pitch {coarse} m",
                size[0], size[1]
            ),
            "choose --acl between one pitch and half the map, better 4 pitches to 1/30 of the map",
        ));
    }
    let frequency = |k: usize, n: usize, length: f64| {
        let signed = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
        std::f64::consts::TAU * signed / length
    };
    let power = |r: usize, c: usize| {
        let kx = frequency(c, w, size[0]);
        let ky = frequency(r, h, size[1]);
        if r == 0 && c == 0 { 0.0 } else { (-(kx * kx + ky * ky) * acl * acl / 4.0).exp() }
    };
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

/// `h = p x + q y` with slopes `p`, `q`: a tilted mirror. x grows with the column, y against the row.
///
/// # Errors
/// `Error::Parameter` for an unusable grid or slopes that are not finite.
pub fn ramp(grid: Grid, slopes: [f64; 2]) -> Result<RawMap> {
    check_grid(grid)?;
    if !slopes.iter().all(|s| s.is_finite()) {
        return Err(Error::parameter(format!("slopes {slopes:?} are not finite"), "give two numbers such as 0.1,0"));
    }
    let heights = Array2::from_shape_fn((grid.height, grid.width), |(r, c)| {
        slopes[0] * grid.pitch[0] * c as f64 - slopes[1] * grid.pitch[1] * r as f64
    });
    Ok(map_of(grid, heights))
}

fn check_grid(grid: Grid) -> Result<()> {
    if grid.width < 2 || grid.height < 2 || grid.width.saturating_mul(grid.height) > 1 << 30 {
        return Err(Error::parameter(
            format!("a map of {} x {} points cannot be made", grid.width, grid.height),
            "choose --size between 2 and 32768",
        ));
    }
    if !grid.pitch.iter().all(|p| p.is_finite() && *p > 0.0) {
        return Err(Error::parameter(
            format!("pitch {:?} m is not positive", grid.pitch),
            "give --pitch with a unit, for example 0.5um",
        ));
    }
    Ok(())
}

fn map_of(grid: Grid, heights: Array2<f64>) -> RawMap {
    RawMap { heights, pitch_x: grid.pitch[0], pitch_y: grid.pitch[1], format: "synthetic", notes: Vec::new() }
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
        assert!(ramp(Grid { pitch: [0.0, 1.0], ..GRID }, [0.1, 0.0]).is_err());
    }
}
