//! `asperity convert`: a height map in another format, as it was measured.

use super::map_options::{Reading, read_map};
use super::{print_json, written};
use crate::chart::height_preview;
use crate::error::Error;
use crate::heightmap::write::{npy, png, sdf, x3p};
use crate::heightmap::{Edges, RawMap, level};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Arguments {
    /// Height map
    #[arg(value_name = "MAP")]
    input: PathBuf,
    /// File to write: .x3p, .sdf, .npy, or .png (16-bit grey; in colour with --preview)
    #[arg(short, long, value_name = "FILE", value_parser = written::map)]
    output: PathBuf,
    /// Write a picture in colour with scale bar and colour bar (.png); the tilt is taken off
    #[arg(long)]
    preview: bool,
    /// Width of that picture in pixels
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u16).range(320..=8000), requires = "preview")]
    width: u16,
    /// How heights are stored: .x3p has all three, .npy the floats, .sdf f64 alone
    #[arg(long, value_enum, default_value_t = SamplesFlag::F64)]
    samples: SamplesFlag,
    /// Write .sdf as text instead of binary numbers
    #[arg(long)]
    ascii: bool,
    #[command(flatten)]
    reading: Reading,
}

/// How heights are stored.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplesFlag {
    /// 65 000 steps over the range (.x3p only; .npy then holds f32)
    Int16,
    F32,
    F64,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let map = read_map(&a.input, &a.reading.options())?;
    let extension = written::ending(&a.output);
    let mut range = None;
    if a.preview {
        if extension != "png" {
            return Err(Error::content(&a.output, "a preview is a picture", "name it .png").into());
        }
        height_preview(&level::level(&map, Edges::Open)?, a.width.into()).save_png(&a.output)?;
    } else if a.ascii {
        if extension != "sdf" {
            return Err(
                Error::content(&a.output, "only .sdf is written as text", "name it .sdf or leave out --ascii").into()
            );
        }
        sdf::write(&a.output, &map, sdf::Encoding::Ascii)?;
    } else if extension == "png" {
        range = Some(png::write(&a.output, &map)?);
    } else {
        write(&a.output, &map, a.samples)?;
    }
    let (rows, columns) = map.heights.dim();
    if json {
        return print_json(&serde_json::json!({
            "file": a.output.display().to_string(), "format_read": map.format, "width": columns, "height": rows,
            "pitch_x_m": map.pitch_x, "pitch_y_m": map.pitch_y, "height_range_m": range,
        }));
    }
    println!("{}: {columns} x {rows} points, read as {}", a.output.display(), map.format);
    if let Some([low, high]) = range {
        println!("black is {low:e} m, white is {high:e} m; the file says so to asperity, other programs need it said");
    }
    Ok(())
}

/// Writes heights in the format that the name of the file asks for.
///
/// # Errors
/// `Error::Content` for a name of another kind, else those of the writer.
pub fn write(path: &Path, map: &RawMap, samples: SamplesFlag) -> Result<(), Error> {
    match written::ending(path).as_str() {
        "x3p" => {
            let samples = match samples {
                SamplesFlag::Int16 => x3p::Samples::Int16,
                SamplesFlag::F32 => x3p::Samples::Float32,
                SamplesFlag::F64 => x3p::Samples::Float64,
            };
            x3p::write(path, map, samples)
        }
        "npy" => {
            let precision = match samples {
                SamplesFlag::F64 => npy::Precision::Float64,
                SamplesFlag::Int16 | SamplesFlag::F32 => npy::Precision::Float32,
            };
            npy::write(path, map, precision)
        }
        "sdf" => sdf::write(path, map, sdf::Encoding::Binary),
        "png" => png::write(path, map).map(|_| ()),
        _ => Err(Error::content(path, "this kind of file cannot be written", "name it .x3p, .sdf, .npy or .png")),
    }
}
