//! Numbers as text: a matrix of heights, one row a line, or `x y z` triples on a regular grid.
//!
//! Lines before the first numbers are a header; it may state the size and the unit as Gwyddion writes them (`# Width:`,
//! `# Value units:`). Otherwise the unit of the heights and, for a matrix, the pitch come from the user.

mod table;
mod triples;

use super::ReadOptions;
use super::fields::into_grid;
use super::units::{decode_text, metres};
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "text";

/// A header is not longer than this many lines.
const MAX_HEADER_LINES: usize = 100;

/// Text in whose first lines a row of numbers appears.
pub fn recognises(bytes: &[u8]) -> bool {
    let start = first_whole_cells(bytes);
    let binary = start.iter().any(|&b| b == 0x7f || (b < 0x20 && !b.is_ascii_whitespace()));
    !binary && decode_text(start).lines().take(MAX_HEADER_LINES).any(table::is_row)
}

/// The first bytes up to the end of a cell: lines may be longer than what is looked at.
fn first_whole_cells(bytes: &[u8]) -> &[u8] {
    let Some(start) = bytes.get(..super::RECOGNITION_BYTES) else { return bytes };
    let end = start.iter().rposition(|b| b.is_ascii_whitespace() || matches!(b, b',' | b';'));
    &start[..end.unwrap_or(start.len())]
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let text = decode_text(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let table = table::parse(&text)?;
    let header = Header::parse(&table.header);
    let unit = header.unit.map_or_else(|| options.unit_or_missing(NAME), Ok)?;
    if table.columns == 3 && table.values.len() > 9 {
        return triples::to_map(&table.values, unit, options);
    }
    let rows = table.values.len() / table.columns;
    let stated = header.width.zip(header.height).map(|(w, h)| [w / table.columns as f64, h / rows as f64]);
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let heights = table.values.iter().map(|h| if h.is_finite() { h * unit } else { f64::NAN }).collect();
    let heights = into_grid(rows, table.columns, heights, NAME)?;
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// What Gwyddion writes above an exported matrix.
#[derive(Default)]
struct Header {
    width: Option<f64>,
    height: Option<f64>,
    unit: Option<f64>,
}

impl Header {
    fn parse(lines: &[&str]) -> Self {
        let mut header = Header::default();
        for line in lines {
            let Some((key, value)) = line.trim_start_matches('#').split_once(':') else { continue };
            let length = || {
                let (number, unit) = value.trim().split_once(char::is_whitespace)?;
                Some(number.parse::<f64>().ok()? * metres(unit)?)
            };
            match key.trim().to_lowercase().as_str() {
                "width" => header.width = length(),
                "height" => header.height = length(),
                "value units" => header.unit = metres(value),
                _ => {}
            }
        }
        header
    }
}
