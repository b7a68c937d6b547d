//! Lafortune: a sum of generalised cosine lobes over a diffuse floor; what measured data were fitted with.
//!
//! `f_r = rho_d / pi + sum_j max(0, C_x wi.x wo.x + C_y wi.y wo.y + C_z wi.z wo.z)^n`, one `C` and `n` per lobe
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `rho_d` | albedo of the diffuse floor, default 0 | | 0 to 1 |
//! | `c_xy`, or `c_x` and `c_y` | horizontal coefficients: -1 mirrors, above 0 returns to the source | | -3 to 3 |
//! | `c_z` | vertical coefficient; above `-c_xy` off-specular towards the normal | | -3 to 3 |
//! | `exponent` | n | | 0.1 to 1e4 |
//! | `c_xy2`, `c_z2`, `exponent2`, ... | second and third lobe | | the same |
//!
//! `C_x = C_y = -1, C_z = 1` is a Phong lobe of peak 1. The base is set to 0 where it is negative, before the power: a
//! negative number to a power that is not whole is not a number.
//!
//! Energy: not guaranteed: the published brushed metal reflects 0.49 at normal incidence and 1.38 at 80 deg. The albedo of
//! one lobe at normal incidence is `2 pi C_z^n / (n + 2)`. Reciprocal. A lobe whose peak `max(|C_x|, |C_y|, C_z)^n`
//! exceeds 1e6 per steradian is refused.
//!
//! Sampling: a mixture of the floor and the lobes; each lobe by `cos^n` about its own axis `(C_x wi.x, C_y wi.y, C_z
//! wi.z)`, raised to the horizon where it points below. Density of the mixture, so the weight uses the whole `f_r`.
//!
//! Picture: `asperity lobe lafortune:c_xy=-1,c_z=0.9,exponent=20,rho_d=0.2 -o lafortune.svg`
//!
//! Source: E. P. F. Lafortune, S.-C. Foo, K. E. Torrance, D. P. Greenberg, SIGGRAPH 1997, equations 6-12.

use super::albedo::{AlbedoTable, DRAWS, sampled_average};
use super::lambert::cosine_direction;
use super::parameter::Parameter;
use super::phong::about_axis;
use super::registry::Entry;
use crate::error::Result;
use crate::math::frame::theta;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "lafortune",
    summary: "generalised cosine lobes over a diffuse floor",
    formula: "f_r = rho_d/pi + sum_j max(0, Cx ix ox + Cy iy oy + Cz iz oz)^n",
    parameters: &[
        HORIZONTAL,
        Parameter { name: "c_x", ..HORIZONTAL }.instead_of("c_xy"),
        Parameter { name: "c_y", ..HORIZONTAL }.instead_of("c_xy"),
        VERTICAL,
        EXPONENT,
        Parameter::number("rho_d", "albedo of the diffuse floor", 0.0, 1.0).usual(0.0, 0.6).or(0.0),
        Parameter { name: "c_xy2", ..HORIZONTAL }.optional(),
        Parameter { name: "c_x2", ..HORIZONTAL }.instead_of("c_xy2"),
        Parameter { name: "c_y2", ..HORIZONTAL }.instead_of("c_xy2"),
        Parameter { name: "c_z2", ..VERTICAL }.optional(),
        Parameter { name: "exponent2", ..EXPONENT }.optional(),
        Parameter { name: "c_xy3", ..HORIZONTAL }.optional(),
        Parameter { name: "c_x3", ..HORIZONTAL }.instead_of("c_xy3"),
        Parameter { name: "c_y3", ..HORIZONTAL }.instead_of("c_xy3"),
        Parameter { name: "c_z3", ..VERTICAL }.optional(),
        Parameter { name: "exponent3", ..EXPONENT }.optional(),
    ],
    exceeds_one: true,
    energy: "not guaranteed: published brushed metal reaches 1.38 at 80 deg",
    source: "Lafortune, Foo, Torrance, Greenberg 1997",
    example: "lafortune:c_xy=-1,c_z=0.9,exponent=20,rho_d=0.2",
    build: |v| {
        let mut lobes = Vec::new();
        for n in ["", "2", "3"] {
            let key = |name: &str| format!("{name}{n}");
            let keys = ["c_xy", "c_x", "c_y", "c_z", "exponent"].map(key);
            if !n.is_empty() && keys.iter().all(|k| v.get(k).is_none()) {
                continue;
            }
            let [x, y] = v.axes(&keys[0], &keys[1], &keys[2])?;
            let lobe = Lobe { c: DVec3::new(x, y, v.required(&keys[3])?), exponent: v.required(&keys[4])? };
            if !(lobe.peak() <= LARGEST_PEAK) {
                let what = format!("lobe {}: its peak C^n exceeds {LARGEST_PEAK:.0e} per steradian", lobes.len() + 1);
                return Err(v.error(format!("{what}; lower `{}` or the coefficients", keys[4])));
            }
            lobes.push(lobe);
        }
        Ok(Box::new(Lafortune::new(v.required("rho_d")?, lobes)?))
    },
    ..Entry::PLAIN
};

const HORIZONTAL: Parameter =
    Parameter::number("c_xy", "horizontal coefficient; -1 mirrors, above 0 returns", -3.0, 3.0).usual(-1.0, -0.5);
const VERTICAL: Parameter = Parameter::number("c_z", "vertical coefficient", -3.0, 3.0).usual(0.5, 1.0);
const EXPONENT: Parameter = Parameter::number("exponent", "sharpness n", 0.1, 1e4).decades(2.0, 200.0);

/// Largest value of one lobe [1/sr].
const LARGEST_PEAK: f64 = 1e6;

/// One lobe `max(0, (C wi) . wo)^n`, the product taken by components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    pub c: DVec3,
    pub exponent: f64,
}

impl Lobe {
    /// Largest value over all pairs of directions.
    fn peak(&self) -> f64 {
        self.c.x.abs().max(self.c.y.abs()).max(self.c.z).powf(self.exponent)
    }

    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        (self.c * wi).dot(wo).max(0.0).powf(self.exponent)
    }

    /// Axis for sampling, and the share of light the lobe is worth.
    fn axis(&self, wi: DVec3) -> (DVec3, f64) {
        let mut axis = self.c * wi;
        axis.z = axis.z.max(0.0);
        let length = axis.length();
        if length == 0.0 {
            return (DVec3::Z, 0.0);
        }
        let axis = axis / length;
        // A lobe along the horizon still reaches above it by its own width.
        let cosine = axis.z.max(0.5 / (self.exponent + 1.0).sqrt());
        (axis, length.powf(self.exponent) * cosine * TAU / (self.exponent + 1.0))
    }

    fn pdf(&self, axis: DVec3, wo: DVec3) -> f64 {
        (self.exponent + 1.0) / TAU * axis.dot(wo).max(0.0).powf(self.exponent)
    }
}

/// Lobes over a floor.
#[derive(Debug, Clone)]
pub struct Lafortune {
    rho_d: f64,
    lobes: Vec<Lobe>,
    albedo: OnceLock<AlbedoTable>,
}

impl Lafortune {
    /// Floor of albedo `rho_d` with any number of lobes.
    ///
    /// # Errors
    /// `Error::Parameter` for a lobe that is not finite or whose peak exceeds 1e6 per steradian.
    pub fn new(rho_d: f64, lobes: Vec<Lobe>) -> Result<Self> {
        match lobes.iter().position(|l| !(l.peak() <= LARGEST_PEAK && l.c.is_finite() && l.exponent >= 0.0)) {
            Some(k) => Err(ENTRY.error(format!("lobe {} has no finite peak below {LARGEST_PEAK:.0e}", k + 1))),
            None => Ok(Lafortune { rho_d, lobes, albedo: OnceLock::new() }),
        }
    }

    fn isotropic(&self) -> bool {
        self.lobes.iter().all(|l| l.c.x == l.c.y)
    }
}

impl Brdf for Lafortune {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.rho_d * FRAC_1_PI + self.lobes.iter().map(|l| l.value(wi, wo)).sum::<f64>()
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let total = self.rho_d + self.lobes.iter().map(|l| l.axis(wi).1).sum::<f64>();
        let mut left = u[0] * total;
        let wo = if left < self.rho_d {
            cosine_direction([left / self.rho_d, u[1]])
        } else {
            left -= self.rho_d;
            let mut chosen = None;
            for lobe in &self.lobes {
                let (axis, share) = lobe.axis(wi);
                if share > 0.0 {
                    // Rounding may leave a hair beyond the last lobe; it belongs to it.
                    chosen = Some((lobe, axis, (left / share).min(1.0 - f64::EPSILON)));
                    if left < share {
                        break;
                    }
                    left -= share;
                }
            }
            let (lobe, axis, rest) = chosen?;
            about_axis(axis, lobe.exponent, [rest, u[1]])
        };
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (mut sum, mut total) = (self.rho_d * wo.z * FRAC_1_PI, self.rho_d);
        for lobe in &self.lobes {
            let (axis, share) = lobe.axis(wi);
            sum += share * lobe.pdf(axis, wo);
            total += share;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        if self.isotropic() { self.albedo(theta(wi)) } else { sampled_average(self, wi, DRAWS) }
    }

    /// Averaged over the incident azimuth if a lobe is anisotropic.
    fn albedo(&self, theta_i: f64) -> f64 {
        let azimuths = if self.isotropic() { 1 } else { 8 };
        self.albedo.get_or_init(|| AlbedoTable::new(azimuths, |wi| sampled_average(self, wi, DRAWS))).at(theta_i)
    }
}
