//! Minnaert: a diffuser that darkens or brightens towards its limb, made for the Moon.
//!
//! `f_r = rho (k + 1) / (2 pi) (cos_theta_i cos_theta_r)^(k - 1)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho` | albedo at normal incidence | | 0 to 1 |
//! | `k` | limb darkening; 1 is Lambert, the Moon about 0.5 to 1 | | 0.05 to 10 |
//!
//! Energy: `albedo = rho cos_theta_i^(k - 1)`: conserving for k >= 1; for k < 1 it grows without bound towards grazing (k
//! 0.5: 1.41 rho at 60 deg, 7.6 rho at 89 deg). Reciprocal. An older convention writes `rho / pi` in front: its rho is
//! ours times `(k + 1) / 2`.
//!
//! Sampling: `cos_theta_r = u^(1 / (k + 1))`, pdf `(k + 1) cos_theta_r^k / (2 pi)`, weight the albedo: no noise.
//!
//! Picture: `asperity lobe minnaert:rho=0.5,k=0.7 minnaert:rho=0.5,k=1.5 -o minnaert.svg`
//!
//! Source: M. Minnaert, Astrophysical Journal 93, 403, 1941.

use super::parameter::Parameter;
use super::registry::Entry;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::TAU;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "minnaert",
    summary: "diffuser with limb darkening or brightening",
    formula: "f_r = rho (k+1)/(2 pi) (cos_theta_i cos_theta_r)^(k-1)",
    parameters: &[
        Parameter::number("rho", "albedo at normal incidence", 0.0, 1.0),
        Parameter::number("k", "limb darkening; 1 is Lambert", 0.05, 10.0).usual(0.5, 2.0),
    ],
    exceeds_one: true,
    energy: "albedo = rho cos_theta_i^(k-1): exceeds 1 towards grazing for k < 1",
    source: "Minnaert 1941",
    example: "minnaert:rho=0.5,k=1.2",
    build: |v| Ok(Box::new(Minnaert { rho: v.required("rho")?, k: v.required("k")? })),
    ..Entry::PLAIN
};

/// `f_r = rho (k + 1) / (2 pi) (cos_theta_i cos_theta_r)^(k - 1)` [1/sr].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minnaert {
    /// Albedo at normal incidence, 0 to 1.
    pub rho: f64,
    /// Limb darkening, above 0.
    pub k: f64,
}

impl Brdf for Minnaert {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.rho * (self.k + 1.0) / TAU * (wi.z * wo.z).powf(self.k - 1.0)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let z = (1.0 - u[0]).powf(1.0 / (self.k + 1.0));
        let (s, c) = (TAU * u[1]).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let wo = DVec3::new(r * c, r * s, z);
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.rho * wi.z.powf(self.k - 1.0), pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 { 0.0 } else { (self.k + 1.0) / TAU * wo.z.powf(self.k) }
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        // A hair above the horizon, where the power is still a number.
        self.rho * theta_i.cos().max(1e-9).powf(self.k - 1.0)
    }
}
