//! `asperity eval`: f_r with its error at listed directions.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use super::written;
use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::math::{Estimate, direction};
use crate::optics::Brdf;
use crate::sample::Reciprocal;
use clap::Args;
use glam::DVec3;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Arguments {
    /// Height map, table, or model such as beckmann:alpha=0.02,n=1.5
    #[arg(value_name = "SOURCE")]
    source: String,
    /// CSV file with the columns theta_i_deg, phi_i_deg, theta_r_deg, phi_r_deg in any order
    #[arg(long, value_name = "FILE")]
    directions: PathBuf,
    /// Write a CSV file: the four angles, f_r_per_sr, standard_error
    #[arg(short, long, value_name = "FILE.csv", value_parser = written::csv)]
    output: Option<PathBuf>,
    /// Evaluate (f(i,o) + f(o,i)) / 2: enforces reciprocity, at the cost of the energy measured per direction
    #[arg(long)]
    reciprocal: bool,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

const COLUMNS: [&str; 4] = ["theta_i_deg", "phi_i_deg", "theta_r_deg", "phi_r_deg"];

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let rows = read_directions(&a.directions)?;
    let bar = Bar::new("scatter", 1);
    let source = Source::open(&a.source, &a.map, &a.scatter, &|share| bar.set(0, share))?;
    bar.finish();
    source.print_preparation();
    let estimate = |wi: DVec3, wo: DVec3| match source.surface() {
        Some(p) => p.brdf.table().estimate(wi, wo),
        None => Estimate::exact(source.brdf().eval(wi, wo)),
    };
    let values: Vec<(Estimate, f64)> = rows
        .iter()
        .map(|row| {
            let r = row.map(f64::to_radians);
            let (wi, wo) = (direction(r[0], r[1]), direction(r[2], r[3]));
            let mut e = estimate(wi, wo);
            if a.reciprocal {
                e.value = Reciprocal(source.brdf()).eval(wi, wo);
                e.standard_error = 0.5 * (e.standard_error + estimate(wo, wi).standard_error);
            }
            (e, source.brdf().specular_core(wi))
        })
        .collect();
    if values.iter().any(|v| v.1 > 0.0) {
        eprintln!("note: f_r leaves out the specular core, a mirror image of its own; see specular_core in --json");
    }
    let mut text = format!("{},f_r_per_sr,standard_error\n", COLUMNS.join(","));
    for (row, (e, _)) in rows.iter().zip(&values) {
        let [a, b, c, d] = row;
        text += &format!("{a},{b},{c},{d},{:e},{:e}\n", e.value, e.standard_error);
    }
    if let Some(path) = &a.output {
        crate::output::write_bytes(path, text.as_bytes())?;
    }
    if json {
        let list: Vec<_> = rows
            .iter()
            .zip(&values)
            .map(|(row, (e, core))| {
                json!({
                    "theta_i_deg": row[0], "phi_i_deg": row[1], "theta_r_deg": row[2], "phi_r_deg": row[3],
                    "f_r_per_sr": e.value, "standard_error": e.standard_error, "specular_core": core,
                })
            })
            .collect();
        return print_json(&json!({
            "source": source.name(), "reciprocity_enforced": a.reciprocal, "directions": list,
        }));
    }
    match &a.output {
        Some(path) => println!("wrote {} directions to {}", rows.len(), path.display()),
        None => print!("{text}"),
    }
    Ok(())
}

/// The four angles of every line \[deg\].
fn read_directions(path: &Path) -> Result<Vec<[f64; 4]>> {
    let columns = Columns::read(path)?;
    if let Some(absent) = COLUMNS.iter().find(|c| !columns.has(c)) {
        let advice = format!("the first line must name the columns {}", COLUMNS.join(", "));
        return Err(Error::content(path, format!("there is no column {absent}"), advice));
    }
    let [theta_i, theta_r] = [COLUMNS[0], COLUMNS[2]].map(|polar| columns.numbers_within(polar, 0.0, 90.0));
    let [phi_i, phi_r] = [COLUMNS[1], COLUMNS[3]].map(|azimuth| columns.numbers(azimuth));
    let (theta_i, phi_i, theta_r, phi_r) = (theta_i?, phi_i?, theta_r?, phi_r?);
    Ok((0..columns.len()).map(|k| [theta_i[k], phi_i[k], theta_r[k], phi_r[k]]).collect())
}
