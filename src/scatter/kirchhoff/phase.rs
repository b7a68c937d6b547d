//! The phase integral of one window at one `v_z`, by FFT.

use super::coherent::phase_factor;
use super::windows::Window;
use crate::heightmap::HeightMap;
use crate::math::fft;
use rayon::prelude::*;
use rustfft::{FftDirection, num_complex::Complex};

/// Power over the directions of one window: `e = |sum of W (exp(-j v_z h) - m) exp(-j v_xy . x)|^2 / (N sum of W^2)` per bin
/// of the N bins, so that the sum over all bins is the incoherent share of the light, `<|exp(-j v_z h) - m|^2>` (Parseval).
pub struct Spectrum {
    /// Columns and rows.
    pub size: [usize; 2],
    /// `v_z` [1/m].
    pub v_z: f64,
    /// Sampling distance along x and y \[m\].
    pub pitch: [f64; 2],
    /// Share of the light per bin, row by row, frequency zero first.
    pub energy: Vec<f32>,
}

impl Spectrum {
    /// Missing points have no weight, and since `m` is taken out before, the mirror beam is not diffracted by the gaps.
    pub fn measure(map: &HeightMap, window: &Window, v_z: f64, m: Complex<f64>) -> Spectrum {
        let [columns, rows] = window.size();
        let m = Complex::new(m.re as f32, m.im as f32);
        let mut field = vec![Complex::<f32>::default(); rows * columns];
        field.par_chunks_mut(columns).enumerate().for_each(|(r, row)| {
            let heights = map.heights.row(window.origin[1] + r);
            for (c, value) in row.iter_mut().enumerate() {
                let h = heights[window.origin[0] + c];
                if !h.is_nan() {
                    *value = (phase_factor(v_z, h) - m) * (window.taper[0][c] * window.taper[1][r]);
                }
            }
        });
        fft::transform(&mut field, rows, columns, FftDirection::Forward);
        let scale = 1.0 / (window.weight * (rows * columns) as f64);
        let energy = field.par_iter().map(|x| (f64::from(x.norm_sqr()) * scale) as f32).collect();
        Spectrum { size: [columns, rows], v_z, pitch: [map.pitch_x, map.pitch_y], energy }
    }

    /// Gives the mirror direction, which taking out the mean has emptied, the mean of its eight neighbours.
    pub fn fill_mirror_direction(&mut self) {
        let [columns, rows] = self.size;
        if columns < 3 || rows < 3 {
            return;
        }
        let mut sum = 0.0;
        for r in [0, 1, rows - 1] {
            for c in [0, 1, columns - 1] {
                sum += if r == 0 && c == 0 { 0.0 } else { self.energy[r * columns + c] };
            }
        }
        self.energy[0] = sum / 8.0;
    }

    /// Width of a bin in slope along x and y: `lambda / (N d (cos_theta_i + cos_theta_r))`.
    pub fn bin(&self) -> [f64; 2] {
        [0, 1].map(|k| std::f64::consts::TAU / (self.size[k] as f64 * self.pitch[k] * self.v_z))
    }

    /// Slope `(p, q) = -v_xy / v_z` at the centre of a bin; rows grow with -y.
    pub fn slope(&self, row: usize, column: usize) -> (f64, f64) {
        let [p, q] = self.bin();
        (-signed(column, self.size[0]) * p, signed(row, self.size[1]) * q)
    }
}

/// Frequency of index `k` of `n`.
fn signed(k: usize, n: usize) -> f64 {
    if 2 * k > n { k as f64 - n as f64 } else { k as f64 }
}
