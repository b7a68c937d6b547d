//! Metallic paints as tristimulus values at three aspecular angles, interpolated between them.

use super::finish::Finish;
use crate::math::frame::theta;
use crate::meter::appearance::flop_index;
use crate::model::metallic::Metallic;
use crate::optics::colour::{Illuminant, lab, white};
use crate::optics::{Brdf, BrdfSample};
use crate::render::Spectral;
use crate::render::spectral::tristimulus_shares;
use glam::DVec3;
use std::sync::Arc;

/// Readings of a multi-angle instrument: X, Y, Z at 15, 45 and 110 deg from the mirror direction under D65, with
/// Y = 100 for the perfect diffuser.
#[derive(Debug, Clone, Copy)]
pub struct Paint {
    pub name: &'static str,
    pub xyz: [[f64; 3]; 3],
}

/// Demonstration values chosen for this program, not measured: flakes that are bright near the mirror direction and dark
/// away from it.
pub const BLUE: Paint =
    Paint { name: "blue", xyz: [[47.25, 46.17, 124.66], [11.88, 10.64, 37.37], [3.15, 2.79, 9.83]] };
/// As [`BLUE`].
pub const RED: Paint = Paint { name: "red", xyz: [[68.30, 52.97, 19.87], [17.50, 12.26, 3.72], [5.14, 3.59, 1.27]] };
/// As [`BLUE`].
pub const GOLD: Paint = Paint { name: "gold", xyz: [[80.37, 83.40, 34.57], [20.39, 20.51, 7.14], [5.55, 5.48, 2.09]] };

impl Paint {
    /// Reflectance factor of the tristimulus value `k` relative to that of the perfect diffuser, at the three angles.
    fn factors(&self, k: usize) -> [f64; 3] {
        let white = white(Illuminant::D65)[k];
        self.xyz.map(|angle| angle[k] / (100.0 * white))
    }

    /// The flakes alone: each tristimulus value interpolated by itself.
    pub fn bare(&self) -> Finish {
        let part = |(k, share)| -> (Box<dyn Brdf>, DVec3) { (Box::new(Metallic::new(self.factors(k))), share) };
        Finish::Colour(Spectral::sum(tristimulus_shares().into_iter().enumerate().map(part).collect()))
    }

    /// The flakes under a first surface, by the rule of [`crate::model::Layered`], with the colourless coat counted once.
    pub fn coated(&self, coat: Box<dyn Brdf>) -> Finish {
        let coat: Arc<dyn Brdf> = coat.into();
        let mut parts: Vec<(Box<dyn Brdf>, DVec3)> = vec![(Box::new(Coat(coat.clone())), DVec3::ONE)];
        for (k, share) in tristimulus_shares().into_iter().enumerate() {
            parts.push((Box::new(Under { coat: coat.clone(), base: Metallic::new(self.factors(k)) }), share));
        }
        Finish::Colour(Spectral::sum(parts))
    }

    /// Flop index from the lightness at the three angles.
    pub fn flop(&self) -> Option<f64> {
        let white = white(Illuminant::D65);
        let [l15, l45, l110] = self.xyz.map(|xyz| lab(xyz.map(|x| x / 100.0), white)[0]);
        flop_index(l15, l45, l110)
    }
}

/// A first surface that is shared.
struct Coat(Arc<dyn Brdf>);

impl Brdf for Coat {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.eval(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        self.0.sample(wi, u)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.pdf(wi, wo)
    }

    fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        self.0.eval_and_pdf(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.0.albedo(theta_i)
    }
}

/// Flakes seen through a first surface: `(1 - R_i)(1 - R_o) f_base`.
struct Under {
    coat: Arc<dyn Brdf>,
    base: Metallic,
}

impl Under {
    fn transmitted(&self, w: DVec3) -> f64 {
        (1.0 - self.coat.albedo(theta(w))).clamp(0.0, 1.0)
    }
}

impl Brdf for Under {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let base = self.base.eval(wi, wo);
        if base > 0.0 { base * self.transmitted(wi) * self.transmitted(wo) } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let draw = self.base.sample(wi, u)?;
        Some(BrdfSample { weight: draw.weight * self.transmitted(wi) * self.transmitted(draw.wo), ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.base.pdf(wi, wo)
    }

    /// At most: without the way back through the coat.
    fn albedo(&self, theta_i: f64) -> f64 {
        (1.0 - self.coat.albedo(theta_i)).clamp(0.0, 1.0) * self.base.albedo(theta_i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::model::metallic::Falloff;
    use crate::model::{Layered, parse};
    use crate::render::spectral::to_linear_srgb;

    /// Between the three angles and beyond them the colours stay inside sRGB, and no paint gives more than it gets.
    #[test]
    fn paints_can_be_shown_and_keep_their_energy() {
        for paint in [BLUE, RED, GOLD] {
            let falloffs = [0, 1, 2].map(|k| Falloff::through(paint.factors(k)));
            for degrees in 0..=180 {
                let at = |k: usize| falloffs[k].at(f64::from(degrees).to_radians()) * white(Illuminant::D65)[k];
                let rgb = to_linear_srgb(DVec3::new(at(0), at(1), at(2)));
                assert!(rgb.min_element() >= 0.0, "{} at {degrees} deg: {rgb}", paint.name);
            }
            for k in 0..3 {
                let brdf = Metallic::new(paint.factors(k));
                for theta in [0.0, 0.5, 1.0, 1.4] {
                    assert!(brdf.albedo(theta) < 0.9, "{} {k} {theta}: {}", paint.name, brdf.albedo(theta));
                }
            }
        }
    }
    /// Coat and base in parts add up to the layered model of each tristimulus value.
    #[test]
    fn a_coated_paint_is_the_layered_model() {
        let coat = || parse("beckmann:alpha=0.1,n=1.5", 550e-9).unwrap();
        let shared: Arc<dyn Brdf> = coat().into();
        for k in 0..3 {
            let whole = Layered::new(coat(), Box::new(Metallic::new(RED.factors(k))));
            let under = Under { coat: shared.clone(), base: Metallic::new(RED.factors(k)) };
            for (ti, to, phi) in [(0.2, 0.3, 3.0), (1.0, 0.9, 2.5), (0.7, 0.1, 0.4)] {
                let (wi, wo) = (direction(ti, 0.0), direction(to, phi));
                let sum = shared.eval(wi, wo) + under.eval(wi, wo);
                // The layered model reads the albedo of its coat from a table over cosines.
                assert!((sum / whole.eval(wi, wo) - 1.0).abs() < 1e-4);
            }
        }
    }
}
