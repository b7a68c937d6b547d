//! `asperity sample`: directions drawn for one incident direction.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use super::{quantity, written};
use crate::error::Error;
use crate::math::{Estimate, direction, random::CounterRng};
use crate::npy;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
#[command(mut_arg("theta_i", |a| a.help("Incident polar angle to draw for in degrees, one").required(true)))]
#[command(mut_arg("phi_i", |a| a.help("Source azimuth to draw for in degrees, one [default: 0]")))]
pub struct Arguments {
    /// Height map, table, or model such as beckmann:alpha=0.02,n=1.5
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Number of draws
    #[arg(short = 'n', long, value_parser = quantity::count, default_value = "10000", value_name = "N")]
    count: u64,
    /// Array to write (.npy): f64, one row x, y, z, pdf, weight per draw
    #[arg(short, long, value_name = "FILE.npy", value_parser = written::npy)]
    output: PathBuf,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    // A map is tabulated at its usual angles, whichever one is drawn for.
    let (scatter, theta_i, phi_i) = a.scatter.clone().without_angles();
    let theta_i = single(theta_i.as_deref().unwrap_or(&[]), "--theta-i")?.unwrap_or(0.0);
    let phi_i = single(phi_i.as_deref().unwrap_or(&[]), "--phi-i")?.unwrap_or(0.0);
    if !(0.0..std::f64::consts::FRAC_PI_2).contains(&theta_i) {
        return Err(
            Error::parameter("the incident angle is not above the surface", "give --theta-i below 90 deg").into()
        );
    }
    if a.count > MOST {
        let what = format!("{} draws make an array of {:.0} GB", a.count, a.count as f64 * 40e-9);
        return Err(Error::parameter(what, format!("give -n up to {MOST}, and another --seed for more")).into());
    }
    let bar = Bar::new("scatter", 1);
    let source = Source::open(&a.source, &a.map, &scatter, &|share| bar.set(0, share))?;
    bar.finish();
    source.print_preparation();
    let brdf = source.brdf();
    let wi = direction(theta_i, phi_i);
    let mut rows = Vec::with_capacity(a.count as usize);
    let (mut specular, mut nothing) = (0u64, 0u64);
    let (mut sum, mut squares) = (0.0, 0.0);
    let many = |from: u64| {
        let numbers = |draw| {
            let mut rng = CounterRng::new(scatter.seed(), 12, draw);
            [rng.uniform(), rng.uniform()]
        };
        let u: Vec<[f64; 2]> = (from..a.count.min(from + TOGETHER as u64)).map(numbers).collect();
        let mut drawn = vec![None; u.len()];
        brdf.sample_many(&[wi; TOGETHER][..u.len()], &u, &mut drawn);
        drawn
    };
    for drawn in (0..a.count).step_by(TOGETHER).flat_map(many) {
        let row = match drawn {
            Some(s) => {
                specular += u64::from(s.specular);
                [s.wo.x, s.wo.y, s.wo.z, s.pdf, s.weight]
            }
            None => {
                nothing += 1;
                [f64::NAN, f64::NAN, f64::NAN, 0.0, 0.0]
            }
        };
        sum += row[4];
        squares += row[4] * row[4];
        rows.push(row);
    }
    let n = a.count as f64;
    let mean = Estimate { value: sum / n, standard_error: ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt() };
    let bytes = npy::encode(&[rows.len(), 5], rows.iter().flatten().copied());
    crate::output::write_bytes(&a.output, &bytes)?;
    let albedo = brdf.albedo_towards(wi);
    if json {
        return print_json(&json!({
            "source": source.name(), "file": a.output.display().to_string(), "columns": ["x", "y", "z", "pdf_per_sr", "weight"],
            "theta_i_deg": theta_i.to_degrees(), "phi_i_deg": phi_i.to_degrees(), "draws": a.count,
            "specular_core": specular, "nothing": nothing, "mean_weight": mean, "albedo": albedo,
        }));
    }
    println!(
        "wrote {} draws to {}: mean weight {:.5} +- {:.5}, albedo {:.5}; {specular} of the specular core (pdf inf), \
         {nothing} below the horizon (NaN, weight 0)",
        a.count,
        a.output.display(),
        mean.value,
        mean.standard_error,
        albedo,
    );
    Ok(())
}

/// Draws that one array holds.
const MOST: u64 = 100_000_000;

/// Draws asked for at once.
const TOGETHER: usize = 1024;

/// The one value of a list.
fn single(list: &[f64], flag: &str) -> Result<Option<f64>, Error> {
    match *list {
        [] => Ok(None),
        [one] => Ok(Some(one)),
        _ => Err(Error::parameter(format!("{flag} has {} values", list.len()), "draws are for one incident direction")),
    }
}
