//! `asperity scan`: a goniometer in the plane of incidence.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::quantity;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use super::written;
use crate::chart::scan_chart;
use crate::meter::scan::angles;
use crate::meter::{Options, Scan, ScanPoint, scan};
use crate::output::write_bytes;
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// Height maps, tables or models such as ggx:alpha=0.1,n=1.5
    #[arg(required = true, value_name = "SOURCE")]
    sources: Vec<String>,
    /// First detector angle in degrees, negative on the side of the source
    #[arg(long, value_parser = quantity::angle, default_value = "-89", value_name = "DEG", allow_hyphen_values = true)]
    from: f64,
    /// Last detector angle in degrees
    #[arg(long, value_parser = quantity::angle, default_value = "89", value_name = "DEG", allow_hyphen_values = true)]
    to: f64,
    /// Step of the detector angle in degrees
    #[arg(long, value_parser = quantity::angle, default_value = "0.5", value_name = "DEG")]
    step: f64,
    /// Half angle that the detector subtends in degrees
    #[arg(long, value_parser = quantity::angle, default_value = "0.5", value_name = "DEG")]
    half_angle: f64,
    /// Half angle of the beam's divergence in degrees
    #[arg(long, value_parser = quantity::angle, default_value = "0.1", value_name = "DEG")]
    divergence: f64,
    /// Write the scan as CSV; it goes to stdout if neither this nor --json is given
    #[arg(short, long, value_name = "FILE.csv", value_parser = written::csv)]
    output: Option<PathBuf>,
    /// Draw the scan
    #[arg(long, value_name = "FILE.png", value_parser = written::png)]
    chart: Option<PathBuf>,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

/// Error of a point relative to the highest, and the most points spent on it.
const TOLERANCE: f64 = 2e-4;
const MOST_POINTS: u32 = 2048;

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let directions = a.scatter.directions()?;
    let theta_r = angles(a.from, a.to, a.step, a.half_angle)?;
    let bar = Bar::new("scan", a.sources.len());
    let mut found = Vec::new();
    for (k, text) in a.sources.iter().enumerate() {
        let source = Source::open(text, &a.map, &a.scatter, &|share| bar.set(k, share))?;
        for (theta_i, phi_i) in &directions {
            let gonio = Scan {
                theta_i: *theta_i,
                phi_i: *phi_i,
                source_half_angle: a.divergence,
                half_angle: a.half_angle,
                theta_r: theta_r.clone(),
            };
            let options = Options { tolerance: TOLERANCE, max_points: MOST_POINTS, ..Options::default() };
            found.push((source.name().to_owned(), gonio.clone(), scan(source.brdf(), &gonio, &options)?));
        }
        if !source.isotropic() && directions.iter().all(|d| d.1 == 0.0) {
            eprintln!("note: {} has a direction; this scan is at source azimuth 0, see --phi-i", source.name());
        }
    }
    bar.finish();
    let csv = as_csv(&found);
    if let Some(path) = &a.output {
        write_bytes(path, csv.as_bytes())?;
    }
    if let Some(path) = &a.chart {
        draw(&found).save_png(path)?;
    }
    if json {
        return print_json(&as_json(&found));
    }
    match (&a.output, &a.chart) {
        (None, None) => print!("{csv}"),
        (output, chart) => {
            output.iter().chain(chart).for_each(|path| println!("wrote {}", path.display()));
        }
    }
    Ok(())
}

type Found = [(String, Scan, Vec<ScanPoint>)];

fn as_csv(found: &Found) -> String {
    let mut csv =
        String::from("source,theta_i_deg,phi_i_deg,theta_r_deg,f_r_per_sr,standard_error_per_sr,ccbrdf_per_sr\n");
    for (name, scan, points) in found {
        let name = if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.clone() };
        for p in points {
            // Writing to a string cannot fail.
            let _ = writeln!(
                csv,
                "{name},{},{},{:.6},{:.6e},{:.2e},{:.6e}",
                short(scan.theta_i),
                short(scan.phi_i),
                short(p.theta_r),
                p.f_r.value,
                p.f_r.standard_error,
                p.f_r.value * p.theta_r.cos(),
            );
        }
    }
    csv
}

fn short(angle: f64) -> f64 {
    (angle.to_degrees() * 1e6).round() / 1e6
}

fn as_json(found: &Found) -> serde_json::Value {
    let list: Vec<_> = found
        .iter()
        .map(|(name, scan, points)| {
            let column = |of: fn(&ScanPoint) -> f64| points.iter().map(of).collect::<Vec<_>>();
            json!({
                "source": name, "theta_i_deg": short(scan.theta_i), "phi_i_deg": short(scan.phi_i),
                "half_angle_deg": short(scan.half_angle), "divergence_half_angle_deg": short(scan.source_half_angle),
                "theta_r_deg": column(|p| short(p.theta_r)), "f_r_per_sr": column(|p| p.f_r.value),
                "standard_error": column(|p| p.f_r.standard_error),
            })
        })
        .collect();
    json!({ "scans": list })
}

fn draw(found: &Found) -> crate::chart::Raster {
    let several = found.windows(2).any(|w| w[0].1.theta_i != w[1].1.theta_i || w[0].1.phi_i != w[1].1.phi_i);
    let curves: Vec<_> = found
        .iter()
        .map(|(name, scan, points)| {
            let label = if several { format!("{name} at {}\u{b0}", short(scan.theta_i)) } else { name.clone() };
            (label, points.iter().map(|p| (p.theta_r.to_degrees(), p.f_r.value)).collect())
        })
        .collect();
    let first = &found[0].1;
    let title =
        format!("Light from {}\u{b0}, detector of {}\u{b0} half angle", short(first.theta_i), short(first.half_angle));
    scan_chart(&title, first.theta_i.to_degrees(), &curves)
}
