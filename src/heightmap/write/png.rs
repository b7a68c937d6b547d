//! 16-bit grey PNG: `raw = 65535 * (height - low) / (high - low)`; a map with gaps gets an alpha channel, 0 where missing.
//!
//! Range and pitch \[m\] are kept in text chunks, which our reader uses; other programs need them said.

use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::heightmap::read::{PNG_PITCH, PNG_RANGE};
use crate::output::write_bytes;
use png::{BitDepth, ColorType, Encoder};
use std::path::Path;

/// Writes the map and returns the heights `[low, high]` \[m\] of black and white.
///
/// # Errors
/// `Error::Parameter` if every point is missing or a side is too long, `Error::Io` otherwise.
pub fn write(path: &Path, map: &RawMap) -> Result<[f64; 2]> {
    let measured = || map.heights.iter().copied().filter(|h| h.is_finite());
    let (low, high) = measured().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    if low > high {
        return Err(Error::parameter("every point of the map is missing", "there is nothing to write"));
    }
    // A flat map is black; any range does.
    let range = if high > low { high - low } else { 1.0 };
    let gaps = map.heights.iter().any(|h| !h.is_finite());
    let mut samples = Vec::with_capacity(map.heights.len() * 4);
    for &height in &map.heights {
        let level = ((height - low) / range * 65535.0).round() as u16;
        samples.extend(level.to_be_bytes());
        if gaps {
            let alpha = if height.is_finite() { u16::MAX } else { 0 };
            samples.extend(alpha.to_be_bytes());
        }
    }
    let bytes = encode(map, &samples, gaps, [low, low + range])
        .map_err(|e| Error::parameter(format!("the picture cannot be encoded: {e}"), "write .x3p or .npy instead"))?;
    write_bytes(path, &bytes)?;
    Ok([low, low + range])
}

fn encode(
    map: &RawMap,
    samples: &[u8],
    gaps: bool,
    range: [f64; 2],
) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let (rows, columns) = map.heights.dim();
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(columns), side(rows));
    encoder.set_color(if gaps { ColorType::GrayscaleAlpha } else { ColorType::Grayscale });
    encoder.set_depth(BitDepth::Sixteen);
    let pair = |[a, b]: [f64; 2]| format!("{a:e} {b:e}");
    encoder.add_text_chunk(PNG_RANGE.to_owned(), pair(range))?;
    encoder.add_text_chunk(PNG_PITCH.to_owned(), pair([map.pitch_x, map.pitch_y]))?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(bytes)
}
