//! Beckmann microfacets: Gaussian slopes, the geometric limit of a Gaussian random surface.
//!
//! `f_r = R(beta) D G / (4 cos_theta_i cos_theta_r)`, `D = exp(-tan^2 theta_h / alpha^2) / (pi alpha^2 cos^4 theta_h)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `alpha` | sqrt 2 times the rms slope along an axis; 2 Sq / correlation length of a Gaussian surface | | 0 to 2 |
//! | `alpha_x`, `alpha_y` | the same along x and y, instead of `alpha` | | 0 to 2 |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//!
//! `Lambda(v) = (exp(-v^2) / (v sqrt pi) - erfc v) / 2`, `v = cot theta / alpha(phi)`; `G = 1 / (1 + Lambda_i + Lambda_o)`.
//! Energy: single scatter, albedo at most R; what would scatter twice is lost (0.1 % at alpha 0.3 and normal
//! incidence, 8 % at 60 deg). Reciprocal. Alpha below 1e-4 is a specular core.
//! Sampling: normals by `D cos_theta_h`, pdf `D cos_theta_h / (4 cos_beta)`.
//! Sources: Beckmann and Spizzichino 1963; Walter et al., EGSR 2007, equations 25-28; Heitz 2014, equation 72.

use super::microfacet::{Microfacet, Shape};
use super::registry::{Entry, Parameter};
use super::smooth::{EXTINCTION, INDEX};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Registry line.
pub const ENTRY: Entry = Entry {
    name: "beckmann",
    summary: "rough interface with Gaussian slopes",
    formula: "f_r = R D G / (4 cos_theta_i cos_theta_r), D = exp(-tan^2/alpha^2) / (pi alpha^2 cos^4)",
    parameters: ROUGH_INTERFACE,
    takes_material: true,
    reciprocal: true,
    energy: "albedo <= R; multiple scattering is lost",
    source: "Beckmann 1963; Walter et al. 2007; Heitz 2014",
    example: "beckmann:alpha=0.02,n=1.5",
    build: |a| Ok(Box::new(Beckmann::new(a.alpha()?, a.material()?))),
};

/// Parameters of both microfacet models.
pub const ROUGH_INTERFACE: &[Parameter] = &[
    Parameter::number("alpha", "roughness, sqrt 2 x rms slope along an axis", 0.0, 2.0),
    Parameter::number("alpha_x", "roughness along x", 0.0, 2.0),
    Parameter::number("alpha_y", "roughness along y", 0.0, 2.0),
    INDEX,
    EXTINCTION,
];

/// Rough interface with Gaussian slopes.
pub type Beckmann = Microfacet<GaussianSlopes>;

/// `P(e) = exp(-e) / pi`.
#[derive(Debug, Clone, Copy, Default)]
pub struct GaussianSlopes;

impl Shape for GaussianSlopes {
    fn slope_density(e: f64) -> f64 {
        (-e).exp() * FRAC_1_PI
    }

    fn distribution(e: f64) -> f64 {
        -(-e).exp_m1()
    }

    fn quantile(c: f64) -> f64 {
        -(-c).ln_1p()
    }

    fn lambda(v: f64) -> f64 {
        // Beyond v = 6 Lambda is below 1e-17; at v = 0 it is infinite and G rightly 0.
        if v >= 6.0 { 0.0 } else { 0.5 * ((-v * v).exp() / (v * PI.sqrt()) - libm::erfc(v)) }
    }

    fn sample_normal(alpha: [f64; 2], _wi: DVec3, u: [f64; 2]) -> DVec3 {
        let t = Self::quantile(u[0]).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        DVec3::new(alpha[0] * t * c, alpha[1] * t * s, 1.0).normalize()
    }

    fn reflected_pdf(_alpha: [f64; 2], _wi: DVec3, wh: DVec3, d: f64, cos_beta: f64) -> f64 {
        d * wh.z / (4.0 * cos_beta)
    }
}
