//! Zygo's text exports: "XYZ Data File" (a line of column, row, height in um per point) and "ASCII Data File" (integers
//! that become heights as in the binary `.dat`).
//!
//! Both begin with the same 14 lines: line 4 holds origin and size of the height map, line 8 among others S, wavelength
//! \[m\], obliquity and lateral resolution \[m\], line 11 first the phase resolution. Lines of one `#` part the sections.
//! Source: appendix "Data File Format" of the MetroPro reference guide OMP-0347.

use super::ReadOptions;
use super::fields::{into_grid, plane_bytes};
use super::metropro::{MISSING, phase_steps};
use super::units::decode_text;
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "Zygo text";

const XYZ: &[u8] = b"Zygo XYZ Data File";
const ASCII: &[u8] = b"Zygo ASCII Data File";

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(XYZ) || bytes.starts_with(ASCII)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let text = decode_text(bytes);
    let mut sections = text.split("\n#").map(|section| section.trim_start_matches(['#', '\r']));
    let header: Vec<&str> = sections.next().unwrap_or_default().lines().collect();
    let item = |line: usize, place: usize| -> Result<f64, Fault> {
        let word = header.get(line - 1).and_then(|l| l.split_whitespace().nth(place - 1));
        let number = word.and_then(|w| w.parse().ok()).filter(|v: &f64| v.is_finite());
        number.ok_or_else(|| corrupt(format!("item {place} of line {line} is missing or no number")))
    };
    let (columns, rows) = (item(4, 3)? as usize, item(4, 4)? as usize);
    let points = plane_bytes(rows, columns, 1, NAME)?;
    let lateral = item(8, 7)?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, Some([lateral, lateral]))?;
    let heights = if bytes.starts_with(XYZ) {
        let lines = sections.next().unwrap_or_default().lines().filter(|l| !l.trim().is_empty());
        lines.map(xyz_height).collect::<Result<Vec<f64>, Fault>>()?
    } else {
        let unit = item(8, 2)? * item(8, 5)? * item(8, 3)? / phase_steps(item(11, 1)? as usize)?;
        // The section between is the intensity image, which may be empty.
        let words = sections.nth(1).unwrap_or_default().split_ascii_whitespace();
        words.map(|word| phase_height(word, unit)).collect::<Result<Vec<f64>, Fault>>()?
    };
    if heights.len() != points {
        return Err(corrupt(format!("{columns} x {rows} heights are announced, {} follow", heights.len())));
    }
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// `column row height` or `column row No Data`; points come row by row.
fn xyz_height(line: &str) -> Result<f64, Fault> {
    let mut words = line.split_whitespace().skip(2);
    match words.next() {
        Some("No") => Ok(f64::NAN),
        Some(word) => {
            let height: f64 = word.parse().map_err(|_| corrupt(format!("{word:?} is not a height")))?;
            Ok(if height.is_finite() { height * 1e-6 } else { f64::NAN })
        }
        None => Err(corrupt(format!("the line {line:?} holds no height"))),
    }
}

fn phase_height(word: &str, unit: f64) -> Result<f64, Fault> {
    let raw: f64 = word.parse().map_err(|_| corrupt(format!("{word:?} is not a height")))?;
    Ok(if raw < MISSING { raw * unit } else { f64::NAN })
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
