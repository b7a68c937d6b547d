//! `asperity eval`: f_r with its error at listed directions.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use crate::math::{Estimate, direction};
use crate::optics::Brdf;
use crate::sample::Reciprocal;
use anyhow::{Context, bail};
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
    #[arg(short, long, value_name = "FILE")]
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
fn read_directions(path: &Path) -> anyhow::Result<Vec<[f64; 4]>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("{}: cannot read", path.display()))?;
    let mut lines =
        text.lines().enumerate().map(|(n, l)| (n + 1, l.trim())).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let advice = format!("the first line must name the columns {}", COLUMNS.join(", "));
    let Some((_, header)) = lines.next() else { bail!("{}: the file is empty; {advice}", path.display()) };
    let names: Vec<&str> = header.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
    let mut places = [0; 4];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = names
            .iter()
            .position(|n| *n == column)
            .with_context(|| format!("{}: there is no column {column}; {advice}", path.display()))?;
    }
    let mut rows = Vec::new();
    for (number, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut row = [0.0; 4];
        for (k, value) in row.iter_mut().enumerate() {
            let field = fields.get(places[k]).copied().unwrap_or("");
            *value = field.parse().ok().filter(|v: &f64| v.is_finite()).with_context(|| {
                format!("{}: line {number}: {} is `{field}`, not a number of degrees", path.display(), COLUMNS[k])
            })?;
        }
        for k in [0, 2] {
            if !(0.0..=90.0).contains(&row[k]) {
                bail!(
                    "{}: line {number}: {} is {}; polar angles lie between 0 and 90 deg",
                    path.display(),
                    COLUMNS[k],
                    row[k]
                );
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        bail!("{}: no directions below the header", path.display());
    }
    Ok(rows)
}
