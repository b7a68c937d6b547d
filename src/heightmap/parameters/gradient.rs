//! Hybrid parameters of ISO 25178-2:2012, 4.3: slopes and area, from the mesh that scatters the light.

use super::heights::contiguous;
use super::lanes::{LANES, Lane, add, each, runs};
use crate::heightmap::{Edges, HeightMap};
use rayon::prelude::*;

/// `Sdq = sqrt(<p^2> + <q^2>)` with the slopes `p` of all mesh edges along x and `q` along y;
/// `Sdr = <sqrt(1 + p^2 + q^2) - 1>` over the facets.
///
/// Source: ISO 25178-2:2012, 4.3. Mesh and facets are those of the scattering: every cell is two triangles with one edge
/// along each axis, so `p` and `q` are forward differences of neighbours (the standard leaves the formula open; five- or
/// seven-point formulas find smaller slopes on rough maps). Each edge counts once, whether or not the rest of its
/// facets is measured; on a map without gaps that is the mean over the facets but for those at the border.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gradient {
    /// Facets with three measured vertices.
    pub facets: u64,
    /// Root-mean-square slopes along x and y, about zero.
    pub rms: [f64; 2],
    /// Root-mean-square gradient.
    pub sdq: f64,
    /// Developed area over projected area, less 1: a ratio, not per cent.
    pub sdr: f64,
}

/// Numbers and squared slopes of edges along x and along y, number of facets and what their area exceeds the plan by.
type Sums = [f64; 6];

impl Gradient {
    /// One reading of the map, no copy of it; the same numbers for any number of threads. All 0 without facets.
    pub fn measure(map: &HeightMap) -> Self {
        let rows = map.height();
        let wraps = map.edges == Edges::Periodic;
        let sums: Vec<Sums> = (0..rows)
            .into_par_iter()
            .map(|r| {
                let row = |r: usize| {
                    let mut row = contiguous(map.heights.row(r % rows));
                    if wraps {
                        let first = row[0];
                        row.to_mut().push(first);
                    }
                    row
                };
                // Below the last row of an open map there is nothing; its edges along x remain.
                let below = (wraps || r + 1 < rows).then(|| row(r + 1));
                below.map_or_else(
                    || border([&row(r)[1..], &row(r)], 1.0 / map.pitch_x, 0),
                    |below| cell_row(&row(r), &below, [1.0 / map.pitch_x, 1.0 / map.pitch_y], wraps),
                )
            })
            .collect();
        let mut total = Sums::default();
        for row in sums {
            total.iter_mut().zip(row).for_each(|(t, s)| *t += s);
        }
        let mean = |sum: usize, count: usize| if total[count] > 0.0 { total[sum] / total[count] } else { 0.0 };
        let (pp, qq) = (mean(1, 0), mean(3, 2));
        Gradient { facets: total[4] as u64, rms: [pp.sqrt(), qq.sqrt()], sdq: (pp + qq).sqrt(), sdr: mean(5, 4) }
    }
}

/// Edges and facets between a row and the one below it, with the edges of the upper row but not of the lower.
fn cell_row(top: &[f32], bottom: &[f32], per_pitch: [f64; 2], wraps: bool) -> Sums {
    let cells = top.len().min(bottom.len()) - 1;
    // A missing height makes every sum NaN: most rows have none and are spared the test of each facet.
    let mut sums = cells_of::<false>(top, bottom, per_pitch, cells);
    if sums.iter().any(|s| s.is_nan()) {
        sums = cells_of::<true>(top, bottom, per_pitch, cells);
    }
    if !wraps {
        let last = border([&top[cells..], &bottom[cells..]], per_pitch[1], 2);
        sums.iter_mut().zip(last).for_each(|(s, l)| *s += l);
    }
    sums
}

fn cells_of<const GAPS: bool>(top: &[f32], bottom: &[f32], per_pitch: [f64; 2], cells: usize) -> Sums {
    let corners = [&top[..cells], &top[1..=cells], &bottom[..cells], &bottom[1..=cells]];
    let mut sums = [[0.0; LANES]; 6];
    // Filled up with flat facets, which add nothing; those of a row with gaps are not counted.
    runs(corners, if GAPS { f32::NAN } else { 0.0 }, |[a, b, c, d]| {
        let slope = |from: &[f32; LANES], to: &[f32; LANES], scale: f64| {
            each(|k| (f64::from(to[k]) - f64::from(from[k])) * scale)
        };
        let [sx, sy] = per_pitch;
        // The upper triangle has the upper edge, the lower one the left edge of the cell.
        let (upper, left) = (slope(a, b, sx), slope(c, a, sy));
        let (lower, right) = (slope(c, d, sx), slope(d, b, sy));
        let squared = |p: &Lane| each(|k| p[k] * p[k]);
        let (upper, left, lower, right) = (squared(&upper), squared(&left), squared(&lower), squared(&right));
        edges::<GAPS>(&mut sums, 0, &upper);
        edges::<GAPS>(&mut sums, 2, &left);
        triangles::<GAPS>(&mut sums, &upper, &right);
        triangles::<GAPS>(&mut sums, &lower, &left);
    });
    let mut sums = sums.map(|lane| lane.iter().sum());
    if !GAPS {
        (sums[0], sums[2], sums[4]) = (cells as f64, cells as f64, 2.0 * cells as f64);
    }
    sums
}

#[inline(always)]
fn edges<const GAPS: bool>(sums: &mut [Lane; 6], first: usize, squared: &Lane) {
    if GAPS {
        add(&mut sums[first], &each(|k| if squared[k].is_nan() { 0.0 } else { 1.0 }));
        add(&mut sums[first + 1], &each(|k| if squared[k].is_nan() { 0.0 } else { squared[k] }));
    } else {
        add(&mut sums[first + 1], squared);
    }
}

/// Adds the areas of eight triangles with the squared slopes `pp`, `qq`; one with a missing vertex adds nothing.
#[inline(always)]
fn triangles<const GAPS: bool>(sums: &mut [Lane; 6], pp: &Lane, qq: &Lane) {
    let mut g = each(|k| pp[k] + qq[k]);
    if GAPS {
        add(&mut sums[4], &each(|k| if g[k].is_nan() { 0.0 } else { 1.0 }));
        g = each(|k| if g[k].is_nan() { 0.0 } else { g[k] });
    }
    // e = sqrt(1 + g) - 1 has lost the digits that 1 + g dropped, which are all of them on a polished surface. One step
    // towards e (2 + e) = g brings them back and is cheaper than the division of g / (1 + sqrt(1 + g)).
    let e = each(|k| (1.0 + g[k]).sqrt() - 1.0);
    add(&mut sums[5], &each(|k| e[k] + 0.5 * (g[k] - e[k] * (2.0 + e[k]))));
}

/// Edges that border one side of a facet only: along the last row (`first` = 0) or the last column (`first` = 2).
fn border([to, from]: [&[f32]; 2], per_pitch: f64, first: usize) -> Sums {
    let mut sums = Sums::default();
    for (&to, &from) in to.iter().zip(from) {
        let slope = (f64::from(to) - f64::from(from)) * per_pitch;
        if !slope.is_nan() {
            sums[first] += 1.0;
            sums[first + 1] += slope * slope;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use std::f64::consts::{PI, TAU};

    fn map(heights: Array2<f32>, edges: Edges) -> HeightMap {
        HeightMap { heights, pitch_x: 2.0, pitch_y: 5.0, edges, removed_slopes: [0.0; 2] }
    }

    /// A plane: `Sdq^2 = p^2 + q^2`, `Sdr = sqrt(1 + Sdq^2) - 1`, steep and as shallow as a polished mirror.
    #[test]
    fn ramps() {
        for scale in [1.0, 1e-5] {
            let (p, q) = (0.75 * scale, -0.5 * scale);
            let plane = Array2::from_shape_fn((9, 21), |(r, c)| (p * 2.0 * c as f64 - q * 5.0 * r as f64) as f32);
            let g = Gradient::measure(&map(plane, Edges::Open));
            let square: f64 = p * p + q * q;
            assert_eq!(g.facets, 2 * 8 * 20);
            assert!((g.sdq / square.sqrt() - 1.0).abs() < 1e-6 && (g.rms[0] / p - 1.0).abs() < 1e-6, "{g:?}");
            let sdr = square / (1.0 + (1.0 + square).sqrt());
            assert!((g.sdr / sdr - 1.0).abs() < 1e-6, "{g:?} {sdr}");
        }
    }

    /// Forward differences of `A sin(k x)` are `(2 A / d) sin(k d / 2) cos(k x + ..)`: rms over whole periods in closed
    /// form, at any sampling; the area of a corrugation is an elliptic integral.
    #[test]
    fn sinusoid() {
        for samples in [8, 64, 1024] {
            let wave =
                Array2::from_shape_fn((16, samples), |(_, c)| (3.0 * (TAU * c as f64 / samples as f64).sin()) as f32);
            let g = Gradient::measure(&map(wave, Edges::Periodic));
            let sdq = 3.0 / 2.0 * 2.0 * (PI / samples as f64).sin() / 2f64.sqrt();
            assert!((g.sdq / sdq - 1.0).abs() < 1e-6 && g.rms[1] == 0.0, "{samples}: {g:?}");
            let amplitude = sdq * 2f64.sqrt();
            let steps = 100_000;
            let length: f64 = (0..steps)
                .map(|k| (1.0 + (amplitude * (TAU * (f64::from(k) + 0.5) / f64::from(steps)).cos()).powi(2)).sqrt())
                .sum::<f64>()
                / f64::from(steps);
            if samples == 1024 {
                // f32 heights cost 3e-8 of the amplitude per difference of 6e-3 of it.
                assert!((g.sdr / (length - 1.0) - 1.0).abs() < 1e-6, "{g:?} {length}");
            }
        }
    }

    /// Edge by edge and facet by facet, with gaps in the middle and at the border.
    #[test]
    fn agrees_with_edges_and_facets_one_by_one() {
        let mut heights = Array2::from_shape_fn((17, 29), |(r, c)| ((r * r * 7 + c * c * 3) % 31) as f32);
        for gaps in [false, true] {
            for edges in [Edges::Open, Edges::Periodic] {
                let m = map(heights.clone(), edges);
                let g = Gradient::measure(&m);
                let (mut facets, mut excess) = (0u64, 0.0);
                for row in 0..if edges == Edges::Open { 16 } else { 17 } {
                    crate::facets::slopes::visit_row(&m, row, |f| {
                        facets += 1;
                        excess += (1.0 + f.p * f.p + f.q * f.q).sqrt() - 1.0;
                    });
                }
                assert_eq!(g.facets, facets);
                assert!((g.sdr / (excess / facets as f64) - 1.0).abs() < 1e-12);
                let slopes = |dr: usize, dc: usize, pitch: f64| {
                    let wraps = edges == Edges::Periodic;
                    let pairs = (0..17).flat_map(|r| (0..29).map(move |c| (r, c)));
                    let inside = pairs.filter(|(r, c)| wraps || (r + dr < 17 && c + dc < 29));
                    let at = |r: usize, c: usize| f64::from(m.heights[[r % 17, c % 29]]);
                    let squares = inside.map(|(r, c)| ((at(r + dr, c + dc) - at(r, c)) / pitch).powi(2));
                    let squares: Vec<f64> = squares.filter(|s| !s.is_nan()).collect();
                    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
                };
                let expected = [slopes(0, 1, 2.0), slopes(1, 0, 5.0)];
                for (found, expected) in g.rms.into_iter().zip(expected) {
                    assert!((found / expected - 1.0).abs() < 1e-12, "{g:?} {expected}");
                }
            }
            if !gaps {
                heights[[4, 5]] = f32::NAN;
                heights[[16, 28]] = f32::NAN;
                heights[[16, 3]] = f32::NAN;
                heights[[9, 28]] = f32::NAN;
            }
        }
    }
}
