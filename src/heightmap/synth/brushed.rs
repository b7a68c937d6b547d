//! A brushed finish: many grooves of one shape at random places along one direction.

use super::{Grid, check_grid, map_of, micrometres};
use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::math::random::CounterRng;
use ndarray::Array2;
use rayon::prelude::*;

/// A finish of identical grooves, periodic in both directions.
#[derive(Debug, Clone, Copy)]
pub struct Brushed {
    /// Root-mean-square height \[m\] of the ensemble; 0 gives a flat map.
    pub sq: f64,
    /// Autocorrelation lengths \[m\] along and across the lay.
    pub acl: [f64; 2],
    /// Direction of the lay from +x \[rad\].
    pub lay: f64,
    /// Grooves that overlap at a point, on average: few make deep scratches in a mirror, many a normal distribution.
    pub overlap: f64,
    /// Seed of the places.
    pub seed: u64,
    /// Scale this one map to Sq exactly.
    pub exact: bool,
}

/// `h = -a sum_k exp(-2 (u - u_k)^2 / acl_1^2 - 2 (v - v_k)^2 / acl_2^2)`, less its mean, with `u` along and `v` across the
/// lay and uniformly distributed places: a filtered shot process.
///
/// By Campbell's theorem (S. O. Rice, Bell Syst. Tech. J. 23, 1944) with `n = overlap / (pi acl_1 acl_2)` grooves per
/// area: `Sq^2 = a^2 overlap / 4`, autocorrelation `exp(-(u/acl_1)^2 - (v/acl_2)^2)`, skewness
/// `Ssk = -4 / (3 sqrt(overlap))`.
///
/// # Errors
/// `Error::Parameter` for an unusable grid, a negative Sq, an overlap outside 0.01 to 10000, a lay that is not finite, or
/// lengths that the grid cannot hold (the one across below one pitch, either above half the map).
pub fn brushed(grid: Grid, surface: Brushed) -> Result<RawMap> {
    check(grid, surface)?;
    let Brushed { sq, acl, lay, overlap, seed, exact } = surface;
    let (w, h) = (grid.width, grid.height);
    if sq == 0.0 {
        return Ok(map_of(grid, Array2::zeros((h, w))));
    }
    let size = [w as f64 * grid.pitch[0], h as f64 * grid.pitch[1]];
    let count = ((overlap * size[0] * size[1] / (std::f64::consts::PI * acl[0] * acl[1])).round() as u64).max(1);
    let depth = 2.0 * sq / overlap.sqrt();
    let places: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let mut rng = CounterRng::new(seed, 1, k);
            [rng.uniform() * size[0], rng.uniform() * size[1]]
        })
        .collect();
    let (sin, cos) = lay.sin_cos();
    // Half extents of the box in which a groove is above 1e-9 of its depth.
    let reach = (0.5 * 1e9f64.ln()).sqrt();
    let extent = |along: f64, across: f64| reach * (along * acl[0]).hypot(across * acl[1]);
    let (half_x, half_y) = (extent(cos, sin).min(size[0] / 2.0), extent(sin, cos).min(size[1] / 2.0));
    let mut heights = Array2::zeros((h, w));
    let mut rows: Vec<(usize, &mut [f64])> = Vec::new();
    if let Some(slice) = heights.as_slice_mut() {
        rows = slice.chunks_mut(w).enumerate().collect();
    }
    // Every row takes the grooves in the same order, so the sums do not depend on the threads.
    rows.into_par_iter().for_each(|(r, row)| {
        for &[x0, y0] in &places {
            let dy = wrapped(y0 - r as f64 * grid.pitch[1], size[1]);
            if dy.abs() > half_y {
                continue;
            }
            let first = ((x0 - half_x) / grid.pitch[0]).ceil() as i64;
            let last = (((x0 + half_x) / grid.pitch[0]).floor() as i64).min(first + w as i64 - 1);
            for c in first..=last {
                let dx = c as f64 * grid.pitch[0] - x0;
                let (u, v) = ((dx * cos + dy * sin) / acl[0], (dy * cos - dx * sin) / acl[1]);
                row[c.rem_euclid(w as i64) as usize] -= depth * (-2.0 * (u * u + v * v)).exp();
            }
        }
    });
    let n = (w * h) as f64;
    let mean = heights.sum() / n;
    heights.mapv_inplace(|z| z - mean);
    if exact {
        let found = (heights.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
        if found > 0.0 {
            heights.mapv_inplace(|z| z * sq / found);
        }
    }
    Ok(map_of(grid, heights))
}

/// `d` on a circle of the given length, between minus and plus half of it.
fn wrapped(d: f64, length: f64) -> f64 {
    d - length * (d / length).round()
}

fn check(grid: Grid, s: Brushed) -> Result<()> {
    check_grid(grid)?;
    if !(s.sq >= 0.0 && s.sq.is_finite()) {
        return Err(Error::parameter(format!("Sq {} m is not a height", s.sq), "give --sq 0 or more, with a unit"));
    }
    if !s.lay.is_finite() {
        return Err(Error::parameter(format!("{} is not an angle", s.lay), "give --angle in degrees"));
    }
    if !(0.01..=1e4).contains(&s.overlap) {
        return Err(Error::parameter(
            format!("an overlap of {} grooves cannot be made", s.overlap),
            "choose --overlap between 0.01 and 10000, for example 10",
        ));
    }
    let coarse = grid.pitch[0].max(grid.pitch[1]);
    let shortest = (grid.width as f64 * grid.pitch[0]).min(grid.height as f64 * grid.pitch[1]);
    match s.acl.into_iter().find(|acl| !(*acl >= coarse && 2.0 * acl <= shortest)) {
        Some(acl) => Err(Error::parameter(
            format!(
                "grooves of length scale {} do not fit a map of {} at pitch {}",
                micrometres(acl),
                micrometres(shortest),
                micrometres(coarse)
            ),
            "choose both --acl between one pitch and half the map",
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::parameters::Heights;
    use crate::heightmap::{Edges, level};
    use crate::math::Estimate;

    const GRID: Grid = Grid { width: 256, height: 200, pitch: [1e-6, 1.5e-6] };
    const SURFACE: Brushed = Brushed { sq: 1e-7, acl: [30e-6, 4e-6], lay: 0.5, overlap: 4.0, seed: 0, exact: false };

    /// Variance, skewness and the autocorrelation at a lag against Campbell's theorem, over several maps.
    #[test]
    fn moments_are_those_of_shot_noise() {
        let maps: Vec<RawMap> = (0..16).map(|seed| brushed(GRID, Brushed { seed, ..SURFACE }).unwrap()).collect();
        let estimate = |of: &dyn Fn(&RawMap) -> f64| Estimate::from_repeats(&maps.iter().map(of).collect::<Vec<_>>());
        let mean = |map: &RawMap, f: &dyn Fn(usize, usize) -> f64| {
            map.heights.indexed_iter().map(|((r, c), _)| f(r, c)).sum::<f64>() / map.heights.len() as f64
        };
        let lag = |map: &RawMap, down: usize, right: usize| {
            mean(map, &|r, c| map.heights[[r, c]] * map.heights[[(r + down) % 200, (c + right) % 256]]) * 1e14
        };
        // The mean that is taken off, and the fixed number of grooves, cost the share pi acl_1 acl_2 / area.
        let f = std::f64::consts::PI * 30e-6 * 4e-6 / (256e-6 * 300e-6);
        let variance = estimate(&|m| lag(m, 0, 0));
        assert!((variance.value - (1.0 - f)).abs() < 4.0 * variance.standard_error, "{variance:?}");
        let third = estimate(&|m| mean(m, &|r, c| m.heights[[r, c]].powi(3)) * 1e21);
        assert!((third.value + 4.0 / (3.0 * 2.0)).abs() < 4.0 * third.standard_error + 3.0 * f, "{third:?}");
        // Three columns to the right, four rows down: x = 3 um, y = -6 um.
        let (sin, cos) = 0.5f64.sin_cos();
        let (u, v) = (3e-6 * cos - 6e-6 * sin, -6e-6 * cos - 3e-6 * sin);
        let expected = (-(u / 30e-6).powi(2) - (v / 4e-6).powi(2)).exp() - f;
        let found = estimate(&|m| lag(m, 4, 3));
        assert!((found.value - expected).abs() < 4.0 * found.standard_error, "{found:?} {expected}");
    }

    #[test]
    fn exact_means_this_map_and_any_number_of_threads() {
        let make = || brushed(GRID, Brushed { exact: true, ..SURFACE }).unwrap();
        let sq = Heights::measure(&level::keep_tilt(&make(), Edges::Periodic)).sq;
        assert!((sq / 1e-7 - 1.0).abs() < 1e-6);
        let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(make);
        assert_eq!(single.heights, make().heights);
    }

    #[test]
    fn refuses_what_it_cannot_make() {
        for bad in [
            Brushed { overlap: 0.0, ..SURFACE },
            Brushed { acl: [1.0, 4e-6], ..SURFACE },
            Brushed { acl: [3e-5, 1e-7], ..SURFACE },
            Brushed { sq: f64::NAN, ..SURFACE },
            Brushed { lay: f64::INFINITY, ..SURFACE },
        ] {
            assert!(brushed(GRID, bad).is_err());
        }
    }
}
