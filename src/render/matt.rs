//! The matt paint of the furniture in our scenes.

use crate::math::frame::DVec3;
use crate::optics::brdf::{Brdf, BrdfSample};
use std::f64::consts::{PI, TAU};

/// `f_r = 1 / pi` (Lambert 1760); the colour is the tint of the material.
pub(super) struct Matt;

impl Brdf for Matt {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 && wo.z > 0.0 { 1.0 / PI } else { 0.0 }
    }

    fn sample(&self, _wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let (s, c) = (TAU * u[1]).sin_cos();
        let z = (1.0 - u[0]).sqrt();
        let wo = DVec3::new(u[0].sqrt() * c, u[0].sqrt() * s, z);
        Some(BrdfSample { wo, weight: 1.0, pdf: z / PI, specular: false })
    }

    fn pdf(&self, _wi: DVec3, wo: DVec3) -> f64 {
        wo.z.max(0.0) / PI
    }

    fn albedo(&self, _theta_i: f64) -> f64 {
        1.0
    }
}
