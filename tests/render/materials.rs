//! Small materials with known answers.

use asperity::math::frame::{DVec3, half_vector, reflect};
use asperity::optics::brdf::{Brdf, BrdfSample};
use asperity::optics::fresnel;
use std::f64::consts::{PI, TAU};

/// `f_r = rho / pi`.
pub struct Lambert(pub f64);

impl Brdf for Lambert {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 && wo.z > 0.0 { self.0 / PI } else { 0.0 }
    }

    fn sample(&self, _wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let (s, c) = (TAU * u[1]).sin_cos();
        let z = (1.0 - u[0]).sqrt();
        let wo = DVec3::new(u[0].sqrt() * c, u[0].sqrt() * s, z);
        Some(BrdfSample { wo, weight: self.0, pdf: z / PI, specular: false })
    }

    fn pdf(&self, _wi: DVec3, wo: DVec3) -> f64 {
        wo.z.max(0.0) / PI
    }

    fn albedo(&self, _theta_i: f64) -> f64 {
        self.0
    }
}

/// All light into the mirror direction.
pub struct Mirror;

impl Brdf for Mirror {
    fn eval(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wi: DVec3, _: [f64; 2]) -> Option<BrdfSample> {
        Some(BrdfSample { wo: reflect(wi, DVec3::Z), weight: 1.0, pdf: f64::INFINITY, specular: true })
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn albedo(&self, _: f64) -> f64 {
        1.0
    }

    fn specular_core(&self, _: DVec3) -> f64 {
        1.0
    }
}

/// Rough black glass: `F D G1 G1 / (4 ci co)` with Beckmann's D (Walter et al. 2007).
pub struct Beckmann {
    pub alpha: f64,
    pub n: f64,
}

impl Beckmann {
    fn density(&self, wh: DVec3) -> f64 {
        let c2 = wh.z * wh.z;
        let a2 = self.alpha * self.alpha;
        let tan2 = (wh.x * wh.x + wh.y * wh.y) / c2;
        (-tan2 / a2).exp() / (PI * a2 * c2 * c2)
    }

    fn g1(&self, w: DVec3) -> f64 {
        let v = w.z / (w.x.hypot(w.y) * self.alpha);
        if v > 5.0 {
            return 1.0;
        }
        let lambda = 0.5 * (libm_erf(v) - 1.0) + (-v * v).exp() / (2.0 * v * PI.sqrt());
        1.0 / (1.0 + lambda)
    }
}

/// Error function by Abramowitz and Stegun 7.1.26, 1.5e-7: enough for a shadowing factor.
fn libm_erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let p = t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    1.0 - p * (-x * x).exp()
}

impl Brdf for Beckmann {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let wh = half_vector(wi, wo);
        let d = self.density(wh);
        if d == 0.0 {
            return 0.0;
        }
        let f = fresnel::dielectric(wi.dot(wh), self.n);
        f * d * self.g1(wi) * self.g1(wo) / (4.0 * wi.z * wo.z)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let tan2 = -self.alpha * self.alpha * (1.0 - u[0]).ln();
        let cos = 1.0 / (1.0 + tan2).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let sin = tan2.sqrt() * cos;
        let wh = DVec3::new(sin * c, sin * s, cos);
        let beta = wi.dot(wh);
        let wo = reflect(wi, wh);
        if beta <= 0.0 || wo.z <= 0.0 {
            return None;
        }
        let weight = fresnel::dielectric(beta, self.n) * self.g1(wi) * self.g1(wo) * beta / (wi.z * wh.z);
        Some(BrdfSample { wo, weight, pdf: self.density(wh) * wh.z / (4.0 * beta), specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let wh = half_vector(wi, wo);
        self.density(wh) * wh.z / (4.0 * wi.dot(wh))
    }

    /// Reflectance of the smooth interface: close enough for the exposure.
    fn albedo(&self, theta_i: f64) -> f64 {
        fresnel::dielectric(theta_i.cos(), self.n)
    }
}
