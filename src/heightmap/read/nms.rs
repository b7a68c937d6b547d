//! NanoFocus `.nms` of confocal microscopes; little-endian, u16 heights between two bounds.
//!
//! `height = zmin + raw / 65535 * (zmax - zmin)` [um]: raw 0 and 65535 are the lowest and the highest point. The pitch
//! is stored in nm. Offsets as SurfaceTopography and surfalize read them; the place of the heights stands in the header.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid};
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "NanoFocus NMS";

const BOUNDS: usize = 16;
const DATE: usize = 1076;
const DATA_OFFSET: usize = 1352;
const SIZES: usize = 1368;
const PITCHES: usize = 1376;

/// The format has no magic: the number of grey levels, the place of the heights and a sensible grid must all fit.
pub fn recognises(bytes: &[u8]) -> bool {
    let file = Fields { bytes, format: NAME, big_endian: false };
    let fits = || -> Result<bool, Fault> {
        let (columns, rows, data) = (file.u32(SIZES)?, file.u32(SIZES + 4)?, file.u32(DATA_OFFSET)?);
        let pitches = [file.number(PITCHES, Sample::F64)?, file.number(PITCHES + 8, Sample::F64)?];
        Ok(file.u32(12)? == 65535
            && (PITCHES + 16..100_000).contains(&data)
            && [columns, rows].iter().all(|n| (1..=100_000).contains(n))
            && pitches.iter().all(|p| *p > 0.0 && *p < 1e9))
    };
    fits().unwrap_or(false)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: false };
    let (columns, rows) = (file.u32(SIZES)?, file.u32(SIZES + 4)?);
    let real = |at| file.number(at, Sample::F64);
    let (low, high) = (real(BOUNDS)? * 1e-6, real(BOUNDS + 8)? * 1e-6);
    if !(low.is_finite() && high.is_finite()) {
        return Err(Fault::Corrupt { format: NAME, what: "the bounds of the heights are no numbers".to_owned() });
    }
    let stated = [real(PITCHES)? * 1e-9, real(PITCHES + 8)? * 1e-9];
    let [pitch_x, pitch_y] = options.pitch_or(NAME, Some(stated))?;
    let mut heights = file.plane(file.u32(DATA_OFFSET)?, rows, columns, Sample::U16)?;
    for height in &mut heights {
        *height = low + *height / 65535.0 * (high - low);
    }
    let notes = vec![("date".to_owned(), file.text(DATE, 16)?)];
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes })
}
