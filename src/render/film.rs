//! Radiance per pixel with its standard error and sample count.

use crate::error::{Error, Result};
use crate::math::frame::DVec3;

/// One pixel: linear RGB radiance [W/(m2 sr)], its standard error in the same unit, and the paths behind them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pixel {
    pub radiance: [f32; 3],
    pub standard_error: [f32; 3],
    pub samples: u32,
}

/// A picture as radiance, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
}

/// Longest side of a picture.
const LIMIT: usize = 1 << 16;

impl Film {
    /// A film of pixels without samples.
    ///
    /// # Errors
    /// `Error::Parameter` if a side is 0 or above 65536 pixels.
    pub fn new(width: usize, height: usize) -> Result<Self> {
        if !(1..=LIMIT).contains(&width) || !(1..=LIMIT).contains(&height) {
            return Err(Error::parameter(
                format!("a picture of {width} x {height} pixels is not possible"),
                format!("choose sides from 1 to {LIMIT} pixels"),
            ));
        }
        Ok(Film { width, height, pixels: vec![Pixel::default(); width * height] })
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top left.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    pub(super) fn pixels_mut(&mut self) -> &mut [Pixel] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`, `None` outside the picture.
    pub fn pixel(&self, x: usize, y: usize) -> Option<&Pixel> {
        (x < self.width).then(|| self.pixels.get(y * self.width + x))?
    }

    /// Mean of all pixels, with the standard error of independent pixels and the sum of their samples.
    pub fn mean(&self) -> Pixel {
        let n = self.pixels.len() as f64;
        let sum = |f: &dyn Fn(&Pixel) -> f64| self.pixels.iter().map(f).sum::<f64>();
        let radiance = std::array::from_fn(|k| (sum(&|p| f64::from(p.radiance[k])) / n) as f32);
        let variance = |k: usize| sum(&|p| f64::from(p.standard_error[k]).powi(2));
        let samples = self.pixels.iter().fold(0u32, |total, p| total.saturating_add(p.samples));
        Pixel { radiance, standard_error: std::array::from_fn(|k| (variance(k).sqrt() / n) as f32), samples }
    }

    /// An exposure [m2 sr/W] that shows the brightest fiftieth of the pixels above 80 % of white; 1 for a black film.
    pub fn natural_exposure(&self) -> f64 {
        let mut brightness: Vec<f32> = self.pixels.iter().map(|p| p.radiance.iter().sum::<f32>() / 3.0).collect();
        brightness.sort_by(f32::total_cmp);
        match brightness.get(brightness.len() * 98 / 100) {
            Some(&bright) if bright > 0.0 => {
                let exact = 0.8 / f64::from(bright);
                // Two digits, to be repeated by hand.
                let step = 10f64.powf(exact.log10().floor() - 1.0);
                (exact / step).round() * step
            }
            _ => 1.0,
        }
    }

    /// Copies `other` with its top left corner at `(x, y)`; what sticks out is lost.
    pub fn paste(&mut self, other: &Film, x: usize, y: usize) {
        let width = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let (to, from) = ((y + row) * self.width + x, row * other.width);
            self.pixels[to..to + width].copy_from_slice(&other.pixels[from..from + width]);
        }
    }
}

/// Running mean and spread of the paths of one pixel.
#[derive(Default)]
pub(super) struct Tally {
    /// Sums are taken about the first path: a pixel of equal paths has no error at all.
    first: DVec3,
    sum: DVec3,
    squares: DVec3,
    count: u32,
}

impl Tally {
    #[inline]
    pub(super) fn add(&mut self, radiance: DVec3) {
        if self.count == 0 {
            self.first = radiance;
        }
        let x = radiance - self.first;
        self.sum += x;
        self.squares += x * x;
        self.count += 1;
    }

    /// Mean and `s / sqrt(n)`, as if the paths were independent. Scrambled Sobol paths are spread more evenly than
    /// that, so the true error is as a rule smaller.
    pub(super) fn pixel(&self) -> Pixel {
        let n = f64::from(self.count.max(1));
        let mean = self.first + self.sum / n;
        let variance = ((self.squares - self.sum * self.sum / n) / (n - 1.0).max(1.0)).max(DVec3::ZERO);
        let error = DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt()) / n.sqrt();
        let narrow = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        Pixel { radiance: narrow(mean), standard_error: narrow(error), samples: self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tally_gives_mean_and_standard_error() {
        let mut tally = Tally::default();
        for x in [1.0, 2.0, 3.0, 4.0] {
            tally.add(DVec3::new(x, 7.0, -x));
        }
        let pixel = tally.pixel();
        assert_eq!(pixel.radiance, [2.5, 7.0, -2.5]);
        // s^2 = 5/3, n = 4.
        let se = (5.0f64 / 12.0).sqrt() as f32;
        assert_eq!(pixel.standard_error, [se, 0.0, se]);
        assert_eq!(pixel.samples, 4);
        assert_eq!(Tally::default().pixel(), Pixel::default());
    }

    #[test]
    fn pasting_clips() {
        let mut film = Film::new(4, 3).unwrap();
        let mut stamp = Film::new(2, 2).unwrap();
        stamp.pixels_mut().fill(Pixel { samples: 9, ..Pixel::default() });
        film.paste(&stamp, 3, 2);
        film.paste(&stamp, 7, 7);
        assert_eq!(film.pixels().iter().filter(|p| p.samples == 9).count(), 1);
        assert_eq!(film.pixel(3, 2).unwrap().samples, 9);
        assert!(film.pixel(4, 0).is_none() && film.pixel(0, 3).is_none());
        assert!(Film::new(0, 5).is_err() && Film::new(5, LIMIT + 1).is_err());
    }
}
