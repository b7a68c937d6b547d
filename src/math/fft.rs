//! Two-dimensional Fourier transform over rows and columns.

use rayon::prelude::*;
use rustfft::{FftDirection, FftNum, FftPlanner, num_complex::Complex};

/// `X[k, l] = sum_rc x[r, c] exp(-+ 2 pi i (k r / rows + l c / columns))`, in place, not normalised.
///
/// `data` is row-major, `rows * columns` long; the sign is `-` for `Forward`, `+` for `Inverse`.
///
/// # Panics
/// If the length of `data` is not `rows * columns`.
pub fn transform<T: FftNum + Default>(
    data: &mut Vec<Complex<T>>,
    rows: usize,
    columns: usize,
    direction: FftDirection,
) {
    assert_eq!(data.len(), rows * columns);
    let mut planner = FftPlanner::new();
    for (count, length) in [(rows, columns), (columns, rows)] {
        let fft = planner.plan_fft(length, direction);
        // Eight rows a task: long enough to pay for the scratch, short enough to balance.
        data.par_chunks_mut(8 * length).for_each(|block| fft.process(block));
        *data = transpose(data, count, length);
    }
}

/// Blocked transpose of a `rows x columns` array: a plain one misses the cache on every write.
pub fn transpose<T: FftNum + Default>(data: &[Complex<T>], rows: usize, columns: usize) -> Vec<Complex<T>> {
    const BLOCK: usize = 32;
    let mut out = vec![Complex::default(); data.len()];
    out.par_chunks_mut(BLOCK * rows).enumerate().for_each(|(k, stripe)| {
        let first = k * BLOCK;
        let wide = stripe.len() / rows;
        for r0 in (0..rows).step_by(BLOCK) {
            for c in 0..wide {
                for r in r0..(r0 + BLOCK).min(rows) {
                    stripe[c * rows + r] = data[r * columns + first + c];
                }
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_sum_on_a_non_square_array() {
        let (rows, columns) = (35, 66);
        let input: Vec<Complex<f64>> =
            (0..rows * columns).map(|i| Complex::new(((i * i) % 17) as f64, ((i * 7) % 5) as f64)).collect();
        let mut fast = input.clone();
        transform(&mut fast, rows, columns, FftDirection::Forward);
        for (k, l) in [(0, 0), (3, 5), (34, 65), (17, 1)] {
            let mut sum = Complex::<f64>::default();
            for r in 0..rows {
                for c in 0..columns {
                    let angle =
                        -std::f64::consts::TAU * ((k * r) as f64 / rows as f64 + (l * c) as f64 / columns as f64);
                    sum += input[r * columns + c] * Complex::from_polar(1.0, angle);
                }
            }
            assert!((sum - fast[k * columns + l]).norm() < 1e-8);
        }
    }
}
