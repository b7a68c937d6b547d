//! `.datx` of Zygo Mx: an HDF5 file. Read with the cargo feature `datx`, which is on by default and pure Rust.

#[cfg(feature = "datx")]
mod surface;

use super::ReadOptions;
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "Zygo DATX";

/// Any HDF5 file; whether it holds a surface shows when reading.
pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89HDF\r\n\x1a\n")
}

#[cfg(feature = "datx")]
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    surface::read(bytes, options)
}

#[cfg(not(feature = "datx"))]
pub fn read(_bytes: &[u8], _options: &ReadOptions) -> Result<RawMap, Fault> {
    Err(Fault::Unsupported {
        format: NAME,
        what: "HDF5 in this build".to_owned(),
        advice: "build with the cargo feature datx".to_owned(),
    })
}
