//! Hybrid parameters of ISO 25178-2:2012, 4.3: slopes and area, from the facets that scatter the light.

use super::heights::contiguous;
use super::lanes::{LANES, Lane, add, each, runs};
use crate::heightmap::{Edges, HeightMap};
use rayon::prelude::*;

/// `Sdq = sqrt <p^2 + q^2>`, `Sdr = <sqrt(1 + p^2 + q^2) - 1>` over the facets of slopes `p = dh/dx`, `q = dh/dy`.
///
/// Source: ISO 25178-2:2012, 4.3. The facets are the two triangles of every cell that the scattering uses, so `p` and
/// `q` are forward differences of neighbouring heights (the standard leaves the difference formula open; programs with
/// five- or seven-point formulas find smaller slopes on rough maps). Triangles with a missing vertex do not count.
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

impl Gradient {
    /// One reading of the map, no copy of it; the same numbers for any number of threads. All 0 without facets.
    pub fn measure(map: &HeightMap) -> Self {
        let wraps = map.edges == Edges::Periodic;
        let cell_rows = if wraps { map.height() } else { map.height().saturating_sub(1) };
        let sums: Vec<[f64; 4]> = (0..cell_rows)
            .into_par_iter()
            .map(|r| {
                let row = |r: usize| {
                    let mut row = contiguous(map.heights.row(r % map.height()));
                    if wraps {
                        let first = row[0];
                        row.to_mut().push(first);
                    }
                    row
                };
                cell_row(&row(r), &row(r + 1), [map.pitch_x, map.pitch_y])
            })
            .collect();
        let mut total = [0.0; 4];
        for row in sums {
            total.iter_mut().zip(row).for_each(|(t, s)| *t += s);
        }
        let [n, pp, qq, excess] = total;
        if n == 0.0 {
            return Gradient::default();
        }
        Gradient {
            facets: n as u64,
            rms: [(pp / n).sqrt(), (qq / n).sqrt()],
            sdq: ((pp + qq) / n).sqrt(),
            sdr: excess / n,
        }
    }
}

/// Count, `p^2`, `q^2` and `sqrt(1 + p^2 + q^2) - 1`, summed over the triangles between two rows.
fn cell_row(top: &[f32], bottom: &[f32], pitch: [f64; 2]) -> [f64; 4] {
    let cells = top.len().min(bottom.len()) - 1;
    // A missing height makes every sum NaN: most rows have none and are spared the test of each facet.
    let whole = sums::<false>(top, bottom, pitch, cells);
    if whole[1].is_nan() || whole[2].is_nan() { sums::<true>(top, bottom, pitch, cells) } else { whole }
}

fn sums<const GAPS: bool>(top: &[f32], bottom: &[f32], pitch: [f64; 2], cells: usize) -> [f64; 4] {
    let (sx, sy) = (1.0 / pitch[0], 1.0 / pitch[1]);
    let corners = [&top[..cells], &top[1..=cells], &bottom[..cells], &bottom[1..=cells]];
    let mut sums = [[0.0; LANES]; 4];
    // Filled up with flat facets, which add nothing; those of a row with gaps are not counted.
    runs(corners, if GAPS { f32::NAN } else { 0.0 }, |[a, b, c, d]| {
        let slope = |from: &[f32; LANES], to: &[f32; LANES], scale: f64| {
            each(|k| (f64::from(to[k]) - f64::from(from[k])) * scale)
        };
        triangles::<GAPS>(&mut sums, slope(c, d, sx), slope(c, a, sy));
        triangles::<GAPS>(&mut sums, slope(a, b, sx), slope(d, b, sy));
    });
    let mut sums = sums.map(|lane| lane.iter().sum());
    if !GAPS {
        sums[0] = 2.0 * cells as f64;
    }
    sums
}

/// Adds eight triangles of slopes `p`, `q` to the sums; one with a missing vertex has a NaN slope and adds nothing.
#[inline(always)]
fn triangles<const GAPS: bool>(sums: &mut [Lane; 4], mut p: Lane, mut q: Lane) {
    if GAPS {
        let measured = each(|k| if (p[k] + q[k]).is_nan() { 0.0 } else { 1.0 });
        add(&mut sums[0], &measured);
        p = each(|k| if measured[k] > 0.0 { p[k] } else { 0.0 });
        q = each(|k| if measured[k] > 0.0 { q[k] } else { 0.0 });
    }
    let (pp, qq) = (each(|k| p[k] * p[k]), each(|k| q[k] * q[k]));
    add(&mut sums[1], &pp);
    add(&mut sums[2], &qq);
    // e = sqrt(1 + g) - 1 has lost the digits that 1 + g dropped, which are all of them on a polished surface. One step
    // towards e (2 + e) = g brings them back and is cheaper than the division of g / (1 + sqrt(1 + g)).
    let g = each(|k| pp[k] + qq[k]);
    let e = each(|k| (1.0 + g[k]).sqrt() - 1.0);
    add(&mut sums[3], &each(|k| e[k] + 0.5 * (g[k] - e[k] * (2.0 + e[k]))));
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

    #[test]
    fn agrees_with_the_facets_one_by_one() {
        let mut heights = Array2::from_shape_fn((17, 29), |(r, c)| ((r * r * 7 + c * c * 3) % 31) as f32);
        heights[[4, 5]] = f32::NAN;
        heights[[16, 28]] = f32::NAN;
        for edges in [Edges::Open, Edges::Periodic] {
            let m = map(heights.clone(), edges);
            let s = crate::facets::SlopeStatistics::measure(&m).unwrap();
            let g = Gradient::measure(&m);
            assert_eq!(g.facets, s.facets);
            assert!((g.sdq / s.sdq - 1.0).abs() < 1e-13 && (g.rms[1] / s.rms[1] - 1.0).abs() < 1e-13);
        }
    }
}
