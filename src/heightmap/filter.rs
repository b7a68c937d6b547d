//! Gaussian areal filters.

use super::{Edges, HeightMap};
use crate::error::{Error, Result};
use crate::math::fft::transpose;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex};
use serde::Serialize;
use std::sync::Arc;

/// Which waves a filter lets through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// S-filter: removes waves shorter than the cut-off.
    Long,
    /// L-filter: removes waves longer than the cut-off.
    Short,
}

/// Share of the amplitude that a low-pass of this cut-off \[m\] transmits at a spatial frequency \[1/m\]:
/// `exp(-pi (alpha lambda_c f)^2) = 2^-(lambda_c f)^2`, `alpha = sqrt(ln 2 / pi)`: half at the cut-off.
pub fn transmission(cut_off: f64, frequency: f64) -> f64 {
    (-(cut_off * frequency).powi(2)).exp2()
}

/// Distance, in cut-offs, at which the weight is treated as zero beyond an open edge.
///
/// There it is `exp(-pi (1.5 / alpha)^2) = 1e-14` of its peak: the truncation is below f64 rounding of the sums.
const REACH: f64 = 1.5;

/// `h <- sum w h / sum w` with `w(x, y) = exp(-pi (x^2 + y^2) / (alpha lambda_c)^2)`, or `h` minus that.
///
/// Linear areal Gaussian filter, ISO 16610-61:2015. The sums run over the measured points only, so gaps and edges draw on
/// the neighbours there are; missing points stay missing. Periodic maps wrap, mirrored maps are mirrored at their first and
/// last sample, open maps end. A wave of length `lambda` along an axis keeps `2^-(lambda_c / lambda)^2` of its amplitude:
/// to rounding on complete periodic maps, and elsewhere a cut-off away from edges and gaps to 1e-6 for cut-offs of ten
/// pitches or more. Shorter ones ring at edges because sampling cuts their transmission off (2e-4 at five pitches).
///
/// Separable, each axis by FFT with the continuous filter's transmission, so that cost does not grow with the cut-off and
/// the sampling does not change the filter. Takes 32 bytes a point.
///
/// # Errors
/// `Error::Parameter` if the cut-off \[m\] is below two pitches or above the longer side of the map.
pub fn gaussian(map: &mut HeightMap, cut_off: f64, pass: Pass) -> Result<()> {
    check(map, cut_off)?;
    let (rows, columns) = map.heights.dim();
    let mean = mean_of(map);
    let mut field: Vec<Complex<f64>> = map
        .heights
        .iter()
        .map(|h| if h.is_nan() { Complex::default() } else { Complex::new(f64::from(*h) - mean, 1.0) })
        .collect();
    // The weights are real, so the heights (real part) and the weights present (imaginary part) travel in one transform.
    Line::new(columns, map.pitch_x, cut_off, map.edges).run(&mut field);
    field = transpose(&field, rows, columns);
    Line::new(rows, map.pitch_y, cut_off, map.edges).run(&mut field);
    field = transpose(&field, columns, rows);
    for (h, f) in map.heights.iter_mut().zip(&field).filter(|p| !p.0.is_nan()) {
        let long = mean + f.re / f.im;
        *h = match pass {
            Pass::Long => long as f32,
            Pass::Short => (f64::from(*h) - long) as f32,
        };
    }
    Ok(())
}

fn check(map: &HeightMap, cut_off: f64) -> Result<()> {
    let shortest = 2.0 * map.pitch_x.max(map.pitch_y);
    let longest = (map.pitch_x * map.width() as f64).max(map.pitch_y * map.height() as f64);
    if cut_off >= shortest && cut_off <= longest {
        return Ok(());
    }
    Err(Error::parameter(
        format!("a filter of cut-off {} um does not suit this map", cut_off * 1e6),
        format!(
            "choose a cut-off between two pitches ({:.6} um) and the side of the map ({:.6} um)",
            shortest * 1e6,
            longest * 1e6
        ),
    ))
}

fn mean_of(map: &HeightMap) -> f64 {
    let (mut n, mut sum) = (0.0, 0.0);
    for h in map.heights.iter().filter(|h| !h.is_nan()) {
        n += 1.0;
        sum += f64::from(*h);
    }
    sum / f64::max(n, 1.0)
}

/// The filter along one axis.
struct Line {
    samples: usize,
    edges: Edges,
    /// Transmission of every Fourier component, divided by their number.
    transfer: Vec<f64>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl Line {
    fn new(samples: usize, pitch: f64, cut_off: f64, edges: Edges) -> Self {
        let length = match edges {
            Edges::Periodic => samples,
            // The border sample is shared by the map and its mirror image.
            Edges::Mirrored => 2 * (samples - 1),
            Edges::Open => fast_length(samples + (REACH * cut_off / pitch).ceil() as usize),
        };
        let transfer = (0..length)
            .map(|k| transmission(cut_off, k.min(length - k) as f64 / (length as f64 * pitch)) / length as f64)
            .collect();
        let mut planner = FftPlanner::new();
        Line {
            samples,
            edges,
            transfer,
            forward: planner.plan_fft_forward(length),
            inverse: planner.plan_fft_inverse(length),
        }
    }

    /// Filters every row of a row-major field.
    fn run(&self, field: &mut [Complex<f64>]) {
        let length = self.transfer.len();
        let n = self.samples;
        let scratch = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        field.par_chunks_mut(n).for_each_init(
            || (vec![Complex::default(); length], vec![Complex::default(); scratch]),
            |(line, scratch), row| {
                line[..n].copy_from_slice(row);
                line[n..].fill(Complex::default());
                if self.edges == Edges::Mirrored {
                    for k in 1..n - 1 {
                        line[length - k] = row[k];
                    }
                }
                self.forward.process_with_scratch(line, scratch);
                line.iter_mut().zip(&self.transfer).for_each(|(v, t)| *v *= t);
                self.inverse.process_with_scratch(line, scratch);
                row.copy_from_slice(&line[..n]);
            },
        );
    }
}

/// Smallest length from `least` on whose prime factors are 2, 3 and 5, which transform fast.
fn fast_length(least: usize) -> usize {
    (least..)
        .find(|n| {
            let mut rest = *n;
            for prime in [2, 3, 5] {
                while rest > 0 && rest.is_multiple_of(prime) {
                    rest /= prime;
                }
            }
            rest == 1
        })
        .unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use std::f64::consts::{LN_2, PI, TAU};

    fn map(heights: Array2<f32>, edges: Edges) -> HeightMap {
        HeightMap { heights, pitch_x: 0.5e-6, pitch_y: 0.8e-6, edges, removed_slopes: [0.0; 2] }
    }

    /// The definition, point by point: sampled weights over whatever is measured.
    fn definition(map: &HeightMap, cut_off: f64, r: usize, c: usize) -> f64 {
        let (rows, columns) = map.heights.dim();
        let (mut sum, mut weights) = (0.0, 0.0);
        // Three copies in each direction reach farther than the weights do.
        let copies: isize = if map.edges == Edges::Open { 0 } else { 3 };
        let (pr, pc) = match map.edges {
            Edges::Mirrored => (2 * (rows - 1), 2 * (columns - 1)),
            _ => (rows, columns),
        };
        let fold = |k: isize, n: usize, period: usize| {
            let k = k.rem_euclid(period as isize) as usize;
            if k < n { k } else { period - k }
        };
        for i in -copies * pr as isize..((copies + 1) * pr as isize) {
            for j in -copies * pc as isize..((copies + 1) * pc as isize) {
                let h = map.heights[[fold(i, rows, pr), fold(j, columns, pc)]];
                let (x, y) = ((j - c as isize) as f64 * map.pitch_x, (i - r as isize) as f64 * map.pitch_y);
                let w = (-PI * (x * x + y * y) / (LN_2 / PI * cut_off * cut_off)).exp();
                if !h.is_nan() {
                    sum += w * f64::from(h);
                    weights += w;
                }
            }
        }
        sum / weights
    }

    #[test]
    fn agrees_with_its_definition_at_edges_and_gaps() {
        let heights = Array2::from_shape_fn((23, 31), |(r, c)| {
            if (r * 5 + c * 3) % 17 == 0 || (r > 12 && c > 20) {
                f32::NAN
            } else {
                1e-6 * (((r * r + 7 * c) % 23) as f32 + 100.0)
            }
        });
        for edges in [Edges::Open, Edges::Mirrored, Edges::Periodic] {
            let original = map(heights.clone(), edges);
            // Twelve samples: the sampled weights of the definition are as good as the continuous ones.
            let cut_off = 9.6e-6;
            let (mut low, mut high) = (original.clone(), original.clone());
            gaussian(&mut low, cut_off, Pass::Long).unwrap();
            gaussian(&mut high, cut_off, Pass::Short).unwrap();
            assert_eq!(low.missing_fraction(), original.missing_fraction());
            for (r, c) in [(0, 1), (0, 30), (11, 15), (22, 1), (13, 20), (9, 25)] {
                let h = f64::from(original.heights[[r, c]]);
                assert!(!h.is_nan());
                let expected = definition(&original, cut_off, r, c);
                // 1e-11 m is the f32 rounding of heights of 100 um; sampled weights differ from it by far less.
                assert!((f64::from(low.heights[[r, c]]) - expected).abs() < 1e-11, "{edges:?} {r} {c}");
                assert!((f64::from(high.heights[[r, c]]) - (h - expected)).abs() < 1e-11, "{edges:?} {r} {c}");
            }
        }
    }

    #[test]
    fn transmits_half_at_the_cut_off_on_every_kind_of_map() {
        let amplitude = |m: &HeightMap, margin: usize| {
            let inside = |k: usize, n: usize| (margin..n - margin).contains(&k);
            let inner = m.heights.indexed_iter().filter(|((r, c), _)| inside(*r, m.height()) && inside(*c, m.width()));
            inner.fold(0.0f64, |a, (_, h)| a.max(f64::from(h.abs())))
        };
        for edges in [Edges::Periodic, Edges::Open, Edges::Mirrored] {
            for (axis, pitch) in [(1, 0.5e-6), (0, 0.8e-6)] {
                // 20 samples a wave, 10 waves a side; a mirrored map ends on the sample the mirror goes through.
                let side = if edges == Edges::Mirrored { 201 } else { 200 };
                let wave =
                    Array2::from_shape_fn((side, side), |(r, c)| (TAU * [r, c][axis] as f64 / 20.0).cos() as f32);
                let length = 20.0 * pitch;
                for ratio in [0.25, 0.5, 1.0, 2.0] {
                    let cut_off = ratio * length;
                    let expected = 2f64.powf(-(ratio * ratio));
                    for (pass, expected) in [(Pass::Long, expected), (Pass::Short, 1.0 - expected)] {
                        let mut m = map(wave.clone(), edges);
                        gaussian(&mut m, cut_off, pass).unwrap();
                        let margin = if edges == Edges::Open { (cut_off / 0.5e-6) as usize } else { 0 };
                        let found = amplitude(&m, margin);
                        // A cut-off of five samples leaves 1.3 % at Nyquist's frequency: the edge rings on a little.
                        let tolerance = if edges == Edges::Open && ratio < 0.5 { 2e-4 } else { 1e-6 };
                        assert!((found - expected).abs() < tolerance, "{edges:?} {axis} {ratio} {pass:?}: {found}");
                    }
                }
            }
        }
        assert!((transmission(2.0, 0.5) - 0.5).abs() < 1e-15);
        assert!((transmission(1.0, 0.5) - (-LN_2 / 4.0).exp()).abs() < 1e-15);
    }

    #[test]
    fn a_constant_passes_whole_and_unusable_cut_offs_are_refused() {
        let mut m = map(Array2::from_elem((40, 30), 3e-6), Edges::Open);
        m.heights[[3, 5]] = f32::NAN;
        gaussian(&mut m, 10e-6, Pass::Long).unwrap();
        assert!(m.heights.iter().all(|h| h.is_nan() || *h == 3e-6));
        for bad in [1.5e-6, 40e-6, f64::NAN, -1.0] {
            assert!(gaussian(&mut m, bad, Pass::Long).is_err());
        }
        assert_eq!([7, 8, 11, 31, 97].map(fast_length), [8, 8, 12, 32, 100]);
    }
}
