//! Digital Surf `.sur` (MountainsMap), plain or compressed: a header of 512 bytes, remarks, then i16 or i32 heights.
//!
//! `height = raw * dz + z_offset` in the unit of dz; if the header says that points are missing, they are
//! `raw = zmin - 2`, and `zmin - 1` and `zmax + 1` were beyond the range of the instrument.
//! Source: Digital Surf file format description, appendix of the MountainsMap manual, as Gwyddion reads it.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid, plane_bytes};
use super::units::{decode_text, metres};
use crate::archive::unpack_limit;
use crate::error::Fault;
use crate::heightmap::RawMap;
use std::io::Read;

pub const NAME: &str = "Digital Surf SUR";

const PLAIN: &[u8] = b"DIGITAL SURF";
const COMPRESSED: &[u8] = b"DSCOMPRESSED";
const HEADER_BYTES: usize = 512;
/// Format code of files written on a Macintosh, with the most significant byte first.
const MACINTOSH: [u8; 2] = [1, 1];

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(PLAIN) || bytes.starts_with(COMPRESSED)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let little = Fields { bytes, format: NAME, big_endian: false };
    let file = Fields { big_endian: little.slice(12, 2)? == MACINTOSH, ..little };
    let size = |at| Ok(file.number(at, Sample::I32)?.max(0.0) as usize);
    let (columns, rows) = (size(108)?, size(112)?);
    refuse_other_kinds(file.u16(18)?, rows)?;
    let sample = match file.u16(98)? {
        16 => Sample::I16,
        32 => Sample::I32,
        bits => return Err(corrupt(format!("heights of {bits} bits"))),
    };
    let unit_at = |at| -> Result<Option<f64>, Fault> { Ok(metres(&decode_text(file.slice(at, 16)?))) };
    let real = |at| file.number(at, Sample::F32);
    let stated = match (unit_at(180)?, unit_at(196)?) {
        (Some(x), Some(y)) => Some([real(120)? * x, real(124)? * y]),
        _ => None,
    };
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let (unit, offset) = match unit_at(212)? {
        Some(unit) => (real(128)? * unit, real(474)? * unit),
        None => (real(128)? * options.unit_or_missing(NAME)?, 0.0),
    };
    let start = HEADER_BYTES + file.u16(334)? + file.u16(336)?;
    let raw = if bytes.starts_with(COMPRESSED) {
        unpack(&file, start, plane_bytes(rows, columns, sample.size(), NAME)?, sample)?
    } else {
        file.plane(start, rows, columns, sample)?
    };
    let offset = if offset.is_finite() { offset } else { 0.0 };
    let [lowest, highest] = [file.number(100, Sample::I32)?, file.number(104, Sample::I32)?];
    let marked = [lowest - 2.0, lowest - 1.0, highest + 1.0];
    let gaps = file.u16(86)? == 1;
    let heights =
        raw.into_iter().map(|h| if gaps && marked.contains(&h) { f64::NAN } else { h * unit + offset }).collect();
    let notes = [("title", decode_text(file.slice(20, 30)?)), ("operator", decode_text(file.slice(50, 30)?))];
    let notes = notes.into_iter().filter(|(_, t)| !t.is_empty()).map(|(k, t)| (k.to_owned(), t)).collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes })
}

fn refuse_other_kinds(kind: usize, rows: usize) -> Result<(), Fault> {
    let what = match kind {
        2 => return Ok(()),
        // Gwyddion writes surfaces with the code of a profile.
        1 if rows > 1 => return Ok(()),
        1 => "a profile",
        3 => "a binary image",
        4 => "a series of profiles",
        5 => "a series of surfaces",
        10..=12 => "an image",
        13 | 16 | 17 => "a surface with colours",
        _ => "a study of another kind",
    };
    let advice = "save the surface alone in MountainsMap".to_owned();
    Err(Fault::Unsupported { format: NAME, what: format!("{what} (type {kind})"), advice })
}

/// Number of streams, their sizes (raw, packed), then as many zlib streams that together hold the heights.
fn unpack(file: &Fields, start: usize, needed: usize, sample: Sample) -> Result<Vec<f64>, Fault> {
    if needed as u64 > unpack_limit(file.bytes.len()) {
        return Err(corrupt(format!("{needed} bytes cannot come from a file of {}", file.bytes.len())));
    }
    let streams = file.u32(start)?;
    let mut at = start.saturating_add(4).saturating_add(streams.saturating_mul(8));
    file.slice(start, at - start)?;
    let mut raw = Vec::new();
    for entry in (0..streams).map(|i| start + 4 + 8 * i) {
        let (length, packed) = (file.u32(entry)?, file.u32(entry + 4)?);
        let wanted = (raw.len() + length).min(needed) - raw.len();
        let stream = flate2::read::ZlibDecoder::new(file.slice(at, packed)?);
        let unpacked = stream.take(wanted as u64).read_to_end(&mut raw);
        unpacked.map_err(|e| corrupt(format!("a compressed block is damaged ({e})")))?;
        at += packed;
    }
    if raw.len() != needed {
        return Err(corrupt(format!("{needed} bytes of heights are announced, {} unpack", raw.len())));
    }
    Ok(sample.decode_all(&raw, file.big_endian))
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
