//! Smooth interface: mirror, clear material, metal. A specular core and nothing else.
//!
//! `f_r = R(theta_i) delta(wo - mirror(wi)) / cos_theta`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `n` | refractive index | | 1 or more (clear), above 0 with `k` |
//! | `k` | extinction coefficient (`conductor`) | | above 0 |
//! | `material` | instead of n and k: `al`, `cu`, `black-glass`, ... | | see `optics::material` |
//!
//! Energy: `albedo = R(theta_i) <= 1`; what enters a clear material is taken as absorbed below (black glass).
//! Reciprocal.
//!
//! Sampling: the one mirror direction, weight R.
//!
//! Picture: none, the core is a delta; `asperity gloss dielectric:n=1.5` reads it.
//!
//! Source: Fresnel; Born and Wolf, sections 1.5.2, 14.2.

use super::parameter::Parameter;
use super::registry::Entry;
use crate::optics::{Brdf, BrdfSample, Material};
use glam::DVec3;

/// Registry line of the perfect mirror.
pub static MIRROR: Entry = Entry {
    name: "mirror",
    summary: "perfect mirror, R = 1",
    formula: "specular core R = 1",
    parameters: &[],
    energy: "albedo = 1",
    source: "definition",
    example: "mirror",
    build: |_| Ok(Box::new(Smooth { material: Material::Mirror })),
    ..Entry::PLAIN
};

/// Registry line of the flat clear material.
pub static DIELECTRIC: Entry = Entry {
    name: "dielectric",
    summary: "flat clear material over black: polished glass, a clear coat",
    formula: "specular core R(theta_i; n)",
    parameters: &[Parameter::number("n", "refractive index", 1.0, 10.0).usual(1.3, 2.5)],
    interface: true,
    energy: "albedo = R <= 1",
    source: "Fresnel; Born and Wolf 1.5.2",
    example: "dielectric:n=1.5",
    build: |a| Ok(Box::new(Smooth { material: a.material()? })),
    ..Entry::PLAIN
};

/// Registry line of the flat metal.
pub static CONDUCTOR: Entry = Entry {
    name: "conductor",
    summary: "flat metal",
    formula: "specular core R(theta_i; n + ik)",
    parameters: &[INDEX, EXTINCTION],
    interface: true,
    energy: "albedo = R <= 1",
    source: "Fresnel; Born and Wolf 14.2",
    example: "conductor:n=1.0,k=6.6",
    build: |a| Ok(Box::new(Smooth { material: a.material()? })),
    ..Entry::PLAIN
};

/// Parameter `n` of every model with an interface.
pub const INDEX: Parameter = Parameter::number("n", "refractive index", 0.01, 10.0).usual(1.3, 2.5);
/// Parameter `k` of every model with an interface.
pub const EXTINCTION: Parameter =
    Parameter::number("k", "extinction coefficient; absent for a clear material", 0.0, 50.0).usual(1.0, 8.0).optional();

/// Smooth interface: specular core `R(theta_i)` of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smooth {
    pub material: Material,
}

impl Brdf for Smooth {
    fn eval(&self, _wi: DVec3, _wo: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wi: DVec3, _u: [f64; 2]) -> Option<BrdfSample> {
        mirror_sample(wi, self.specular_core(wi))
    }

    fn pdf(&self, _wi: DVec3, _wo: DVec3) -> f64 {
        0.0
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.material.reflectance(theta_i.cos())
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        if wi.z > 0.0 { self.material.reflectance(wi.z) } else { 0.0 }
    }
}

/// The mirror direction of `wi` with the given weight, as a draw from the specular core.
pub fn mirror_sample(wi: DVec3, weight: f64) -> Option<BrdfSample> {
    (wi.z > 0.0).then(|| BrdfSample { wo: DVec3::new(-wi.x, -wi.y, wi.z), weight, pdf: f64::INFINITY, specular: true })
}
