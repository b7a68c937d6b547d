//! `asperity brdf`: one map to one table, or to detectors counted one by one; in one go or in parts.

mod detectors;
mod table;

use super::map_options::{MapOptions, print_report};
use super::print_json;
use super::scatter_options::ScatterOptions;
use crate::error::{Error, Result};
use crate::heightmap::HeightMap;
use crate::heightmap::crop::Region;
use crate::heightmap::sampling::Sampling;
use crate::scatter::run::{Run, Sums, fingerprint};
use crate::scatter::{Footprint, Options, Part, Partition};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct Arguments {
    /// Height map
    map_file: PathBuf,
    /// What to write: a table (.npz), or one row per detector (.csv)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
    #[command(flatten)]
    counting: CountingFlags,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    parts: Parts,
}

/// Flags of the .csv output.
#[derive(Args)]
#[command(next_help_heading = "Detectors, for .csv output")]
struct CountingFlags {
    /// half-vector, klems, theta-phi:DT,DP in degrees, equal-area:N, or shirley-chiu:K for 4^K cells; counted at every
    /// --theta-i and --phi-i (here by default 0) in the frame of the map, or averaged over azimuth with --symmetry isotropic.
    /// Rows of half-vector cells give the angles of the half vector [default: half-vector]
    #[arg(long, value_name = "PARTITION", value_parser = |text: &str| Partition::parse(text))]
    detectors: Option<Partition>,
}

/// Flags of both.
#[derive(Args)]
#[command(next_help_heading = "Light")]
struct LightFlags {
    /// Light only this part of the map, X0,Y0,X1,Y1 from the top left as fractions or lengths; unlike with --region the rest
    /// still shadows and reflects
    #[arg(long, value_name = "REGION", value_parser = super::quantity::region, allow_hyphen_values = true)]
    footprint: Option<Region>,
}

/// Flags of a run in parts.
#[derive(Args)]
#[command(next_help_heading = "Long runs in parts")]
struct Parts {
    /// Count only part K of N and write its sums to --output (.json); give the flags of the whole run with it
    #[arg(long, value_name = "K/N", value_parser = |text: &str| Part::parse(text))]
    part: Option<Part>,
    /// Take the beams from the files of all parts: writes the same bytes as one run with the same flags
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "part")]
    merge: Vec<PathBuf>,
}

impl Parts {
    /// The run these flags ask for; `what` tells a table from detectors.
    fn run(&self, map: &HeightMap, options: &Options, what: &str) -> Result<Run> {
        if let Some(part) = self.part {
            return Ok(Run::Part(Sums::new(part, fingerprint(map, options, what))));
        }
        if self.merge.is_empty() {
            return Ok(Run::Whole);
        }
        Ok(Run::Merged { sums: Sums::merge(&self.merge)?, next: 0 })
    }
}

/// What a call has to say, for programs and for people.
struct Answer {
    json: Value,
    text: String,
}

impl Answer {
    /// A part says no more than that it was written.
    fn of_part(sums: &Sums) -> Self {
        Answer { json: json!({ "part": sums.part().to_string() }), text: String::new() }
    }
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let extension = super::written::ending(&a.output);
    let to_detectors = extension == "csv" || a.counting.detectors.is_some();
    check_output(a, &extension, to_detectors)?;
    let mut settings = a.scatter.settings()?;
    let prepared = a.map.load(&a.map_file)?;
    settings.scatter.footprint = a.light.footprint.map(|region| Footprint::of(region, &prepared.map)).transpose()?;
    print_report(&a.map_file, &prepared.report);
    for warning in Sampling::examine(&prepared.map).warnings {
        eprintln!("warning: {warning}");
    }
    let Answer { json: mut answer, text } = if to_detectors {
        detectors::run(a, &settings, &prepared.map)?
    } else {
        table::run(a, &settings, &prepared.map)?
    };
    let seconds = start.elapsed().as_secs_f64();
    if json {
        answer["file"] = json!(a.output.display().to_string());
        answer["seconds"] = json!(seconds);
        answer["preparation"] = json!(prepared.report);
        return print_json(&answer);
    }
    println!("{text}wrote {} in {seconds:.2} s", a.output.display());
    Ok(())
}

/// An angle \[rad\] in degrees, as the user gave it: to a billionth.
fn degrees(angle: f64) -> f64 {
    (angle.to_degrees() * 1e9).round() / 1e9
}

/// The extension must say what is written.
fn check_output(a: &Arguments, extension: &str, to_detectors: bool) -> Result<()> {
    let wrong = |advice: &str| {
        Err(Error::parameter(format!("{} is no name for this output", a.output.display()), advice.to_owned()))
    };
    match (a.parts.part.is_some(), to_detectors, extension) {
        (true, _, "csv" | "npz") => {
            wrong("a part holds sums, neither table nor rows: name it .json, and merge all parts")
        }
        (true, ..) | (false, true, "csv") | (false, false, "npz") => Ok(()),
        (false, true, _) => wrong("detectors go to a .csv file; leave out --detectors for a table"),
        (false, false, _) => wrong("name it .npz for a table, .csv for detectors"),
    }
}
