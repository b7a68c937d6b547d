//! NumPy `.npy` with heights in metres; the format has no place for the pitch.

use crate::error::Result;
use crate::heightmap::RawMap;
use crate::npy;
use crate::output::write_bytes;
use std::path::Path;

/// How heights are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// 24 bits of fraction: 7 nm at 76 mm, so level first.
    Float32,
    /// As in memory.
    Float64,
}

/// Writes `heights` \[m\] as a matrix in C order, row 0 first; missing points are NaN.
///
/// # Errors
/// `Error::Io`.
pub fn write(path: &Path, map: &RawMap, precision: Precision) -> Result<()> {
    let (rows, columns) = map.heights.dim();
    let bytes = match precision {
        Precision::Float32 => npy::encode(&[rows, columns], map.heights.iter().map(|&h| h as f32)),
        Precision::Float64 => npy::encode(&[rows, columns], map.heights.iter().copied()),
    };
    write_bytes(path, &bytes)
}
