//! SPIP `.bcrf` (f32) and `.bcr` (i16): a text header of fixed length, in Latin-1 or UTF-16, then the heights.
//!
//! f32: height in `zunit`; i16: `height = raw * bit2nm` in `zunit`. Pitch = `xlength / xpixels` in `xunit`. Units are nm
//! if not given. `headersize` counts characters. Source: BCR-STM file format of Image Metrology's SPIP handbook.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid};
use super::units::{decode_text, metres};
use crate::error::Fault;
use crate::heightmap::RawMap;
use std::collections::HashMap;

pub const NAME: &str = "SPIP BCR";

const MAGIC: &str = "fileformat = bcr";
/// Length of the header in characters where `headersize` is not given, and of the part that must hold it.
const USUAL_HEADER: usize = 2048;

#[derive(Clone, Copy)]
enum Encoding {
    Latin1,
    Utf16 { big_endian: bool },
}

fn encoding(bytes: &[u8]) -> Option<Encoding> {
    let wide = |big_endian: bool| {
        let units = MAGIC.encode_utf16();
        units.flat_map(|u| if big_endian { u.to_be_bytes() } else { u.to_le_bytes() }).collect::<Vec<u8>>()
    };
    let rest = bytes.strip_prefix(b"\xff\xfe").unwrap_or(bytes);
    match () {
        () if bytes.starts_with(MAGIC.as_bytes()) => Some(Encoding::Latin1),
        () if rest.starts_with(&wide(false)) => Some(Encoding::Utf16 { big_endian: false }),
        () if bytes.strip_prefix(b"\xfe\xff")?.starts_with(&wide(true)) => Some(Encoding::Utf16 { big_endian: true }),
        () => None,
    }
}

pub fn recognises(bytes: &[u8]) -> bool {
    encoding(bytes).is_some()
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let encoding = encoding(bytes).ok_or(Fault::NotThisFormat(NAME))?;
    let corrupt = |what: &str| Fault::Corrupt { format: NAME, what: what.to_owned() };
    let width = if matches!(encoding, Encoding::Latin1) { 1 } else { 2 };
    let header = |characters: usize| {
        let text = bytes.get(..characters.saturating_mul(width)).ok_or_else(|| corrupt("the header ends early"))?;
        Ok(parse_header(&decode(text, encoding)))
    };
    let size = header(USUAL_HEADER)?.get("headersize").map_or(Ok(USUAL_HEADER), |t| t.parse());
    let size: usize = size.map_err(|_| corrupt("headersize is not a count"))?;
    let header: HashMap<String, String> = header(size)?;
    let count = |key: &str| {
        let value = header.get(key).and_then(|t| t.parse::<usize>().ok());
        value.ok_or_else(|| corrupt(&format!("{key} is missing or not a count")))
    };
    let number = |key: &str| header.get(key).and_then(|t| t.parse::<f64>().ok());
    let unit = |key: &str| {
        let name = header.get(key).map_or("nm", |t| t.as_str());
        metres(name).ok_or_else(|| Fault::Unsupported {
            format: NAME,
            what: format!("{key} {name:?}"),
            advice: "export a topography with heights and lengths in a unit of length".to_owned(),
        })
    };
    let (columns, rows) = (count("xpixels")?, count("ypixels")?);
    let floats = header.get("fileformat").is_some_and(|f| f.starts_with("bcrf"));
    let (sample, missing_from, factor) =
        if floats { (Sample::F32, 1.7e38, 1.0) } else { (Sample::I16, 32767.0, number("bit2nm").unwrap_or(1.0)) };
    let factor = factor * unit("zunit")?;
    let stated = match (number("xlength"), number("ylength")) {
        (Some(x), Some(y)) => Some([x * unit("xunit")? / columns as f64, y * unit("yunit")? / rows as f64]),
        _ => None,
    };
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let big_endian = number("intelmode") == Some(0.0);
    let file = Fields { bytes, format: NAME, big_endian };
    let mut heights = file.plane(size.saturating_mul(width), rows, columns, sample)?;
    for height in &mut heights {
        *height = if height.is_finite() && *height < missing_from { *height * factor } else { f64::NAN };
    }
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

fn decode(bytes: &[u8], encoding: Encoding) -> String {
    match encoding {
        Encoding::Latin1 => bytes.iter().map(|&b| char::from(b)).collect(),
        Encoding::Utf16 { big_endian } => {
            let unit = |pair: &[u8]| {
                let pair = [pair[0], pair[1]];
                if big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
            };
            let units: Vec<u16> = bytes.chunks_exact(2).map(unit).collect();
            String::from_utf16_lossy(&units).trim_start_matches('\u{feff}').to_owned()
        }
    }
}

/// `key = value` lines; `%` and `#` begin remarks.
fn parse_header(text: &str) -> HashMap<String, String> {
    let lines = text.lines().filter(|l| !l.starts_with(['%', '#']));
    let pairs = lines.filter_map(|l| l.split_once('='));
    pairs.map(|(key, value)| (key.trim().to_lowercase(), decode_text(value.as_bytes()))).collect()
}
