//! Grey `.tif`: floats times the user's unit, or unsigned integers spread over the user's height range.
//!
//! NaN and infinities are missing points. Resolution tags are not used: they are made for printers, in dots per inch,
//! and most programs leave 72 or 96 there.

use super::ReadOptions;
use super::fields::{Fields, into_grid};
use crate::archive::unpack_limit;
use crate::error::Fault;
use crate::heightmap::RawMap;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};

pub const NAME: &str = "TIFF";

pub fn recognises(bytes: &[u8]) -> bool {
    // 42 marks the classic kind, 43 the one with 64-bit offsets.
    matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let limit = usize::try_from(unpack_limit(bytes.len())).unwrap_or(usize::MAX);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = limit;
    limits.intermediate_buffer_size = limit;
    limits.ifd_value_size = bytes.len();
    refuse_impossible_fields(bytes)?;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?.with_limits(limits);
    let (columns, rows) = decoder.dimensions().map_err(broken)?;
    let (columns, rows) = (columns as usize, rows as usize);
    match decoder.colortype().map_err(broken)? {
        tiff::ColorType::Gray(_) => {}
        other => {
            return Err(Fault::Unsupported {
                format: NAME,
                what: format!("a picture of type {other:?}"),
                advice: "save the heights as one channel of 32-bit floats".to_owned(),
            });
        }
    }
    let floats = |values: Vec<f64>| -> Result<Vec<f64>, Fault> {
        let unit = options.unit_or_missing(NAME)?;
        Ok(values.into_iter().map(|h| if h.is_finite() { h * unit } else { f64::NAN }).collect())
    };
    let levels = |values: Vec<f64>, highest: f64| -> Result<Vec<f64>, Fault> {
        let height = options.height_of_level(NAME, highest)?;
        Ok(values.into_iter().map(height).collect())
    };
    let heights = match decoder.read_image().map_err(broken)? {
        DecodingResult::F16(v) => floats(v.into_iter().map(f64::from).collect()),
        DecodingResult::F32(v) => floats(v.into_iter().map(f64::from).collect()),
        DecodingResult::F64(v) => floats(v),
        DecodingResult::I16(v) => floats(v.into_iter().map(f64::from).collect()),
        DecodingResult::I32(v) => floats(v.into_iter().map(f64::from).collect()),
        DecodingResult::U16(v) => levels(v.into_iter().map(f64::from).collect(), 65535.0),
        DecodingResult::U32(v) => levels(v.into_iter().map(f64::from).collect(), f64::from(u32::MAX)),
        _ => Err(Fault::Unsupported {
            format: NAME,
            what: "a picture with 8 or 64 bits to the point".to_owned(),
            advice: "save the heights as one channel of 32-bit floats".to_owned(),
        }),
    }?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, None)?;
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// The decoder makes room for every field of the first directory before its limits can be set, so their counts are
/// weighed against the file first.
fn refuse_impossible_fields(bytes: &[u8]) -> Result<(), Fault> {
    let file = Fields { bytes, format: NAME, big_endian: bytes[0] == b'M' };
    // The kind with 64-bit offsets: where the directory is, bytes of its number of fields, of a count and of a field.
    let long = |at: usize| -> Result<usize, Fault> {
        let (first, second) = (file.u32(at)?, file.u32(at + 4)?);
        let (high, low) = if file.big_endian { (first, second) } else { (second, first) };
        // What does not fit 32 bits is in no file that fits memory.
        Ok(if high == 0 { low } else { usize::MAX })
    };
    let wide = bytes[2..4].contains(&43);
    let directory = if wide { long(8)? } else { file.u32(4)? };
    file.slice(directory, if wide { 8 } else { 2 })?;
    let fields = if wide { long(directory)? } else { file.u16(directory)? };
    let (start, step) = if wide { (directory + 8, 20) } else { (directory + 2, 12) };
    file.slice(start, fields.saturating_mul(step))?;
    for field in (0..fields).map(|k| start + k * step) {
        let count = if wide { long(field + 4)? } else { file.u32(field + 4)? };
        if count > bytes.len() {
            let what = format!("a field of {count} values cannot be in a file of {} bytes", bytes.len());
            return Err(Fault::Corrupt { format: NAME, what });
        }
    }
    Ok(())
}

fn broken(error: tiff::TiffError) -> Fault {
    match error {
        tiff::TiffError::UnsupportedError(why) => Fault::Unsupported {
            format: NAME,
            what: why.to_string(),
            advice: "save the heights as one channel of 32-bit floats, uncompressed".to_owned(),
        },
        other => Fault::Corrupt { format: NAME, what: format!("the picture cannot be decoded ({other})") },
    }
}
