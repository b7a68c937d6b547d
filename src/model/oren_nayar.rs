//! Oren-Nayar: a rough matte surface of Lambertian V-cavities, brighter towards the source.
//!
//! `f_r = L1 + L2`, `L1 = rho/pi [C1 + cos dphi C2 tan b + (1 - |cos dphi|) C3 tan((a + b)/2)]`,
//! `L2 = 0.17 rho^2/pi s2/(s2 + 0.13) [1 - cos dphi (2 b/pi)^2]`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho` | albedo of the facets | | 0 to 1 |
//! | `sigma` | standard deviation of the facet angle | deg or rad | 0 to 60 deg |
//! | `form` | `full`, or `qualitative`: `rho/pi [A + B max(0, cos dphi) sin a tan b]` | | |
//!
//! `s2 = sigma^2`; `a`, `b` the larger and smaller of theta_i, theta_r; `dphi = phi_r - phi_i`, 0 when looking from the
//! source. `C1 = A = 1 - 0.5 s2/(s2 + 0.33)`; `C2 = 0.45 s2/(s2 + 0.09)` times `sin a` for `cos dphi >= 0`, else times
//! `sin a - (2 b/pi)^3`; `C3 = 0.125 s2/(s2 + 0.09) (4 a b/pi^2)^2`; `B = 0.45 s2/(s2 + 0.09)`.
//!
//! Energy: nearly conserving. The full form with rho 1 reaches 1.03 (sigma 10 deg) or 1.04 (20 deg) at 89 deg; the
//! qualitative form loses light (0.77 at normal incidence, sigma 30 deg). Reciprocal. `tan b` is held below that of 89.9
//! deg, and a sum that turns negative (both directions grazing, opposite) is 0.
//!
//! Sampling: cosine, pdf `cos_theta_r / pi`, weight `pi f_r`.
//!
//! Picture: `asperity lobe oren-nayar:rho=0.8,sigma=30deg lambert:rho=0.8 -o oren_nayar.svg`
//!
//! Source: M. Oren and S. K. Nayar, SIGGRAPH 1994, equations 30 (qualitative) and the functional form of section 4.3.

use super::albedo::{AlbedoTable, DRAWS, sampled_average};
use super::lambert::cosine_direction;
use super::parameter::{Parameter, Unit, Word};
use super::registry::Entry;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_3};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "oren-nayar",
    summary: "rough matte surface, brighter towards the source",
    formula: "f_r = rho/pi [C1 + cos dphi C2 tan b + (1 - |cos dphi|) C3 tan((a+b)/2)] + interreflection",
    parameters: &[
        Parameter::number("rho", "albedo of the facets", 0.0, 1.0),
        Parameter::number("sigma", "standard deviation of the facet angle", 0.0, FRAC_PI_3)
            .unit(Unit::Angle)
            .usual(0.0, 0.7),
    ],
    words: &[Word {
        name: "form",
        meaning: "with interreflection, or the short formula",
        options: &["full", "qualitative"],
    }],
    exceeds_one: true,
    energy: "albedo up to 1.04 rho at grazing in the full form; the qualitative form loses light",
    source: "Oren and Nayar 1994",
    example: "oren-nayar:rho=0.8,sigma=20deg",
    build: |v| {
        let full = v.word("form") == Some("full");
        Ok(Box::new(OrenNayar::new(v.required("rho")?, v.required("sigma")?, full)))
    },
    ..Entry::PLAIN
};

/// Largest `tan b`: that of 89.9 deg.
const LARGEST_TANGENT: f64 = 572.957;

/// Rough matte surface.
#[derive(Debug, Clone)]
pub struct OrenNayar {
    rho: f64,
    full: bool,
    /// `C1 = A`, `0.45 s2/(s2 + 0.09)`, `0.125 s2/(s2 + 0.09) (4/pi^2)^2`, `0.17 rho s2/(s2 + 0.13)`.
    c1: f64,
    c2: f64,
    c3: f64,
    again: f64,
    albedo: OnceLock<AlbedoTable>,
}

impl OrenNayar {
    /// Facets of albedo `rho` and angle spread `sigma` \[rad\], in the full or the qualitative form.
    pub fn new(rho: f64, sigma: f64, full: bool) -> Self {
        let s2 = sigma * sigma;
        let spread = s2 / (s2 + 0.09);
        OrenNayar {
            rho,
            full,
            c1: 1.0 - 0.5 * s2 / (s2 + 0.33),
            c2: 0.45 * spread,
            c3: 0.125 * spread * FRAC_2_PI.powi(4),
            again: 0.17 * rho * s2 / (s2 + 0.13),
            albedo: OnceLock::new(),
        }
    }

    /// `[A, B]` of the qualitative form.
    pub fn a_b(&self) -> [f64; 2] {
        [self.c1, self.c2]
    }
}

impl Brdf for OrenNayar {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (steep, flat) = if wi.z < wo.z { (wi.z, wo.z) } else { (wo.z, wi.z) };
        let sine = |z: f64| (1.0 - z * z).max(0.0).sqrt();
        let (sin_a, sin_b) = (sine(steep), sine(flat));
        let both = sin_a * sin_b;
        let cos_dphi = if both > 0.0 { ((wi.x * wo.x + wi.y * wo.y) / both).clamp(-1.0, 1.0) } else { 1.0 };
        let tan_b = (sin_b / flat).min(LARGEST_TANGENT);
        if !self.full {
            return self.rho * FRAC_1_PI * (self.c1 + self.c2 * cos_dphi.max(0.0) * sin_a * tan_b);
        }
        let (a, b) = (sin_a.atan2(steep), sin_b.atan2(flat));
        let bent = FRAC_2_PI * b;
        let c2 = self.c2 * if cos_dphi >= 0.0 { sin_a } else { sin_a - bent * bent * bent };
        let c3 = self.c3 * (a * b) * (a * b);
        // tan((a + b) / 2) = sin(a + b) / (1 + cos(a + b)).
        let half_tangent = (sin_a * flat + steep * sin_b) / (1.0 + steep * flat - both).max(1e-12);
        let half_tangent = half_tangent.min(LARGEST_TANGENT);
        let direct = self.c1 + cos_dphi * c2 * tan_b + (1.0 - cos_dphi.abs()) * c3 * half_tangent;
        let again = self.again * (1.0 - cos_dphi * bent * bent);
        self.rho * FRAC_1_PI * (direct + again).max(0.0)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let wo = cosine_direction(u);
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 { wo.z.max(0.0) * FRAC_1_PI } else { 0.0 }
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.albedo.get_or_init(|| AlbedoTable::new(1, |wi| sampled_average(self, wi, DRAWS))).at(theta_i)
    }
}
