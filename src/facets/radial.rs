//! Histogram of slopes by their distance from a centre.

use super::slopes;
use crate::heightmap::HeightMap;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rayon::prelude::*;

/// Bins per octave of the squared radius are `2^BIN_BITS`: the leading bits of its mantissa name them.
const BIN_BITS: u32 = 4;
const SHIFT: u32 = f32::MANTISSA_DIGITS - 1 - BIN_BITS;

/// Squared radii from 2^-66 to 2^22; what lies outside belongs to the outermost bins.
const FIRST: u32 = (127 - 66) << BIN_BITS;
const BINS: usize = (66 + 22) << BIN_BITS;

/// Rows per task.
const ROWS: usize = 32;

/// Facets per bin of the radius `|A (slope - centre)|`; the bins are 2 to 3 % wide.
#[derive(Debug, Clone)]
pub struct RadialHistogram(Vec<u64>);

impl RadialHistogram {
    /// Counts all facets; `rows` are the rows of A. Exact counts, so the order of threads cannot matter.
    pub fn measure(map: &HeightMap, centre: [f64; 2], rows: [[f64; 2]; 2]) -> Self {
        let (nx, ny) = slopes::cells(map);
        let (centre, rows) = (centre.map(|x| x as f32), rows.map(|row| row.map(|x| x as f32)));
        let starts: Vec<usize> = (0..ny).step_by(ROWS).collect();
        let counts = starts
            .into_par_iter()
            .fold(
                || vec![0u64; BINS],
                |mut sum, start| {
                    let level = Level::new();
                    // Neighbours often fall into the same bin; counting them apart does not wait for the last sum.
                    let mut counts = [vec![0u32; BINS + 1], vec![0u32; BINS + 1]];
                    let mut bins = vec![0u32; nx];
                    slopes::visit_lanes(map, start..(start + ROWS).min(ny), |p, q| {
                        dispatch!(level, simd => find_bins(simd, p, q, centre, rows, &mut bins));
                        let [even, odd] = &mut counts;
                        let mut pairs = bins.chunks_exact(2);
                        for pair in &mut pairs {
                            even[pair[0] as usize] += 1;
                            odd[pair[1] as usize] += 1;
                        }
                        pairs.remainder().iter().for_each(|&bin| even[bin as usize] += 1);
                    });
                    for counts in &counts {
                        sum.iter_mut().zip(counts).for_each(|(a, b)| *a += u64::from(*b));
                    }
                    sum
                },
            )
            .reduce(
                || vec![0u64; BINS],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(x, y)| *x += y);
                    a
                },
            );
        RadialHistogram(counts)
    }

    /// Radius and number of facets of each bin that has some, by radius.
    pub fn bins(&self) -> impl Iterator<Item = (f64, u64)> {
        self.0.iter().enumerate().filter(|(_, count)| **count > 0).map(|(k, &count)| {
            let edge = |k: usize| f64::from(f32::from_bits((k as u32 + FIRST) << SHIFT));
            ((0.5 * (edge(k) + edge(k + 1))).sqrt(), count)
        })
    }
}

/// Bins of a row of slopes; missing facets get the one behind the last.
#[simd]
fn find_bins<S: Simd>(_: S, p: &[f32], q: &[f32], centre: [f32; 2], rows: [[f32; 2]; 2], bins: &mut [u32]) {
    let n = bins.len();
    let (p, q) = (&p[..n], &q[..n]);
    for k in 0..n {
        let (p, q) = (p[k] - centre[0], q[k] - centre[1]);
        let (x, y) = (rows[0][0] * p + rows[0][1] * q, rows[1][0] * p + rows[1][1] * q);
        let square = x * x + y * y;
        let bits = square.to_bits() >> SHIFT;
        let bits = if bits > FIRST { bits } else { FIRST };
        let last = FIRST + BINS as u32 - 1;
        let bits = if bits < last { bits } else { last };
        bins[k] = if square.is_nan() { BINS as u32 } else { bits - FIRST };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::Edges;
    use ndarray::Array2;

    /// Against radii in f64, one facet at a time.
    #[test]
    fn every_facet_is_in_the_bin_of_its_radius() {
        let mut heights = Array2::from_shape_fn((40, 37), |(r, c)| ((r * r * 7 + 3 * c * c) % 101) as f32 * 1e-2);
        heights[[5, 5]] = f32::NAN;
        let map = HeightMap { heights, pitch_x: 2.0, pitch_y: 5.0, edges: Edges::Open, removed_slopes: [0.0; 2] };
        let (centre, rows) = ([0.1, -0.05], [[2.0, 1.0], [-0.5, 3.0]]);
        let histogram = RadialHistogram::measure(&map, centre, rows);
        let mut radii = Vec::new();
        for row in 0..slopes::cells(&map).1 {
            slopes::visit_row(&map, row, |f| {
                let (p, q) = (f.p - centre[0], f.q - centre[1]);
                radii.push((rows[0][0] * p + rows[0][1] * q).hypot(rows[1][0] * p + rows[1][1] * q));
            });
        }
        radii.sort_by(f64::total_cmp);
        let mut next = radii.iter();
        for (radius, count) in histogram.bins() {
            for _ in 0..count {
                let exact = next.next().unwrap();
                assert!((radius / exact - 1.0).abs() < 0.017, "{radius} {exact}");
            }
        }
        assert!(next.next().is_none());
    }
}
