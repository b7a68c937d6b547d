//! Single points far from all their neighbours.

use crate::heightmap::HeightMap;
use rayon::prelude::*;

/// Points that stand out from the median of their neighbours, and what they do to the slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spikes {
    /// How many.
    pub count: u64,
    /// The farthest \[m\].
    pub largest: f64,
    /// What counts as far \[m\]: six standard deviations, estimated from the median absolute deviation.
    pub threshold: f64,
    /// Share of the squared slopes that lies on pairs of neighbours with such a point.
    pub slope_share: f64,
}

/// Standard deviations from which a point is a spike.
const FAR: f64 = 6.0;

/// Standard deviation of a normal distribution over its median absolute deviation.
const PER_MAD: f64 = 1.4826;

/// Compares every inner point with the median of its eight neighbours; `None` if none is far from it. It must
/// be as far above or below every single one, which edges and corners of a scratch are not.
///
/// `quantum` \[m\] is the step of the heights: a point one step off is no spike.
pub(super) fn find(map: &HeightMap, quantum: f64) -> Option<Spikes> {
    let (rows, columns) = map.heights.dim();
    if rows < 3 || columns < 3 {
        return None;
    }
    let inner = rows - 2;
    let mut residuals = vec![0.0f32; inner * columns];
    residuals.par_chunks_mut(columns).enumerate().for_each(|(r, row)| {
        for c in 1..columns - 1 {
            row[c] = residual(map, r + 1, c);
        }
    });
    let stride = (residuals.len() / 500_000).max(1);
    let mut sample: Vec<f32> = residuals.iter().step_by(stride).map(|r| r.abs()).filter(|r| !r.is_nan()).collect();
    if sample.is_empty() {
        return None;
    }
    let mean = sample.iter().map(|&r| f64::from(r)).sum::<f64>() / sample.len() as f64;
    let middle = sample.len() / 2;
    let (_, mad, _) = sample.select_nth_unstable_by(middle, f32::total_cmp);
    // On a flat map with a few spikes more than half of the residuals are zero; their mean is not.
    let threshold = (FAR * PER_MAD * f64::from(*mad)).max(FAR * mean).max(2.5 * quantum);
    let far = |r: usize, c: usize| {
        let candidate = (1..=inner).contains(&r) && f64::from(residuals[(r - 1) * columns + c].abs()) > threshold;
        candidate && off_all_neighbours(map, r, c) > threshold
    };
    let (mut count, mut largest) = (0, 0.0f64);
    for (i, &residual) in residuals.iter().enumerate() {
        if f64::from(residual.abs()) > threshold && far(i / columns + 1, i % columns) {
            count += 1;
            largest = largest.max(f64::from(residual.abs()));
        }
    }
    if count == 0 {
        return None;
    }
    let sums: Vec<[f64; 2]> = (0..rows)
        .into_par_iter()
        .map(|r| {
            let (mut all, mut touched) = (0.0, 0.0);
            let mut pair = |(r2, c2): (usize, usize), c: usize, pitch: f64| {
                let slope = (f64::from(map.heights[[r2, c2]]) - f64::from(map.heights[[r, c]])) / pitch;
                if !slope.is_nan() {
                    all += slope * slope;
                    touched += if far(r, c) || far(r2, c2) { slope * slope } else { 0.0 };
                }
            };
            for c in 0..columns {
                if c + 1 < columns {
                    pair((r, c + 1), c, map.pitch_x);
                }
                if r + 1 < rows {
                    pair((r + 1, c), c, map.pitch_y);
                }
            }
            [all, touched]
        })
        .collect();
    let (all, touched) = sums.iter().fold((0.0, 0.0), |(a, t), s| (a + s[0], t + s[1]));
    Some(Spikes { count, largest, threshold, slope_share: if all > 0.0 { touched / all } else { 0.0 } })
}

const AROUND: [(usize, usize); 8] = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)];

/// Height of an inner point above the highest neighbour, or depth below the lowest \[m\]; negative in between.
fn off_all_neighbours(map: &HeightMap, r: usize, c: usize) -> f64 {
    let h = map.heights[[r, c]];
    let neighbours = AROUND.iter().map(|(dr, dc)| map.heights[[r + dr - 1, c + dc - 1]]).filter(|n| !n.is_nan());
    let (low, high) = neighbours.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), n| (l.min(n), h.max(n)));
    f64::from((h - high).max(low - h))
}

/// Height above the median of the neighbours \[m\]; NaN with fewer than five of them, or if the point is missing.
fn residual(map: &HeightMap, r: usize, c: usize) -> f32 {
    let h = map.heights[[r, c]];
    let around = AROUND.map(|(dr, dc)| map.heights[[r + dr - 1, c + dc - 1]]);
    if around.iter().all(|n| !n.is_nan()) {
        return h - median_of_eight(around);
    }
    let mut measured: Vec<f32> = around.into_iter().filter(|n| !n.is_nan()).collect();
    if measured.len() < 5 {
        return f32::NAN;
    }
    measured.sort_unstable_by(f32::total_cmp);
    h - 0.5 * (measured[(measured.len() - 1) / 2] + measured[measured.len() / 2])
}

/// Compare-exchanges that sort eight numbers (Batcher's odd-even merge sort, 1968): no branches, a tenth of the time of a
/// general sort.
const NETWORK: [(usize, usize); 19] = [
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (1, 2),
    (5, 6),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
    (2, 4),
    (3, 5),
    (1, 2),
    (3, 4),
    (5, 6),
];

/// Mean of the two middle ones of eight numbers, none of them NaN.
fn median_of_eight(mut v: [f32; 8]) -> f32 {
    for (i, j) in NETWORK {
        let (low, high) = if v[j] < v[i] { (v[j], v[i]) } else { (v[i], v[j]) };
        (v[i], v[j]) = (low, high);
    }
    0.5 * (v[3] + v[4])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    /// A network sorts everything if it sorts every sequence of zeros and ones (Knuth, volume 3, theorem Z).
    #[test]
    fn the_network_sorts() {
        for bits in 0..256u32 {
            let mut v: [f32; 8] = std::array::from_fn(|k| (bits >> k & 1) as f32);
            let median = median_of_eight(v);
            v.sort_unstable_by(f32::total_cmp);
            assert_eq!(median, 0.5 * (v[3] + v[4]), "{bits:08b}");
        }
    }

    #[test]
    fn spikes_are_counted_and_steps_are_not() {
        let grid = synth::Grid { width: 200, height: 150, pitch: [1e-6; 2] };
        let raw = synth::gaussian(grid, synth::Gaussian { sq: 1e-7, acl: 6e-6, seed: 1, exact: true }).unwrap();
        let mut map = level::keep_tilt(&raw, Edges::Open);
        assert_eq!(find(&map, 0.0), None);
        // The edge of a deep pit is no spike.
        (0..400).for_each(|k| map.heights[[20 + k / 20, 20 + k % 20]] -= 2e-6);
        assert_eq!(find(&map, 0.0), None);
        for k in 0..7 {
            map.heights[[60 + 10 * k, 30 + 20 * k]] += if k % 2 == 0 { 1e-6 } else { -3e-6 };
        }
        let found = find(&map, 0.0).unwrap();
        assert_eq!(found.count, 7);
        assert!((found.largest - 3e-6).abs() < 5e-8 && found.slope_share > 0.1 && found.slope_share < 1.0, "{found:?}");
        // Spikes on a flat mirror carry all of the slope.
        let mut flat = HeightMap { heights: ndarray::Array2::zeros((50, 50)), ..map };
        flat.heights[[7, 9]] = 1e-9;
        let found = find(&flat, 0.0).unwrap();
        assert!(found.count == 1 && (found.slope_share - 1.0).abs() < 1e-12);
    }
}
