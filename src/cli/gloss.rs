//! `asperity gloss`: the virtual light meter on any source.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::readings::{self, CSV_HEAD, HEADS, Readings};
use super::scatter_options::ScatterOptions;
use super::source::Source;
use crate::math::Estimate;
use crate::meter::Holds;
use crate::output::write_bytes;
use crate::report::Prediction;
use clap::Args;
use rayon::prelude::*;
use serde_json::json;

#[derive(Args)]
pub struct Arguments {
    /// Height maps, tables or models such as beckmann:alpha=0.02,n=1.5
    #[arg(required = true, value_name = "SOURCE")]
    sources: Vec<String>,
    #[command(flatten)]
    readings: readings::Flags,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

const ANGLES: [&str; 3] = ["20", "60", "85"];

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let bench = a.readings.bench()?;
    let bar = Bar::new("gloss", a.sources.len());
    let sources: Vec<Source> = a
        .sources
        .iter()
        .enumerate()
        .map(|(k, text)| Source::open(text, &a.map, &a.scatter, &|share| bar.set(k, share)))
        .collect::<Result<_, _>>()?;
    let found: Vec<Readings> =
        sources.par_iter().map(|s| bench.read(s, &readings::azimuths(s))).collect::<Result<_, _>>()?;
    bar.finish();
    sources.iter().for_each(Source::print_preparation);
    for p in sources.iter().filter_map(Source::surface) {
        for warning in &p.warnings {
            eprintln!("warning: {}: {warning}", p.name);
        }
    }
    for (s, readings) in sources.iter().zip(&found) {
        for name in readings.unconverged() {
            eprintln!("warning: {}: `{name}` has not converged to its tolerance; judge it by its error", s.name());
        }
        if let Some(warning) = readings.doubt() {
            eprintln!("warning: {}: {warning}", s.name());
        }
    }
    if let Some(path) = &a.readings.csv {
        let rows: String = sources.iter().zip(&found).map(|(s, r)| r.csv(s.name(), s.gloss())).collect();
        write_bytes(path, (CSV_HEAD.to_owned() + &rows).as_bytes())?;
    }
    if json {
        let list: Vec<_> = sources
            .iter()
            .zip(&found)
            .map(|(s, readings)| {
                let mut entry = json!({
                    "source": s.name(), "gloss": gloss_json(s.gloss(), s.surface()),
                    "method": s.surface().map_or_else(|| "model".to_owned(), Prediction::method_summary),
                });
                readings.add_to(&mut entry);
                if let Some(report) = s.preparation() {
                    entry["preparation"] = json!(report);
                }
                entry
            })
            .collect();
        return print_json(&json!({ "sources": list }));
    }
    let width = sources.iter().map(|s| s.name().chars().count()).max().unwrap_or(0).max(6);
    println!("{:<width$}  {:>18}  {:>18}  {:>18}", "source", "20 deg, GU", "60 deg, GU", "85 deg, GU");
    for s in &sources {
        let holds = s.surface().map_or([Holds::Rays; 3], Prediction::holds);
        print!("{:<width$}", s.name());
        for (g, holds) in s.gloss().iter().zip(holds) {
            print!("  {:>17}{}", format!("{:.3} +- {:.3}", g.value, g.standard_error), holds.mark());
        }
        println!();
    }
    print_marks(sources.iter().filter_map(Source::surface));
    sources.iter().filter_map(Source::surface).for_each(print_both);
    println!(
        "\n{:<width$}  {:>16}  {:>16}  {:>16}  {:>16}  {:>16}",
        "source", HEADS[0], HEADS[1], HEADS[2], HEADS[3], HEADS[4]
    );
    for (s, readings) in sources.iter().zip(&found) {
        let [haze, log_haze, index, doi, rspec] = readings.line();
        println!("{:<width$}  {haze:>16}  {log_haze:>16}  {index:>16}  {doi:>16}  {rspec:>16}", s.name());
    }
    println!(
        "\nGloss, haze (both sides of 20 deg together) and Rspec in GU: black glass n = 1.567 reads 100. DOI in percent.\n\
         +- is one standard error: of the integration and, for a surface, of its sub-areas, its mirror beam and the steps of its heights."
    );
    for (s, readings) in sources.iter().zip(&found) {
        readings.print_sheets(s.name());
    }
    if let Some(path) = &a.readings.csv {
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// Rays and waves side by side for one map, the Rayleigh parameter that judges them, and which holds.
fn print_both(p: &Prediction) {
    let Some(rays) = p.ray_gloss else { return };
    println!("\n{}: rays straight from the facets, waves where they were asked", p.name);
    println!("  {:>6}  {:>11}  {:>18}  {:>18}  believe", "angle", "Rayleigh g", "rays, GU", "waves, GU");
    for k in 0..3 {
        let text = |e: Estimate| format!("{:.3} +- {:.3}", e.value, e.standard_error);
        let believe = match p.holds()[k] {
            Holds::Rays if p.sq == 0.0 => "rays: the map is exactly flat".to_owned(),
            Holds::Rays => format!("rays: {:.1e} of the light is a coherent mirror beam", (-p.rayleigh[k]).exp()),
            Holds::Waves => format!("waves: {:.3} of the light is a coherent mirror beam", (-p.rayleigh[k]).exp()),
            Holds::Neither => "neither: see the warnings".to_owned(),
        };
        println!(
            "  {:>6}  {:>11}  {:>18}  {:>18}  {believe}",
            format!("{} deg", ANGLES[k]),
            if p.rayleigh[k] < 1000.0 { format!("{:.3}", p.rayleigh[k]) } else { format!("{:.3e}", p.rayleigh[k]) },
            text(rays[k]),
            p.wave_gloss(k).map_or_else(|| "not needed".to_owned(), text),
        );
    }
}

/// What the marks beside the values mean, if there are any.
pub fn print_marks<'a>(surfaces: impl Iterator<Item = &'a Prediction>) {
    let holds: Vec<Holds> = surfaces.flat_map(Prediction::holds).collect();
    if holds.contains(&Holds::Waves) {
        println!("~ by waves (Kirchhoff, with the mirror beam): Rayleigh parameter below 9, where rays do not hold.");
    }
    if holds.contains(&Holds::Neither) {
        println!("* the calculation does not hold at this angle; see the warnings.");
    }
}

/// `{"20": {"value", "standard_error", "rayleigh_g", "ray_valid", "served_by", "holds", "rays", "waves"}, ...}`.
pub fn gloss_json(gloss: [Estimate; 3], surface: Option<&Prediction>) -> serde_json::Value {
    let mut object = serde_json::Map::new();
    for k in 0..3 {
        let mut entry = json!({ "value": gloss[k].value, "standard_error": gloss[k].standard_error });
        if let Some(p) = surface {
            entry["rayleigh_g"] = json!(p.rayleigh[k]);
            entry["ray_valid"] = json!(p.ray_valid()[k]);
            entry["served_by"] = json!(if p.wave[k] { "waves" } else { "rays" });
            entry["holds"] = json!(p.holds()[k].to_string());
            entry["rays"] = json!(p.ray_gloss.map(|g| g[k].value));
            entry["waves"] = json!(p.wave_gloss(k).map(|g| g.value));
        }
        object.insert(ANGLES[k].to_owned(), entry);
    }
    object.into()
}
