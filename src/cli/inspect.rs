//! `asperity inspect`: what a map is and whether it can be trusted, before light falls on it.

use super::map_options::{MapOptions, print_report};
use super::source::file_name;
use super::{print_json, quantity};
use crate::chart::{PageNotes, facts, inspection_page};
use crate::heightmap::{HeightMap, Survey};
use crate::meter::{Geometry, check_rays, rayleigh_parameter};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Characters of a note that the screen and the page show.
const LONGEST_NOTE: usize = 40;

/// Characters of format and notes on the screen.
const LONGEST_ORIGIN: usize = 98;

#[derive(Args)]
pub struct Arguments {
    /// Height map
    #[arg(value_name = "MAP")]
    input: PathBuf,
    /// Page to write (.png): heights, slope distribution, spectrum, autocorrelation, numbers
    #[arg(short, long, value_name = "FILE.png", value_parser = super::written::png)]
    output: Option<PathBuf>,
    /// Wavelength at which rays are judged
    #[arg(long, value_parser = quantity::wavelength, default_value = "550nm")]
    wavelength: f64,
    #[command(flatten)]
    map: MapOptions,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let prepared = a.map.load(&a.input)?;
    print_report(&a.input, &prepared.report);
    let map = prepared.map;
    let survey = Survey::of(&map);
    let name = file_name(&a.input);
    let rays: Vec<String> = Geometry::standard_three()
        .iter()
        .filter_map(|geometry| check_rays(survey.heights.sq, geometry, a.wavelength))
        .map(|w| w.to_string())
        .collect();
    if let Some(output) = &a.output {
        let warnings = prepared.report.warnings.iter().map(ToString::to_string).collect();
        let subtitle = format!("{}\n{}", origin(prepared.format, &prepared.notes), prepared.report);
        let band = prepared.report.band_m;
        let notes = PageNotes { title: name.clone(), subtitle, band, wavelength: a.wavelength, warnings };
        inspection_page(&map, &survey, &notes).save_png(output)?;
    }
    if json {
        for warning in survey.warnings.iter().map(ToString::to_string).chain(rays) {
            eprintln!("warning: {name}: {warning}");
        }
        let mut found = object(a, &map, &survey);
        found["preparation"] = json!(prepared.report);
        found["format"] = json!(prepared.format);
        found["notes"] = prepared.notes.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
        return print_json(&found);
    }
    println!("{name}");
    println!("  {:<12} {}", "read as", shortened(&origin(prepared.format, &prepared.notes), LONGEST_ORIGIN));
    screen(&map, &survey, prepared.report.band_m, a.wavelength);
    if let Some(output) = &a.output {
        println!("\npage: {}", output.display());
    }
    // On the screen the lines on rays already say what their warnings would.
    for warning in &survey.warnings {
        eprintln!("warning: {name}: {warning}");
    }
    Ok(())
}

/// Format and what the file says of itself, in one line.
fn origin(format: &str, notes: &[(String, String)]) -> String {
    let mut line = format.to_owned();
    for (key, value) in notes {
        // Remarks may have lines of their own; what is unknown has a placeholder, as in our own files.
        let value = value.split_whitespace().collect::<Vec<_>>().join(" ");
        if !(value.is_empty() || ["not available", "n/a", "1970-01-01T00:00:00Z"].contains(&value.as_str())) {
            line += &format!(", {key} {}", shortened(&value, LONGEST_NOTE));
        }
    }
    line
}

/// At most `most` characters, the cut marked by dots.
fn shortened(text: &str, most: usize) -> String {
    let mut short: String = text.chars().take(most).collect();
    if short.len() < text.len() {
        short += "..";
    }
    short
}

fn screen(map: &HeightMap, survey: &Survey, band: [f64; 2], wavelength: f64) {
    for (label, value) in facts::of_grid(map, survey, band) {
        println!("  {label:<12} {value}");
    }
    println!();
    let (left, right) = (facts::of_heights(survey), facts::of_texture(survey));
    for (l, r) in left.iter().zip(&right) {
        println!("  {:<5} {:<16} {:<12} {}", l.0, l.1, r.0, r.1);
    }
    println!();
    println!("  slope x      {}", facts::of_scales(&survey.sampling.along_x, 4));
    println!("  slope y      {}", facts::of_scales(&survey.sampling.along_y, 4));
    println!();
    for (label, value) in facts::of_rays(survey.heights.sq, wavelength) {
        println!("  {label:<15} {value} (wavelength {:.0} nm)", wavelength * 1e9);
    }
}

/// Field names are a contract: others may come, none may go.
fn object(a: &Arguments, map: &HeightMap, survey: &Survey) -> serde_json::Value {
    let (h, g, t) = (&survey.heights, &survey.gradient, &survey.texture);
    let scales = |list: &[crate::heightmap::sampling::SlopeScale]| -> Vec<_> {
        list.iter().map(|s| json!({ "distance_m": s.distance, "slope_rms": s.rms, "pairs": s.pairs })).collect()
    };
    let rays: serde_json::Map<_, _> = ["20", "60", "85"]
        .into_iter()
        .zip(&Geometry::standard_three())
        .map(|(angle, geometry)| {
            let g = rayleigh_parameter(h.sq, geometry.theta_i, a.wavelength);
            let valid = check_rays(h.sq, geometry, a.wavelength).is_none();
            (angle.to_owned(), json!({ "rayleigh_g": g, "ray_valid": valid }))
        })
        .collect();
    json!({
        "file": a.input.display().to_string(),
        "width": map.width(), "height": map.height(),
        "pitch_x_m": map.pitch_x, "pitch_y_m": map.pitch_y,
        "missing_fraction": survey.missing_fraction,
        "removed_slope_x": map.removed_slopes[0], "removed_slope_y": map.removed_slopes[1],
        "Sa_m": h.sa, "Sq_m": h.sq, "Ssk": h.ssk, "Sku": h.sku, "Sp_m": h.sp, "Sv_m": h.sv, "Sz_m": h.sz(),
        "Sdq": g.sdq, "Sdr": g.sdr, "slope_rms_x": g.rms[0], "slope_rms_y": g.rms[1],
        "Sal_m": t.sal, "Str": t.str, "Str_is_upper_bound": t.str_is_upper_bound,
        "Std_deg": t.std.map(f64::to_degrees),
        "bandwidth_per_m": survey.spectrum.bandwidth,
        "slopes_x": scales(&survey.sampling.along_x), "slopes_y": scales(&survey.sampling.along_y),
        "wavelength_m": a.wavelength, "rays": rays,
        "warnings": survey.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
