//! Gwyddion `.gwy`: nested objects of named, typed components; channel N is the data field `/N/data`.
//!
//! Pitch = `xreal / xres`; heights row by row from the top, in the unit `si_unit_z`. Source: chapter "Gwyddion Native
//! Format" of the Gwyddion user guide.
//!
//! Gwyddion knows no missing points: its import filters fill them with one value and mark them in `/N/mask`. A mask over
//! one single value is therefore taken as missing points, a mask over varying heights as a selection somebody drew.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid};
use super::units::{decode_text, metres};
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "Gwyddion";

const MAGIC: &[u8] = b"GWYP";

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: false };
    let top = object(&file, MAGIC.len(), bytes.len())?;
    let container = components(&file, &top)?;
    let number_of = |name: &str| name.strip_prefix('/')?.strip_suffix("/data")?.parse::<usize>().ok();
    let mut channels: Vec<(usize, Field)> = Vec::new();
    for component in container.iter().filter(|c| c.kind == b'o') {
        if let Some(number) = number_of(&component.name) {
            channels.push((number, field(&file, component)?));
        }
    }
    channels.sort_by_key(|(number, _)| *number);
    let heights_only = channels.iter().find(|(_, f)| f.unit_z.is_some());
    let chosen = match options.layer {
        Some(wanted) => channels.iter().find(|(n, _)| *n == wanted),
        // A file without any unit, as scripts write it, still has a first channel.
        None => heights_only.or(channels.first()),
    };
    let (number, channel) = chosen.ok_or_else(|| Fault::Unsupported {
        format: NAME,
        what: match options.layer {
            Some(n) => format!("channel {n} of a file with {} channel(s)", channels.len()),
            None => "a file without a channel".to_owned(),
        },
        advice: "save the height channel in Gwyddion".to_owned(),
    })?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, channel.pitch)?;
    let unit = channel.unit_z.map_or_else(|| options.unit_or_missing(NAME), Ok)?;
    let mut heights = channel.heights(&file)?;
    heights.iter_mut().for_each(|h| *h = if h.is_finite() { *h * unit } else { f64::NAN });
    let mut notes = Vec::new();
    let named = |suffix: &str| container.iter().find(|c| c.name == format!("/{number}/{suffix}"));
    if let Some(title) = named("data/title").filter(|c| c.kind == b's') {
        notes.push(("title".to_owned(), decode_text(&bytes[title.at..title.end])));
    }
    if let Some(mask) = named("mask").filter(|c| c.kind == b'o') {
        let mask = field(&file, mask)?;
        if (mask.rows, mask.columns) == (channel.rows, channel.columns) {
            let marked = mask.heights(&file)?;
            notes.push(("mask".to_owned(), apply_mask(&mut heights, &marked).to_owned()));
        }
    }
    let heights = into_grid(channel.rows, channel.columns, heights, NAME)?;
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes })
}

/// Makes the marked points missing if they all hold one filled-in value.
fn apply_mask(heights: &mut [f64], mask: &[f64]) -> &'static str {
    let marked: Vec<usize> = (0..mask.len()).filter(|&i| mask[i] > 0.0).collect();
    let Some(&first) = marked.first() else { return "empty" };
    if marked.iter().any(|&i| heights[i] != heights[first]) {
        return "kept: the marked points hold measured heights";
    }
    marked.iter().for_each(|&i| heights[i] = f64::NAN);
    "the marked points hold one filled-in value and are missing"
}

/// A stretch of the file with its name and type.
struct Component {
    name: String,
    kind: u8,
    at: usize,
    end: usize,
}

/// The extent of a serialised object: a name, its size, then the components.
fn object(file: &Fields, at: usize, limit: usize) -> Result<Component, Fault> {
    let (name, start) = name_at(file, at, limit)?;
    let size = file.u32(start)?;
    let end = start + 4 + size;
    if end > limit {
        return Err(corrupt(format!("object {name:?} of {size} bytes is longer than what holds it")));
    }
    Ok(Component { name, kind: b'o', at: start + 4, end })
}

/// Name and end of a NUL-terminated string.
fn name_at(file: &Fields, at: usize, limit: usize) -> Result<(String, usize), Fault> {
    let bytes = file.bytes.get(at..limit).unwrap_or_default();
    let length = bytes.iter().position(|&b| b == 0).ok_or_else(|| corrupt("a name has no end".to_owned()))?;
    Ok((decode_text(&bytes[..length]), at + length + 1))
}

/// The components directly inside an object. An object component spans its own name and size too.
fn components(file: &Fields, object: &Component) -> Result<Vec<Component>, Fault> {
    let mut found = Vec::new();
    let mut at = object.at;
    while at < object.end {
        let (name, after) = name_at(file, at, object.end)?;
        let kind = file.slice(after, 1)?[0];
        let start = after + 1;
        let item = |size: usize| Ok(start + size);
        let array = |size: usize| Ok(start.saturating_add(4).saturating_add(file.u32(start)?.saturating_mul(size)));
        let end = match kind {
            b'b' | b'c' => item(1),
            b'i' => item(4),
            b'q' | b'd' => item(8),
            b's' => Ok(name_at(file, start, object.end)?.1),
            b'o' => Ok(self::object(file, start, object.end)?.end),
            b'C' => array(1),
            b'I' => array(4),
            b'Q' | b'D' => array(8),
            b'S' => (0..file.u32(start)?).try_fold(start + 4, |at, _| Ok(name_at(file, at, object.end)?.1)),
            b'O' => (0..file.u32(start)?).try_fold(start + 4, |at, _| Ok(self::object(file, at, object.end)?.end)),
            other => Err(corrupt(format!("component {name:?} has the unknown type {other:#04x}"))),
        }?;
        if end > object.end {
            return Err(corrupt(format!("component {name:?} is longer than what holds it")));
        }
        found.push(Component { name, kind, at: start, end });
        at = end;
    }
    Ok(found)
}

/// A `GwyDataField`.
struct Field {
    columns: usize,
    rows: usize,
    pitch: Option<[f64; 2]>,
    unit_z: Option<f64>,
    data: Option<usize>,
    count: usize,
}

impl Field {
    fn heights(&self, file: &Fields) -> Result<Vec<f64>, Fault> {
        let (Some(at), true) = (self.data, self.count == self.rows.saturating_mul(self.columns)) else {
            let (columns, rows, count) = (self.columns, self.rows, self.count);
            return Err(corrupt(format!("a channel of {columns} x {rows} points has {count} heights")));
        };
        file.plane(at, self.rows, self.columns, Sample::F64)
    }
}

fn field(file: &Fields, component: &Component) -> Result<Field, Fault> {
    let parts = components(file, &object(file, component.at, component.end)?)?;
    let find = |name: &str, kind: u8| parts.iter().find(|c| c.name == name && c.kind == kind);
    let size = |name: &str| match find(name, b'i') {
        Some(c) => Ok(file.number(c.at, Sample::I32)?.max(0.0) as usize),
        None => Err(corrupt(format!("a channel has no {name}"))),
    };
    let (columns, rows) = (size("xres")?, size("yres")?);
    let real = |name: &str| find(name, b'd').map(|c| file.number(c.at, Sample::F64)).transpose();
    let unit = |name: &str| -> Result<String, Fault> {
        let Some(c) = find(name, b'o') else { return Ok(String::new()) };
        let parts = components(file, &object(file, c.at, c.end)?)?;
        let text = parts.iter().find(|c| c.name == "unitstr" && c.kind == b's');
        Ok(text.map_or_else(String::new, |c| decode_text(&file.bytes[c.at..c.end])))
    };
    let unit_xy = metres(&unit("si_unit_xy")?);
    let pitch = match (real("xreal")?, real("yreal")?, unit_xy) {
        (Some(x), Some(y), Some(unit)) => Some([x * unit / columns as f64, y * unit / rows as f64]),
        _ => None,
    };
    let data = find("data", b'D');
    let count = data.map_or(Ok(0), |c| file.u32(c.at))?;
    Ok(Field { columns, rows, pitch, unit_z: metres(&unit("si_unit_z")?), data: data.map(|c| c.at + 4), count })
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
