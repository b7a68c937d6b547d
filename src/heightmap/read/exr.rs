//! OpenEXR with one channel of heights in the user's unit; NaN and infinities are missing points.

use super::ReadOptions;
use super::fields::into_grid;
use crate::archive::unpack_limit;
use crate::error::Fault;
use crate::heightmap::RawMap;
use exr::image::{AnyChannels, FlatSamples, Image, Layer};
use exr::prelude::{MetaData, ReadChannels, ReadLayers};
use std::io::Cursor;

pub const NAME: &str = "OpenEXR";

/// A channel of this name holds the heights even if there are others.
const USUAL_NAMES: [&str; 3] = ["height", "heights", "Z"];

pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x76\x2f\x31\x01")
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    refuse_impossible_sizes(bytes)?;
    let image: Image<Layer<AnyChannels<FlatSamples>>> = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    let usual = USUAL_NAMES.iter().find_map(|usual| names.iter().position(|name| name == usual));
    let index = usual.or((names.len() == 1).then_some(0)).ok_or_else(|| Fault::Unsupported {
        format: NAME,
        what: format!("a picture with the channels {}", names.join(", ")),
        advice: "save the heights as a single channel".to_owned(),
    })?;
    let unit = options.unit_or_missing(NAME)?;
    let heights: Vec<f64> = match &channels[index].sample_data {
        FlatSamples::F16(v) => v.iter().map(|h| f64::from(h.to_f32())).collect(),
        FlatSamples::F32(v) => v.iter().map(|&h| f64::from(h)).collect(),
        FlatSamples::U32(v) => v.iter().map(|&h| f64::from(h)).collect(),
    };
    let heights = heights.into_iter().map(|h| if h.is_finite() { h * unit } else { f64::NAN }).collect();
    let [pitch_x, pitch_y] = options.pitch_or(NAME, None)?;
    let exr::prelude::Vec2(columns, rows) = image.layer_data.size;
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// The decoder believes the header, so what it announces is weighed against the file first.
fn refuse_impossible_sizes(bytes: &[u8]) -> Result<(), Fault> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    let sizes = meta.headers.iter().map(|header| {
        let samples = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        samples.saturating_mul(4 * header.channels.list.len() as u64)
    });
    let announced = sizes.fold(0, u64::saturating_add);
    if announced > unpack_limit(bytes.len()) {
        let what = format!("a picture of {announced} bytes cannot be in a file of {}", bytes.len());
        return Err(Fault::Corrupt { format: NAME, what });
    }
    Ok(())
}

fn broken(error: exr::error::Error) -> Fault {
    match error {
        exr::error::Error::NotSupported(why) => Fault::Unsupported {
            format: NAME,
            what: why.to_string(),
            advice: "save the heights as a single flat channel".to_owned(),
        },
        other => Fault::Corrupt { format: NAME, what: format!("the picture cannot be decoded ({other})") },
    }
}
