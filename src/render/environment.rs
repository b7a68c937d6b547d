//! A picture of the surroundings, infinitely far away.

use super::film::Film;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use crate::sample::AliasTable;
use std::f64::consts::{PI, TAU};

/// Radiance by longitude and latitude [W/(m2 sr)], constant within a pixel: z up, the middle of the picture towards +x,
/// right of it -y.
pub struct Environment {
    width: usize,
    height: usize,
    radiance: Vec<DVec3>,
    alias: AliasTable,
    /// Density per steradian with which [`Self::sample`] draws directions of each pixel.
    pdf: Vec<f64>,
    turn: f64,
    irradiance: f64,
}

impl Environment {
    /// Surroundings from a film, `scale` times as bright, turned about z by `turn` \[rad\], counterclockwise from above.
    ///
    /// # Errors
    /// `Error::Parameter` if a radiance is negative or not finite, or all are 0.
    pub fn new(film: &Film, scale: f64, turn: f64) -> Result<Self> {
        let (width, height) = (film.width(), film.height());
        if !(scale > 0.0 && scale.is_finite() && turn.is_finite()) {
            return Err(Error::parameter(
                format!("an environment scaled by {scale} and turned by {turn} rad is not possible"),
                "give a scale above 0 and a finite angle",
            ));
        }
        let radiance: Vec<DVec3> =
            film.pixels().iter().map(|p| scale * DVec3::from(p.radiance.map(f64::from))).collect();
        if let Some(k) = radiance.iter().position(|l| !(l.is_finite() && l.min_element() >= 0.0)) {
            return Err(Error::parameter(
                format!("pixel ({}, {}) of the environment is negative or not finite", k % width, k / width),
                "mend the picture",
            ));
        }
        let solid_angle = |row: usize| {
            let z = |k: usize| (PI * k as f64 / height as f64).cos();
            TAU / width as f64 * (z(row) - z(row + 1))
        };
        let weights: Vec<f64> =
            radiance.iter().enumerate().map(|(k, l)| l.element_sum() / 3.0 * solid_angle(k / width)).collect();
        let alias = AliasTable::new(&weights).map_err(|_| {
            Error::parameter("the environment is black", "take another picture, or leave the environment out")
        })?;
        let pdf = alias.probabilities().iter().enumerate().map(|(k, p)| p / solid_angle(k / width)).collect();
        Ok(Environment { width, height, radiance, irradiance: weights.iter().sum(), alias, pdf, turn })
    }

    /// Integral of the mean of the channels over all directions [W/m2].
    pub(super) fn irradiance(&self) -> f64 {
        self.irradiance
    }

    /// Radiance from `direction` and the density of [`Self::sample`] there.
    #[inline]
    pub(super) fn look(&self, direction: DVec3) -> (DVec3, f64) {
        let k = self.pixel(direction);
        (self.radiance[k], self.pdf[k])
    }

    #[inline]
    fn pixel(&self, direction: DVec3) -> usize {
        let theta = direction.x.hypot(direction.y).atan2(direction.z);
        let phi = direction.y.atan2(direction.x) - self.turn;
        let across = (0.5 - phi / TAU).rem_euclid(1.0);
        let column = ((across * self.width as f64) as usize).min(self.width - 1);
        let row = ((theta / PI * self.height as f64) as usize).min(self.height - 1);
        row * self.width + column
    }

    /// A direction in proportion to the radiance: direction, radiance, density.
    #[inline]
    pub(super) fn sample(&self, u: [f64; 2]) -> (DVec3, DVec3, f64) {
        let (k, left) = self.alias.draw(((u[0] * (1u64 << 53) as f64) as u64) << 11);
        let (row, column) = (k / self.width, k % self.width);
        let z_at = |k: usize| (PI * k as f64 / self.height as f64).cos();
        let z = z_at(row) + u[1] * (z_at(row + 1) - z_at(row));
        let phi = self.turn + TAU * (0.5 - (column as f64 + left) / self.width as f64);
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = phi.sin_cos();
        (DVec3::new(sin * c, sin * s, z), self.radiance[k], self.pdf[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Pixel;

    fn film() -> Film {
        let mut film = Film::new(8, 4).unwrap();
        for (k, pixel) in film.pixels_mut().iter_mut().enumerate() {
            *pixel = Pixel { radiance: [k as f32, 1.0, if k == 13 { 50.0 } else { 0.0 }], ..Pixel::default() };
        }
        film
    }

    #[test]
    fn draws_look_where_they_say() {
        let environment = Environment::new(&film(), 2.0, 0.7).unwrap();
        let mut sum = 0.0;
        let n = 4000;
        for k in 0..n {
            let u = [(f64::from(k) + 0.5) / f64::from(n), (f64::from(k) * 0.618).fract()];
            let (direction, radiance, pdf) = environment.sample(u);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let (seen, density) = environment.look(direction);
            // A draw on the edge of a pixel may round into its neighbour.
            if seen == radiance {
                assert_eq!(density, pdf);
            }
            sum += radiance.element_sum() / 3.0 / pdf;
        }
        assert!((sum / f64::from(n) / environment.irradiance() - 1.0).abs() < 1e-6);
        // A uniform sky of radiance 1: 4 pi.
        let mut white = Film::new(5, 3).unwrap();
        white.pixels_mut().fill(Pixel { radiance: [1.0; 3], ..Pixel::default() });
        assert!((Environment::new(&white, 1.0, 0.0).unwrap().irradiance() - 2.0 * TAU).abs() < 1e-12);
    }

    #[test]
    fn the_middle_looks_along_x_and_the_right_along_minus_y() {
        let mut film = Film::new(4, 1).unwrap();
        for (k, pixel) in film.pixels_mut().iter_mut().enumerate() {
            pixel.radiance = [k as f32 + 1.0; 3];
        }
        let environment = Environment::new(&film, 1.0, 0.0).unwrap();
        let at = |x: f64, y: f64| environment.look(DVec3::new(x, y, 0.3)).0.x;
        assert_eq!((at(1.0, 0.01), at(1.0, -0.01), at(-0.01, -1.0), at(-1.0, 0.01)), (2.0, 3.0, 4.0, 1.0));
        let turned = Environment::new(&film, 1.0, TAU / 4.0).unwrap();
        assert_eq!(turned.look(DVec3::new(-0.01, 1.0, 0.0)).0.x, 2.0);
    }

    #[test]
    fn impossible_surroundings_are_refused() {
        let mut bad = film();
        assert!(Environment::new(&bad, 0.0, 0.0).is_err());
        bad.pixels_mut()[9].radiance[1] = f32::NAN;
        assert!(Environment::new(&bad, 1.0, 0.0).err().unwrap().to_string().contains("(1, 1)"));
        assert!(Environment::new(&Film::new(4, 2).unwrap(), 1.0, 0.0).err().unwrap().to_string().contains("black"));
    }
}
