//! The metallic paints of the figures.

use crate::meter::appearance::flop_index;
use crate::optics::colour::{Illuminant, lab, white};
use crate::render::MetallicPaint;

/// Flakes of one colour.
#[derive(Debug, Clone, Copy)]
pub struct Paint {
    pub name: &'static str,
    pub flakes: MetallicPaint,
}

/// Demonstration values chosen for this program, not measured: flakes that are bright near the mirror direction and dark
/// away from it.
pub const BLUE: Paint = paint("blue", [[47.25, 46.17, 124.66], [11.88, 10.64, 37.37], [3.15, 2.79, 9.83]]);
/// As [`BLUE`].
pub const RED: Paint = paint("red", [[68.30, 52.97, 19.87], [17.50, 12.26, 3.72], [5.14, 3.59, 1.27]]);
/// As [`BLUE`].
pub const GOLD: Paint = paint("gold", [[80.37, 83.40, 34.57], [20.39, 20.51, 7.14], [5.55, 5.48, 2.09]]);

const fn paint(name: &'static str, xyz: [[f64; 3]; 3]) -> Paint {
    Paint { name, flakes: MetallicPaint { xyz } }
}

impl Paint {
    /// Luminance factors at the three angles.
    pub fn luminance(&self) -> [f64; 3] {
        self.flakes.xyz.map(|xyz| xyz[1] / 100.0)
    }

    /// Flop index from the lightness at the three angles.
    pub fn flop(&self) -> Option<f64> {
        let white = white(Illuminant::D65);
        let [l15, l45, l110] = self.flakes.xyz.map(|xyz| lab(xyz.map(|x| x / 100.0), white)[0]);
        flop_index(l15, l45, l110)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::metallic::{Falloff, Metallic};
    use crate::optics::Brdf;
    use crate::render::spectral::to_linear_srgb;
    use glam::DVec3;

    /// Between the three angles and beyond them the colours stay inside sRGB, and no paint gives more than it gets.
    #[test]
    fn paints_can_be_shown_and_keep_their_energy() {
        for paint in [BLUE, RED, GOLD] {
            let falloffs = [0, 1, 2].map(|k| Falloff::through(paint.flakes.factors(k)));
            for degrees in 0..=180 {
                let at = |k: usize| falloffs[k].at(f64::from(degrees).to_radians()) * white(Illuminant::D65)[k];
                let rgb = to_linear_srgb(DVec3::new(at(0), at(1), at(2)));
                assert!(rgb.min_element() >= 0.0, "{} at {degrees} deg: {rgb}", paint.name);
            }
            for k in 0..3 {
                let brdf = Metallic::new(paint.flakes.factors(k));
                for theta in [0.0, 0.5, 1.0, 1.4] {
                    assert!(brdf.albedo(theta) < 0.9, "{} {k} {theta}: {}", paint.name, brdf.albedo(theta));
                }
            }
        }
    }
}
