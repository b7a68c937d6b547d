//! `asperity synth`: height maps from a formula.

use super::{print_json, quantity};
use crate::error::Error;
use crate::facets::SlopeStatistics;
use crate::heightmap::synth::{Gaussian, Grid, gaussian, ramp};
use crate::heightmap::write::{npy, x3p};
use crate::heightmap::{Edges, level, parameters};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// File to write: .x3p or .npy (heights in metres)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Root-mean-square height; 0 gives a flat map
    #[arg(long, value_parser = quantity::length, default_value = "0.2um")]
    sq: f64,
    /// Autocorrelation length: the Gaussian autocorrelation falls to 1/e there
    #[arg(long, value_parser = quantity::length, default_value = "20um")]
    acl: f64,
    /// Samples: N or WIDTHxHEIGHT
    #[arg(long, value_parser = quantity::size, default_value = "1024")]
    size: [usize; 2],
    /// Sampling distance, or X,Y
    #[arg(long, value_parser = quantity::pitch, default_value = "0.6um")]
    pitch: [f64; 2],
    /// Seed of the random phases
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fixed spectral amplitudes: Sq and Sdq of this map equal those of the ensemble
    #[arg(long)]
    exact: bool,
    /// A plane of slopes P,Q instead of a rough surface
    #[arg(long, value_parser = quantity::pair, value_name = "P,Q", allow_hyphen_values = true, conflicts_with_all = ["sq", "acl", "exact"])]
    ramp: Option<[f64; 2]>,
    /// How heights are stored
    #[arg(long, value_enum, default_value_t = SamplesFlag::Int16)]
    samples: SamplesFlag,
}

#[derive(ValueEnum, Clone, Copy)]
enum SamplesFlag {
    /// 65 000 steps over the range (.x3p only; .npy then holds f32)
    Int16,
    F32,
    F64,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let grid = Grid { width: a.size[0], height: a.size[1], pitch: a.pitch };
    let map = match a.ramp {
        Some(slopes) => ramp(grid, slopes)?,
        None => gaussian(grid, Gaussian { sq: a.sq, acl: a.acl, seed: a.seed, exact: a.exact })?,
    };
    let extension = a.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("x3p") => x3p::write(
            &a.output,
            &map,
            match a.samples {
                SamplesFlag::Int16 => x3p::Samples::Int16,
                SamplesFlag::F32 => x3p::Samples::Float32,
                SamplesFlag::F64 => x3p::Samples::Float64,
            },
        )?,
        Some("npy") => npy::write(
            &a.output,
            &map,
            match a.samples {
                SamplesFlag::F64 => npy::Precision::Float64,
                SamplesFlag::Int16 | SamplesFlag::F32 => npy::Precision::Float32,
            },
        )?,
        _ => {
            return Err(Error::content(&a.output, "this kind of file cannot be written", "name it .x3p or .npy").into());
        }
    }
    let edges = if a.ramp.is_some() { Edges::Open } else { Edges::Periodic };
    let made = level::keep_tilt(&map, edges);
    let statistics = SlopeStatistics::measure(&made)?;
    let (sq, sdq) = (parameters::sq(&made), statistics.sdq);
    if json {
        return print_json(&serde_json::json!({
            "file": a.output.display().to_string(), "width": a.size[0], "height": a.size[1],
            "pitch_x_m": a.pitch[0], "pitch_y_m": a.pitch[1], "Sq_m": sq, "Sdq": sdq,
        }));
    }
    println!(
        "{}: {} x {} samples, pitch {} x {} um, Sq {:.3} nm, Sdq {:.5}",
        a.output.display(),
        a.size[0],
        a.size[1],
        a.pitch[0] * 1e6,
        a.pitch[1] * 1e6,
        sq * 1e9,
        sdq
    );
    Ok(())
}
