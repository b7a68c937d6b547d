//! `asperity brdf`: one map to one table.

use super::map_options::{MapOptions, print_report};
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::file_name;
use crate::report::predict;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct Arguments {
    /// Height map
    map_file: PathBuf,
    /// Table to write (.npz)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let settings = a.scatter.settings()?;
    let prepared = a.map.load(&a.map_file)?;
    print_report(&a.map_file, &prepared.report);
    let bar = Bar::new("scatter", 1);
    let prediction = predict(&prepared.map, &file_name(&a.map_file), &settings, &|share| bar.set(0, share))?;
    bar.finish();
    let table = prediction.brdf.table();
    table.save(&a.output)?;
    let degrees: Vec<f64> = table.theta_i().iter().map(|t| t.to_degrees()).collect();
    // Over the azimuths of an anisotropic table the mean is reported.
    let mean = |field: fn(&crate::table::Node) -> f64| -> Vec<f64> {
        let phis = table.phi_i().len();
        (0..degrees.len()).map(|t| (0..phis).map(|p| field(&table.node(t, p))).sum::<f64>() / phis as f64).collect()
    };
    let (albedo, albedo_se) = (mean(|n| n.albedo), mean(|n| n.albedo_error));
    let (multiple, lost) = (mean(|n| n.multiple), mean(|n| n.lost));
    for warning in &prediction.warnings {
        eprintln!("warning: {warning}");
    }
    if json {
        return print_json(&json!({
            "file": a.output.display().to_string(), "method": prediction.method_summary(),
            "seconds": start.elapsed().as_secs_f64(), "isotropic": prediction.isotropic, "cells": table.cells().len(),
            "theta_i_deg": degrees, "albedo": albedo, "albedo_se": albedo_se,
            "multiple_bounce_fraction": multiple, "lost_fraction": lost,
            "shadowed_fraction": mean(|n| n.shadowed),
            "predicted_blocked_fraction": prediction.decisions.iter().map(|d| d.predicted_blocked).collect::<Vec<_>>(),
            "preparation": prepared.report,
            "reasons": prediction.decisions.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "waves": prediction.decisions.iter().map(|d| d.wave).collect::<Vec<_>>(),
            "visibility": prediction.decisions.iter().map(|d| d.visibility).collect::<Vec<_>>(),
        }));
    }
    println!(
        "{}: Sq {:.2} nm, Sdq {:.4}, missing {:.3} %, {}",
        prediction.name,
        prediction.sq * 1e9,
        prediction.sdq,
        100.0 * prediction.missing_fraction,
        if prediction.isotropic { "isotropic" } else { "anisotropic" },
    );
    println!("theta_i  albedo            multiple   lost       hidden (predicted)  visibility");
    for (t, d) in prediction.decisions.iter().enumerate() {
        println!(
            "{:>6.1}   {:.5} +- {:.5}  {:.6}   {:.6}   {:.6}            {}",
            degrees[t],
            albedo[t],
            albedo_se[t],
            multiple[t],
            lost[t],
            d.predicted_blocked,
            if d.wave {
                "Smith (waves)"
            } else if d.visibility {
                "traced"
            } else {
                "Smith"
            },
        );
    }
    println!(
        "wrote {} ({} cells per direction) in {:.2} s",
        a.output.display(),
        table.cells().len(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
