//! A model that would reflect more than it receives, scaled down so that it cannot.
//!
//! `f_r' = f_r / max(1, E(theta_i), E(theta_r))`, `E` the directional albedo of the model
//!
//! The divisor is symmetric, so reciprocity stays; where the model conserves energy nothing changes. Switched on by
//! `bounded=true` in the text of any model, off by default: the published formula is then what it is.
//!
//! Energy: `albedo <= 1` for an isotropic model, since every direction is divided by at least `E(theta_i)`. Of a brushed
//! model the albedo averaged over azimuth is bounded, not that of every azimuth.
//!
//! Sampling: that of the model; the weight is divided as `f_r` is.
//!
//! Source: the defect of the NEF-BM at grazing, Westlund and Meyer 2002, section 3.2; this cure is ours.

use super::albedo::{AlbedoTable, CosineTable, DRAWS, sampled_average};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::sync::OnceLock;

/// `f_r / max(1, E_i, E_o)` [1/sr].
pub struct Bounded {
    inner: Box<dyn Brdf>,
    free: OnceLock<CosineTable>,
    albedo: OnceLock<AlbedoTable>,
}

impl Bounded {
    /// Bounds `inner`.
    pub fn new(inner: Box<dyn Brdf>) -> Self {
        Bounded { inner, free: OnceLock::new(), albedo: OnceLock::new() }
    }

    /// `max(1, E_i, E_o)`.
    fn divisor(&self, wi: DVec3, wo: DVec3) -> f64 {
        let free = self.free.get_or_init(|| CosineTable::new(|theta| self.inner.albedo(theta)));
        free.at(wi.z).max(free.at(wo.z)).max(1.0)
    }
}

impl Brdf for Bounded {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let f = self.inner.eval(wi, wo);
        // The albedo is only looked up where there is something to divide.
        if f > 0.0 { f / self.divisor(wi, wo) } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let draw = self.inner.sample(wi, u)?;
        Some(BrdfSample { weight: draw.weight / self.divisor(wi, draw.wo), ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.inner.pdf(wi, wo)
    }

    /// A mean over draws, and where few heavy ones decide, the closed limit `min(1, E)`.
    fn albedo(&self, theta_i: f64) -> f64 {
        let table = self.albedo.get_or_init(|| AlbedoTable::new(1, |wi| sampled_average(self, wi, DRAWS)));
        table.at(theta_i).min(self.inner.albedo(theta_i)).min(1.0)
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        sampled_average(self, wi, DRAWS)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        let core = self.inner.specular_core(wi);
        if core > 0.0 { core / self.divisor(wi, wi) } else { 0.0 }
    }
}
