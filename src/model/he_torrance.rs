//! He-Torrance: wave optics of a Gaussian rough surface: specular core, directional diffuse, uniform diffuse.
//!
//! `f_r = R(beta) G S D / (pi cos_theta_i cos_theta_r) + rho_d / pi`, and a specular core `R exp(-g) S`
//!
//! `D = pi^2 tau^2 / (4 lambda^2) sum_{m>=1} g^m e^-g / (m! m) exp(-v_xy^2 tau^2 / (4 m))`,
//! `g = [(2 pi sigma' / lambda)(cos_theta_i + cos_theta_r)]^2`, `v = (2 pi / lambda)(wi + wo)`,
//! `G = (2 cos_beta / cos_theta_h)^2`, `S = S(theta_i) S(theta_r)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `sigma` | rms height | length | 0 to 10 um |
//! | `tau` | correlation length, where the autocorrelation falls to 1/e | length | 0.1 um to 10 mm, at least 2 sigma |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//! | `wavelength` | of the light, default that of the command | length | 0.1 um to 20 um |
//! | `rho_d` | albedo of the uniform diffuse part a(lambda), default 0 | | 0 to 1 |
//!
//! Shadowing: `S(theta) = (1 - erfc(c)/2) / (1 + Lambda)`, `c = tau cot theta / (2 sigma)`, `Lambda = (exp(-c^2) / (c sqrt
//! pi) - erfc c) / 2`. A version without `exp(-c^2)` circulates; it darkens 20 deg by 2.7 % and 75 deg by 23 % where the
//! truth is 0 and 0.5 % (sigma/tau 0.067). The roughness that counts, `sigma' = sigma / sqrt(1 + (z0/sigma)^2)`, leaves
//! out what lies in shadow: `x exp(x^2) = (K_i + K_r) / (4 sqrt pi)`, `x = z0 / (sigma sqrt 2)`, `K = tan theta erfc c`.
//!
//! Validity: tangent planes, tau >= about 4 sigma and above a wavelength. Energy: albedo at most R up to grazing, where
//! nothing bounds it. Reciprocal; what scatters twice is lost. Rough (g >> 1) it is Beckmann with alpha 2 sigma / tau
//! under another G.
//!
//! Sampling: the sum is a Poisson mixture: m of mean g0 = g at the mirror direction, 0 is the core; else `v_xy` is Gaussian
//! of variance `2 m / tau^2` an axis, refused where it leaves the hemisphere. The pdf is that of the mixture, the same sum
//! at g0; weight `R S cos_beta^2 / (cos_theta_h^2 cos_theta_i cos_theta_r)` times the ratio of both sums.
//!
//! Picture: `asperity lobe he-torrance:sigma=0.05um,tau=3um,n=1.5 he-torrance:sigma=0.2um,tau=3um,n=1.5 -o he.svg`
//!
//! Source: X. D. He, K. E. Torrance, F. X. Sillion, D. P. Greenberg, SIGGRAPH 1991; shadowing: B. G. Smith, IEEE
//! Transactions AP-15, 668, 1967; sampling ours.

use super::albedo::{AlbedoTable, sampled_average};
use super::beckmann::GaussianSlopes;
use super::floor::WithFloor;
use super::microfacet::Shape;
use super::parameter::{Parameter, Unit};
use super::poisson_series::{draw, sigma};
use super::registry::Entry;
use super::smooth::{EXTINCTION, INDEX};
use crate::error::Result;
use crate::math::half_vector;
use crate::optics::{Brdf, BrdfSample, Material};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "he-torrance",
    summary: "wave optics of a Gaussian rough surface: specular core, directional and uniform diffuse",
    formula: "f_r = R G S D / (pi cos_theta_i cos_theta_r) + rho_d/pi, core R exp(-g) S",
    parameters: &[
        Parameter::number("sigma", "rms height", 0.0, 1e-5).unit(Unit::Length).decades(2e-8, 5e-7),
        Parameter::number("tau", "correlation length", 1e-7, 1e-2).unit(Unit::Length).decades(2e-6, 3e-5),
        INDEX,
        EXTINCTION,
        Parameter::number("rho_d", "albedo of the uniform diffuse part", 0.0, 1.0).usual(0.0, 0.5).or(0.0),
    ],
    interface: true,
    wave: true,
    energy: "albedo <= R + rho_d except within a few degrees of grazing",
    source: "He, Torrance, Sillion, Greenberg 1991; Smith 1967",
    example: "he-torrance:sigma=0.2um,tau=3um,n=1.5,wavelength=550nm",
    build: |v| {
        let (rho_d, material) = (v.required("rho_d")?, v.material()?);
        let [height, length] = [v.required("sigma")?, v.required("tau")?];
        let lobe = HeTorrance::new(height, length, material, v.wavelength)?;
        Ok(Box::new(WithFloor::new(rho_d, material.reflectance(0.5), lobe)))
    },
    ..Entry::PLAIN
};

/// Draws for the albedo; one takes about a microsecond.
const DRAWS: usize = 2048;

/// Core and directional diffuse part.
#[derive(Debug, Clone)]
pub struct HeTorrance {
    height: f64,
    length: f64,
    material: Material,
    /// `2 pi / lambda` [1/m].
    k: f64,
    albedo: OnceLock<AlbedoTable>,
}

/// The factors of one pair of directions, as reference programs print them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// Rms height that counts \[m\].
    pub sigma_effective: f64,
    pub g: f64,
    pub d: f64,
    pub geometry: f64,
    pub shadowing: f64,
}

impl HeTorrance {
    /// Rms height and correlation length \[m\] of an interface, seen at `wavelength` \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` if the correlation length is below twice the rms height: slopes are then too steep for tangent
    /// planes.
    pub fn new(height: f64, length: f64, material: Material, wavelength: f64) -> Result<Self> {
        if length < 2.0 * height {
            let (t, s) = (Unit::Length.write(length), Unit::Length.write(height));
            return Err(ENTRY.error(format!("`tau={t}` is below twice `sigma={s}`, too steep for tangent planes")));
        }
        Ok(HeTorrance { height, length, material, k: TAU / wavelength, albedo: OnceLock::new() })
    }

    /// `c = tau cot theta / (2 sigma)`.
    fn cot(&self, w: DVec3) -> f64 {
        w.z * self.length / (2.0 * self.height * (w.x * w.x + w.y * w.y).sqrt())
    }

    /// `S(theta)` and `K`, of `c`.
    fn shadow(&self, c: f64) -> (f64, f64) {
        if c > 6.0 {
            return (1.0, 0.0);
        }
        let hidden = libm::erfc(c);
        let tangent = self.length / (2.0 * self.height * c);
        ((1.0 - 0.5 * hidden) / (1.0 + GaussianSlopes::lambda(c * c, 1.0)), tangent * hidden)
    }

    /// `S` and `sigma'` for a pair of directions.
    fn surface(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        let (ci, co) = (self.cot(wi), self.cot(wo));
        // Most pairs see everything.
        if ci.min(co) > 6.0 || self.height == 0.0 {
            return (1.0, self.height);
        }
        let ((si, ki), (so, ko)) = (self.shadow(ci), self.shadow(co));
        let x = hidden_height((ki + ko) / (4.0 * PI.sqrt()));
        (si * so, self.height / (1.0 + 2.0 * x * x).sqrt())
    }

    /// `g` for the roughness `height`.
    fn phase(&self, height: f64, wi: DVec3, wo: DVec3) -> f64 {
        let p = self.k * height * (wi.z + wo.z);
        p * p
    }

    /// `v_xy^2 tau^2 / 4`.
    fn spread(&self, wi: DVec3, wo: DVec3) -> f64 {
        let (x, y) = (wi.x + wo.x, wi.y + wo.y);
        let scale = 0.5 * self.k * self.length;
        (x * x + y * y) * scale * scale
    }

    /// Every factor of the directional diffuse part.
    pub fn factors(&self, wi: DVec3, wo: DVec3) -> Factors {
        let (shadowing, sigma_effective) = self.surface(wi, wo);
        let g = self.phase(sigma_effective, wi, wo);
        let wh = half_vector(wi, wo);
        let d = (0.25 * self.k * self.length).powi(2) * sigma(g, self.spread(wi, wo));
        Factors { sigma_effective, g, d, geometry: (2.0 * wi.dot(wh) / wh.z).powi(2), shadowing }
    }

    /// `S` and `g` at the mirror direction.
    fn mirror(&self, wi: DVec3) -> (f64, f64) {
        let (s, height) = self.surface(wi, wi);
        (s, self.phase(height, wi, wi))
    }
}

/// `x` with `x exp(x^2) = a`, `a >= 0`.
fn hidden_height(a: f64) -> f64 {
    if a == 0.0 {
        return 0.0;
    }
    // Light along the horizon: the logarithm keeps the answer finite.
    let a = a.min(1e300);
    let mut x = if a < 1.0 { a / (1.0 + a * a) } else { a.ln().sqrt().max(0.6) };
    for _ in 0..30 {
        // Newton on ln x + x^2 = ln a: concave in x, no overflow.
        let step = ((a / x).ln() - x * x) / (1.0 / x + 2.0 * x);
        x = (x + step).max(0.1 * x);
        if step.abs() < 1e-12 * x {
            break;
        }
    }
    x
}

impl Brdf for HeTorrance {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let f = self.factors(wi, wo);
        if f.d == 0.0 {
            return 0.0;
        }
        let r = self.material.reflectance(wi.dot(half_vector(wi, wo)));
        r * f.geometry * f.shadowing * f.d * FRAC_1_PI / (wi.z * wo.z)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let (s, g0) = self.mirror(wi);
        let (m, rest) = draw(g0, u[0]);
        if m == 0.0 {
            // The core is chosen as often as it is strong.
            let weight = self.material.reflectance(wi.z) * s;
            return super::smooth::mirror_sample(wi, weight);
        }
        let radius = (-4.0 * m * (1.0 - rest).ln()).sqrt() / (self.length * self.k);
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let (x, y) = (radius * cos - wi.x, radius * sin - wi.y);
        let z2 = 1.0 - x * x - y * y;
        if z2 <= 0.0 {
            return None;
        }
        let wo = DVec3::new(x, y, z2.sqrt()).normalize();
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (_, g0) = self.mirror(wi);
        (self.k * self.length).powi(2) * wo.z / (4.0 * PI) * sigma(g0, self.spread(wi, wo))
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.albedo.get_or_init(|| AlbedoTable::new(1, |wi| sampled_average(self, wi, DRAWS))).at(theta_i)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let (s, g) = self.mirror(wi);
        self.material.reflectance(wi.z) * s * (-g).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_height_solves_its_equation() {
        for a in [1e-300, 1e-9, 0.01, 0.5, 1.0, 3.0, 100.0, 1e12, 1e200] {
            let x = hidden_height(a);
            assert!((x.ln() + x * x - a.ln()).abs() < 1e-9 * (1.0 + a.ln().abs()), "{a}: {x}");
        }
        assert_eq!(hidden_height(0.0), 0.0);
    }
}
