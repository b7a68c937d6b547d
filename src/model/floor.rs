//! A lobe over a diffuse floor: `f_r = rho_d / pi + f_lobe`.
//!
//! Sampling picks the floor with probability `rho_d / (rho_d + rho_s)` and reports the density of the mixture, so
//! the weight uses the whole `f_r` (Veach 1997, section 9.2.4). A specular core of the lobe stays a branch of its own.

use super::lambert::{Lambert, cosine_direction};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;

/// `f_r = rho_d / pi + f_lobe` [1/sr].
#[derive(Debug, Clone)]
pub struct WithFloor<B> {
    floor: Lambert,
    lobe: B,
    /// Probability of drawing from the floor.
    share: f64,
}

impl<B: Brdf> WithFloor<B> {
    /// Puts `lobe`, of which about `rho_s` is reflected, over a floor of albedo `rho_d`.
    pub fn new(rho_d: f64, rho_s: f64, lobe: B) -> Self {
        let total = rho_d + rho_s;
        let share = if total > 0.0 { rho_d / total } else { 1.0 };
        WithFloor { floor: Lambert { rho: rho_d }, lobe, share }
    }
}

impl<B: Brdf> Brdf for WithFloor<B> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.floor.eval(wi, wo) + self.lobe.eval(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        // The number that chose the branch is stretched back to [0, 1) and used again.
        let wo = if u[0] < self.share {
            cosine_direction([u[0] / self.share, u[1]])
        } else {
            let draw = self.lobe.sample(wi, [(u[0] - self.share) / (1.0 - self.share), u[1]])?;
            if draw.specular {
                return Some(BrdfSample { weight: draw.weight / (1.0 - self.share), ..draw });
            }
            draw.wo
        };
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0 && wo.z > 0.0).then(|| BrdfSample {
            wo,
            weight: self.eval(wi, wo) * wo.z / pdf,
            pdf,
            specular: false,
        })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.share * self.floor.pdf(wi, wo) + (1.0 - self.share) * self.lobe.pdf(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.floor.rho + self.lobe.albedo(theta_i)
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        self.floor.rho + self.lobe.albedo_towards(wi)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.lobe.specular_core(wi)
    }
}
