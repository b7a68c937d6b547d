//! Slopes at growing sampling distance.

use super::warning::MapAxis;
use crate::heightmap::HeightMap;
use rayon::prelude::*;

/// Root-mean-square slope between points a given distance apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeScale {
    /// Distance \[m\].
    pub distance: f64,
    /// `s = sqrt <(h(x + distance) - h(x))^2> / distance`.
    pub rms: f64,
    /// Pairs of measured points.
    pub pairs: u64,
}

/// `s(d), s(2d), s(4d), ..` along one axis up to a quarter of the map; distances without pairs are left out.
///
/// `s(d)^2 = 2 (C(0) - C(d)) / d^2` for any autocovariance C: constant where slopes are resolved, like `1/d^2` where
/// neighbours have nothing to do with each other.
pub(super) fn slope_scales(map: &HeightMap, axis: MapAxis) -> Vec<SlopeScale> {
    let (rows, columns) = map.heights.dim();
    let (side, pitch) = match axis {
        MapAxis::X => (columns, map.pitch_x),
        MapAxis::Y => (rows, map.pitch_y),
    };
    let steps = std::iter::successors(Some(1usize), |k| k.checked_mul(2)).take_while(|&k| k == 1 || 4 * k <= side);
    let measured = steps.filter_map(|k| {
        let sums: Vec<[f64; 2]> = match axis {
            MapAxis::X => (0..rows).into_par_iter().map(|r| row_pairs(map, [r, r], k, columns)).collect(),
            MapAxis::Y => {
                (0..rows.saturating_sub(k)).into_par_iter().map(|r| row_pairs(map, [r, r + k], 0, columns)).collect()
            }
        };
        let (pairs, squares) = sums.iter().fold((0.0, 0.0), |(n, s), row| (n + row[0], s + row[1]));
        let distance = k as f64 * pitch;
        let rms = (squares / f64::max(pairs, 1.0)).sqrt() / distance;
        (pairs > 0.0).then_some(SlopeScale { distance, rms, pairs: pairs as u64 })
    });
    measured.collect()
}

/// Number and squared differences of the measured pairs between two rows, `shift` columns apart.
fn row_pairs(map: &HeightMap, rows: [usize; 2], shift: usize, columns: usize) -> [f64; 2] {
    let [from, to] = rows.map(|r| map.heights.row(r));
    let (mut pairs, mut squares) = (0.0, 0.0);
    for (&a, &b) in from.iter().zip(to.iter().skip(shift)).take(columns - shift.min(columns)) {
        let difference = f64::from(b) - f64::from(a);
        if !difference.is_nan() {
            pairs += 1.0;
            squares += difference * difference;
        }
    }
    [pairs, squares]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    /// Gaussian ACF: `s(d)^2 = 2 Sq^2 (1 - exp(-d^2 / acl^2)) / d^2` (TV46), on each axis with its own pitch.
    #[test]
    fn a_gaussian_surface_at_every_distance() {
        let grid = synth::Grid { width: 512, height: 384, pitch: [0.5e-6, 1e-6] };
        let (sq, acl) = (1e-7, 5e-6);
        let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed: 2, exact: true }).unwrap();
        let map = level::keep_tilt(&raw, Edges::Open);
        for axis in [MapAxis::X, MapAxis::Y] {
            let scales = slope_scales(&map, axis);
            assert_eq!(scales.len(), if axis == MapAxis::X { 8 } else { 7 });
            for s in &scales[..5] {
                let expected = sq * (2.0 * (1.0 - (-(s.distance / acl).powi(2)).exp())).sqrt() / s.distance;
                // Pairs over the border are left out, so the ensemble's value is met within its scatter.
                assert!((s.rms / expected - 1.0).abs() < 0.02, "{axis:?} {s:?} {expected}");
            }
        }
    }

    #[test]
    fn gaps_and_small_maps() {
        let mut heights = ndarray::Array2::from_shape_fn((3, 5), |(r, c)| (2 * c + 7 * r) as f32);
        heights[[0, 2]] = f32::NAN;
        let map = HeightMap { heights, pitch_x: 2.0, pitch_y: 7.0, edges: Edges::Open, removed_slopes: [0.0; 2] };
        assert_eq!(slope_scales(&map, MapAxis::X), [SlopeScale { distance: 2.0, rms: 1.0, pairs: 10 }]);
        assert_eq!(slope_scales(&map, MapAxis::Y), [SlopeScale { distance: 7.0, rms: 1.0, pairs: 9 }]);
    }
}
