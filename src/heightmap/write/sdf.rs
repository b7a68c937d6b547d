//! Surface data file of ISO 25178-71, edition 1.0: binary f64 or ASCII. `height = raw * Zscale` \[m\].
//!
//! Counts are 16 bits wide, so a map has at most 65535 points a side. Same map, same bytes: the dates are fixed.

use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::output::write_bytes;
use std::fmt::Write;
use std::path::Path;

/// How heights are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// f64 metres; missing points are the lowest f64.
    Binary,
    /// Metres in the shortest decimals that are exact, one profile a line; missing points are BAD.
    Ascii,
}

/// The format wants dates (DDMMYYYYHHMM), which a reproducible file cannot have.
const DATE: &str = "010119700000";

/// Data type 7 of the standard.
const DOUBLE: u8 = 7;

/// Writes the map.
///
/// # Errors
/// `Error::Parameter` if a side has more than 65535 points, `Error::Io` otherwise.
pub fn write(path: &Path, map: &RawMap, encoding: Encoding) -> Result<()> {
    let side = |n: usize| {
        u16::try_from(n).map_err(|_| {
            Error::parameter(format!("a side of {n} points is too long for SDF"), "write .x3p or .npy instead")
        })
    };
    let (rows, columns) = map.heights.dim();
    let (rows, columns) = (side(rows)?, side(columns)?);
    let bytes = match encoding {
        Encoding::Binary => binary(map, rows, columns),
        Encoding::Ascii => ascii(map, rows, columns).into_bytes(),
    };
    write_bytes(path, &bytes)
}

fn binary(map: &RawMap, rows: u16, columns: u16) -> Vec<u8> {
    let mut bytes = b"bISO-1.0asperity  ".to_vec();
    bytes.extend(DATE.bytes());
    bytes.extend(DATE.bytes());
    bytes.extend(columns.to_le_bytes());
    bytes.extend(rows.to_le_bytes());
    // Scales of x, y, z [m]; a negative resolution is an unknown one.
    for scale in [map.pitch_x, map.pitch_y, 1.0, -1.0] {
        bytes.extend(scale.to_le_bytes());
    }
    // No compression, the data type, no checksum.
    bytes.extend([0, DOUBLE, 0]);
    for &height in &map.heights {
        bytes.extend(if height.is_finite() { height } else { f64::MIN }.to_le_bytes());
    }
    bytes
}

fn ascii(map: &RawMap, rows: u16, columns: u16) -> String {
    let (x, y) = (map.pitch_x, map.pitch_y);
    let mut text = format!(
        "aISO-1.0\nManufacID = asperity\nCreateDate = {DATE}\nModDate = {DATE}\nNumPoints = {columns}\n\
         NumProfiles = {rows}\nXscale = {x:e}\nYscale = {y:e}\nZscale = 1\nZresolution = -1\nCompression = 0\n\
         DataType = {DOUBLE}\nCheckType = 0\n*\n"
    );
    for row in map.heights.outer_iter() {
        for (i, &height) in row.iter().enumerate() {
            let blank = if i == 0 { "" } else { " " };
            // Writing to a String cannot fail.
            let _ = if height.is_finite() { write!(text, "{blank}{height:e}") } else { write!(text, "{blank}BAD") };
        }
        text.push('\n');
    }
    text + "*\n"
}
