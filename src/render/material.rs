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
    /// Albedo of an ideal diffuser, else below 0.
    matt: f64,
    /// Coats of one reflector have one number in a scene.
    group: usize,
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

impl Reflector<'_> {
    /// Whether both are one and the same; values without a size have no place to tell them apart by.
    fn is(&self, other: &Reflector) -> bool {
        match (self, other) {
            (Reflector::Grey(a), Reflector::Grey(b)) => std::ptr::addr_eq(*a, *b) && size_of_val(*a) > 0,
            (Reflector::Spectral(a), Reflector::Spectral(b)) => std::ptr::eq(*a, *b),
            _ => false,
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
        let matt = match reflector {
            Reflector::Grey(brdf) => brdf.diffuser().unwrap_or(-1.0),
            Reflector::Spectral(_) => -1.0,
        };
        Coat { reflector, tint, delta, has_core, matt, group: 0 }
    }

    /// Whether only a specular core reflects.
    #[inline(always)]
    pub(super) fn is_delta(&self) -> bool {
        self.delta
    }

    /// Albedo, if it is an ideal diffuser.
    #[inline(always)]
    pub(super) fn matt(&self) -> Option<f64> {
        (self.matt >= 0.0).then_some(self.matt)
    }

    #[inline(always)]
    pub(super) fn tint(&self) -> DVec3 {
        self.tint
    }

    #[inline(always)]
    pub(super) fn group(&self) -> usize {
        self.group
    }

    /// The BRDF, if it is one for all channels.
    #[inline(always)]
    pub(super) fn grey(&self) -> Option<&'a dyn Brdf> {
        if let Reflector::Grey(brdf) = self.reflector { Some(brdf) } else { None }
    }

    /// `f_r` per channel without tint, and the density of [`Self::sample`], of many pairs; `grey` is room to work in.
    #[inline(always)]
    pub(super) fn evaluate(&self, wi: &[DVec3], wo: &[DVec3], found: &mut [(DVec3, f64)], grey: &mut Vec<(f64, f64)>) {
        match self.reflector {
            Reflector::Grey(brdf) => {
                grey.clear();
                grey.resize(wi.len(), (0.0, 0.0));
                brdf.eval_and_pdf_many(wi, wo, grey);
                for (found, (f_r, pdf)) in found.iter_mut().zip(grey) {
                    *found = (DVec3::splat(*f_r), *pdf);
                }
            }
            Reflector::Spectral(spectral) => {
                for ((wi, wo), found) in wi.iter().zip(wo).zip(found) {
                    *found = spectral.eval_and_pdf(*wi, *wo);
                }
            }
        }
    }

    /// A direction by the BRDF's own density; the weight is without tint.
    #[inline(always)]
    pub(super) fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<ColourDraw> {
        match self.reflector {
            Reflector::Grey(brdf) => brdf.sample(wi, u).map(ColourDraw::from),
            Reflector::Spectral(spectral) => spectral.sample(wi, u),
        }
    }

    /// The specular core as one of [`Self::core_share`] of all draws, the rest uniform over the hemisphere; the weight is without tint.
    pub(super) fn core_draw(&self, wi: DVec3) -> ColourDraw {
        let core = match self.reflector {
            Reflector::Grey(brdf) => DVec3::splat(brdf.specular_core(wi)),
            Reflector::Spectral(spectral) => spectral.specular_core(wi),
        };
        let weight = core / self.core_share();
        ColourDraw { wo: reflect(wi, DVec3::Z), weight, pdf: f64::INFINITY, specular: true }
    }

    /// Density of the directions uniform over the hemisphere that remain beside [`Self::core_draw`].
    pub(super) fn uniform_pdf(&self) -> f64 {
        (1.0 - self.core_share()) / TAU
    }

    /// Share of the draws that goes to the specular core where directions are uniform: half of them if there is one.
    #[inline(always)]
    pub(super) fn core_share(&self) -> f64 {
        match (self.delta, self.has_core) {
            (true, _) => 1.0,
            (false, true) => 0.5,
            (false, false) => 0.0,
        }
    }
}

impl<'a> Cover<'a> {
    /// Gives each coat the number of its reflector in `reflectors`, which grows by those that are new.
    pub(super) fn join(&mut self, reflectors: &mut Vec<Reflector<'a>>) {
        let coats = match self {
            Cover::Plain(coat) | Cover::Painted(coat, _) => std::slice::from_mut(coat),
            Cover::Checker(coats, _) => &mut coats[..],
        };
        for coat in coats {
            coat.group = reflectors.iter().position(|r| r.is(&coat.reflector)).unwrap_or_else(|| {
                reflectors.push(coat.reflector);
                reflectors.len() - 1
            });
        }
    }
}

/// Whether a place lies in a cell of the second coat of a checker: `floor(x / size) + floor(y / size) + floor(z / size)` is
/// odd. In metres from the corner of a plane, or in space where the shape has no plane.
#[inline(always)]
pub(super) fn odd_cell(place: DVec3, inverse_size: f64) -> bool {
    let cell = (place * inverse_size).floor();
    let half = 0.5 * (cell.x + cell.y + cell.z);
    half > half.floor()
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
        let odd = |x: f64, y: f64| odd_cell(DVec3::new(x, y, 0.0), 1.0 / 2.0);
        assert_eq!([odd(1.0, 1.0), odd(3.0, 1.0), odd(3.0, 3.0), odd(-1.0, 1.0)], [false, true, false, true]);
    }
}
