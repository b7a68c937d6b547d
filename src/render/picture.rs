//! Films as files: `.exr` holds the radiance, `.png` what a screen can show of it.

use super::film::Film;
use crate::error::{Error, Result};
use crate::output;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text};
use exr::prelude::{Vec2, WritableImage};
use std::io;
use std::path::Path;

/// An 8-bit sRGB picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour (sRGB bytes).
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Picture { width, height, rgb: colour.repeat(width * height) }
    }

    /// A whole film at an exposure: [`Self::draw_film`] on a fresh picture.
    pub fn from_film(film: &Film, exposure: f64) -> Self {
        let mut picture = Picture::filled(film.width(), film.height(), [0; 3]);
        picture.draw_film(film, 0, 0, exposure);
        picture
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    /// sRGB bytes, row by row from the top left.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// The bytes of a pixel, `None` outside the picture.
    pub(super) fn pixel_mut(&mut self, x: usize, y: usize) -> Option<&mut [u8; 3]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let start = 3 * (y * self.width + x);
        self.rgb.get_mut(start..start + 3)?.try_into().ok()
    }

    /// `255 sRGB(exposure L)`, `exposure` in m2 sr/W, clipped at 0 and 1, with the film's top left at `(x, y)`.
    ///
    /// Rounding is dithered by less than one step, so that smooth shading shows no bands.
    pub fn draw_film(&mut self, film: &Film, x: usize, y: usize, exposure: f64) {
        for (i, pixel) in film.pixels().iter().enumerate() {
            let (column, row) = (i % film.width(), i / film.width());
            let Some(bytes) = self.pixel_mut(x + column, y + row) else { continue };
            let rounding = dither(column, row);
            for (byte, radiance) in bytes.iter_mut().zip(pixel.radiance) {
                *byte = (255.0 * srgb(exposure * f64::from(radiance)) + rounding) as u8;
            }
        }
    }

    /// A frame of one pixel just outside the rectangle of `width` x `height` at `(x, y)`.
    pub fn draw_frame(&mut self, x: usize, y: usize, width: usize, height: usize, ink: [u8; 3]) {
        let (left, top) = (x.wrapping_sub(1), y.wrapping_sub(1));
        let across = (0..width + 2).flat_map(|i| [(left.wrapping_add(i), top), (left.wrapping_add(i), y + height)]);
        let down = (0..height).flat_map(|i| [(left, y + i), (x + width, y + i)]);
        for (column, row) in across.chain(down) {
            if let Some(bytes) = self.pixel_mut(column, row) {
                *bytes = ink;
            }
        }
    }

    /// The bytes of a `.png` file.
    ///
    /// # Errors
    /// `io::Error` if the picture is too large for the format.
    pub fn png_bytes(&self) -> io::Result<Vec<u8>> {
        output::png(&self.rgb, [self.width, self.height])
    }

    /// Writes a `.png` file, whole or not at all.
    ///
    /// # Errors
    /// `Error::Io` naming `path`.
    pub fn save_png(&self, path: &Path) -> Result<()> {
        let bytes = self.png_bytes().map_err(|e| Error::io(path, "write", e))?;
        output::write_bytes(path, &bytes)
    }
}

/// `12.92 x` below 0.0031308, else `1.055 x^(1/2.4) - 0.055`, for `x` clipped to `[0, 1]` (IEC 61966-2-1, 1999).
pub fn srgb(linear: f64) -> f64 {
    // The branch below misses 1 by a rounding error.
    if linear >= 1.0 {
        return 1.0;
    }
    let x = linear.max(0.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// A rounding offset in `[0, 1)` that looks like fine even grain: interleaved gradient noise (Jimenez 2014).
fn dither(x: usize, y: usize) -> f64 {
    (52.982_918_9 * (0.067_110_56 * x as f64 + 0.005_837_15 * y as f64).fract()).fract()
}

/// The bytes of an `.exr` file: `R G B` hold the radiance [W/(m2 sr)], the layer `standard_error` its error in the
/// same unit, the channel `samples` the paths per pixel; `comment` goes into the header.
///
/// Lossless, 32 bits a channel. The bytes depend on the film and the comment alone.
///
/// # Errors
/// `io::Error` if the encoder refuses the film.
pub fn exr_bytes(film: &Film, comment: &str) -> io::Result<Vec<u8>> {
    let float = |name: &str, value: &dyn Fn(&super::film::Pixel) -> f32| {
        AnyChannel::new(name, FlatSamples::F32(film.pixels().iter().map(value).collect()))
    };
    let mut channels = SmallVec::new();
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(float(name, &|p| p.radiance[i]));
        channels.push(float(&format!("standard_error.{name}"), &|p| p.standard_error[i]));
    }
    channels.push(AnyChannel::new("samples", FlatSamples::U32(film.pixels().iter().map(|p| p.samples).collect())));
    let attributes = LayerAttributes {
        software_name: Some(Text::from(concat!("asperity ", env!("CARGO_PKG_VERSION")))),
        // The header holds Latin-1 only.
        comments: Text::new_or_none(comment.replace(|c: char| u32::from(c) > 0xFF, "?")),
        ..LayerAttributes::default()
    };
    let size = Vec2(film.width(), film.height());
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// Writes [`exr_bytes`] to a file, whole or not at all.
///
/// # Errors
/// `Error::Io` naming `path`.
pub fn save_exr(film: &Film, comment: &str, path: &Path) -> Result<()> {
    let bytes = exr_bytes(film, comment).map_err(|e| Error::io(path, "write", e))?;
    output::write_bytes(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::Pixel;

    /// Corner points of the standard's curve: the two branches meet, and middle grey of 0.2140 is byte 127.5.
    #[test]
    fn the_srgb_curve_meets_its_standard() {
        assert_eq!(srgb(-1.0), 0.0);
        assert!((srgb(2.0) - 1.0).abs() < 1e-12);
        assert!((srgb(0.003_130_8) - srgb(0.003_130_801)).abs() < 1e-7);
        assert!((srgb(0.214_041_14) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_film_is_exposed_and_dithered_by_less_than_a_step() {
        let mut film = Film::new(64, 64).unwrap();
        film.pixels_mut().fill(Pixel { radiance: [0.2140, 0.0, 9.0], ..Pixel::default() });
        let picture = Picture::from_film(&film, 1.0);
        let bytes: Vec<&[u8]> = picture.rgb().chunks(3).collect();
        assert!(bytes.iter().all(|b| (b[0] == 127 || b[0] == 128) && b[1] == 0 && b[2] == 255));
        let mean = bytes.iter().map(|b| f64::from(b[0])).sum::<f64>() / bytes.len() as f64;
        assert!((mean - 255.0 * srgb(0.2140)).abs() < 0.02, "{mean}");
        // Twice the exposure of half the radiance.
        film.pixels_mut().fill(Pixel { radiance: [0.1070, 0.0, 4.5], ..Pixel::default() });
        assert_eq!(Picture::from_film(&film, 2.0), picture);
    }

    #[test]
    fn drawing_outside_is_lost() {
        let film = Film::new(3, 3).unwrap();
        let mut picture = Picture::filled(2, 2, [9, 9, 9]);
        picture.draw_film(&film, 1, 1, 1.0);
        assert_eq!(picture.rgb(), [9, 9, 9, 9, 9, 9, 9, 9, 9, 0, 0, 0]);
        let mut framed = Picture::filled(4, 3, [0; 3]);
        framed.draw_frame(1, 1, 2, 1, [1; 3]);
        framed.draw_frame(0, 0, 9, 9, [2; 3]);
        let first: Vec<u8> = framed.rgb().iter().step_by(3).copied().collect();
        assert_eq!(first, [1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1]);
        assert!(picture.pixel_mut(2, 0).is_none() && picture.pixel_mut(0, 2).is_none());
    }
}
