//! Alicona `.al3d`: text tags of fixed width, then the depth image as f32 metres.
//!
//! A tag is key (20 bytes), value (30), CR LF; scan lines are padded to a multiple of 8 bytes. Instruments store heights
//! far from zero (76 mm above the stage), where an f32 step is 7 nm. Source: Alicona AL3D File Format Specification 1.0.

use super::ReadOptions;
use super::fields::{Fields, Sample, into_grid, plane_bytes};
use super::units::decode_text;
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "Alicona AL3D";

const MAGIC: &[u8] = b"AliconaImaging\0\r\n";
const TAG_BYTES: usize = 52;

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    if !recognises(bytes) {
        return Err(Fault::NotThisFormat(NAME));
    }
    let file = Fields { bytes, format: NAME, big_endian: false };
    let tags = tags(&file)?;
    let text = |key: &str| tags.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str()).filter(|v| !v.is_empty());
    let count = |key: &str| text(key).and_then(|v| v.parse::<usize>().ok()).unwrap_or(0);
    let (columns, rows, start) = (count("Cols"), count("Rows"), count("DepthImageOffset"));
    if start == 0 {
        return Err(Fault::Unsupported {
            format: NAME,
            what: "a file without a depth image".to_owned(),
            advice: "export the surface with its depth image".to_owned(),
        });
    }
    let length = |key: &str| text(key).and_then(|v| v.parse::<f64>().ok());
    let stated = length("PixelSizeXMeter").zip(length("PixelSizeYMeter")).map(|(x, y)| [x, y]);
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let line = plane_bytes(1, columns, 4, NAME)?.next_multiple_of(8);
    // The padding of the last line may be absent.
    let image = file.slice(start, plane_bytes(rows, line, 1, NAME)? - (line - columns * 4))?;
    let invalid = length("InvalidPixelValue").unwrap_or(f64::INFINITY);
    let measured = |depth: f64| match invalid {
        v if v > 0.0 => depth < v * (1.0 - 1.5e-7),
        v => (depth - v).abs() > 1.5e-7 * v.abs(),
    };
    let mut heights = Vec::with_capacity(rows * columns);
    for stored in image.chunks(line) {
        let depths = Sample::F32.decode_all(&stored[..columns * 4], false);
        heights.extend(depths.into_iter().map(|d| if d.is_finite() && measured(d) { d } else { f64::NAN }));
    }
    let notes = text("CreatingApplication").map(|v| ("creator".to_owned(), v.to_owned())).into_iter().collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes })
}

/// `Version`, `TagCount` and as many further tags as that says.
fn tags(file: &Fields) -> Result<Vec<(String, String)>, Fault> {
    let mut tags = Vec::new();
    let mut further = 2;
    while tags.len() < further {
        let tag = file.slice(MAGIC.len() + tags.len() * TAG_BYTES, TAG_BYTES)?;
        let (key, value) = (decode_text(&tag[..20]), decode_text(&tag[20..50]));
        if tags.len() == 1 {
            further += value.parse::<usize>().unwrap_or(0);
        }
        tags.push((key, value));
    }
    Ok(tags)
}
