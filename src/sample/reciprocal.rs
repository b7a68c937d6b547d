//! Reciprocity by force, for those who ask for it.

use crate::math::direction;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::TAU;

/// `f = (f(wi, wo) + f(wo, wi)) / 2`: reciprocity enforced, drawn as before.
///
/// Energy is then no longer that of the tallies: measured tables are reciprocal only within their errors, and a
/// formula that is not stays another formula. Nothing applies this unless asked.
pub struct Reciprocal<'a>(pub &'a dyn Brdf);

impl Brdf for Reciprocal<'_> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        0.5 * (self.0.eval(wi, wo) + self.0.eval(wo, wi))
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let mut sample = self.0.sample(wi, u)?;
        if !sample.specular {
            sample.weight = self.eval(wi, sample.wo) * sample.wo.z / sample.pdf;
        }
        Some(sample)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.pdf(wi, wo)
    }

    /// The mean over twelve azimuths.
    fn albedo(&self, theta_i: f64) -> f64 {
        let at = |k: u32| self.albedo_towards(direction(theta_i, TAU * f64::from(k) / 12.0));
        (0..12).map(at).sum::<f64>() / 12.0
    }

    /// By quadrature over the draws of the original.
    fn albedo_towards(&self, wi: DVec3) -> f64 {
        let n = 1 << 14;
        let sum: f64 = (0..n)
            .filter_map(|k| {
                // R2 sequence (Roberts 2018): even in both numbers.
                let u = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
                self.sample(wi, u.map(|a| (0.5 + a * f64::from(k)).fract()))
            })
            .map(|s| s.weight)
            .sum();
        sum / f64::from(n)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.0.specular_core(wi)
    }
}
