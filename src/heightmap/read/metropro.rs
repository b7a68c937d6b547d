//! MetroPro `.dat` of Zygo interferometers, formats 1 to 3; big-endian.
//!
//! `height = raw * S * O * W / R` [m]: S the interferometric scale factor, O the obliquity, W the wavelength \[m\], R the
//! phase steps per fringe (4096, 32768 or 131072). A 16-bit intensity image precedes the 32-bit heights.
//! Source: header table of the MetroPro reference guide, as read alike by Gwyddion, prysm and SurfaceTopography.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid, plane_bytes};
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "MetroPro";

/// Heights from here on mean "no data".
pub const MISSING: f64 = 2_147_483_640.0;

pub fn recognises(bytes: &[u8]) -> bool {
    // The three magics end in 6F, 70, 71 for header formats 1, 2, 3.
    matches!(bytes, [0x88, 0x1b, 0x03, 0x6f..=0x71, ..])
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: true };
    let header_size = file.u32(6)?;
    let (intensity_columns, intensity_rows, frames) = (file.u16(52)?, file.u16(54)?, file.u16(56)?);
    let (columns, rows) = (file.u16(68)?, file.u16(70)?);
    if columns == 0 || rows == 0 {
        return Err(Fault::Unsupported {
            format: NAME,
            what: "a file with an intensity image but no heights".to_owned(),
            advice: "save the phase data in MetroPro".to_owned(),
        });
    }
    let intensity = match (intensity_columns, intensity_rows, frames) {
        (0, _, _) | (_, 0, _) | (_, _, 0) => 0,
        _ => plane_bytes(intensity_rows, intensity_columns, 2 * frames, NAME)?,
    };
    let real = |at| file.number(at, Sample::F32);
    let factor = real(164)? * real(176)? * real(168)? / phase_steps(file.u16(218)?)?;
    let sign = if file.u16(232)? == 0 { 1.0 } else { -1.0 };
    let unit = if factor.is_finite() && factor != 0.0 { sign * factor } else { options.unit_or_missing(NAME)? };
    let lateral = real(184)?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, Some([lateral, lateral]))?;
    let mut heights = file.plane(header_size.saturating_add(intensity), rows, columns, Sample::I32)?;
    for height in &mut heights {
        *height = if *height >= MISSING { f64::NAN } else { *height * unit };
    }
    let comment = file.text(80, 82)?;
    let notes = if comment.is_empty() { vec![] } else { vec![("comment".to_owned(), comment)] };
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes })
}

/// Steps per fringe for the three phase resolutions; readers exist that are one place off and 8 times too high.
pub fn phase_steps(resolution: usize) -> Result<f64, Fault> {
    match resolution {
        0 => Ok(4096.0),
        1 => Ok(32768.0),
        2 => Ok(131_072.0),
        other => Err(Fault::Corrupt { format: NAME, what: format!("phase resolution {other} is unknown") }),
    }
}
