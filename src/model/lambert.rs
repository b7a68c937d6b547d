//! Lambert: equally bright from everywhere.
//!
//! `f_r = rho / pi`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho` | albedo | | 0 to 1 |
//!
//! Energy: `albedo = rho` exactly, at every angle. Reciprocal.
//!
//! Sampling: cosine, `pdf = cos theta_r / pi`, weight `rho`.
//!
//! Picture: `asperity lobe lambert:rho=0.5 -o lambert.svg`
//!
//! Source: J. H. Lambert, Photometria, 1760.

use super::parameter::Parameter;
use super::registry::Entry;
use crate::math::frame::sin_cos_turns;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "lambert",
    summary: "ideal diffuser",
    formula: "f_r = rho / pi",
    parameters: &[Parameter::number("rho", "albedo", 0.0, 1.0)],
    energy: "albedo = rho",
    source: "Lambert 1760",
    example: "lambert:rho=0.5",
    build: |a| Ok(Box::new(Lambert { rho: a.required("rho")? })),
    ..Entry::PLAIN
};

/// `f_r = rho / pi` [1/sr].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambert {
    /// Albedo, 0 to 1.
    pub rho: f64,
}

/// `(sqrt(u0) cos 2 pi u1, sqrt(u0) sin 2 pi u1, sqrt(1 - u0))`: density `cos_theta / pi`
/// (Malley's method; Pharr, Jakob, Humphreys, Physically Based Rendering, 4th ed., A.5.3).
#[inline(always)]
pub fn cosine_direction(u: [f64; 2]) -> DVec3 {
    let radius = u[0].sqrt();
    let (s, c) = sin_cos_turns(u[1]);
    DVec3::new(radius * c, radius * s, (1.0 - u[0]).max(0.0).sqrt())
}

impl Brdf for Lambert {
    fn diffuser(&self) -> Option<f64> {
        Some(self.rho)
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 && wo.z > 0.0 { self.rho * FRAC_1_PI } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let wo = cosine_direction(u);
        (wi.z > 0.0 && wo.z > 0.0).then_some(BrdfSample {
            wo,
            weight: self.rho,
            pdf: wo.z * FRAC_1_PI,
            specular: false,
        })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 { wo.z.max(0.0) * FRAC_1_PI } else { 0.0 }
    }

    fn albedo(&self, _theta_i: f64) -> f64 {
        self.rho
    }
}
