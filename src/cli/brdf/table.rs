//! The table over all incident directions.

use super::super::progress::Bar;
use super::super::source::file_name;
use super::{Answer, Arguments};
use crate::heightmap::HeightMap;
use crate::report::{Prediction, Settings, predict_run};
use crate::scatter::{self, Run};
use crate::table::Node;
use serde_json::json;
use std::fmt::Write;

pub(super) fn run(a: &Arguments, settings: &Settings, map: &HeightMap) -> anyhow::Result<Answer> {
    let mut run = a.parts.run(map, &settings.scatter, "table")?;
    let bar = Bar::new("scatter", 1);
    let progress = |share| bar.set(0, share);
    if !run.is_whole() {
        scatter::scatter_run(map, &settings.scatter, &mut run, &progress)?;
    }
    if let Run::Part(sums) = &run {
        bar.finish();
        sums.save(&a.output)?;
        return Ok(Answer::of_part(sums));
    }
    let prediction = predict_run(map, &file_name(&a.map_file), settings, &mut run, &progress)?;
    bar.finish();
    prediction.brdf.table().save(&a.output)?;
    let unused = a.scatter.unused_azimuths(prediction.isotropic);
    let warnings: Vec<String> = unused.into_iter().chain(prediction.warnings.iter().map(ToString::to_string)).collect();
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    Ok(describe(&prediction, &warnings))
}

fn describe(prediction: &Prediction, warnings: &[String]) -> Answer {
    let table = prediction.brdf.table();
    let degrees: Vec<f64> = table.theta_i().iter().map(|&t| super::degrees(t)).collect();
    // Over the azimuths of an anisotropic table the mean is reported.
    let mean = |field: fn(&Node) -> f64| -> Vec<f64> {
        let phis = table.phi_i().len();
        (0..degrees.len()).map(|t| (0..phis).map(|p| field(&table.node(t, p))).sum::<f64>() / phis as f64).collect()
    };
    let (albedo, albedo_se) = (mean(|n| n.albedo), mean(|n| n.albedo_error));
    let (multiple, lost) = (mean(|n| n.multiple), mean(|n| n.lost));
    let mut text = format!(
        "{}: Sq {:.2} nm, Sdq {:.4}, {} facets, missing {:.3} %, {}\n\
         theta_i  albedo            multiple   lost       hidden (predicted)  visibility\n",
        prediction.name,
        prediction.sq * 1e9,
        prediction.sdq,
        prediction.facets,
        100.0 * prediction.missing_fraction,
        if prediction.isotropic { "isotropic" } else { "anisotropic" },
    );
    for (t, d) in prediction.decisions.iter().enumerate() {
        let _ = writeln!(
            text,
            "{:>6.1}   {:.5} +- {:.5}  {:.6}   {:.6}   {:.6}            {}",
            degrees[t],
            albedo[t],
            albedo_se[t],
            multiple[t],
            lost[t],
            d.predicted_blocked,
            match (d.wave, d.visibility) {
                (true, _) => "waves, Smith",
                (false, true) => "traced",
                (false, false) => "Smith",
            },
        );
    }
    for (degrees, d) in degrees.iter().zip(&prediction.decisions) {
        let _ = writeln!(text, "{degrees:>6.1}   {d}");
    }
    let azimuths = table.phi_i().len();
    let _ = match azimuths {
        1 => writeln!(text, "{} cells per direction", table.cells().len()),
        _ => writeln!(text, "{} cells per direction, {azimuths} source azimuths", table.cells().len()),
    };
    let json = json!({
        "method": prediction.method_summary(), "isotropic": prediction.isotropic, "cells": table.cells().len(),
        "facets": prediction.facets,
        "phi_i_deg": table.phi_i().iter().map(|&p| super::degrees(p)).collect::<Vec<_>>(),
        "theta_i_deg": degrees, "albedo": albedo, "albedo_se": albedo_se,
        "multiple_bounce_fraction": multiple, "lost_fraction": lost,
        "bounce_fractions": prediction.bounce_fractions,
        "shadowed_fraction": mean(|n| n.shadowed),
        "predicted_blocked_fraction": prediction.decisions.iter().map(|d| d.predicted_blocked).collect::<Vec<_>>(),
        "waves": prediction.decisions.iter().map(|d| d.wave).collect::<Vec<_>>(),
        "reasons": prediction.decisions.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "visibility": prediction.decisions.iter().map(|d| d.visibility).collect::<Vec<_>>(),
        "warnings": warnings,
    });
    Answer { json, text }
}
