//! Microfacets: what Beckmann and GGX surfaces share. The pages with parameters are [`super::beckmann`] and
//! [`super::ggx`].
//!
//! `f_r = R(beta) D(wh) G / (4 cos_theta_i cos_theta_r)`, `G = 1 / (1 + Lambda(wi) + Lambda(wo))`
//!
//! | `shadowing` | G | source |
//! |---|---|---|
//! | `correlated` | `1 / (1 + Lambda_i + Lambda_o)`; agrees with rays on Gaussian height fields to 1 % | Heitz 2014 |
//! | `separable` | `1 / ((1 + Lambda_i) (1 + Lambda_o))` | Walter et al. 2007 |
//! | `v-cavity` | `min(1, 2 cos_theta_h cos_theta_i / cos_beta, 2 cos_theta_h cos_theta_r / cos_beta)` | Torrance and Sparrow 1967 |
//! | `unconditional` | `S_i S_o`, `S` = share of slopes below `cot theta`, over `1 + Lambda` | Smith 1967; NIST SCATMECH |
//! | `none` | 1 | |
//!
//! `D(wh) = P(e) / (alpha_x alpha_y wh.z^4)` with `e = tan^2 theta_h (cos^2 phi_h / alpha_x^2 + sin^2 phi_h /
//! alpha_y^2)` and `P` the slope density on the unit scale; `beta` is the angle of incidence on the facet.
//!
//! Sources: Walter, Marschner, Li, Torrance, EGSR 2007, equations 20-34; height-correlated Smith G: Heitz, J. Computer
//! Graphics Techniques 3(2), 2014.

use super::albedo::{AlbedoTable, half_vector_average};
use super::parameter::Word;
use super::smooth::mirror_sample;
use crate::math::frame::theta;
use crate::math::{half_vector, reflect};
use crate::optics::{Brdf, BrdfSample, Material};
use glam::DVec3;
use std::sync::OnceLock;

/// Below this roughness the lobe is a specular core: its width, 0.008 deg, is under what any instrument or
/// picture resolves, while `D(0) = 1 / (pi alpha^2)` grows without bound.
pub const ALPHA_CORE: f64 = 1e-4;

/// Incident azimuths averaged for the albedo of an anisotropic surface.
const AZIMUTHS: usize = 16;

/// A slope distribution of fixed shape, on the unit scale `alpha = 1`.
pub trait Shape: Copy + Default + Send + Sync + std::fmt::Debug {
    /// `P(e)`: density of slopes over the plane, `int P(t^2) 2 pi t dt = 1`.
    fn slope_density(e: f64) -> f64;

    /// Share of slopes with `e` up to the given one.
    fn distribution(e: f64) -> f64;

    /// The `e` below which the share `c` of slopes lies, `c` in `[0, 1)`.
    fn quantile(c: f64) -> f64;

    /// Smith `Lambda` at `v = cot theta / alpha(phi)`, given as `v^2 = z2 / s2`.
    fn lambda(z2: f64, s2: f64) -> f64;

    /// Share of slopes along one axis that lie below `v`.
    fn share_below(v: f64) -> f64;

    /// Draws a facet normal as seen from `wi`: density `D G1(wi) cos_beta / cos_theta_i` per steradian.
    fn sample_normal(alpha: [f64; 2], wi: DVec3, u: [f64; 2]) -> DVec3;
}

/// What facets hide of one another: the factor G.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shadowing {
    #[default]
    Correlated,
    Separable,
    VCavity,
    Unconditional,
    None,
}

/// The word of both models, in the order of [`Shadowing`].
pub const SHADOWING: Word = Word {
    name: "shadowing",
    meaning: "what facets hide of one another",
    options: &["correlated", "separable", "v-cavity", "unconditional", "none"],
};

impl Shadowing {
    /// The shadowing of that name; unknown names are the default.
    pub fn named(name: Option<&str>) -> Self {
        use Shadowing::*;
        let all = [Correlated, Separable, VCavity, Unconditional, None];
        let place = SHADOWING.options.iter().position(|&option| Some(option) == name);
        all[place.unwrap_or(0)]
    }
}

/// `min(1, 2 cos_theta_h cos_theta_i / cos_beta, 2 cos_theta_h cos_theta_r / cos_beta)` (Torrance and Sparrow 1967).
#[inline]
pub fn v_cavity(wi: DVec3, wo: DVec3, wh: DVec3) -> f64 {
    let cos_beta = wi.dot(wh);
    if cos_beta > 0.0 { (2.0 * wh.z * wi.z.min(wo.z) / cos_beta).min(1.0) } else { 0.0 }
}

/// Rough interface with slope distribution `S`.
#[derive(Debug, Clone)]
pub struct Microfacet<S: Shape> {
    alpha: [f64; 2],
    /// `1 / alpha^2` along x and y, and `1 / (alpha_x alpha_y)`; infinite for a specular core.
    inverse: [f64; 3],
    material: Material,
    shadowing: Shadowing,
    albedo: OnceLock<AlbedoTable>,
    shape: std::marker::PhantomData<S>,
}

/// Both zero if both are below [`ALPHA_CORE`], else each raised to it.
pub fn floor_alpha(alpha: [f64; 2]) -> [f64; 2] {
    if alpha[0].max(alpha[1]) < ALPHA_CORE { [0.0; 2] } else { alpha.map(|a| a.max(ALPHA_CORE)) }
}

/// `[z2, s2]`, whose ratio is the square of `v = cot theta / alpha(phi)`, anisotropic by stretching (Heitz 2014).
#[inline]
fn cot_on_unit_scale(alpha: [f64; 2], w: DVec3) -> [f64; 2] {
    let (x, y) = (alpha[0] * w.x, alpha[1] * w.y);
    [w.z * w.z, x * x + y * y]
}

impl<S: Shape> Microfacet<S> {
    /// Roughness `[alpha_x, alpha_y]` (sqrt 2 times the rms slope along each axis), in `(0, inf)`; both below
    /// [`ALPHA_CORE`] make a specular core, one alone is raised to it.
    pub fn new(alpha: [f64; 2], material: Material) -> Self {
        let (albedo, shadowing) = (OnceLock::new(), Shadowing::default());
        let alpha = floor_alpha(alpha);
        let inverse = [alpha[0] * alpha[0], alpha[1] * alpha[1], alpha[0] * alpha[1]].map(|square| 1.0 / square);
        Microfacet { alpha, inverse, material, shadowing, albedo, shape: std::marker::PhantomData }
    }

    /// The same with another factor G.
    pub fn with_shadowing(self, shadowing: Shadowing) -> Self {
        Microfacet { shadowing, albedo: OnceLock::new(), ..self }
    }

    fn is_core(&self) -> bool {
        self.alpha[0] == 0.0
    }

    /// `D(wh)` [1/sr]: facet area per steradian of normals and unit mean-plane area; 0 for a specular core.
    pub fn normal_density(&self, wh: DVec3) -> f64 {
        if self.is_core() || wh.z <= 0.0 {
            return 0.0;
        }
        self.density_along(wh)
    }

    /// `D` of the normal along `h`, which need not be of unit length: no root is taken.
    #[inline]
    fn density_along(&self, h: DVec3) -> f64 {
        let z2 = h.z * h.z;
        let [x, y, peak] = self.inverse;
        let e = (h.x * h.x * x + h.y * h.y * y) / z2;
        let from_plane = h.length_squared() / z2;
        S::slope_density(e) * peak * (from_plane * from_plane)
    }

    /// Smith `Lambda(w)`; 0 for a specular core.
    #[inline]
    pub fn lambda(&self, w: DVec3) -> f64 {
        let [z2, s2] = cot_on_unit_scale(self.alpha, w);
        S::lambda(z2, s2)
    }

    /// G for the facet `wh` that reflects `wi` to `wo`.
    fn shadowing(&self, wi: DVec3, wo: DVec3, wh: DVec3) -> f64 {
        let smith = |w: DVec3| 1.0 / (1.0 + self.lambda(w));
        match self.shadowing {
            Shadowing::Correlated => 1.0 / (1.0 + self.lambda(wi) + self.lambda(wo)),
            Shadowing::Separable => smith(wi) * smith(wo),
            Shadowing::VCavity => v_cavity(wi, wo, wh),
            Shadowing::Unconditional => {
                let share = |w: DVec3| {
                    let [z2, s2] = cot_on_unit_scale(self.alpha, w);
                    S::share_below((z2 / s2).sqrt())
                };
                smith(wi) * share(wi) * smith(wo) * share(wo)
            }
            Shadowing::None => 1.0,
        }
    }

    /// Albedo at `wi` by quadrature (five digits).
    fn integrate(&self, wi: DVec3) -> f64 {
        half_vector_average(
            self.alpha,
            wi,
            |c| S::quantile(c).sqrt(),
            |t| S::distribution(t * t),
            |wh, wo| {
                let cos_beta = wi.dot(wh);
                self.material.reflectance(cos_beta) * self.shadowing(wi, wo, wh) * cos_beta / (wi.z * wh.z)
            },
        )
    }
}

impl<S: Shape> Brdf for Microfacet<S> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 || self.is_core() {
            return 0.0;
        }
        let h = wi + wo;
        let d = self.density_along(h);
        // Far from the lobe D underflows to 0, and shadowing need not be computed.
        if d == 0.0 {
            return 0.0;
        }
        // Half of the length of wi + wo.
        let cos_beta = 0.5 * h.length();
        let light = self.material.reflectance(cos_beta) * d;
        let cosines = 4.0 * wi.z * wo.z;
        match self.shadowing {
            Shadowing::Correlated => light / (cosines * (1.0 + self.lambda(wi) + self.lambda(wo))),
            _ => light * self.shadowing(wi, wo, half_vector(wi, wo)) / cosines,
        }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        if self.is_core() {
            return mirror_sample(wi, self.specular_core(wi));
        }
        let wh = S::sample_normal(self.alpha, wi, u);
        let wo = reflect(wi, wh);
        if wo.z <= 0.0 {
            return None;
        }
        let hidden = 1.0 + self.lambda(wi);
        let pdf = self.normal_density(wh) / (4.0 * wi.z * hidden);
        // D cancels between f_r and the pdf.
        let g = match self.shadowing {
            Shadowing::Correlated => 1.0 / (hidden + self.lambda(wo)),
            _ => self.shadowing(wi, wo, wh),
        };
        let weight = self.material.reflectance(wi.dot(wh)) * hidden * g;
        (pdf > 0.0).then_some(BrdfSample { wo, weight, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 || self.is_core() {
            return 0.0;
        }
        let d = self.density_along(wi + wo);
        if d == 0.0 { 0.0 } else { d / (4.0 * wi.z * (1.0 + self.lambda(wi))) }
    }

    /// Averaged over the incident azimuth if the surface is anisotropic.
    fn albedo(&self, theta_i: f64) -> f64 {
        if self.is_core() {
            return self.material.reflectance(theta_i.cos());
        }
        let azimuths = if self.alpha[0] == self.alpha[1] { 1 } else { AZIMUTHS };
        self.albedo.get_or_init(|| AlbedoTable::new(azimuths, |wi| self.integrate(wi))).at(theta_i)
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        if self.alpha[0] == self.alpha[1] { self.albedo(theta(wi)) } else { self.integrate(wi) }
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        if self.is_core() && wi.z > 0.0 { self.material.reflectance(wi.z) } else { 0.0 }
    }
}
