//! A part of a map.

use super::RawMap;
use crate::error::{Error, Result};
use ndarray::{Axis, Slice};
use serde::Serialize;

/// A rectangle `x0, y0, x1, y1` from the top left corner of the map, x to the right, y downward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Region {
    /// In shares of width and height.
    Fraction([f64; 4]),
    /// In metres.
    Length([f64; 4]),
}

/// The samples that were kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Cropped {
    /// First column and row.
    pub first: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

impl std::fmt::Display for Cropped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x, y], [w, h]) = (self.first, self.size);
        write!(f, "cropped to {w} x {h} points from column {x}, row {y}")
    }
}

/// Keeps the samples `round(x0) <= column < round(x1)`, `round(y0) <= row < round(y1)`, the region in samples.
///
/// A sample owns one pitch, so a map of `n` samples is `n` pitches wide and adjoining regions share no sample.
///
/// # Errors
/// `Error::Parameter` if the region is not inside the map, is turned around, or holds fewer than 2 x 2 samples.
pub fn crop(raw: &mut RawMap, region: Region) -> Result<Cropped> {
    let (rows, columns) = raw.heights.dim();
    let samples = [columns as f64, rows as f64];
    let (corners, scale) = match region {
        Region::Fraction(c) => (c, samples),
        Region::Length(c) => (c, [1.0 / raw.pitch_x, 1.0 / raw.pitch_y]),
    };
    let at = |k: usize| (corners[k] * scale[k % 2]).round();
    let ([x0, y0], [x1, y1]) = ([at(0), at(1)], [at(2), at(3)]);
    if !(x0 >= 0.0 && y0 >= 0.0 && x1 <= samples[0] && y1 <= samples[1]) {
        return Err(Error::parameter(
            format!("the region reaches beyond the map of {columns} x {rows} points"),
            match region {
                Region::Fraction(_) => {
                    "give fractions from 0 to 1 from the top left, such as 0.25,0.25,0.75,0.75".into()
                }
                Region::Length(_) => format!(
                    "the map measures {:.6} um x {:.6} um",
                    samples[0] * raw.pitch_x * 1e6,
                    samples[1] * raw.pitch_y * 1e6
                ),
            },
        ));
    }
    if !(x1 - x0 >= 2.0 && y1 - y0 >= 2.0) {
        return Err(Error::parameter(
            format!("the region holds {} x {} points of the map", (x1 - x0).max(0.0), (y1 - y0).max(0.0)),
            "give x0,y0,x1,y1 with x0 < x1 and y0 < y1, at least two points apart",
        ));
    }
    let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|v| v as usize);
    let mut part = raw.heights.view();
    part.slice_axis_inplace(Axis(0), Slice::from(y0..y1));
    part.slice_axis_inplace(Axis(1), Slice::from(x0..x1));
    raw.heights = part.to_owned();
    Ok(Cropped { first: [x0, y0], size: [x1 - x0, y1 - y0] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn raw() -> RawMap {
        let heights = Array2::from_shape_fn((10, 20), |(r, c)| (100 * r + c) as f64);
        RawMap { heights, pitch_x: 1e-6, pitch_y: 3e-6, format: "test", notes: vec![] }
    }

    #[test]
    fn fractions_and_lengths_choose_the_same_samples() {
        let (mut a, mut b) = (raw(), raw());
        let kept = crop(&mut a, Region::Fraction([0.25, 0.2, 0.75, 0.5])).unwrap();
        assert_eq!(kept, Cropped { first: [5, 2], size: [10, 3] });
        assert_eq!(a.heights[[0, 0]], 205.0);
        assert_eq!(a.heights[[2, 9]], 414.0);
        crop(&mut b, Region::Length([5e-6, 6e-6, 15e-6, 15e-6])).unwrap();
        assert_eq!(a.heights, b.heights);
        let mut whole = raw();
        crop(&mut whole, Region::Fraction([0.0, 0.0, 1.0, 1.0])).unwrap();
        assert_eq!(whole.heights, raw().heights);
    }

    #[test]
    fn neighbours_tile_the_map() {
        let mut size = 0;
        for k in 0..3 {
            let (x0, x1) = (f64::from(k) / 3.0, f64::from(k + 1) / 3.0);
            size += crop(&mut raw(), Region::Fraction([x0, 0.0, x1, 1.0])).unwrap().size[0];
        }
        assert_eq!(size, 20);
    }

    #[test]
    fn refuses_what_is_no_part_of_the_map() {
        for bad in [
            Region::Fraction([0.0, 0.0, 1.2, 1.0]),
            Region::Fraction([-0.1, 0.0, 1.0, 1.0]),
            Region::Fraction([0.5, 0.0, 0.4, 1.0]),
            Region::Fraction([0.5, 0.5, 0.55, 1.0]),
            Region::Fraction([f64::NAN, 0.0, 1.0, 1.0]),
            Region::Length([0.0, 0.0, 30e-6, 30e-6]),
        ] {
            let mut map = raw();
            assert!(crop(&mut map, bad).is_err(), "{bad:?}");
            assert_eq!(map.heights.dim(), (10, 20));
        }
    }
}
