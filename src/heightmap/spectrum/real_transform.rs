//! Two-dimensional Fourier transform of real heights in the memory of the heights.
//!
//! Half of the transform of real numbers mirrors the other half, so only the columns of non-negative frequency are
//! kept; they are stored in f32 (the heights have no more digits) and computed in f64.

use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};

/// Columns kept side by side: one cache line of a row.
const STRIP: usize = 8;

/// Row pairs transformed before they are sorted into strips.
const BATCH: usize = 64;

/// `X[k, l] = sum_rc x[r, c] exp(-2 pi i (k r / rows + l c / columns))` for `l = 0 ..= columns / 2`, not normalised;
/// along the rows first, then, column by column, wherever a caller asks.
pub(super) struct HalfSpectrum {
    rows: usize,
    columns: usize,
    /// Strip `s` holds columns `s * STRIP ..`, row by row.
    strips: Vec<Vec<Complex<f32>>>,
}

impl HalfSpectrum {
    /// Transforms along the rows; `fill` writes row `r < filled` (`columns` numbers, zero before), the rest is zero.
    ///
    /// f32 holds the result, so the numbers should be of order 1.
    pub fn of_rows(rows: usize, columns: usize, filled: usize, fill: impl Fn(usize, &mut [f64]) + Sync) -> Self {
        let kept = columns / 2 + 1;
        let widths = (0..kept).step_by(STRIP).map(|first| STRIP.min(kept - first));
        let mut strips: Vec<_> = widths.map(|w| vec![Complex::<f32>::default(); w * rows]).collect();
        let fft = FftPlanner::new().plan_fft_forward(columns);
        let pairs: Vec<usize> = (0..filled.min(rows)).step_by(2).collect();
        for batch in pairs.chunks(BATCH) {
            // Two real rows are the real and imaginary part of one complex row.
            let transformed: Vec<[Vec<Complex<f32>>; 2]> = batch
                .par_iter()
                .map(|&r| {
                    let mut pair = [vec![0.0; columns], vec![0.0; columns]];
                    fill(r, &mut pair[0]);
                    if r + 1 < filled {
                        fill(r + 1, &mut pair[1]);
                    }
                    let mut both: Vec<_> = pair[0].iter().zip(&pair[1]).map(|(&a, &b)| Complex::new(a, b)).collect();
                    fft.process(&mut both);
                    let part = |k: usize, second: bool| {
                        let (z, w) = (both[k], both[(columns - k) % columns].conj());
                        let half = if second { (z - w) * Complex::new(0.0, -0.5) } else { (z + w) * 0.5 };
                        Complex::new(half.re as f32, half.im as f32)
                    };
                    [false, true].map(|second| (0..kept).map(|k| part(k, second)).collect())
                })
                .collect();
            for (&r, pair) in batch.iter().zip(&transformed) {
                for (row, values) in (r..filled.min(rows)).zip(pair) {
                    for (strip, values) in strips.iter_mut().zip(values.chunks(STRIP)) {
                        strip[row * values.len()..][..values.len()].copy_from_slice(values);
                    }
                }
            }
        }
        HalfSpectrum { rows, columns, strips }
    }

    /// Transforms strip by strip along the columns and hands each finished column to `visit(l, column, result)`.
    ///
    /// Returns one result per strip, left to right.
    pub fn fold_columns<T: Default + Send>(&self, visit: impl Fn(usize, &[Complex<f64>], &mut T) + Sync) -> Vec<T> {
        let fft = FftPlanner::new().plan_fft_forward(self.rows);
        let results = self.strips.par_iter().enumerate().map(|(s, strip)| {
            let mut result = T::default();
            let mut columns = self.gathered(strip);
            fft.process(&mut columns);
            for (k, column) in columns.chunks(self.rows).enumerate() {
                visit(s * STRIP + k, column, &mut result);
            }
            result
        });
        results.collect()
    }

    /// Replaces every value by its squared magnitude and transforms back along the columns, divided by their length
    /// and `scale`.
    pub fn square(&mut self, scale: f64) {
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(self.rows), planner.plan_fft_inverse(self.rows));
        let rows = self.rows;
        let factor = 1.0 / (rows as f64 * scale);
        let strips = std::mem::take(&mut self.strips);
        self.strips = strips
            .into_par_iter()
            .map(|mut strip| {
                let mut columns = self.gathered(&strip);
                forward.process(&mut columns);
                columns.iter_mut().for_each(|z| *z = Complex::new(z.norm_sqr() * factor, 0.0));
                inverse.process(&mut columns);
                let width = strip.len() / rows;
                for (i, value) in strip.iter_mut().enumerate() {
                    let z = columns[i % width * rows + i / width];
                    *value = Complex::new(z.re as f32, z.im as f32);
                }
                strip
            })
            .collect();
    }

    /// Columns of a strip, one after the other, in f64.
    fn gathered(&self, strip: &[Complex<f32>]) -> Vec<Complex<f64>> {
        let width = strip.len() / self.rows;
        let mut columns = Vec::with_capacity(strip.len());
        for k in 0..width {
            let column = strip.iter().skip(k).step_by(width);
            columns.extend(column.map(|z| Complex::new(f64::from(z.re), f64::from(z.im))));
        }
        columns
    }

    /// Real rows `wanted` after transforming back along them, divided by their length: the first `take` numbers each.
    pub fn rows_back(&self, wanted: &[usize], take: usize) -> Vec<Vec<f32>> {
        let fft = FftPlanner::new().plan_fft_inverse(self.columns);
        let kept = self.columns / 2 + 1;
        let row = |r: usize| -> Vec<Complex<f64>> {
            let pieces = self.strips.iter().flat_map(|strip| {
                let width = strip.len() / self.rows;
                strip[r * width..][..width].iter()
            });
            pieces.map(|z| Complex::new(f64::from(z.re), f64::from(z.im))).collect()
        };
        let pairs: Vec<Vec<Vec<f32>>> = wanted
            .par_chunks(2)
            .map(|pair| {
                let a = row(pair[0]);
                let b = if pair.len() > 1 { row(pair[1]) } else { vec![Complex::default(); kept] };
                let mut both: Vec<Complex<f64>> = (0..self.columns)
                    .map(|k| {
                        let i = Complex::<f64>::i();
                        if k < kept {
                            a[k] + i * b[k]
                        } else {
                            (a[self.columns - k].conj()) + i * b[self.columns - k].conj()
                        }
                    })
                    .collect();
                fft.process(&mut both);
                let scale = 1.0 / self.columns as f64;
                let real = both[..take].iter().map(|z| (z.re * scale) as f32).collect();
                let imaginary = both[..take].iter().map(|z| (z.im * scale) as f32).collect();
                if pair.len() > 1 { vec![real, imaginary] } else { vec![real] }
            })
            .collect();
        pairs.into_iter().flatten().collect()
    }

    /// How often column `l` stands in the whole transform: twice, but for the columns that mirror onto themselves.
    pub fn multiplicity(&self, l: usize) -> f64 {
        if l == 0 || 2 * l == self.columns { 1.0 } else { 2.0 }
    }
}

/// Smallest length of at least `n` with no prime factor above 5, which the transform is fast for.
pub(super) fn fast_length(n: usize) -> usize {
    let smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    (n.max(1)..).find(|&n| smooth(n)).unwrap_or(n)
}

/// Signed frequency of index `k` of `n` [cycles per length of the map].
pub(super) fn signed(k: usize, n: usize) -> f64 {
    if 2 * k > n { k as f64 - n as f64 } else { k as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(r: usize, c: usize) -> f64 {
        ((r * 7 + c * c * 3) % 11) as f64 / 11.0 - 0.4
    }

    #[test]
    fn columns_agree_with_the_sum_for_even_and_odd_sides() {
        for (rows, columns, filled) in [(9, 20, 9), (12, 31, 7), (1, 5, 1)] {
            let half = HalfSpectrum::of_rows(rows, columns, filled, |r, row| {
                row.iter_mut().enumerate().for_each(|(c, v)| *v = number(r, c));
            });
            let found: Vec<Vec<(usize, Vec<Complex<f64>>)>> =
                half.fold_columns(|l, column, all: &mut Vec<_>| all.push((l, column.to_vec())));
            let found: Vec<_> = found.into_iter().flatten().collect();
            assert_eq!(found.len(), columns / 2 + 1);
            for (l, column) in found {
                for (k, value) in column.iter().enumerate() {
                    let mut sum = Complex::<f64>::default();
                    for r in 0..filled {
                        for c in 0..columns {
                            let turns = (k * r) as f64 / rows as f64 + (l * c) as f64 / columns as f64;
                            sum += number(r, c) * Complex::from_polar(1.0, -std::f64::consts::TAU * turns);
                        }
                    }
                    assert!((sum - value).norm() < 1e-5, "{k} {l}: {sum} {value}");
                }
            }
        }
    }

    #[test]
    fn the_square_transformed_back_is_the_circular_correlation() {
        for (rows, columns) in [(7, 18), (10, 21)] {
            let mut half = HalfSpectrum::of_rows(rows, columns, rows, |r, row| {
                row.iter_mut().enumerate().for_each(|(c, v)| *v = number(r, c));
            });
            half.square(2.0);
            let wanted: Vec<usize> = (0..rows).collect();
            for (dr, row) in half.rows_back(&wanted, columns).iter().enumerate() {
                for (dc, &value) in row.iter().enumerate() {
                    let sum: f64 = (0..rows * columns)
                        .map(|i| (i / columns, i % columns))
                        .map(|(r, c)| number(r, c) * number((r + dr) % rows, (c + dc) % columns))
                        .sum();
                    assert!((sum / 2.0 - f64::from(value)).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn fast_lengths() {
        assert_eq!([1, 7, 11, 97, 1025, 1537].map(fast_length), [1, 8, 12, 100, 1080, 1600]);
        assert_eq!([signed(0, 4), signed(2, 4), signed(3, 4), signed(3, 5)], [0.0, 2.0, -1.0, -2.0]);
    }
}
