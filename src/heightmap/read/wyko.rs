//! Wyko `.opd` of Veeco and Bruker Vision; little-endian blocks named in a directory.
//!
//! `height = raw * Wavelength / Mult` \[nm\]; pitch along x `Pixel_size` [mm], along y `Pixel_size * Aspect`. Arrays are
//! stored column by column, each from the bottom up. Source: the block layout as Gwyddion and SurfaceTopography read it.

use super::ReadOptions;
use super::fields::{Fields, Sample, plane_bytes};
use crate::error::Fault;
use crate::heightmap::RawMap;
use ndarray::Array2;

pub const NAME: &str = "Wyko OPD";

const ENTRY_BYTES: usize = 24;
const HEIGHT_BLOCKS: [&str; 5] = ["RAW DATA", "RAW_DATA", "OPD", "Raw", "SAMPLE_DATA"];

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x01\x00Directory\0")
}

/// A named stretch of the file.
struct Block {
    name: String,
    kind: usize,
    at: usize,
    length: usize,
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: false };
    let blocks = directory(&file)?;
    let find = |name: &str| blocks.iter().find(|b| b.name == name);
    let number = |name: &str| find(name).map_or(Ok(None), |b| scalar(&file, b));
    let array =
        HEIGHT_BLOCKS.iter().find_map(|name| find(name).filter(|b| b.kind == 3)).ok_or_else(|| Fault::Unsupported {
            format: NAME,
            what: "a file without a height array".to_owned(),
            advice: "save the raw data in Vision".to_owned(),
        })?;
    let unit = match number("Wavelength")?.map(|nm| nm * 1e-9) {
        Some(wavelength) => wavelength / number("Mult")?.filter(|&m| m != 0.0).unwrap_or(1.0),
        None => options.unit_or_missing(NAME)?,
    };
    let aspect = number("Aspect")?.unwrap_or(1.0);
    let stated = number("Pixel_size")?.map(|mm| [mm * 1e-3, mm * 1e-3 * aspect]);
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let heights = height_array(&file, array, unit)?;
    let notes = ["Title", "Date", "Time"]
        .into_iter()
        .filter_map(|name| find(name).filter(|b| b.kind == 5))
        .map(|b| Ok((b.name.to_lowercase(), file.text(b.at, b.length)?)))
        .collect::<Result<Vec<_>, Fault>>()?;
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes })
}

/// All blocks with a payload; payloads follow the directory in its order.
fn directory(file: &Fields) -> Result<Vec<Block>, Fault> {
    // The first entry describes the directory itself.
    let directory_bytes = file.u32(2 + 18)?;
    file.slice(2, directory_bytes)?;
    let mut at = 2 + directory_bytes;
    let mut blocks = Vec::new();
    for entry in (1..directory_bytes / ENTRY_BYTES).map(|i| 2 + i * ENTRY_BYTES) {
        let length = file.number(entry + 18, Sample::I32)?;
        if length <= 0.0 {
            continue;
        }
        let length = length as usize;
        blocks.push(Block { name: file.text(entry, 16)?, kind: file.u16(entry + 16)?, at, length });
        at += length;
    }
    Ok(blocks)
}

/// The number in a scalar block. Some writers declare a wrong type, so the length decides where it must.
fn scalar(file: &Fields, block: &Block) -> Result<Option<f64>, Fault> {
    let sample = match (block.kind, block.length) {
        (6 | 7, 2) => Sample::I16,
        (6 | 12, 4) => Sample::I32,
        (7, 4..) => Sample::F32,
        (8, 8..) => Sample::F64,
        _ => return Ok(None),
    };
    let value = file.number(block.at, sample)?;
    Ok(Some(value).filter(|v| v.is_finite()))
}

fn height_array(file: &Fields, block: &Block, unit: f64) -> Result<Array2<f64>, Fault> {
    let corrupt = |what: String| Fault::Corrupt { format: NAME, what };
    let (columns, rows) = (file.u16(block.at)?, file.u16(block.at + 2)?);
    let (sample, missing_from) = match file.u16(block.at + 4)? {
        2 => (Sample::I16, 32766.0),
        4 => (Sample::F32, 1e38),
        size => return Err(corrupt(format!("the heights of block {} have {size} bytes each", block.name))),
    };
    if plane_bytes(rows, columns, sample.size(), NAME)? > block.length.saturating_sub(6) {
        let (name, length) = (&block.name, block.length);
        return Err(corrupt(format!("block {name} of {length} bytes is too short for {columns} x {rows} points")));
    }
    let stored = file.plane(block.at + 6, columns, rows, sample)?;
    Ok(Array2::from_shape_fn((rows, columns), |(r, c)| {
        let raw = stored[c * rows + (rows - 1 - r)];
        if raw.is_finite() && raw < missing_from { raw * unit } else { f64::NAN }
    }))
}
