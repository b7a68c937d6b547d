//! A first surface over a base: clear coat over paint, gloss over metallic flakes.
//!
//! `f_r = f_coat + (1 - R_i)(1 - R_o) f_base`, `R` the directional albedo of the coat at `theta_i`, `theta_r`
//!
//! Written `layered:COAT,over=BASE`, each a model or a table: `layered:ggx:alpha=0.05,n=1.5,over=lambert:rho=0.4`. The base
//! may be layered itself.
//!
//! What the coat does not reflect reaches the base, and as much of what the base reflects leaves again. For a smooth coat
//! R is Fresnel's; for a rough one or a table it is its measured or computed directional-hemispherical reflectance, core
//! included, so the rule never counts light twice.
//!
//! Energy: conserving if both layers are: `albedo = R + (1 - R) int f_base (1 - R_o) cos`; light that goes to and fro
//! between the layers is lost. A coat whose albedo exceeds 1 lets nothing through. Reciprocal if both are.
//!
//! Sampling: coat with the probability `R / (R + (1 - R) E_base)`, else base; density of the mixture. A specular core of
//! either layer stays a branch of its own.
//!
//! Picture: `asperity lobe layered:ggx:alpha=0.05,n=1.5,over=lambert:rho=0.4 -o layered.svg`
//!
//! Source: the rule of the metallic paints of Westlund and Meyer, SIGGRAPH 2001, figure 14 of Westlund, Meyer, Hunt 2002.

use super::albedo::{AlbedoTable, CosineTable, sampled_average};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::sync::OnceLock;

/// `layered:` in front of a text.
const NAME: &str = "layered:";

/// Coat and base of `layered:COAT,over=BASE`; `None` if the text is something else.
pub fn split(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let rest = text.get(..NAME.len()).filter(|name| name.eq_ignore_ascii_case(NAME)).map(|_| &text[NAME.len()..])?;
    // Without a base the whole is the coat, and the error will say so.
    Some(rest.split_once(",over=").map_or((rest.trim(), ""), |(coat, base)| (coat.trim(), base.trim())))
}

/// Coat over base.
pub struct Layered {
    coat: Box<dyn Brdf>,
    base: Box<dyn Brdf>,
    /// Albedo of coat and base, by cosine.
    alone: OnceLock<[CosineTable; 2]>,
    through: OnceLock<AlbedoTable>,
}

/// Draws for the albedo of the base under the coat.
const DRAWS: usize = 4096;

impl Layered {
    /// Puts `coat` over `base`.
    pub fn new(coat: Box<dyn Brdf>, base: Box<dyn Brdf>) -> Self {
        Layered { coat, base, alone: OnceLock::new(), through: OnceLock::new() }
    }

    /// Albedo of coat and base alone.
    fn alone(&self) -> &[CosineTable; 2] {
        self.alone.get_or_init(|| [&self.coat, &self.base].map(|layer| CosineTable::new(|theta| layer.albedo(theta))))
    }

    /// `1 - R` of the coat.
    fn transmitted(&self, w: DVec3) -> f64 {
        (1.0 - self.alone()[0].at(w.z)).clamp(0.0, 1.0)
    }

    /// Probability of drawing from the coat.
    fn share(&self, wi: DVec3, transmitted: f64) -> f64 {
        let [coat, base] = self.alone();
        let (coat, base) = (coat.at(wi.z), transmitted * base.at(wi.z));
        if coat + base > 0.0 { coat / (coat + base) } else { 0.5 }
    }
}

impl Brdf for Layered {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let base = self.base.eval(wi, wo);
        let base = if base > 0.0 { base * self.transmitted(wi) * self.transmitted(wo) } else { 0.0 };
        self.coat.eval(wi, wo) + base
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let transmitted = self.transmitted(wi);
        let share = self.share(wi, transmitted);
        let (draw, chance, factor) = if u[0] < share {
            (self.coat.sample(wi, [u[0] / share, u[1]])?, share, 1.0)
        } else {
            let rest = ((u[0] - share) / (1.0 - share)).min(1.0 - f64::EPSILON);
            (self.base.sample(wi, [rest, u[1]])?, 1.0 - share, transmitted * transmitted)
        };
        if draw.specular {
            return Some(BrdfSample { weight: draw.weight * factor / chance, ..draw });
        }
        let pdf = self.pdf(wi, draw.wo);
        (pdf > 0.0).then(|| BrdfSample { weight: self.eval(wi, draw.wo) * draw.wo.z / pdf, pdf, ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let share = self.share(wi, self.transmitted(wi));
        share * self.coat.pdf(wi, wo) + (1.0 - share) * self.base.pdf(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        // The base lit from `wi` as seen through the coat once, on the way out.
        let through = |wi: DVec3| sampled_average(&Through { layers: self }, wi, DRAWS);
        let base = self.through.get_or_init(|| AlbedoTable::new(1, through)).at(theta_i);
        let coat = self.coat.albedo(theta_i);
        coat + (1.0 - coat).max(0.0) * base
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        let base = sampled_average(&Through { layers: self }, wi, DRAWS);
        self.coat.albedo_towards(wi) + self.transmitted(wi) * base
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        let base = self.base.specular_core(wi);
        self.coat.specular_core(wi) + if base > 0.0 { base * self.transmitted(wi).powi(2) } else { 0.0 }
    }
}

/// `f_base (1 - R_o)`, drawn as the base draws.
struct Through<'a> {
    layers: &'a Layered,
}

impl Brdf for Through<'_> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.layers.base.eval(wi, wo) * self.layers.transmitted(wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let draw = self.layers.base.sample(wi, u)?;
        Some(BrdfSample { weight: draw.weight * self.layers.transmitted(draw.wo), ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.layers.base.pdf(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.layers.base.albedo(theta_i)
    }
}
