//! `asperity check`: the audit of any source.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use crate::sample::Reciprocal;
use crate::sample::audit::{self, Audit, Row, audit};
use anyhow::bail;
use clap::Args;
use serde_json::json;

#[derive(Args)]
pub struct Arguments {
    /// Height map, table, or model such as beckmann:alpha=0.02,n=1.5
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Draws per incident direction
    #[arg(long, value_parser = super::quantity::count, default_value = "200000", value_name = "N")]
    draws: u64,
    /// Audit (f(i,o) + f(o,i)) / 2 instead: reciprocity enforced
    #[arg(long)]
    reciprocal: bool,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let bar = Bar::new("scatter", 1);
    let source = Source::open(&a.source, &a.map, &a.scatter, &|share| bar.set(0, share))?;
    bar.finish();
    source.print_preparation();
    let mut options = audit::Options { draws: a.draws.max(1000), ..audit::Options::default() };
    if source.surface().is_some_and(|p| p.isotropic) {
        // One azimuth tells of all; a second one tells of the frame.
        options.phi_i.truncate(2);
    }
    let table = source.surface().map(|p| p.brdf.table());
    let estimate = |wi, wo| table.expect("only asked of tables").estimate(wi, wo);
    let error_of: Option<audit::ErrorOf> = if table.is_some() { Some(&estimate) } else { None };
    let found = if a.reciprocal {
        audit(&Reciprocal(source.brdf()), error_of, &options)
    } else {
        audit(source.brdf(), error_of, &options)
    };
    if json {
        let mut object = json!({ "source": source.name(), "reciprocity_enforced": a.reciprocal });
        object["audit"] = json!(found);
        print_json(&object)?;
    } else {
        print(&source, &found, options.phi_i.len());
    }
    if !found.passed {
        bail!("{}: {} of the statements do not hold", source.name(), found.findings.len());
    }
    Ok(())
}

/// One line per polar angle: the worst of its azimuths.
fn print(source: &Source, found: &Audit, azimuths: usize) {
    println!("{}: {} incident directions", source.name(), found.rows.len());
    println!(
        "theta_i  albedo   integral  mean weight          asymmetry        pdf integral (due)  chi-square (dof)    p        weight"
    );
    for rows in found.rows.chunks(azimuths) {
        let worst = |f: fn(&Row) -> f64| rows.iter().max_by(|a, b| f(a).total_cmp(&f(b))).expect("an azimuth");
        let energy = worst(|r| (r.integral - r.albedo).abs());
        let chi = worst(|r| -r.p_value);
        let pdf = worst(|r| (r.pdf_integral - r.pdf_expected).abs());
        let turned = worst(|r| r.asymmetry);
        let sigma = turned.asymmetry_sigma.map_or(String::new(), |s| format!(" {s:.1} SE"));
        let mean = energy.mean_weight;
        println!(
            "{:>6.1}   {:.5}  {:.5}   {:.5} +- {:.5}   {:>6.2} %{:<9} {:.5} ({:.5})   {:>6.0} ({:>3.0})       {:<7.4}  {:.0e}",
            energy.theta_i_deg,
            energy.albedo,
            energy.integral,
            mean.value,
            mean.standard_error,
            200.0 * turned.asymmetry,
            sigma,
            pdf.pdf_integral,
            pdf.pdf_expected,
            chi.chi_square,
            chi.degrees_of_freedom,
            chi.p_value,
            worst(|r| r.weight_error).weight_error,
        );
    }
    for finding in &found.findings {
        println!("FAULT at {:.0} deg, azimuth {:.0} deg: {}", finding.theta_i_deg, finding.phi_i_deg, finding.what);
    }
    if found.passed {
        println!("every statement holds");
    }
}
