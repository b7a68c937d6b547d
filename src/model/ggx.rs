//! GGX (Trowbridge-Reitz) microfacets: slopes with long tails, the haze around a highlight.
//!
//! `f_r = R(beta) D G / (4 cos_theta_i cos_theta_r)`, `D = alpha^2 / (pi ((alpha^2 - 1) cos^2 theta_h + 1)^2)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `alpha` | slope within which half of the facets lie | | 0 to 2 |
//! | `alpha_x`, `alpha_y` | the same along x and y, instead of `alpha` | | 0 to 2 |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//! | `shadowing` | the factor G; `correlated` by default | | see [`super::microfacet`] |
//!
//! `Lambda(v) = (sqrt(1 + 1 / v^2) - 1) / 2`, `v = cot theta / alpha(phi)`; `G = 1 / (1 + Lambda_i + Lambda_o)`.
//! The rms slope is infinite: alpha here is not that of a measured Gaussian surface.
//!
//! Energy: single scatter, albedo at most R; what would scatter twice is lost (12 % at alpha 0.3 and normal
//! incidence). Reciprocal. Alpha below 1e-4 is a specular core.
//!
//! Sampling: visible normals, pdf `G1 D / (4 cos_theta_i)`, weight `R (1 + Lambda_i) G <= R`.
//!
//! Picture: `asperity lobe ggx:alpha=0.05,n=1.5 ggx:alpha=0.2,n=1.5 --theta-i 20,60,80 -o ggx.svg`
//!
//! Sources: Trowbridge and Reitz 1975; Walter et al., EGSR 2007, equations 33-34; sampling: Dupuy and Benyoub,
//! Sampling visible GGX normals with spherical caps, Computer Graphics Forum 42(8), 2023.

use super::beckmann::ROUGH_INTERFACE;
use super::microfacet::{Microfacet, SHADOWING, Shadowing, Shape};
use super::registry::Entry;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "ggx",
    summary: "rough interface with long-tailed slopes (Trowbridge-Reitz)",
    formula: "f_r = R D G / (4 cos_theta_i cos_theta_r), D = alpha^2 / (pi ((alpha^2 - 1) cos^2 + 1)^2)",
    parameters: ROUGH_INTERFACE,
    words: &[SHADOWING],
    interface: true,
    exceeds_one: true,
    energy: "albedo <= R, multiple scattering is lost; with shadowing=none it exceeds 1 at grazing",
    source: "Trowbridge and Reitz 1975; Walter et al. 2007; Heitz 2014",
    example: "ggx:alpha=0.1,n=1.5",
    build: |v| {
        let shadowing = Shadowing::named(v.word("shadowing"));
        Ok(Box::new(Ggx::new(v.alpha()?, v.material()?).with_shadowing(shadowing)))
    },
    ..Entry::PLAIN
};

/// Rough interface with GGX slopes.
pub type Ggx = Microfacet<GgxSlopes>;

/// `P(e) = 1 / (pi (1 + e)^2)`.
#[derive(Debug, Clone, Copy, Default)]
pub struct GgxSlopes;

impl Shape for GgxSlopes {
    fn slope_density(e: f64) -> f64 {
        FRAC_1_PI / ((1.0 + e) * (1.0 + e))
    }

    fn distribution(e: f64) -> f64 {
        if e.is_finite() { e / (1.0 + e) } else { 1.0 }
    }

    fn quantile(c: f64) -> f64 {
        c / (1.0 - c)
    }

    fn lambda(z2: f64, s2: f64) -> f64 {
        // (sqrt(1 + x) - 1) / 2 without cancellation at small x.
        let x = s2 / z2;
        if x.is_finite() { 0.5 * x / ((1.0 + x).sqrt() + 1.0) } else { f64::INFINITY }
    }

    fn share_below(v: f64) -> f64 {
        // The slopes along one axis have density 1 / (2 (1 + x^2)^1.5).
        if v.is_finite() { 0.5 + 0.5 * v / (1.0 + v * v).sqrt() } else { 1.0 }
    }

    fn sample_normal(alpha: [f64; 2], wi: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(alpha[0] * wi.x, alpha[1] * wi.y, wi.z).normalize();
        // The reflections of visible normals of a hemisphere fill a cap uniformly.
        let z = (1.0 - u[0]) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let h = DVec3::new(radius * c, radius * s, z) + stretched;
        DVec3::new(alpha[0] * h.x, alpha[1] * h.y, h.z.max(0.0)).try_normalize().unwrap_or(DVec3::Z)
    }
}
