//! 16-bit grey `.png`: `height = low + raw / 65535 * (high - low)`; points with an alpha of 0 are missing.
//!
//! Our own writer leaves range and pitch \[m\] in text chunks. For other pictures the user gives them; 8 bits are refused,
//! because 256 steps are terraces whose edges scatter.

use super::ReadOptions;
use super::fields::{Sample, into_grid};
use crate::archive::unpack_limit;
use crate::error::Fault;
use crate::heightmap::RawMap;
use png::{BitDepth, ColorType, Decoder, Limits};
use std::io::Cursor;

pub const NAME: &str = "PNG";

/// Text chunks in which a map of ours keeps what a picture cannot say: two numbers in metres each.
pub const RANGE_KEYWORD: &str = "asperity:height_range_m";
/// As [`RANGE_KEYWORD`], for the pitch along x and y.
pub const PITCH_KEYWORD: &str = "asperity:pitch_m";

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let limit = usize::try_from(unpack_limit(bytes.len())).unwrap_or(usize::MAX);
    let mut reader =
        Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: limit }).read_info().map_err(broken)?;
    let channels = match (reader.info().color_type, reader.info().bit_depth) {
        (ColorType::Grayscale, BitDepth::Sixteen) => 1,
        (ColorType::GrayscaleAlpha, BitDepth::Sixteen) => 2,
        (colour, depth) => {
            return Err(Fault::Unsupported {
                format: NAME,
                what: format!("a picture of type {colour:?} with {} bits", depth as u8),
                advice: "save the heights as 16-bit grey".to_owned(),
            });
        }
    };
    let (columns, rows) = (reader.info().width as usize, reader.info().height as usize);
    let size = reader.output_buffer_size().filter(|&n| n <= limit);
    let mut buffer = vec![0; size.ok_or_else(|| corrupt(format!("{columns} x {rows} points cannot be in the file")))?];
    reader.next_frame(&mut buffer).map_err(broken)?;
    let text = |keyword: &str| {
        let chunks = &reader.info().uncompressed_latin1_text;
        pair(&chunks.iter().find(|c| c.keyword == keyword)?.text)
    };
    let own = ReadOptions { height_range: options.height_range.or(text(RANGE_KEYWORD)), ..*options };
    let height = own.height_of_level(NAME, 65535.0)?;
    let [pitch_x, pitch_y] = options.pitch_or(NAME, text(PITCH_KEYWORD))?;
    let samples = Sample::U16.decode_all(&buffer, true);
    let point = |point: &[f64]| if point.get(1) == Some(&0.0) { f64::NAN } else { height(point[0]) };
    let heights = samples.chunks_exact(channels).map(point).collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

fn pair(text: &str) -> Option<[f64; 2]> {
    let (first, second) = text.trim().split_once(' ')?;
    Some([first.parse().ok()?, second.parse().ok()?]).filter(|p: &[f64; 2]| p.iter().all(|v| v.is_finite()))
}

fn broken(error: png::DecodingError) -> Fault {
    corrupt(format!("the picture cannot be decoded ({error})"))
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
