//! The coherent mirror beam: the mean of the phase factor.

use crate::heightmap::HeightMap;
use crate::math::Estimate;
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// Sub-areas along each axis whose scatter is the error of the mean.
const ACROSS: usize = 4;

/// A coherent beam is told from a speckle that happens to lie in the mirror direction only if it holds so many times the
/// mean speckle: one speckle in `exp(9)` is as bright.
const SIGNIFICANT: f64 = 9.0;

/// `m = <exp(-j v_z h)>` over the measured points; `|m|^2` of the light stays a mirror beam.
///
/// For normally distributed heights `|m|^2 = exp(-g)`, `g = (v_z Sq)^2`; the mean itself holds for any distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coherent {
    /// `m`.
    pub mean: Complex<f64>,
    /// Standard error of `|m|^2` relative to it, from sub-areas of the map.
    pub relative_error: f64,
}

impl Coherent {
    /// Mean over all measured points of `map` at `v_z` [1/m]; zero where none is measured.
    pub fn measure(map: &HeightMap, v_z: f64) -> Self {
        let (rows, columns) = map.heights.dim();
        let bands: Vec<[(Complex<f64>, f64); ACROSS]> = (0..ACROSS)
            .into_par_iter()
            .map(|band| {
                let mut sums = [(Complex::new(0.0, 0.0), 0.0); ACROSS];
                for row in band * rows / ACROSS..(band + 1) * rows / ACROSS {
                    for (column, &h) in map.heights.row(row).iter().enumerate() {
                        if h.is_nan() {
                            continue;
                        }
                        let u = phase_factor(v_z, h);
                        let sum = &mut sums[column * ACROSS / columns];
                        sum.0 += Complex::new(f64::from(u.re), f64::from(u.im));
                        sum.1 += 1.0;
                    }
                }
                sums
            })
            .collect();
        let parts = || bands.iter().flatten();
        let points: f64 = parts().map(|s| s.1).sum();
        let mean = parts().map(|s| s.0).sum::<Complex<f64>>() / points.max(1.0);
        // |m|^2 answers to the component of a change along m.
        let along: Vec<f64> = parts().filter(|s| s.1 > 0.0).map(|s| (s.0 / s.1 / mean).re).collect();
        let relative_error =
            if mean.norm_sqr() > 0.0 { 2.0 * Estimate::from_repeats(&along).standard_error } else { 0.0 };
        Coherent { mean, relative_error }
    }

    /// `|m|^2`.
    pub fn share(&self) -> f64 {
        self.mean.norm_sqr()
    }

    /// Keeps the beam if it stands out from the speckle, else sets it to zero: on a rough finite map the mean is not zero but
    /// one more speckle, `speckle` being the mean share of one.
    pub fn if_significant(self, speckle: f64) -> Coherent {
        if self.share() > SIGNIFICANT * speckle {
            self
        } else {
            Coherent { mean: Complex::new(0.0, 0.0), relative_error: 0.0 }
        }
    }
}

/// `exp(-j v_z h)`; full turns are taken off in f64, so heights of many wavelengths keep their phase.
#[inline]
pub(super) fn phase_factor(v_z: f64, h: f32) -> Complex<f32> {
    let turns = v_z * f64::from(h) * (1.0 / std::f64::consts::TAU);
    let (sin, cos) = ((std::f64::consts::TAU * (turns - (turns as i64) as f64)) as f32).sin_cos();
    Complex::new(cos, -sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    #[test]
    fn gaussian_heights_keep_exp_of_minus_g() {
        let grid = synth::Grid { width: 600, height: 400, pitch: [0.5e-6, 0.8e-6] };
        let raw = synth::gaussian(grid, synth::Gaussian { sq: 50e-9, acl: 4e-6, seed: 3, exact: true }).unwrap();
        let map = level::keep_tilt(&raw, Edges::Periodic);
        for g in [1e-3f64, 0.3, 1.0, 4.0] {
            let found = Coherent::measure(&map, g.sqrt() / 50e-9);
            let error = 4.0 * found.relative_error * found.share();
            assert!((found.share() - (-g).exp()).abs() < error + 1e-6, "{g}: {found:?}");
        }
    }

    #[test]
    fn phases_of_many_turns_are_kept() {
        for k in 0..50 {
            let h = k as f32 * 3.3e-6;
            let exact = Complex::from_polar(1.0, -2.3e7 * f64::from(h));
            let found = phase_factor(2.3e7, h);
            assert!((f64::from(found.re) - exact.re).abs() < 1e-6 && (f64::from(found.im) - exact.im).abs() < 1e-6);
        }
    }
}
