//! Sensofar `.plu` (also Leica DCM): a date as text, calibration, then layers of f32 heights [um]; little-endian.
//!
//! Each layer: rows u32, columns u32, heights, lowest and highest f32, then `images` RGB pictures of its size.
//! Field order as SurfaceTopography reads it; both kinds of scan settings take 40 bytes, so the first layer is at 500.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid, plane_bytes};
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "Sensofar PLU";

const COMMENT: usize = 132;
const PITCH: usize = 404;
const KIND: usize = 428;
const LAYERS: usize = 489;
const IMAGES: usize = 492;
const FIRST_LAYER: usize = 500;

/// Heights of this value [um] were not measured.
const MISSING: f64 = 1_000_001.0;

/// The format has no magic; it begins like `Fri Mar 10 16:35:59 2023`, padded with NUL.
pub fn recognises(bytes: &[u8]) -> bool {
    let Some(date) = bytes.get(..25) else { return false };
    date.iter().zip(b"aaa aaa d0 00:00:00 0000\0").all(|(byte, pattern)| match pattern {
        b'a' => byte.is_ascii_alphabetic(),
        b'0' => byte.is_ascii_digit(),
        b'd' => byte.is_ascii_digit() || *byte == b' ',
        exact => byte == exact,
    })
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: false };
    let refuse = |what: String, advice: &str| Err(Fault::Unsupported { format: NAME, what, advice: advice.to_owned() });
    match file.u32(KIND)? {
        3 => {}
        1 => return refuse("a profile".to_owned(), "export the topography"),
        other => return refuse(format!("measurement type {other}"), "export the topography"),
    }
    let layers = usize::from(file.slice(LAYERS, 1)?[0]);
    let images = usize::from(file.slice(IMAGES, 1)?[0]);
    let wanted = options.layer.unwrap_or(0);
    if wanted >= layers {
        return refuse(format!("layer {wanted} of a file with {layers} layer(s)"), "count from 0");
    }
    let mut at = FIRST_LAYER;
    for _ in 0..wanted {
        let (rows, columns) = (file.u32(at)?, file.u32(at + 4)?);
        at = at.saturating_add(16).saturating_add(plane_bytes(rows, columns, 4 + 3 * images, NAME)?);
    }
    let (rows, columns) = (file.u32(at)?, file.u32(at + 4)?);
    let micrometres = |at| Ok(file.number(at, Sample::F32)? * 1e-6);
    let [pitch_x, pitch_y] = options.pitch_or(NAME, Some([micrometres(PITCH)?, micrometres(PITCH + 4)?]))?;
    let mut heights = file.plane(at + 8, rows, columns, Sample::F32)?;
    for height in &mut heights {
        *height = if height.is_finite() && *height != MISSING { *height * 1e-6 } else { f64::NAN };
    }
    let notes = [("date", file.text(0, 128)?), ("comment", file.text(COMMENT, 256)?)];
    let notes = notes.into_iter().filter(|(_, t)| !t.is_empty()).map(|(k, t)| (k.to_owned(), t)).collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes })
}
