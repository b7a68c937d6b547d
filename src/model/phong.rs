//! Modified Phong: a power of the cosine about the mirror direction, in the reciprocal form.
//!
//! `f_r = rho_d / pi + rho_s (n + 2) / (2 pi) max(0, r . wo)^n`, `r` the mirror direction of `wi`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho_s` | albedo of the lobe at normal incidence | | 0 to 1 |
//! | `exponent` | n; as wide as Beckmann at n = 1 / (2 alpha^2) | | 1 to 1e6 |
//! | `rho_d` | albedo of the diffuse floor, default 0 | | 0 to 1 - rho_s |
//!
//! Energy: albedo at most `rho_d + rho_s`, equal at normal incidence; for large n the lobe's is `rho_s cos_theta_i`,
//! so it darkens towards grazing where real gloss brightens. Reciprocal. Not Phong's original, which divides by
//! `cos_theta_i` and gains energy.
//!
//! Sampling: `cos a = u^(1 / (n + 1))` about r, pdf `(n + 1) / (2 pi) cos^n a`,
//! weight `rho_s (n + 2) / (n + 1) cos_theta_r`.
//!
//! Sources: Phong, CACM 18(6), 1975; Lewis, EGWR 1993; Lafortune and Willems, Report CW 197, 1994.

use super::albedo::{AlbedoTable, ray_average};
use super::floor::WithFloor;
use super::parameter::Parameter;
use super::registry::Entry;
use crate::math::frame::tangents;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "phong",
    summary: "power-of-cosine lobe over a diffuse floor (modified, reciprocal form)",
    formula: "f_r = rho_d/pi + rho_s (n+2)/(2 pi) max(0, r.wo)^n",
    parameters: &[
        Parameter::number("rho_s", "albedo of the lobe at normal incidence", 0.0, 1.0),
        Parameter::number("exponent", "sharpness n", 1.0, 1e6).decades(2.0, 1e4),
        Parameter::number("rho_d", "albedo of the diffuse floor", 0.0, 1.0).or(0.0),
    ],
    energy: "albedo <= rho_d + rho_s; the lobe falls as cos_theta_i",
    source: "Phong 1975; Lewis 1993; Lafortune and Willems 1994",
    example: "phong:rho_s=0.04,exponent=1000",
    build: |a| {
        let [rho_d, rho_s] = a.floor_and_lobe()?;
        Ok(Box::new(WithFloor::new(rho_d, rho_s, Phong::new(rho_s, a.required("exponent")?))))
    },
    ..Entry::PLAIN
};

/// `f_r = rho_s (n + 2) / (2 pi) max(0, r . wo)^n` [1/sr].
#[derive(Debug, Clone)]
pub struct Phong {
    rho_s: f64,
    exponent: f64,
    albedo: OnceLock<AlbedoTable>,
}

impl Phong {
    /// Lobe of albedo `rho_s` at normal incidence and the given exponent, 1 or more.
    pub fn new(rho_s: f64, exponent: f64) -> Self {
        Phong { rho_s, exponent, albedo: OnceLock::new() }
    }

    /// `cos^n a` about the mirror direction; 0 behind it or below the surface.
    fn lobe(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        mirror(wi).dot(wo).clamp(0.0, 1.0).powf(self.exponent)
    }

    /// `1 - cos a` of the share `1 - u` of the lobe, without cancellation at large n.
    fn versine(&self, u: f64) -> f64 {
        -((1.0 - u).ln() / (self.exponent + 1.0)).exp_m1()
    }
}

fn mirror(wi: DVec3) -> DVec3 {
    DVec3::new(-wi.x, -wi.y, wi.z)
}

impl Brdf for Phong {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.rho_s * (self.exponent + 2.0) / TAU * self.lobe(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let versine = self.versine(u[0]);
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let r = mirror(wi);
        let (t, b) = tangents(r);
        let wo = (sin * c * t + sin * s * b + (1.0 - versine) * r).normalize();
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return None;
        }
        let weight = self.rho_s * (self.exponent + 2.0) / (self.exponent + 1.0) * wo.z;
        Some(BrdfSample { wo, weight, pdf: self.pdf(wi, wo), specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        (self.exponent + 1.0) / TAU * self.lobe(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        let scale = self.rho_s * (self.exponent + 2.0) / (self.exponent + 1.0);
        let table = || AlbedoTable::new(1, |wi| scale * ray_average(mirror(wi), |u| self.versine(u)));
        self.albedo.get_or_init(table).at(theta_i)
    }
}
