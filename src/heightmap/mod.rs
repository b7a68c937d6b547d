//! Floor 2: height maps: read, prepare, describe, diagnose, synthesise, write.

pub mod crop;
pub mod despike;
pub mod fill;
pub mod filter;
pub mod form;
pub mod level;
pub mod noise;
pub mod orient;
pub mod parameters;
pub mod polynomial;
pub mod prepare;
pub mod read;
pub mod sampling;
pub mod spectrum;
pub mod sphere;
pub mod survey;
pub mod synth;
pub mod warning;
pub mod write;

pub use prepare::{Preparation, Prepared, prepare};
pub use survey::Survey;

use crate::error::{Error, Result};
use ndarray::Array2;

/// A map as a file holds it: heights in metres, f64, not levelled; missing points are NaN.
///
/// Shape `(rows, columns)`; row 0 is the top row: column grows with +x, row grows with -y.
#[derive(Debug, Clone)]
pub struct RawMap {
    /// Heights \[m\], NaN where missing.
    pub heights: Array2<f64>,
    /// Sampling distance along x \[m\].
    pub pitch_x: f64,
    /// Sampling distance along y \[m\].
    pub pitch_y: f64,
    /// Name of the format it came from, for people.
    pub format: &'static str,
    /// Title, instrument and the like as the file states them.
    pub notes: Vec<(String, String)>,
}

/// A levelled map: a least-squares plane is removed in f64, the rest is stored as f32 metres.
///
/// Shape and orientation as in [`RawMap`]. A sample is a vertex of the facet mesh.
#[derive(Debug, Clone)]
pub struct HeightMap {
    /// Levelled heights \[m\], NaN where missing.
    pub heights: Array2<f32>,
    /// Sampling distance along x \[m\].
    pub pitch_x: f64,
    /// Sampling distance along y \[m\].
    pub pitch_y: f64,
    /// What lies beyond the border.
    pub edges: Edges,
    /// Slopes of the removed plane `(dh/dx, dh/dy)`.
    pub removed_slopes: [f64; 2],
}

/// What a ray meets beyond the border of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Edges {
    /// Nothing: the map ends.
    #[default]
    Open,
    /// The map again, mirrored.
    Mirrored,
    /// The map again; the last column is followed by the first. Only for maps made periodic.
    Periodic,
}

impl HeightMap {
    /// Number of samples along x.
    pub fn width(&self) -> usize {
        self.heights.ncols()
    }

    /// Number of samples along y.
    pub fn height(&self) -> usize {
        self.heights.nrows()
    }

    /// Share of samples that are missing, 0 to 1.
    pub fn missing_fraction(&self) -> f64 {
        let missing = self.heights.iter().filter(|h| h.is_nan()).count();
        missing as f64 / self.heights.len() as f64
    }
}

impl RawMap {
    /// Checks what every map must fulfil: at least 2 x 2 samples, positive finite pitch, at least one facet.
    ///
    /// # Errors
    /// `Error::Parameter` with the first rule that fails; the caller adds the file's name.
    pub fn check(&self) -> Result<()> {
        let (rows, columns) = self.heights.dim();
        if rows < 2 || columns < 2 {
            return Err(Error::parameter(
                format!("the map has {columns} x {rows} points"),
                "a surface needs at least 2 x 2 points to have a slope; is it a profile?",
            ));
        }
        for (axis, pitch) in [("x", self.pitch_x), ("y", self.pitch_y)] {
            if !(pitch.is_finite() && pitch > 0.0) {
                return Err(Error::parameter(
                    format!("the pitch along {axis} is {pitch} m"),
                    "give the sampling distance with --pitch, for example --pitch 0.5um",
                ));
            }
        }
        let facet = (0..rows - 1).any(|r| {
            (0..columns - 1).any(|c| {
                let ok = |i: usize, j: usize| self.heights[[r + i, c + j]].is_finite();
                ok(0, 0) && ok(1, 1) && (ok(1, 0) || ok(0, 1))
            })
        });
        if !facet {
            let measured = self.heights.iter().filter(|h| h.is_finite()).count();
            return Err(Error::parameter(
                if measured == 0 {
                    "every point of the map is missing".to_owned()
                } else {
                    format!("the {measured} measured points form no facet")
                },
                "measure again or mend the gaps in the instrument's software",
            ));
        }
        Ok(())
    }
}
