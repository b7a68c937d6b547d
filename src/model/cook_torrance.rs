//! Cook-Torrance: Beckmann facets in V-cavities over a diffuse floor; the colour of metals comes from Fresnel.
//!
//! `f_r = rho_d / pi + rho_s R(beta) D G / (4 cos_theta_i cos_theta_r)`,
//! `D = exp(-tan^2 theta_h / alpha^2) / (pi alpha^2 cos^4 theta_h)`,
//! `G = min(1, 2 cos_theta_h cos_theta_r / cos_beta, 2 cos_theta_h cos_theta_i / cos_beta)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `alpha` | Cook and Torrance's m: sqrt 2 times the rms slope along an axis | | 0 to 2 |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//! | `rho_d` | albedo of the diffuse floor (their d), default 0 | | 0 to 1 |
//! | `rho_s` | share of the surface that is facets (their s), default 1 - rho_d | | 0 to 1 - rho_d |
//!
//! Normalisation: printed with `D = exp(..) / (m^2 cos^4)` and `1 / pi` in front, the lobe reflects exactly 4 times the
//! light it receives. With the normalised D above, and 1/4, it is right; some programs still carry the 4.
//!
//! Energy: albedo at most `rho_s R + rho_d`; V-cavities hide less than Smith at grazing, more at 60 deg. Reciprocal. Alpha below 1e-4 is
//! a specular core.
//!
//! Sampling: half vectors by `D cos_theta_h`, pdf `D cos_theta_h / (4 cos_beta)`, weight `rho_s R G cos_beta /
//! (cos_theta_i cos_theta_h) <= 2 rho_s R`.
//!
//! Picture: `asperity lobe cook-torrance:alpha=0.3,material=cu --wavelengths 464nm,550nm,611nm -o copper.svg`
//!
//! Source: R. L. Cook and K. E. Torrance, ACM Transactions on Graphics 1(1), 1982.

use super::albedo::{AlbedoTable, half_vector_average};
use super::beckmann::GaussianSlopes;
use super::floor::WithFloor;
use super::microfacet::{ALPHA_CORE, Shape, v_cavity};
use super::parameter::Parameter;
use super::registry::Entry;
use super::smooth::{EXTINCTION, INDEX, mirror_sample};
use crate::math::{half_vector, reflect};
use crate::optics::{Brdf, BrdfSample, Material};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "cook-torrance",
    summary: "Gaussian facets in V-cavities over a diffuse floor",
    formula: "f_r = rho_d/pi + rho_s R D G / (4 cos_theta_i cos_theta_r), G of V-cavities",
    parameters: &[
        Parameter::number("alpha", "roughness m, sqrt 2 x rms slope along an axis", 0.0, 2.0).decades(0.005, 0.7),
        INDEX,
        EXTINCTION,
        Parameter::number("rho_d", "albedo of the diffuse floor", 0.0, 1.0).usual(0.0, 0.5).or(0.0),
        Parameter::number("rho_s", "share of the facets, 1 - rho_d if absent", 0.0, 1.0).usual(0.1, 0.5).optional(),
    ],
    interface: true,
    energy: "albedo <= rho_s R + rho_d",
    source: "Cook and Torrance 1982",
    example: "cook-torrance:alpha=0.3,material=cu",
    build: |v| {
        let rho_d = v.required("rho_d")?;
        let rho_s = v.get("rho_s").unwrap_or(1.0 - rho_d);
        if rho_d + rho_s > 1.0 + 1e-9 {
            return Err(v.error(format!("rho_d + rho_s = {} is more than 1", rho_d + rho_s)));
        }
        let material = v.material()?;
        // The lobe's worth of light, for the choice between lobe and floor.
        let worth = rho_s * material.reflectance(0.5);
        Ok(Box::new(WithFloor::new(rho_d, worth, CookTorrance::new(rho_s, v.required("alpha")?, material))))
    },
    ..Entry::PLAIN
};

/// The lobe `rho_s R D G / (4 cos_theta_i cos_theta_r)` [1/sr].
#[derive(Debug, Clone)]
pub struct CookTorrance {
    rho_s: f64,
    alpha: f64,
    material: Material,
    albedo: OnceLock<AlbedoTable>,
}

impl CookTorrance {
    /// Facets of roughness `alpha` on the share `rho_s` of the surface; below [`ALPHA_CORE`] a specular core.
    pub fn new(rho_s: f64, alpha: f64, material: Material) -> Self {
        CookTorrance { rho_s, alpha, material, albedo: OnceLock::new() }
    }

    fn is_core(&self) -> bool {
        self.alpha < ALPHA_CORE
    }

    fn normal_density(&self, wh: DVec3) -> f64 {
        let (z2, a2) = (wh.z * wh.z, self.alpha * self.alpha);
        let e = (1.0 - z2).max(0.0) / (z2 * a2);
        (-e).exp() / (PI * a2 * z2 * z2)
    }

    fn visible(&self, wi: DVec3, wo: DVec3) -> bool {
        wi.z > 0.0 && wo.z > 0.0 && !self.is_core()
    }

    fn weight(&self, wi: DVec3, wo: DVec3, wh: DVec3) -> f64 {
        let cos_beta = wi.dot(wh);
        self.rho_s * self.material.reflectance(cos_beta) * v_cavity(wi, wo, wh) * cos_beta / (wi.z * wh.z)
    }
}

impl Brdf for CookTorrance {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !self.visible(wi, wo) {
            return 0.0;
        }
        let wh = half_vector(wi, wo);
        let r = self.material.reflectance(wi.dot(wh));
        self.rho_s * r * self.normal_density(wh) * v_cavity(wi, wo, wh) / (4.0 * wi.z * wo.z)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        if self.is_core() {
            return mirror_sample(wi, self.specular_core(wi));
        }
        let t = self.alpha * GaussianSlopes::quantile(u[0]).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let wh = DVec3::new(t * c, t * s, 1.0).normalize();
        let wo = reflect(wi, wh);
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.weight(wi, wo, wh), pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !self.visible(wi, wo) {
            return 0.0;
        }
        let wh = half_vector(wi, wo);
        self.normal_density(wh) * wh.z / (4.0 * wi.dot(wh))
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        if self.is_core() {
            return self.rho_s * self.material.reflectance(theta_i.cos());
        }
        let integrate = |wi: DVec3| {
            half_vector_average(
                [self.alpha; 2],
                wi,
                |c| GaussianSlopes::quantile(c).sqrt(),
                |t| GaussianSlopes::distribution(t * t),
                |wh, wo| self.weight(wi, wo, wh),
            )
        };
        self.albedo.get_or_init(|| AlbedoTable::new(1, integrate)).at(theta_i)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        if self.is_core() && wi.z > 0.0 { self.rho_s * self.material.reflectance(wi.z) } else { 0.0 }
    }
}
