//! Holes filled with the smoothest surface that meets their rims.

use super::{Edges, HeightMap};
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;

/// Share of a map that may be filled unless the user says otherwise: more than this is invention.
pub const USUAL_LIMIT: f64 = 0.05;

/// What may be filled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fill {
    /// Largest share of the map that may be filled; more is an error.
    pub limit: f64,
    /// Holes of more points than this are left open.
    pub largest_hole: Option<usize>,
}

impl Default for Fill {
    fn default() -> Self {
        Fill { limit: USUAL_LIMIT, largest_hole: None }
    }
}

/// What was filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Filled {
    /// Points that were given a height.
    pub points: usize,
    /// Holes they were in; points that touch along an edge are in one hole.
    pub holes: usize,
    /// Points of the largest of them.
    pub largest_hole: usize,
    /// Points that were left missing.
    pub left: usize,
    /// Samples of the map.
    pub samples: usize,
    /// Whether every hole reached the stated convergence.
    pub converged: bool,
}

impl Filled {
    /// Share of the map that was filled.
    pub fn fraction(&self) -> f64 {
        self.points as f64 / self.samples as f64
    }
}

impl std::fmt::Display for Filled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "filled {} points ({:.2} %) in {} holes", self.points, 100.0 * self.fraction(), self.holes)?;
        if self.left > 0 {
            write!(f, ", {} points left missing", self.left)?;
        }
        Ok(())
    }
}

/// Solves `d2h/dx2 + d2h/dy2 = 0` in every hole, with the measured heights around it fixed.
///
/// Five-point differences with the pitches of the map; at an open border the slope across it is zero, periodic maps wrap.
/// Each hole by successive over-relaxation (Young 1954) until the estimated error is below 1e-6 of the range of heights on
/// its rim. Filled heights lie between the lowest and highest of the rim; slopes inside are smaller than they were.
///
/// # Errors
/// `Error::Parameter` if more than `limit` of the map would be filled, or the limit is not a share; the map is then
/// unchanged.
pub fn fill(map: &mut HeightMap, fill: Fill) -> Result<Filled> {
    if !(fill.limit >= 0.0 && fill.limit <= 1.0) {
        return Err(Error::parameter(
            format!("{} is not a share of the map", fill.limit),
            "give --fill a number between 0 and 1, such as 0.1",
        ));
    }
    let (rows, columns) = map.heights.dim();
    let grid = Grid { rows, columns, periodic: map.edges == Edges::Periodic };
    let heights: Vec<f32> = map.heights.iter().copied().collect();
    let mut holes = holes(&grid, &heights);
    let missing: usize = holes.iter().map(Vec::len).sum();
    holes.retain(|h| h.len() <= fill.largest_hole.unwrap_or(usize::MAX));
    let points: usize = holes.iter().map(Vec::len).sum();
    let filled = Filled {
        points,
        holes: holes.len(),
        largest_hole: holes.iter().map(Vec::len).max().unwrap_or(0),
        left: missing - points,
        samples: heights.len(),
        converged: true,
    };
    if filled.fraction() > fill.limit {
        return Err(Error::parameter(
            format!(
                "{:.2} % of the points are missing and may be filled only up to {:.2} %",
                100.0 * filled.fraction(),
                100.0 * fill.limit
            ),
            format!(
                "leave them missing, fill small holes only with --fill-hole 100, or allow it with --fill {:.2}",
                (filled.fraction() * 100.0).ceil() / 100.0
            ),
        ));
    }
    let weights = [1.0, (map.pitch_x / map.pitch_y).powi(2)];
    let solved: Vec<(Vec<f64>, bool)> = holes.par_iter().map(|hole| solve(&grid, &heights, hole, weights)).collect();
    let mut converged = true;
    for (hole, (values, reached)) in holes.iter().zip(&solved) {
        converged &= reached;
        for (k, value) in hole.iter().zip(values) {
            map.heights[[k / columns, k % columns]] = *value as f32;
        }
    }
    Ok(Filled { converged, ..filled })
}

struct Grid {
    rows: usize,
    columns: usize,
    periodic: bool,
}

impl Grid {
    /// Right, left, lower and upper neighbour.
    fn neighbours(&self, k: usize) -> [Option<usize>; 4] {
        let (r, c) = (k / self.columns, k % self.columns);
        let step = |at: usize, n: usize, forward: bool| {
            let wrapped = if forward { (at + 1) % n } else { (at + n - 1) % n };
            let inside = if forward { at + 1 < n } else { at > 0 };
            (inside || self.periodic).then_some(wrapped)
        };
        [
            step(c, self.columns, true).map(|c| r * self.columns + c),
            step(c, self.columns, false).map(|c| r * self.columns + c),
            step(r, self.rows, true).map(|r| r * self.columns + c),
            step(r, self.rows, false).map(|r| r * self.columns + c),
        ]
    }
}

/// Missing points in connected groups, each in rising order.
fn holes(grid: &Grid, heights: &[f32]) -> Vec<Vec<usize>> {
    let mut seen = vec![false; heights.len()];
    let mut found = Vec::new();
    for start in 0..heights.len() {
        if !heights[start].is_nan() || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut hole = vec![start];
        let mut next = 0;
        while next < hole.len() {
            for n in grid.neighbours(hole[next]).into_iter().flatten() {
                if heights[n].is_nan() && !seen[n] {
                    seen[n] = true;
                    hole.push(n);
                }
            }
            next += 1;
        }
        hole.sort_unstable();
        found.push(hole);
    }
    found
}

/// One unknown: its unknown neighbours, the weighted sum of its known ones and one over all weights.
struct Point {
    inside: [Option<u32>; 4],
    known: f64,
    scale: f64,
}

/// Heights of one hole, and whether they converged.
fn solve(grid: &Grid, heights: &[f32], hole: &[usize], weights: [f64; 2]) -> (Vec<f64>, bool) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut open = false;
    let points: Vec<Point> = hole
        .iter()
        .map(|k| {
            let mut point = Point { inside: [None; 4], known: 0.0, scale: 0.0 };
            for (side, n) in grid.neighbours(*k).into_iter().enumerate() {
                let Some(n) = n else {
                    open = true;
                    continue;
                };
                let weight = weights[side / 2];
                point.scale += weight;
                let h = f64::from(heights[n]);
                if h.is_nan() {
                    point.inside[side] = hole.binary_search(&n).ok().map(|i| i as u32);
                } else {
                    point.known += weight * h;
                    (low, high) = (low.min(h), high.max(h));
                }
            }
            point.scale = 1.0 / point.scale;
            point
        })
        .collect();
    let span = high - low;
    let mut values = vec![0.5 * (low + high); hole.len()];
    if span <= 0.0 {
        return (values, true);
    }
    let omega = relaxation(grid, hole, open, weights);
    // At or above the best factor the error shrinks by omega - 1 a sweep, so a change of d leaves at most d / (2 - omega).
    let enough = 1e-6 * span * (2.0 - omega);
    let most = 200 + (60.0 / (2.0 - omega)) as usize;
    for _ in 0..most {
        let mut change = 0.0f64;
        for (k, point) in points.iter().enumerate() {
            let mut sum = point.known;
            for (side, n) in point.inside.iter().enumerate() {
                if let Some(n) = n {
                    sum += weights[side / 2] * values[*n as usize];
                }
            }
            let step = omega * (sum * point.scale - values[k]);
            values[k] += step;
            change = change.max(step.abs());
        }
        if change <= enough {
            return (values, true);
        }
    }
    (values, false)
}

/// The best over-relaxation factor of the rectangle around the hole: `2 / (1 + sqrt(1 - mu^2))`, `mu` the spectral radius
/// of Jacobi's iteration. A hole within the rectangle has a smaller `mu`, and too large a factor costs little.
fn relaxation(grid: &Grid, hole: &[usize], open: bool, [wx, wy]: [f64; 2]) -> f64 {
    let range = |values: &mut dyn Iterator<Item = usize>| {
        let (a, b) = values.fold((usize::MAX, 0), |(a, b), v| (a.min(v), b.max(v)));
        (b - a + 1) as f64
    };
    // A border without a rim lets the slowest wave be twice as long.
    let stretch = if open { 2.0 } else { 1.0 };
    let across = stretch * range(&mut hole.iter().map(|k| k % grid.columns));
    let down = stretch * range(&mut hole.iter().map(|k| k / grid.columns));
    let cosine = |n: f64| (std::f64::consts::PI / (n + 1.0)).cos();
    let mu = (wx * cosine(across) + wy * cosine(down)) / (wx + wy);
    2.0 / (1.0 + (1.0 - mu * mu).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// A harmonic function of x and y, heights about 1e-6.
    fn harmonic(pitch: [f64; 2]) -> HeightMap {
        let heights = Array2::from_shape_fn((80, 120), |(r, c)| {
            let (x, y) = (c as f64 / 120.0, r as f64 * pitch[1] / (120.0 * pitch[0]));
            (1e-6 * (x * x - y * y + 0.3 * x * y + x)) as f32
        });
        HeightMap { heights, pitch_x: pitch[0], pitch_y: pitch[1], edges: Edges::Open, removed_slopes: [0.0; 2] }
    }

    #[test]
    fn a_harmonic_surface_comes_back() {
        // The five-point formula is exact for quadratics.
        for pitch in [[1e-6, 1e-6], [1e-6, 2.7e-6]] {
            let truth = harmonic(pitch);
            let mut map = truth.clone();
            let mut holes = 0;
            for ((r, c), h) in map.heights.indexed_iter_mut() {
                let disc = (r as f64 - 40.0).hypot(c as f64 - 60.0) < 25.0;
                let single = (r, c) == (3, 4) || (r, c) == (70, 110);
                let thin = (5..75).contains(&r) && c == r / 3 + 2;
                if disc || single || thin {
                    *h = f32::NAN;
                    holes += 1;
                }
            }
            let filled = fill(&mut map, Fill { limit: 0.5, largest_hole: None }).unwrap();
            assert!(filled.converged && filled.points == holes && filled.left == 0, "{filled:?}");
            let span = 1e-6;
            for (h, t) in map.heights.iter().zip(&truth.heights) {
                assert!((h - t).abs() < 4e-6 * span, "{h} {t}");
            }
        }
    }

    #[test]
    fn a_gap_across_a_periodic_seam_and_one_at_an_open_border() {
        // Only x varies, linearly between the rims: across the seam that is a ramp from the last to the first column.
        let heights = Array2::from_shape_fn((6, 40), |(_, c)| c as f32);
        let mut map =
            HeightMap { heights, pitch_x: 1.0, pitch_y: 2.0, edges: Edges::Periodic, removed_slopes: [0.0; 2] };
        for r in 0..6 {
            for c in [38, 39, 0, 1, 2] {
                map.heights[[r, c]] = f32::NAN;
            }
        }
        let mut open = HeightMap { edges: Edges::Open, ..map.clone() };
        let allowed = Fill { limit: 1.0, largest_hole: None };
        assert_eq!(fill(&mut map, allowed).unwrap().holes, 1);
        for (k, c) in [38, 39, 0, 1, 2].into_iter().enumerate() {
            let expected = 37.0 + (3.0 - 37.0) * (k + 1) as f32 / 6.0;
            assert!((map.heights[[2, c]] - expected).abs() < 1e-3, "{c}: {}", map.heights[[2, c]]);
        }
        // Zero slope across an open border continues the rim.
        assert_eq!(fill(&mut open, allowed).unwrap().holes, 2);
        assert!((open.heights[[3, 0]] - 3.0).abs() < 1e-4 && (open.heights[[3, 39]] - 37.0).abs() < 1e-4);
    }

    #[test]
    fn never_more_than_allowed_and_large_holes_stay_open_on_request() {
        let mut map = harmonic([1e-6, 1e-6]);
        (10..40).for_each(|r| (10..30).for_each(|c| map.heights[[r, c]] = f32::NAN));
        map.heights[[60, 60]] = f32::NAN;
        let before = map.missing_fraction();
        let refused = fill(&mut map, Fill::default()).unwrap_err().to_string();
        assert!(refused.contains("6.26 %") && refused.contains("--fill 0.07"), "{refused}");
        assert_eq!(map.missing_fraction(), before);
        let some = fill(&mut map, Fill { largest_hole: Some(100), ..Fill::default() }).unwrap();
        assert_eq!((some.points, some.holes, some.left), (1, 1, 600));
        assert!(fill(&mut map, Fill { limit: f64::NAN, largest_hole: None }).is_err());
        let all = fill(&mut map, Fill { limit: 0.07, largest_hole: None }).unwrap();
        assert_eq!((all.points, map.missing_fraction()), (600, 0.0));
        let none = fill(&mut map, Fill::default()).unwrap();
        assert_eq!((none.points, none.holes, none.converged), (0, 0, true));
    }
}
