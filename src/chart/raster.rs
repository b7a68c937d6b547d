//! A sheet of pixels: anti-aliased lines, areas, and letters in any colour, upright or turned.

use crate::error::{Error, Result};
use crate::output;
use crate::render::caption::Lettering;
use crate::render::picture::Picture;
use std::path::Path;

/// sRGB bytes.
pub type Colour = [u8; 3];

pub const WHITE: Colour = [255; 3];
pub const INK: Colour = [30, 30, 30];
pub const SOFT_INK: Colour = [95, 95, 95];
pub const GRID: Colour = [222, 222, 222];
pub const FAINT_GRID: Colour = [240, 240, 240];

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

impl Area {
    pub fn right(&self) -> usize {
        self.x + self.width
    }

    pub fn bottom(&self) -> usize {
        self.y + self.height
    }
}

/// Which part of a text lies at the point it is written at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Start,
    Middle,
    End,
}

impl Align {
    /// Where a text of `width` begins.
    fn start(self, at: f64, width: usize) -> i64 {
        let before = match self {
            Align::Start => 0.0,
            Align::Middle => 0.5,
            Align::End => 1.0,
        };
        (at - before * width as f64).round() as i64
    }
}

/// The sheet. Nothing is drawn outside it, nor outside the clip while one is set.
#[derive(Debug, Clone)]
pub struct Raster {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
    clip: Area,
}

impl Raster {
    pub fn new(width: usize, height: usize, paper: Colour) -> Self {
        let clip = Area { x: 0, y: 0, width, height };
        Raster { width, height, rgb: paper.repeat(width * height), clip }
    }

    /// Runs `draw` with everything outside `area` protected.
    pub fn clipped(&mut self, area: Area, draw: impl FnOnce(&mut Raster)) {
        let before = std::mem::replace(&mut self.clip, area);
        draw(self);
        self.clip = before;
    }

    /// `pixel += cover (ink - pixel)`.
    pub fn blend(&mut self, x: i64, y: i64, ink: Colour, cover: f64) {
        let inside = |v: i64, low: usize, size: usize| v >= low as i64 && v < (low + size) as i64;
        let clip = self.clip;
        if !inside(x, clip.x, clip.width) || !inside(y, clip.y, clip.height) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        if x >= self.width || y >= self.height {
            return;
        }
        let first = 3 * (y * self.width + x);
        for (byte, ink) in self.rgb[first..first + 3].iter_mut().zip(ink) {
            let paper = f64::from(*byte);
            *byte = (paper + cover.clamp(0.0, 1.0) * (f64::from(ink) - paper)).round() as u8;
        }
    }

    pub fn fill(&mut self, area: Area, ink: Colour) {
        for y in area.y..area.bottom() {
            for x in area.x..area.right() {
                self.blend(x as i64, y as i64, ink, 1.0);
            }
        }
    }

    /// One pixel wide, just inside the area.
    pub fn frame(&mut self, area: Area, ink: Colour) {
        let Area { x, y, width, height } = area;
        for (x, y, width, height) in
            [(x, y, width, 1), (x, area.bottom() - 1, width, 1), (x, y, 1, height), (area.right() - 1, y, 1, height)]
        {
            self.fill(Area { x, y, width, height }, ink);
        }
    }

    /// Line through points in pixels (whole numbers are pixel centres). Points that are not finite break it.
    pub fn line(&mut self, points: &[(f64, f64)], ink: Colour, width: f64) {
        for ends in points.windows(2) {
            self.segment(ends[0], ends[1], ink, width);
        }
    }

    /// Line of dashes and gaps of the given lengths in turn.
    pub fn dashed(&mut self, points: &[(f64, f64)], ink: Colour, width: f64, pattern: [f64; 2]) {
        let mut gone = 0.0;
        let period = pattern[0] + pattern[1];
        for ends in points.windows(2) {
            let ((x0, y0), (x1, y1)) = (ends[0], ends[1]);
            let length = (x1 - x0).hypot(y1 - y0);
            if !(length > 0.0 && length.is_finite()) {
                continue;
            }
            let at = |t: f64| (x0 + (x1 - x0) * t / length, y0 + (y1 - y0) * t / length);
            // Dashes of the endless pattern that overlap this segment.
            let mut start = -(gone % period);
            while start < length {
                let (from, to) = (start.max(0.0), (start + pattern[0]).min(length));
                if to > from {
                    self.segment(at(from), at(to), ink, width);
                }
                start += period;
            }
            gone += length;
        }
    }

    /// Covers each pixel by how much of it lies within half the width of the segment, as if it were round.
    fn segment(&mut self, from: (f64, f64), to: (f64, f64), ink: Colour, width: f64) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        if !length.is_finite() {
            return;
        }
        let steep = dy.abs() > dx.abs();
        let major = |p: (f64, f64)| if steep { p.1 } else { p.0 };
        let minor = |p: (f64, f64)| if steep { p.0 } else { p.1 };
        let (a, b) = if major(from) <= major(to) { (from, to) } else { (to, from) };
        let slope = if major(b) > major(a) { (minor(b) - minor(a)) / (major(b) - major(a)) } else { 0.0 };
        let reach = 0.5 * width + 1.0;
        let limit = self.width.max(self.height) as f64;
        let (first, last) = ((major(a) - reach).floor().max(0.0), (major(b) + reach).ceil().min(limit));
        let mut m = first;
        while m <= last {
            let along = m.clamp(major(a), major(b));
            let centre = minor(a) + slope * (along - major(a));
            let spread = reach * (1.0 + slope * slope).sqrt() + 1.0;
            let (low, high) = ((centre - spread).floor().max(0.0), (centre + spread).ceil().min(limit));
            let mut n = low;
            while n <= high {
                let (x, y) = if steep { (n, m) } else { (m, n) };
                let t = if length > 0.0 { ((x - from.0) * dx + (y - from.1) * dy) / (length * length) } else { 0.0 };
                let t = t.clamp(0.0, 1.0);
                let distance = (x - from.0 - t * dx).hypot(y - from.1 - t * dy);
                let cover = 0.5 * width + 0.5 - distance;
                if cover > 0.0 {
                    self.blend(x as i64, y as i64, ink, cover);
                }
                n += 1.0;
            }
            m += 1.0;
        }
    }

    /// One line of text, centred on `y`.
    pub fn text(&mut self, text: &str, x: f64, y: f64, align: Align, lettering: Lettering, ink: Colour) {
        let (width, height, cover) = letters(text, lettering);
        let (left, top) = (align.start(x, width), Align::Middle.start(y, height));
        for (i, cover) in cover.into_iter().enumerate().filter(|(_, c)| *c > 0.0) {
            self.blend(left + (i % width) as i64, top + (i / width) as i64, ink, cover);
        }
    }

    /// One line of text that reads upwards, centred on `x`.
    pub fn upward_text(&mut self, text: &str, x: f64, y: f64, align: Align, lettering: Lettering, ink: Colour) {
        let (width, height, cover) = letters(text, lettering);
        let left = Align::Middle.start(x, height);
        // What is the start of the text lies lowest.
        let bottom = -align.start(-y, width);
        for (i, cover) in cover.into_iter().enumerate().filter(|(_, c)| *c > 0.0) {
            self.blend(left + (i / width) as i64, bottom - (i % width) as i64, ink, cover);
        }
    }

    /// `10` with a raised exponent, aligned as one word and centred on `y`.
    pub fn power_of_ten(&mut self, exponent: i32, x: f64, y: f64, align: Align, ink: Colour) {
        let raised = exponent.to_string();
        let base = Lettering::Medium.text_width("10");
        let left = align.start(x, base + Lettering::Small.text_width(&raised)) as f64;
        self.text("10", left, y + 2.0, Align::Start, Lettering::Medium, ink);
        self.text(&raised, left + base as f64, y - 5.0, Align::Start, Lettering::Small, ink);
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

    /// Writes a `.png` file, whole or not at all; the same drawing gives the same bytes.
    ///
    /// # Errors
    /// `Error::Io` naming `path`.
    pub fn save_png(&self, path: &Path) -> Result<()> {
        let bytes = self.png_bytes().map_err(|e| Error::io(path, "write", e))?;
        output::write_bytes(path, &bytes)
    }

    /// The bytes of a `.png` file.
    ///
    /// # Errors
    /// `io::Error` if the sheet is too large for the format.
    pub fn png_bytes(&self) -> std::io::Result<Vec<u8>> {
        output::png(&self.rgb, [self.width, self.height])
    }
}

/// Width, height and cover of the pixels of a text. A letter the font lacks is a question mark.
fn letters(text: &str, lettering: Lettering) -> (usize, usize, Vec<f64>) {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let (width, height) = (lettering.text_width(&clean).max(1), lettering.line_height());
    let mut strip = Picture::filled(width, height, [0; 3]);
    // The line is four pixels higher than the letters; two above and two below centre them.
    strip.write_text(0, 2, &clean, lettering, [255; 3]);
    let cover = strip.rgb().chunks(3).map(|p| f64::from(p[0]) / 255.0).collect();
    (width, height, cover)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn darkness(raster: &Raster) -> f64 {
        raster.rgb().iter().map(|&b| f64::from(255 - b) / 255.0 / 3.0).sum()
    }

    /// A line covers its length times its width, at any angle.
    #[test]
    fn lines_have_their_width() {
        for degrees in [0.0, 10.0, 45.0, 80.0, 90.0, 200.0f64] {
            let mut raster = Raster::new(200, 200, WHITE);
            let (sin, cos) = degrees.to_radians().sin_cos();
            raster.line(
                &[(100.0 - 80.0 * cos, 100.0 - 80.0 * sin), (100.0 + 80.0 * cos, 100.0 + 80.0 * sin)],
                [0; 3],
                3.0,
            );
            // Round ends add the area of a disc.
            let expected = 160.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5;
            assert!((darkness(&raster) / expected - 1.0).abs() < 0.03, "{degrees}: {} {expected}", darkness(&raster));
        }
        let mut dashes = Raster::new(300, 20, WHITE);
        dashes.dashed(&[(10.0, 10.0), (130.0, 10.0), (250.0, 10.0)], [0; 3], 1.0, [10.0, 10.0]);
        let solid = 12.0 * (10.0 + std::f64::consts::FRAC_PI_4);
        assert!((darkness(&dashes) / solid - 1.0).abs() < 0.05, "{} {solid}", darkness(&dashes));
    }

    #[test]
    fn nothing_leaves_the_sheet_or_the_clip() {
        let mut raster = Raster::new(40, 30, WHITE);
        raster.line(&[(-1e9, 5.0), (1e9, 9.0), (f64::NAN, 3.0), (f64::INFINITY, 3.0)], INK, 2.0);
        raster.text("outside", -500.0, 900.0, Align::End, Lettering::Small, INK);
        let clip = Area { x: 10, y: 10, width: 5, height: 5 };
        let mut clipped = Raster::new(40, 30, WHITE);
        clipped.clipped(clip, |r| r.fill(Area { x: 0, y: 0, width: 40, height: 30 }, [0; 3]));
        assert!((darkness(&clipped) - 25.0).abs() < 1e-9);
    }

    #[test]
    fn turned_letters_have_the_same_ink() {
        let mut upright = Raster::new(200, 200, WHITE);
        upright.text("PSD / nm\u{b2}", 100.0, 100.0, Align::Middle, Lettering::Medium, INK);
        let mut turned = Raster::new(200, 200, WHITE);
        turned.upward_text("PSD / nm\u{b2}", 100.0, 100.0, Align::Middle, Lettering::Medium, INK);
        assert!(darkness(&upright) > 50.0 && (darkness(&upright) - darkness(&turned)).abs() < 1e-9);
    }
}
