//! NumPy `.npy`: a matrix of heights without pitch or unit, which the user must give.

use super::ReadOptions;
use super::fields::into_grid;
use crate::error::Fault;
use crate::heightmap::RawMap;
use crate::npy::{self, Array};
use ndarray::Array2;

pub const NAME: &str = npy::NAME;

pub fn recognises(bytes: &[u8]) -> bool {
    npy::recognises(bytes)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let array = npy::decode(bytes)?;
    let heights = heights(&array, options.unit_or_missing(NAME)?)?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, None)?;
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// The matrix times `unit` \[m\]; NaN and infinities are missing points.
fn heights(array: &Array, unit: f64) -> Result<Array2<f64>, Fault> {
    let &[rows, columns] = array.shape.as_slice() else {
        return Err(Fault::Unsupported {
            format: NAME,
            what: format!("an array of shape {:?}", array.shape),
            advice: "save a matrix of rows and columns".to_owned(),
        });
    };
    let mut values = array.to_f64();
    for value in &mut values {
        *value = if value.is_finite() { *value * unit } else { f64::NAN };
    }
    into_grid(rows, columns, values, NAME)
}
