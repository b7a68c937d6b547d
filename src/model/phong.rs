//! Phong: a power of the cosine about the mirror direction, over a diffuse floor.
//!
//! `f_r = rho_d / pi + rho_s (n + 2) / (2 pi) max(0, r . wo)^n`, `r` the mirror direction of `wi` (form `modified`)
//!
//! `f_r = rho_d / pi + rho_s (n + 1) / (2 pi) max(0, r . wo)^n / cos_theta_i` (form `original`)
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho_s` | albedo of the lobe at normal incidence (of a sharp one, in the original form) | | 0 to 1 |
//! | `exponent` | n; as wide as Beckmann at n = 1 / (2 alpha^2) | | 1 to 1e6 |
//! | `rho_d` | albedo of the diffuse floor, default 0 | | 0 to 1 - rho_s |
//! | `form` | `modified` or `original` | | |
//!
//! Energy, modified: albedo at most `rho_d + rho_s`, equal at normal incidence; for large n the lobe's is `rho_s
//! cos_theta_i`, so it darkens towards grazing where real gloss brightens. Reciprocal.
//!
//! Energy, original: Phong set the radiance itself to `cos^n`, so the BRDF divides by `cos_theta_i`: not reciprocal, and
//! the lobe's albedo grows to 2.8 rho_s at 89 deg (n = 100).
//!
//! Sampling: `cos a = u^(1 / (n + 1))` about r, pdf `(n + 1) / (2 pi) cos^n a`; weight `rho_s (n + 2) / (n + 1)
//! cos_theta_r`, original `rho_s cos_theta_r / cos_theta_i`.
//!
//! Picture: `asperity lobe phong:rho_s=0.5,exponent=20 phong:rho_s=0.5,exponent=20,form=original -o phong.svg`
//!
//! Sources: Phong, CACM 18(6), 1975; Lewis, EGWR 1993; Lafortune and Willems, Report CW 197, 1994.

use super::albedo::{AlbedoTable, ray_average};
use super::floor::WithFloor;
use super::parameter::{Parameter, Word};
use super::registry::Entry;
use crate::math::frame::tangents;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "phong",
    summary: "power-of-cosine lobe over a diffuse floor",
    formula: "f_r = rho_d/pi + rho_s (n+2)/(2 pi) max(0, r.wo)^n; original: (n+1)/(2 pi) .../cos_theta_i",
    parameters: &[
        Parameter::number("rho_s", "albedo of the lobe at normal incidence", 0.0, 1.0),
        Parameter::number("exponent", "sharpness n", 1.0, 1e6).decades(2.0, 1e4),
        Parameter::number("rho_d", "albedo of the diffuse floor", 0.0, 1.0).or(0.0),
    ],
    words: &[Word { name: "form", meaning: "reciprocal form, or Phong's own", options: &["modified", "original"] }],
    not_reciprocal: Some("original"),
    exceeds_one: true,
    energy: "modified: albedo <= rho_d + rho_s, falls as cos_theta_i; original: grows beyond 1 towards grazing",
    source: "Phong 1975; Lewis 1993; Lafortune and Willems 1994",
    example: "phong:rho_s=0.04,exponent=1000",
    build: |v| {
        let [rho_d, rho_s] = v.floor_and_lobe()?;
        let original = v.word("form") == Some("original");
        Ok(Box::new(WithFloor::new(rho_d, rho_s, Phong::new(rho_s, v.required("exponent")?, original))))
    },
    ..Entry::PLAIN
};

/// `f_r = rho_s (n + 2) / (2 pi) max(0, r . wo)^n` [1/sr], or the original form.
#[derive(Debug, Clone)]
pub struct Phong {
    exponent: f64,
    original: bool,
    /// Factor of `cos^n a`, without the original's `1 / cos_theta_i`.
    scale: f64,
    albedo: OnceLock<AlbedoTable>,
}

impl Phong {
    /// Lobe of strength `rho_s` and the given exponent, 1 or more, in the modified or the original form.
    pub fn new(rho_s: f64, exponent: f64, original: bool) -> Self {
        let scale = rho_s * (exponent + if original { 1.0 } else { 2.0 }) / TAU;
        Phong { exponent, original, scale, albedo: OnceLock::new() }
    }

    /// `cos^n a` about the mirror direction; 0 behind it or below the surface.
    fn lobe(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        mirror(wi).dot(wo).clamp(0.0, 1.0).powf(self.exponent)
    }

    /// Factor of `cos^n a` for `wi`.
    fn strength(&self, wi: DVec3) -> f64 {
        if self.original { self.scale / wi.z.max(1e-9) } else { self.scale }
    }

    /// `f_r cos_theta_r / pdf` over `cos_theta_r`.
    fn weight(&self, wi: DVec3) -> f64 {
        self.strength(wi) * TAU / (self.exponent + 1.0)
    }
}

fn mirror(wi: DVec3) -> DVec3 {
    DVec3::new(-wi.x, -wi.y, wi.z)
}

/// `1 - cos a` of the share `u` of a lobe `cos^n a`, without cancellation at large n.
fn versine(exponent: f64, u: f64) -> f64 {
    -((1.0 - u).ln() / (exponent + 1.0)).exp_m1()
}

/// A direction about the unit vector `axis` with density `(n + 1) / (2 pi) cos^n a`.
pub fn about_axis(axis: DVec3, exponent: f64, u: [f64; 2]) -> DVec3 {
    let versine = versine(exponent, u[0]);
    let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    let (t, b) = tangents(axis);
    (sin * c * t + sin * s * b + (1.0 - versine) * axis).normalize()
}

impl Brdf for Phong {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let lobe = self.lobe(wi, wo);
        if lobe > 0.0 { self.strength(wi) * lobe } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let wo = about_axis(mirror(wi), self.exponent, u);
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.weight(wi) * wo.z, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        (self.exponent + 1.0) / TAU * self.lobe(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        // The original's 1 / cos_theta_i is kept out of the table.
        let scale = self.scale * TAU / (self.exponent + 1.0);
        let integrate = |wi| scale * ray_average(mirror(wi), |u| versine(self.exponent, u));
        let smooth = self.albedo.get_or_init(|| AlbedoTable::new(1, integrate)).at(theta_i);
        if self.original { smooth / theta_i.cos().max(1e-4) } else { smooth }
    }
}
