//! Blinn's dust: a layer of small particles that scatters once, over a diffuse floor.
//!
//! `f_r = w p(g) / (4 pi (cos_theta_i + cos_theta_r)) (1 - T) + rho_d T / pi`,
//! `T = exp(-tau (1/cos_theta_i + 1/cos_theta_r))`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `w` | albedo of one particle | | 0 to 1 |
//! | `g` | mean cosine of the scattering angle; below 0 back towards the source, default 0 | | -0.95 to 0.95 |
//! | `tau` | optical thickness of the layer, default 100 (opaque) | | 0 to 1000 |
//! | `rho_d` | albedo of the floor under the dust, default 0 | | 0 to 1 |
//!
//! `p = (1 - g^2) / (1 + g^2 - 2 g cos)^1.5` of Henyey and Greenstein, of mean 1 over the sphere, with `cos` of the angle
//! between the light's path and `wo`. Thick and g 0 it is the law of Lommel and Seeliger.
//!
//! Energy: conserving; single scattering, so light that would scatter twice is lost: albedo `(w/2)(1 - cos ln(1 + 1/cos))`
//! for g 0 and a thick layer. Reciprocal.
//!
//! Sampling: an equal mixture of the phase function (weight at most w) and a cosine, which also serves the floor.
//!
//! Picture: `asperity lobe blinn-dusty:w=0.9,g=-0.3 blinn-dusty:w=0.9,g=0.6 -o dust.svg`
//!
//! Sources: J. F. Blinn, Light reflection functions for simulation of clouds and dusty surfaces, SIGGRAPH 1982; Henyey
//! and Greenstein, Astrophysical Journal 93, 70, 1941.

use super::albedo::{AlbedoTable, DRAWS, sampled_average};
use super::lambert::cosine_direction;
use super::parameter::Parameter;
use super::registry::Entry;
use crate::math::frame::tangents;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "blinn-dusty",
    summary: "dust or cloud layer, single scattering, over a diffuse floor",
    formula: "f_r = w p(g)/(4 pi (cos_theta_i + cos_theta_r)) (1 - T) + rho_d T/pi, T = exp(-tau (1/ci + 1/cr))",
    parameters: &[
        Parameter::number("w", "albedo of one particle", 0.0, 1.0),
        Parameter::number("g", "mean cosine of the scattering angle", -0.95, 0.95).usual(-0.6, 0.6).or(0.0),
        Parameter::number("tau", "optical thickness of the layer", 0.0, 1000.0).decades(0.1, 100.0).or(100.0),
        Parameter::number("rho_d", "albedo of the floor under the dust", 0.0, 1.0).or(0.0),
    ],
    energy: "conserving; light that scatters twice is lost",
    source: "Blinn 1982; Henyey and Greenstein 1941",
    example: "blinn-dusty:w=0.8,g=0.2,tau=0.5,rho_d=0.3",
    build: |v| {
        let [w, g, tau, rho_d] = ["w", "g", "tau", "rho_d"].map(|key| v.required(key));
        Ok(Box::new(BlinnDusty { w: w?, g: g?, tau: tau?, rho_d: rho_d?, albedo: OnceLock::new() }))
    },
    ..Entry::PLAIN
};

/// Dust over a floor.
#[derive(Debug, Clone)]
pub struct BlinnDusty {
    w: f64,
    g: f64,
    tau: f64,
    rho_d: f64,
    albedo: OnceLock<AlbedoTable>,
}

impl BlinnDusty {
    /// `p / (4 pi)` [1/sr], the density of one scattering.
    fn phase(&self, wi: DVec3, wo: DVec3) -> f64 {
        let g = self.g;
        // The light travels along -wi.
        let base = (1.0 + g * g + 2.0 * g * wi.dot(wo)).max((1.0 - g.abs()).powi(2));
        (1.0 - g * g) / (base * base.sqrt()) / (4.0 * PI)
    }

    /// `wo` drawn from the phase function (Henyey and Greenstein's inverse).
    fn scatter(&self, wi: DVec3, u: [f64; 2]) -> DVec3 {
        let g = self.g;
        let cosine = if g.abs() < 1e-3 {
            // The inverse to first order in g, where the formula divides by it.
            let x = 2.0 * u[0] - 1.0;
            x + 1.5 * g * (1.0 - x * x)
        } else {
            let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
            (1.0 + g * g - s * s) / (2.0 * g)
        };
        let cosine = cosine.clamp(-1.0, 1.0);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let (t, b) = tangents(wi);
        (sine * c * t + sine * s * b - cosine * wi).normalize()
    }
}

impl Brdf for BlinnDusty {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let depth = self.tau * (wi.z + wo.z) / (wi.z * wo.z);
        // -expm1 keeps thin layers exact.
        let scattered = -(-depth).exp_m1();
        self.w * self.phase(wi, wo) / (wi.z + wo.z) * scattered + self.rho_d * FRAC_1_PI * (1.0 - scattered)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let half = |v: f64| 2.0 * v - (2.0 * v).floor();
        let wo = if u[0] < 0.5 { self.scatter(wi, [half(u[0]), u[1]]) } else { cosine_direction([half(u[0]), u[1]]) };
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 { 0.0 } else { 0.5 * (self.phase(wi, wo) + wo.z * FRAC_1_PI) }
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.albedo.get_or_init(|| AlbedoTable::new(1, |wi| sampled_average(self, wi, DRAWS))).at(theta_i)
    }
}
