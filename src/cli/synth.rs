//! `asperity synth`: height maps from a formula.

use super::convert::{SamplesFlag, write};
use super::{print_json, quantity, written};
use crate::error::Error;
use crate::heightmap::synth::{self, Brushed, Decay, Defects, Gaussian, Grid, Rough};
use crate::heightmap::{Edges, RawMap, level, parameters};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// File to write: .x3p, .sdf, .npy (heights in metres) or 16-bit .png
    #[arg(short, long, value_name = "FILE", value_parser = written::map)]
    output: PathBuf,
    /// Samples: N or WIDTHxHEIGHT
    #[arg(long, value_parser = quantity::size, default_value = "1024")]
    size: [usize; 2],
    /// Sampling distance, or X,Y
    #[arg(long, value_parser = quantity::pitch, default_value = "0.6um")]
    pitch: [f64; 2],
    /// Seed of everything random: same seed, same bytes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How heights are stored: .x3p has all three, .npy the floats, .sdf f64 alone
    #[arg(long, value_enum, default_value_t = SamplesFlag::Int16)]
    samples: SamplesFlag,
    #[command(flatten)]
    surface: Surface,
    #[command(flatten)]
    defects: DefectFlags,
}

#[derive(Args)]
#[command(next_help_heading = "Surface")]
struct Surface {
    /// What to make
    #[arg(long, value_enum, default_value_t = ShapeFlag::Gaussian)]
    shape: ShapeFlag,
    /// Root-mean-square height of gaussian, exponential, brushed and sinusoid; 0 gives a flat map
    #[arg(long, value_parser = quantity::length, default_value = "0.2um")]
    sq: f64,
    /// Autocorrelation length: where a gaussian or exponential autocorrelation falls to 1/e. Two lengths A,B make the
    /// surface anisotropic: A along --angle, B across [brushed: along and across the lay]
    #[arg(long, value_parser = quantity::pitch, default_value = "20um", value_name = "LENGTH[,LENGTH]")]
    acl: [f64; 2],
    /// Direction from +x: of the first --acl, of the lay, or in which sinusoid and sawtooth rise and fall
    #[arg(long, value_parser = quantity::angle, default_value = "0deg", allow_hyphen_values = true)]
    angle: f64,
    /// Sq of this one map is exactly --sq: spectral amplitudes are fixed (Sdq is then the ensemble's as well), a brushed map
    /// is scaled; a sinusoid always is exact over whole periods
    #[arg(long)]
    exact: bool,
    /// Period of sinusoid and sawtooth
    #[arg(long, value_parser = quantity::length, default_value = "20um")]
    period: f64,
    /// Slope of both flanks of the sawtooth
    #[arg(long, default_value_t = 0.1)]
    slope: f64,
    /// Radius of curvature of the cap; negative for a bowl
    #[arg(long, value_parser = quantity::length, default_value = "10mm", allow_hyphen_values = true)]
    radius: f64,
    /// Grooves of a brushed map that overlap at a point on average: 0.3 is a scratched mirror, 30 a satin finish
    #[arg(long, default_value_t = 10.0)]
    overlap: f64,
    /// A plane of slopes P,Q: the same as --shape ramp
    #[arg(long, value_parser = quantity::pair, value_name = "P,Q", allow_hyphen_values = true, conflicts_with_all = ["sq", "acl", "exact"])]
    ramp: Option<[f64; 2]>,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq)]
enum ShapeFlag {
    /// Random, autocorrelation exp(-(r/acl)^2): --sq --acl --angle --exact
    Gaussian,
    /// Random, autocorrelation exp(-r/acl), no rms slope: --sq --acl --angle --exact
    Exponential,
    /// Grooves of one shape at random places: --sq --acl --angle --overlap --exact
    Brushed,
    /// A wave: --sq --period --angle
    Sinusoid,
    /// Two slopes: --slope --period --angle
    Sawtooth,
    /// A sphere: --radius
    Cap,
    /// A plane: --ramp
    Ramp,
}

#[derive(Args)]
#[command(next_help_heading = "Defects, added in this order")]
struct DefectFlags {
    /// Standard deviation of white height noise
    #[arg(long, value_parser = quantity::length, default_value = "0", hide_default_value = true, value_name = "LENGTH")]
    noise: f64,
    /// Share of the points that become spikes, such as 1% or 0.01
    #[arg(long, value_parser = quantity::share, default_value = "0", hide_default_value = true, value_name = "SHARE", requires = "spike_height")]
    spikes: f64,
    /// How far a spike stands out, up or down at random
    #[arg(long, value_parser = quantity::length, default_value = "0", hide_default_value = true, value_name = "LENGTH")]
    spike_height: f64,
    /// Step that heights are rounded to
    #[arg(long, value_parser = quantity::length, default_value = "0", hide_default_value = true, value_name = "LENGTH")]
    quantum: f64,
    /// Share of the points that go missing, such as 5% or 0.05
    #[arg(long, value_parser = quantity::share, default_value = "0", hide_default_value = true, value_name = "SHARE")]
    dropouts: f64,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let grid = Grid { width: a.size[0], height: a.size[1], pitch: a.pitch };
    let (mut map, edges) = make(grid, &a.surface, a.seed)?;
    let d = &a.defects;
    let (spikes, spike_height) = (d.spikes, d.spike_height);
    let defects =
        Defects { noise: d.noise, spikes, spike_height, quantum: d.quantum, dropouts: d.dropouts, seed: a.seed };
    synth::add_defects(&mut map, &defects)?;
    write(&a.output, &map, a.samples)?;
    let made = level::keep_tilt(&map, edges);
    // Dropouts may leave no facet; the file is as asked.
    let sdq = parameters::Gradient::measure(&made).sdq;
    let sq = parameters::sq(&made);
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

/// The surface, and whether it goes on beyond its border.
fn make(grid: Grid, s: &Surface, seed: u64) -> Result<(RawMap, Edges), Error> {
    let Surface { sq, acl, angle, exact, .. } = *s;
    let rough = |decay| synth::rough(grid, Rough { sq, acl, angle, decay, seed, exact });
    if let Some(slopes) = s.ramp {
        return Ok((synth::ramp(grid, slopes)?, Edges::Open));
    }
    Ok(match s.shape {
        // One length has no direction.
        ShapeFlag::Gaussian if acl[0] == acl[1] => {
            (synth::gaussian(grid, Gaussian { sq, acl: acl[0], seed, exact })?, Edges::Periodic)
        }
        ShapeFlag::Gaussian => (rough(Decay::Gaussian)?, Edges::Periodic),
        ShapeFlag::Exponential => (rough(Decay::Exponential)?, Edges::Periodic),
        ShapeFlag::Brushed => {
            let brushed = Brushed { sq, acl, lay: angle, overlap: s.overlap, seed, exact };
            (synth::brushed(grid, brushed)?, Edges::Periodic)
        }
        ShapeFlag::Sinusoid => (synth::sinusoid(grid, sq, s.period, angle)?, Edges::Open),
        ShapeFlag::Sawtooth => (synth::sawtooth(grid, s.slope, s.period, angle)?, Edges::Open),
        ShapeFlag::Cap => (synth::cap(grid, s.radius)?, Edges::Open),
        ShapeFlag::Ramp => {
            return Err(Error::parameter("the plane has no slopes", "give them with --ramp, for example --ramp 0.1,0"));
        }
    })
}
