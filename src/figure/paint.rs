//! Metallic paints as tristimulus values at three aspecular angles, interpolated between them.

use super::finish::Finish;
use crate::error::Result;
use crate::meter::appearance::flop_index;
use crate::model::Layered;
use crate::model::metallic::Metallic;
use crate::optics::Brdf;
use crate::optics::colour::{Illuminant, lab, white};
use crate::render::Spectral;

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
    ///
    /// # Errors
    /// None for finite readings.
    pub fn bare(&self) -> Result<Finish> {
        let part = |k: usize| -> Result<Box<dyn Brdf>> { Ok(Box::new(Metallic::new(self.factors(k)))) };
        Ok(Finish::Colour(Spectral::tristimulus(&part)?))
    }

    /// The flakes under a first surface.
    ///
    /// # Errors
    /// Those of `coat`.
    pub fn coated(&self, coat: &dyn Fn() -> Result<Box<dyn Brdf>>) -> Result<Finish> {
        let part = |k: usize| -> Result<Box<dyn Brdf>> {
            Ok(Box::new(Layered::new(coat()?, Box::new(Metallic::new(self.factors(k))))))
        };
        Ok(Finish::Colour(Spectral::tristimulus(&part)?))
    }

    /// Flop index from the lightness at the three angles.
    pub fn flop(&self) -> Option<f64> {
        let white = white(Illuminant::D65);
        let [l15, l45, l110] = self.xyz.map(|xyz| lab(xyz.map(|x| x / 100.0), white)[0]);
        flop_index(l15, l45, l110)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::metallic::Falloff;
    use crate::render::spectral::to_linear_srgb;
    use glam::DVec3;

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
}
