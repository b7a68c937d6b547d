//! Words as a pattern of bright and dark: what a lit sign shows.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Lines of text as a grid of ink coverage, drawn bold.
#[derive(Debug, PartialEq)]
pub struct Letters {
    columns: usize,
    rows: usize,
    /// Row by row from the top; 255 is full ink.
    coverage: Vec<u8>,
    bright_fraction: f64,
}

const WEIGHT: FontWeight = FontWeight::Bold;
const SIZE: RasterHeight = RasterHeight::Size24;
/// Empty space around the text, in grid points.
const MARGIN: usize = 4;
/// Coverage from which a point is ink.
const EDGE: f64 = 127.5;

impl Letters {
    /// The lines below each other, centred; letters that the font lacks appear as `?`.
    pub fn new(lines: &[&str]) -> Self {
        let (letter, line_height) = (get_raster_width(WEIGHT, SIZE), SIZE.val());
        let longest = lines.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        let columns = longest * letter + 2 * MARGIN;
        let rows = lines.len() * line_height + 2 * MARGIN;
        let mut coverage = vec![0; columns * rows];
        for (k, line) in lines.iter().enumerate() {
            let left = MARGIN + (longest - line.chars().count()) * letter / 2;
            for (i, c) in line.chars().enumerate() {
                let Some(glyph) = get_raster(c, WEIGHT, SIZE).or_else(|| get_raster('?', WEIGHT, SIZE)) else {
                    continue;
                };
                for (y, row) in glyph.rows().enumerate() {
                    let start = (MARGIN + k * line_height + y) * columns + left + i * letter;
                    coverage[start..start + row.len()].copy_from_slice(row);
                }
            }
        }
        let mut letters = Letters { columns, rows, coverage, bright_fraction: 0.0 };
        // Four points across each grid point see the outlines well enough for a mean.
        let (w, h) = (4 * columns, 4 * rows);
        let at = |k: usize| letters.is_ink([((k % w) as f64 + 0.5) / w as f64, ((k / w) as f64 + 0.5) / h as f64]);
        letters.bright_fraction = (0..w * h).filter(|&k| at(k)).count() as f64 / (w * h) as f64;
        letters
    }

    /// Width over height.
    pub fn aspect(&self) -> f64 {
        self.columns as f64 / self.rows as f64
    }

    /// Share of the rectangle that is ink.
    pub fn bright_fraction(&self) -> f64 {
        self.bright_fraction
    }

    /// Whether there is ink at `u` to the right and `v` downwards, both in `[0, 1]`: where the coverage, linear between the
    /// grid points, is above one half.
    pub fn is_ink(&self, [u, v]: [f64; 2]) -> bool {
        let (x, y) = (u * self.columns as f64 - 0.5, v * self.rows as f64 - 0.5);
        let at = |column: f64, row: f64| {
            let inside = column >= 0.0 && row >= 0.0 && (column as usize) < self.columns && (row as usize) < self.rows;
            if inside { f64::from(self.coverage[row as usize * self.columns + column as usize]) } else { 0.0 }
        };
        let (left, top) = (x.floor(), y.floor());
        let (s, t) = (x - left, y - top);
        let mix = |row: f64| (1.0 - s) * at(left, row) + s * at(left + 1.0, row);
        (1.0 - t) * mix(top) + t * mix(top + 1.0) > EDGE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_is_where_the_letters_are() {
        let letters = Letters::new(&["I I", "III"]);
        assert!(letters.bright_fraction() > 0.05 && letters.bright_fraction() < 0.6);
        let ink = |u0: f64, u1: f64, v0: f64, v1: f64| {
            (0..10_000)
                .filter(|k| {
                    let (s, t) = (f64::from(k % 100) / 100.0, f64::from(k / 100) / 100.0);
                    letters.is_ink([u0 + s * (u1 - u0), v0 + t * (v1 - v0)])
                })
                .count()
        };
        // The gap between the letters of the first line, and the letter below it.
        assert_eq!(ink(0.42, 0.58, 0.1, 0.45), 0);
        assert!(ink(0.42, 0.58, 0.55, 0.9) > 500);
        // Two above, three below.
        let (above, below) = (ink(0.0, 1.0, 0.0, 0.5), ink(0.0, 1.0, 0.5, 1.0));
        assert!((below as f64 / above as f64 - 1.5).abs() < 0.1, "{above} {below}");
        let outside = [[-0.5, 0.5], [1.5, 0.5], [0.5, -0.5], [0.5, 1.5]];
        assert!(outside.iter().all(|&uv| !letters.is_ink(uv)));
        assert_eq!(Letters::new(&[]).bright_fraction(), 0.0);
    }
}
