//! `asperity lobe`: slices in the plane of incidence and lobes in the round.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::quantity;
use super::scatter_options::ScatterOptions;
use super::source::{Source, file_name};
use super::written;
use crate::chart::lobe::{Lobe, MOST, RadiusScale, lobe_page};
use crate::error::Error;
use crate::output::write_bytes;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Arguments {
    /// Height maps, tables or models such as beckmann:alpha=0.1,n=1.5
    #[arg(required = true, value_name = "SOURCE")]
    sources: Vec<String>,
    /// Picture to write (.svg or .png)
    #[arg(short, long, value_name = "FILE", value_parser = written::drawing)]
    output: PathBuf,
    /// Incident polar angles in degrees, drawn over each other [default: 20,45,70 for one source, 45 for several]
    #[arg(long, value_parser = quantity::angle, value_delimiter = ',', value_name = "LIST")]
    angles: Option<Vec<f64>>,
    /// Azimuth of the source in degrees
    #[arg(long, value_parser = quantity::angle, default_value = "0", value_name = "DEG")]
    phi: f64,
    /// Wavelengths drawn over each other [default: that of --wavelength]
    #[arg(long, value_parser = quantity::wavelength, value_delimiter = ',', value_name = "LIST")]
    wavelengths: Vec<f64>,
    /// Radius of the curves: auto takes log for glossy lobes and lobes of different height
    #[arg(long, value_enum, default_value_t = ScaleFlag::Auto)]
    scale: ScaleFlag,
    /// Decades of --scale log
    #[arg(long, default_value_t = 5.0, value_parser = decades, value_name = "N")]
    decades: f64,
    /// Largest polar angle drawn [default: 89, or 80 where a lobe grows without bound beyond]
    #[arg(long, value_parser = quantity::angle, value_name = "DEG")]
    up_to: Option<f64>,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum ScaleFlag {
    Auto,
    Linear,
    Log,
}

/// Decades that a picture can show.
fn decades(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|d| (0.5..=12.0).contains(d));
    number.ok_or_else(|| "give decades from 0.5 to 12, such as 5".to_owned())
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let angles = match &a.angles {
        Some(list) => list.clone(),
        None if a.sources.len() * a.wavelengths.len().max(1) == 1 => [20.0, 45.0, 70.0].map(f64::to_radians).to_vec(),
        None => vec![45f64.to_radians()],
    };
    if let Some(t) = angles.iter().find(|t| !(**t >= 0.0 && t.to_degrees() < 90.0)) {
        let what = format!("incident angle {} deg", t.to_degrees());
        return Err(Error::parameter(what, "give angles from 0 to below 90 deg").into());
    }
    if let Some(t) = a.up_to.filter(|t| !(*t > 0.0 && t.to_degrees() <= 89.0)) {
        let what = format!("--up-to {} deg", t.to_degrees());
        return Err(Error::parameter(what, "give an angle above 0, to 89 deg").into());
    }
    let wavelengths = if a.wavelengths.is_empty() { vec![a.scatter.wavelength()] } else { a.wavelengths.clone() };
    let count = a.sources.len() * wavelengths.len() * angles.len();
    if count > MOST {
        let what = format!("{count} lobes on one page cannot be told apart");
        return Err(Error::parameter(what, format!("give at most {MOST}: fewer sources, angles or wavelengths")).into());
    }
    let pairs: Vec<(&String, f64)> = a.sources.iter().flat_map(|s| wavelengths.iter().map(move |&l| (s, l))).collect();
    let bar = Bar::new("lobe", pairs.len());
    let mut opened = Vec::new();
    for (k, (text, wavelength)) in pairs.iter().enumerate() {
        let scatter = a.scatter.at_wavelength(*wavelength);
        opened.push(Source::open(text, &a.map, &scatter, &|share| bar.set(k, share))?);
    }
    bar.finish();
    opened.iter().for_each(Source::print_preparation);
    let mut lobes = Vec::new();
    for (source, (text, wavelength)) in opened.iter().zip(&pairs) {
        for &theta_i in &angles {
            // What all lobes share stands in the title.
            let mut parts = Vec::new();
            if a.sources.len() > 1 {
                parts.push(short_name(text));
            }
            if wavelengths.len() > 1 {
                parts.push(format!("{:.0} nm", wavelength * 1e9));
            }
            if angles.len() > 1 || parts.is_empty() {
                parts.push(format!("theta_i {:.0}\u{b0}", theta_i.to_degrees()));
            }
            lobes.push(Lobe { label: parts.join(", "), brdf: source.brdf(), theta_i, phi_i: a.phi });
        }
    }
    let scale = match a.scale {
        ScaleFlag::Auto => RadiusScale::Auto,
        ScaleFlag::Linear => RadiusScale::Linear,
        ScaleFlag::Log => RadiusScale::Logarithmic { decades: a.decades },
    };
    let drawing = lobe_page(&lobes, &title(a, &angles, &wavelengths), scale, a.up_to);
    if written::ending(&a.output) == "svg" {
        write_bytes(&a.output, drawing.to_svg().as_bytes())?;
    } else {
        drawing.to_raster().save_png(&a.output)?;
    }
    if json {
        let list: Vec<_> =
            lobes.iter().map(|l| json!({ "label": l.label, "theta_i_deg": l.theta_i.to_degrees() })).collect();
        return print_json(&json!({ "file": a.output.display().to_string(), "lobes": list }));
    }
    println!("wrote {}", a.output.display());
    Ok(())
}

fn title(a: &Arguments, angles: &[f64], wavelengths: &[f64]) -> String {
    let mut parts = Vec::new();
    if let [one] = a.sources.as_slice() {
        parts.push(short_name(one));
    } else {
        parts.push("Lobes".to_owned());
    }
    if let [theta] = angles {
        parts.push(format!("theta_i {:.0}\u{b0}", theta.to_degrees()));
    }
    if let [wavelength] = wavelengths {
        parts.push(format!("{:.0} nm", wavelength * 1e9));
    }
    parts.join(", ")
}

/// A file without its folder; the text of a model.
fn short_name(text: &str) -> String {
    if crate::model::is_model(text) { text.to_owned() } else { file_name(Path::new(text)) }
}
