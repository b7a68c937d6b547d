//! Metallic paint as a multi-angle instrument reads it: tristimulus values at three angles from the mirror direction.
//!
//! `f_r = sum_k s_k X_k(gamma) / pi`, `s_k` the linear sRGB of tristimulus value k of the perfect diffuser, `X_k` its
//! reflectance factor through 15, 45 and 110 deg ([`Metallic`]).

use super::spectral::{Spectral, tristimulus_shares};
use crate::error::{Error, Result};
use crate::math::frame::theta;
use crate::model::metallic::Metallic;
use crate::optics::colour::{Illuminant, white};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::sync::Arc;

/// X, Y, Z at 15, 45 and 110 deg from the mirror direction under D65 and the CIE 1931 observer, Y = 100 for the perfect
/// diffuser (ASTM E2194, ASTM E308).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetallicPaint {
    pub xyz: [[f64; 3]; 3],
}

impl MetallicPaint {
    /// # Errors
    /// `Error::Parameter` if a value is negative, above 10 000, or not a number.
    pub fn new(xyz: [[f64; 3]; 3]) -> Result<Self> {
        if let Some(bad) = xyz.iter().flatten().find(|v| !(0.0..=1e4).contains(*v)) {
            return Err(Error::parameter(
                format!("{bad} is no tristimulus value of a paint"),
                "give X, Y, Z from 0 up, with Y = 100 for the perfect diffuser",
            ));
        }
        Ok(MetallicPaint { xyz })
    }

    /// Reflectance factor of the tristimulus value `k` relative to that of the perfect diffuser, at the three angles.
    pub fn factors(&self, k: usize) -> [f64; 3] {
        let white = white(Illuminant::D65)[k];
        self.xyz.map(|angle| angle[k] / (100.0 * white))
    }

    /// The flakes alone.
    pub fn bare(&self) -> Spectral {
        let part = |(k, share)| -> (Box<dyn Brdf>, DVec3) { (Box::new(Metallic::new(self.factors(k))), share) };
        Spectral::sum(tristimulus_shares().into_iter().enumerate().map(part).collect())
    }

    /// The flakes under a first surface, by the rule of [`crate::model::Layered`], with the colourless coat counted once.
    pub fn coated(&self, coat: Box<dyn Brdf>) -> Spectral {
        let coat: Arc<dyn Brdf> = coat.into();
        let mut parts: Vec<(Box<dyn Brdf>, DVec3)> = vec![(Box::new(Coat(coat.clone())), DVec3::ONE)];
        for (k, share) in tristimulus_shares().into_iter().enumerate() {
            parts.push((Box::new(Under { coat: coat.clone(), base: Metallic::new(self.factors(k)) }), share));
        }
        Spectral::sum(parts)
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

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.0.specular_core(wi)
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
    use crate::model::{Layered, parse};
    use crate::render::spectral::to_linear_srgb;

    const RED: MetallicPaint = MetallicPaint { xyz: [[68.30, 52.97, 19.87], [17.50, 12.26, 3.72], [5.14, 3.59, 1.27]] };

    /// What the paint sends to a multi-angle instrument is what the instrument read.
    #[test]
    fn the_instrument_reads_what_went_in() {
        let paint = RED.bare();
        let wi = direction(45f64.to_radians(), 0.0);
        for (angle, xyz) in [15.0f64, 45.0, 110.0].into_iter().zip(RED.xyz) {
            // In the plane of incidence, from the mirror direction towards the source.
            let turned = (45.0 - angle).to_radians();
            let wo = DVec3::new(-turned.sin(), 0.0, turned.cos());
            // The perfect diffuser is exactly white, whatever the rounding of the matrix.
            let diffuser = to_linear_srgb(DVec3::from(white(Illuminant::D65)));
            let expected = to_linear_srgb(DVec3::from(xyz) / 100.0) / diffuser;
            let read = paint.eval_and_pdf(wi, wo).0 * std::f64::consts::PI;
            assert!(
                (read - expected).abs().max_element() < 1e-4 * expected.max_element(),
                "{angle}: {read} {expected}"
            );
        }
        assert!(MetallicPaint::new([[1.0, -1.0, 1.0]; 3]).is_err() && MetallicPaint::new([[f64::NAN; 3]; 3]).is_err());
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
