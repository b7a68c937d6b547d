//! Surface data file `.sdf` of ISO 25178-71 (editions 1.0 and 2.0, and BCR before it), ASCII and binary.
//!
//! `height = raw * Zscale` \[m\]; pitches are Xscale and Yscale \[m\]. A record is one profile along x. Missing points are
//! the word BAD, or the lowest value of a signed or float type and the highest of an unsigned one.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid, plane_bytes};
use super::units::decode_text;
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "SDF";

/// Type codes 0 to 7 of the standard, with the value that marks a missing point.
const TYPES: [(Sample, f64); 8] = [
    (Sample::U8, u8::MAX as f64),
    (Sample::U16, u16::MAX as f64),
    (Sample::U32, u32::MAX as f64),
    (Sample::F32, f32::MIN as f64),
    (Sample::I8, i8::MIN as f64),
    (Sample::I16, i16::MIN as f64),
    (Sample::I32, i32::MIN as f64),
    (Sample::F64, f64::MIN),
];

struct Header {
    columns: usize,
    rows: usize,
    scales: [f64; 3],
    maker: String,
}

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.len() > 8 && matches!(bytes[0], b'a' | b'b') && matches!(&bytes[1..5], b"ISO-" | b"BCR-") && bytes[6] == b'.'
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let (header, raw) = if bytes[0] == b'a' { read_text(bytes)? } else { read_binary(bytes)? };
    let [x, y, z] = header.scales;
    // A scale of zero would flatten the surface, so it is as good as none.
    let unit = if z.is_finite() && z != 0.0 { z } else { options.unit_or_missing(NAME)? };
    let [pitch_x, pitch_y] = options.pitch_or(NAME, Some([x, y]))?;
    let heights = raw.into_iter().map(|h| if h.is_finite() { h * unit } else { f64::NAN }).collect();
    let heights = into_grid(header.rows, header.columns, heights, NAME)?;
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes: vec![("manufacturer".to_owned(), header.maker)] })
}

/// Raw values, NaN where missing.
fn read_binary(bytes: &[u8]) -> Result<(Header, Vec<f64>), Fault> {
    let file = Fields { bytes, format: NAME, big_endian: false };
    // Edition 2.0 has wider counts, which shift everything behind them.
    let wide = bytes[5] == b'2';
    let (columns, rows, rest) =
        if wide { (file.u32(42)?, file.u32(46)?, 50) } else { (file.u16(42)?, file.u16(44)?, 46) };
    let real = |i: usize| file.number(rest + 8 * i, Sample::F64);
    let codes = file.slice(rest + 32, 3)?;
    refuse_compression(codes[0] != 0)?;
    let (sample, missing) = *TYPES.get(usize::from(codes[1])).ok_or_else(|| unknown_type(codes[1]))?;
    let mut raw = file.plane(rest + 35, rows, columns, sample)?;
    raw.iter_mut().filter(|h| **h == missing).for_each(|h| *h = f64::NAN);
    Ok((Header { columns, rows, scales: [real(0)?, real(1)?, real(2)?], maker: file.text(8, 10)? }, raw))
}

/// Three records closed by lines with an asterisk: header, numbers, remarks (which may be absent).
fn read_text(bytes: &[u8]) -> Result<(Header, Vec<f64>), Fault> {
    let corrupt = |what: String| Fault::Corrupt { format: NAME, what };
    let text = decode_text(bytes);
    let Some((head, rest)) = text.split_once('*') else { return Err(corrupt("the header has no end".to_owned())) };
    let field = |key: &str| {
        let fields = head.lines().filter_map(|l| l.split_once('='));
        fields.map(|(k, v)| (k.trim(), v.trim())).find(|(k, _)| k.eq_ignore_ascii_case(key)).map(|(_, v)| v)
    };
    let count = |key: &str| {
        let value = field(key).and_then(|v| v.parse::<usize>().ok());
        value.ok_or_else(|| corrupt(format!("{key} is missing or not a count")))
    };
    let scale = |key: &str| field(key).and_then(|v| v.parse::<f64>().ok()).unwrap_or(f64::NAN);
    let (columns, rows) = (count("NumPoints")?, count("NumProfiles")?);
    refuse_compression(field("Compression").is_some_and(|v| v != "0"))?;
    let points = plane_bytes(rows, columns, 1, NAME)?;
    let numbers = rest.split_once('*').map_or(rest, |(numbers, _)| numbers);
    let mut raw = Vec::new();
    for word in numbers.split_ascii_whitespace() {
        raw.push(match word {
            w if w.eq_ignore_ascii_case("bad") => f64::NAN,
            w => w.parse().map_err(|_| corrupt(format!("{w:?} is not a height")))?,
        });
    }
    if raw.len() != points {
        return Err(corrupt(format!("{columns} x {rows} heights are announced, {} follow", raw.len())));
    }
    let scales = [scale("Xscale"), scale("Yscale"), scale("Zscale")];
    Ok((Header { columns, rows, scales, maker: field("ManufacID").unwrap_or_default().to_owned() }, raw))
}

fn refuse_compression(compressed: bool) -> Result<(), Fault> {
    if !compressed {
        return Ok(());
    }
    let advice = "write the file without compression".to_owned();
    Err(Fault::Unsupported { format: NAME, what: "compressed data".to_owned(), advice })
}

fn unknown_type(code: u8) -> Fault {
    Fault::Corrupt { format: NAME, what: format!("data type {code} is not one of 0 to 7") }
}
