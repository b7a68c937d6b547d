//! What covers a shape that reflects.

use super::paint::{Paint, Pattern};
use super::spectral::{ColourDraw, Spectral};
use crate::math::frame::{DVec3, direction, reflect};
use crate::optics::brdf::Brdf;
use std::f64::consts::TAU;

/// A surface that reflects: `f_r(wi, wo) tint(u, v)`, the same on both sides.
#[derive(Clone, Copy)]
pub struct Material<'a> {
    /// In the local frame z is the normal on the side that is seen and x runs along `edge_u` of a quad.
    pub brdf: &'a dyn Brdf,
    /// Linear RGB factor, to be kept at or below 1.
    pub tint: Paint,
}

/// A BRDF of one value for all channels, or of the visible spectrum.
#[derive(Clone, Copy)]
pub enum Reflector<'a> {
    Grey(&'a dyn Brdf),
    Spectral(&'a Spectral),
}

/// A reflector and the linear RGB factor on it.
#[derive(Clone, Copy)]
pub struct Coat<'a> {
    reflector: Reflector<'a>,
    tint: DVec3,
    /// Whether it has a specular core and nothing else: no lamp can be asked for.
    delta: bool,
    has_core: bool,
}

/// Everything a shape can be covered with.
#[derive(Clone, Copy)]
pub enum Cover<'a> {
    Plain(Coat<'a>),
    /// A pattern of tints in the plane coordinates of the shape.
    Painted(Coat<'a>, Paint),
    /// Cells of two coats by turns; the side of a cell \[m\].
    Checker([Coat<'a>; 2], f64),
}

impl<'a> From<Material<'a>> for Cover<'a> {
    fn from(material: Material<'a>) -> Self {
        let coat = Coat::new(Reflector::Grey(material.brdf), DVec3::ONE);
        if material.tint.pattern() == Pattern::Plain {
            Cover::Plain(Coat { tint: material.tint.mean(), ..coat })
        } else {
            Cover::Painted(coat, material.tint)
        }
    }
}

impl<'a> Coat<'a> {
    /// A coat whose tint is linear RGB, to be kept at or below 1.
    pub fn new(reflector: Reflector<'a>, tint: DVec3) -> Self {
        let angles = [0.0f64, 0.5, 1.0, 1.3];
        let core = |theta: f64| match reflector {
            Reflector::Grey(brdf) => brdf.specular_core(direction(theta, 0.3)),
            Reflector::Spectral(spectral) => spectral.specular_core(direction(theta, 0.3)).max_element(),
        };
        let albedo = |theta: f64| match reflector {
            Reflector::Grey(brdf) => brdf.albedo(theta),
            Reflector::Spectral(spectral) => spectral.albedo(theta).max_element(),
        };
        let has_core = angles.iter().any(|&t| core(t) > 0.0);
        let delta = has_core && angles.iter().all(|&t| albedo(t) <= core(t) * (1.0 + 1e-9));
        Coat { reflector, tint, delta, has_core }
    }

    /// Whether only a specular core reflects.
    #[inline(always)]
    pub(super) fn is_delta(&self) -> bool {
        self.delta
    }

    /// `f_r` per channel and the density of [`Self::sample`].
    #[inline(always)]
    pub(super) fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (DVec3, f64) {
        match self.reflector {
            Reflector::Grey(brdf) => {
                let (f_r, pdf) = brdf.eval_and_pdf(wi, wo);
                (f_r * self.tint, pdf)
            }
            Reflector::Spectral(spectral) => {
                let (f_r, pdf) = spectral.eval_and_pdf(wi, wo);
                (f_r * self.tint, pdf)
            }
        }
    }

    /// A direction by the BRDF's own density.
    #[inline(always)]
    pub(super) fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<ColourDraw> {
        match self.reflector {
            Reflector::Grey(brdf) => {
                let draw = brdf.sample(wi, u)?;
                Some(ColourDraw {
                    wo: draw.wo,
                    weight: draw.weight * self.tint,
                    pdf: draw.pdf,
                    specular: draw.specular,
                })
            }
            Reflector::Spectral(spectral) => {
                let draw = spectral.sample(wi, u)?;
                Some(ColourDraw { weight: draw.weight * self.tint, ..draw })
            }
        }
    }

    /// A direction uniform over the hemisphere, half of the draws in the specular core if there is one.
    pub(super) fn sample_uniformly(&self, wi: DVec3, mut u: [f64; 2]) -> Option<ColourDraw> {
        let share = self.core_share();
        if u[0] < share {
            let core = match self.reflector {
                Reflector::Grey(brdf) => DVec3::splat(brdf.specular_core(wi)),
                Reflector::Spectral(spectral) => spectral.specular_core(wi),
            };
            let weight = core * self.tint / share;
            return Some(ColourDraw { wo: reflect(wi, DVec3::Z), weight, pdf: f64::INFINITY, specular: true });
        }
        u[0] = (u[0] - share) / (1.0 - share);
        let sin = (1.0 - u[0] * u[0]).max(0.0).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let wo = DVec3::new(sin * c, sin * s, u[0]);
        let pdf = self.uniform_pdf();
        Some(ColourDraw { wo, weight: self.eval_and_pdf(wi, wo).0 * (wo.z / pdf), pdf, specular: false })
    }

    /// Density of [`Self::sample_uniformly`] per steradian.
    pub(super) fn uniform_pdf(&self) -> f64 {
        (1.0 - self.core_share()) / TAU
    }

    fn core_share(&self) -> f64 {
        match (self.delta, self.has_core) {
            (true, _) => 1.0,
            (false, true) => 0.5,
            (false, false) => 0.0,
        }
    }
}

impl<'a> Cover<'a> {
    /// The coat at a point with plane coordinates `uv`; `place` is the point in metres from the corner of its plane, or in
    /// space where the shape has no plane.
    #[inline(always)]
    pub(super) fn at(&self, uv: impl FnOnce() -> [f64; 2], place: impl FnOnce() -> DVec3) -> Coat<'a> {
        match self {
            Cover::Plain(coat) => *coat,
            Cover::Painted(coat, paint) => Coat { tint: coat.tint * paint.colour(uv), ..*coat },
            Cover::Checker(coats, size) => {
                let cell = (place() / *size).floor();
                coats[usize::from((cell.x + cell.y + cell.z).rem_euclid(2.0) >= 1.0)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;

    #[test]
    fn a_mirror_is_a_delta_and_a_polished_floor_is_not() {
        let mirror = model::parse("mirror", 550e-9).unwrap();
        let rough = model::parse("beckmann:alpha=0.1,n=1.5", 550e-9).unwrap();
        let coat = |brdf| Coat::new(Reflector::Grey(brdf), DVec3::ONE);
        assert!(coat(mirror.as_ref()).is_delta() && !coat(rough.as_ref()).is_delta());
        assert_eq!((coat(mirror.as_ref()).core_share(), coat(rough.as_ref()).core_share()), (1.0, 0.0));
    }

    #[test]
    fn a_checker_counts_cells() {
        let matt = model::Lambert { rho: 1.0 };
        let coats = [1.0, 0.25].map(|t| Coat::new(Reflector::Grey(&matt), DVec3::splat(t)));
        let checker = Cover::Checker(coats, 2.0);
        let tint = |x: f64, y: f64| checker.at(|| [0.0; 2], || DVec3::new(x, y, 0.0)).tint.x;
        assert_eq!((tint(1.0, 1.0), tint(3.0, 1.0), tint(3.0, 3.0), tint(-1.0, 1.0)), (1.0, 0.25, 1.0, 0.25));
    }
}
