//! Ward: a Gaussian of the half vector's slope, in the form of 1992.
//!
//! `f_r = rho_d / pi + rho_s exp(-e) / (4 pi alpha_x alpha_y sqrt(cos_theta_i cos_theta_r))`,
//! `e = tan^2 theta_h (cos^2 phi_h / alpha_x^2 + sin^2 phi_h / alpha_y^2)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho_s` | strength of the lobe; its albedo is about `rho_s cos_theta_i` | | 0 to 1 |
//! | `alpha`, or `alpha_x` and `alpha_y` | sqrt 2 times the rms slope; Ward used 0.01 to 0.3 | | 0 to 1 |
//! | `rho_d` | albedo of the diffuse floor, default 0 | | 0 to 1 - rho_s |
//!
//! Energy: for small alpha the lobe reflects `rho_s cos_theta_i`, not `rho_s`: a tile with `rho_s = R(20 deg)` of
//! black glass reads at most 93.96 / 24.52 / 0.69 gloss units. Not conserving within a degree of grazing, where it
//! grows as `1 / sqrt(cos_theta_i)`. Reciprocal. Alpha below 1e-4 is a specular core `rho_s cos_theta_i`.
//!
//! Sampling: half vectors by the Gaussian, pdf `exp(-e) / (4 pi alpha_x alpha_y cos_beta cos^3 theta_h)`, weight `rho_s
//! cos_beta cos^3 theta_h sqrt(cos_theta_r / cos_theta_i)`.
//!
//! Sources: G. J. Ward, SIGGRAPH 1992, equations 4 and 5; sampling
//! weight: B. Walter, Notes on the Ward BRDF, Cornell PCG-05-06, 2005.

use super::albedo::{AlbedoTable, half_vector_average};
use super::beckmann::GaussianSlopes;
use super::floor::WithFloor;
use super::microfacet::{ALPHA_CORE, Shape, floor_alpha};
use super::parameter::Parameter;
use super::registry::Entry;
use super::smooth::mirror_sample;
use crate::math::{half_vector, reflect};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "ward",
    summary: "Gaussian lobe over a diffuse floor, isotropic or brushed (1992 form)",
    formula: "f_r = rho_d/pi + rho_s exp(-tan^2(cos^2/ax^2 + sin^2/ay^2)) / (4 pi ax ay sqrt(cos_theta_i cos_theta_r))",
    parameters: &[
        Parameter::number("rho_s", "strength of the lobe", 0.0, 1.0),
        Parameter::number("alpha", "roughness, sqrt 2 x rms slope along an axis", 0.0, 1.0).decades(0.005, 0.5),
        Parameter::number("alpha_x", "roughness along x", 0.0, 1.0).decades(0.005, 0.5).instead_of("alpha"),
        Parameter::number("alpha_y", "roughness along y", 0.0, 1.0).decades(0.005, 0.5).instead_of("alpha"),
        Parameter::number("rho_d", "albedo of the diffuse floor", 0.0, 1.0).or(0.0),
    ],
    exceeds_one: true,
    energy: "lobe albedo about rho_s cos_theta_i; exceeds 1 within a degree of grazing",
    source: "Ward 1992; Walter 2005",
    example: "ward:rho_s=0.045,alpha=0.02",
    build: |a| {
        let [rho_d, rho_s] = a.floor_and_lobe()?;
        Ok(Box::new(WithFloor::new(rho_d, rho_s, Ward::new(rho_s, a.alpha()?))))
    },
    ..Entry::PLAIN
};

/// Incident azimuths averaged for the albedo of a brushed surface.
const AZIMUTHS: usize = 16;

/// `f_r = rho_s exp(-e) / (4 pi alpha_x alpha_y sqrt(cos_theta_i cos_theta_r))` [1/sr].
#[derive(Debug, Clone)]
pub struct Ward {
    rho_s: f64,
    alpha: [f64; 2],
    albedo: OnceLock<AlbedoTable>,
}

impl Ward {
    /// Lobe of strength `rho_s` and roughness `[alpha_x, alpha_y]`; both below [`ALPHA_CORE`] make a specular core.
    pub fn new(rho_s: f64, alpha: [f64; 2]) -> Self {
        Ward { rho_s, alpha: floor_alpha(alpha), albedo: OnceLock::new() }
    }

    fn is_core(&self) -> bool {
        self.alpha[0] < ALPHA_CORE
    }

    /// `exp(-e) / (4 pi alpha_x alpha_y)`.
    fn gaussian(&self, wh: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let e = ((wh.x / ax).powi(2) + (wh.y / ay).powi(2)) / (wh.z * wh.z);
        (-e).exp() / (4.0 * PI * ax * ay)
    }

    fn visible(&self, wi: DVec3, wo: DVec3) -> bool {
        wi.z > 0.0 && wo.z > 0.0 && !self.is_core()
    }

    /// `f_r cos_theta_r / pdf`.
    fn weight(&self, wi: DVec3, wo: DVec3, wh: DVec3) -> f64 {
        self.rho_s * wi.dot(wh) * wh.z.powi(3) * (wo.z / wi.z).sqrt()
    }
}

impl Brdf for Ward {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !self.visible(wi, wo) {
            return 0.0;
        }
        self.rho_s * self.gaussian(half_vector(wi, wo)) / (wi.z * wo.z).sqrt()
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        if self.is_core() {
            return mirror_sample(wi, self.specular_core(wi));
        }
        let t = GaussianSlopes::quantile(u[0]).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let wh = DVec3::new(self.alpha[0] * t * c, self.alpha[1] * t * s, 1.0).normalize();
        let wo = reflect(wi, wh);
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.weight(wi, wo, wh), pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !self.visible(wi, wo) {
            return 0.0;
        }
        let wh = half_vector(wi, wo);
        self.gaussian(wh) / (wi.dot(wh) * wh.z.powi(3))
    }

    /// Averaged over the incident azimuth if the surface is brushed.
    fn albedo(&self, theta_i: f64) -> f64 {
        if self.is_core() {
            return self.rho_s * theta_i.cos().max(0.0);
        }
        let integrate = |wi: DVec3| {
            half_vector_average(
                self.alpha,
                wi,
                |c| GaussianSlopes::quantile(c).sqrt(),
                |t| GaussianSlopes::distribution(t * t),
                |wh, wo| self.weight(wi, wo, wh),
            )
        };
        let azimuths = if self.alpha[0] == self.alpha[1] { 1 } else { AZIMUTHS };
        self.albedo.get_or_init(|| AlbedoTable::new(azimuths, integrate)).at(theta_i)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        if self.is_core() { self.rho_s * wi.z.max(0.0) } else { 0.0 }
    }
}
