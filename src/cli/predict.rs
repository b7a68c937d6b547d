//! `asperity predict`: the whole chain, for maps and folders of maps.

use super::map_options::{MapOptions, print_report};
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::file_name;
use super::tiles::{Look, caption};
use crate::chart::{GlossPoint, gloss_vs_roughness, height_preview};
use crate::error::{Error, Result};
use crate::heightmap::prepare::Report;
use crate::heightmap::read::is_candidate;
use crate::meter::Holds;
use crate::output::write_bytes;
use crate::render::{Tile, TilesOptions, render_tiles};
use crate::report::html::{Page, Section, page};
use crate::report::{Prediction, Settings, csv, predict};
use crate::scatter::Decision;
use anyhow::{Context, bail};
use clap::Args;
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub struct Arguments {
    /// Height maps, or folders of them
    #[arg(required = true, value_name = "MAP|DIR")]
    maps: Vec<PathBuf>,
    /// Folder for the results; made if absent
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
    #[command(flatten)]
    look: Look,
}

/// A map that went through, with how it was prepared and the file its table is in.
struct Done {
    map: PathBuf,
    preparation: Report,
    /// Points across and down, their distances \[m\], and a picture of the heights (.png).
    size: [usize; 2],
    pitch: [f64; 2],
    heights: Vec<u8>,
    prediction: Prediction,
    table: PathBuf,
    seconds: f64,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let settings = a.scatter.settings()?;
    // Before the long work, not after it.
    let look = a.look.options()?;
    let (paths, mut failures) = collect(&a.maps);
    if paths.is_empty() && failures.is_empty() {
        bail!(
            "no height map found in {}; put .x3p, .opd, .dat or other maps there, or name the files one by one",
            a.maps.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
        );
    }
    std::fs::create_dir_all(&a.output).with_context(|| format!("cannot make the folder {}", a.output.display()))?;
    let names = unique_stems(&paths);

    let bar = Bar::new("tables", paths.len());
    let results: Vec<(PathBuf, Result<Done>)> = paths
        .par_iter()
        .zip(&names)
        .enumerate()
        .map(|(k, (path, stem))| {
            let done = one_map(a, path, stem, &settings, &|share| bar.set(k, share));
            bar.set(k, 1.0);
            (path.clone(), done)
        })
        .collect();
    bar.finish();
    let mut done = Vec::new();
    for (path, result) in results {
        match result {
            Ok(d) => done.push(d),
            Err(e) => failures.push((path, e)),
        }
    }
    done.sort_by(|x, y| {
        x.prediction.sq.total_cmp(&y.prediction.sq).then_with(|| x.prediction.name.cmp(&y.prediction.name))
    });
    let outputs = if done.is_empty() { Vec::new() } else { summarise(a, &settings, &look, &done, &failures)? };
    if json {
        print_json(&as_json(&done, &failures, &outputs, start.elapsed().as_secs_f64()))?;
    } else {
        print_table(&done);
        for path in &outputs {
            println!("wrote {}", path.display());
        }
        if !done.is_empty() {
            println!("{} maps in {:.1} s", done.len(), start.elapsed().as_secs_f64());
        }
    }
    for d in &done {
        print_report(&d.map, &d.preparation);
    }
    print_warnings(&done);
    if done.is_empty() && failures.len() == 1 {
        // The one map there was: its own error says it all.
        let (_, error) = failures.remove(0);
        return Err(error.into());
    }
    for (_, error) in &failures {
        eprintln!("error: {error}");
    }
    if failures.is_empty() {
        return Ok(());
    }
    let list: Vec<String> = failures.iter().map(|(path, _)| file_name(path)).collect();
    bail!("{} of {} maps failed: {}", failures.len(), failures.len() + done.len(), list.join(", "))
}

fn one_map(
    a: &Arguments,
    path: &Path,
    stem: &str,
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Done> {
    let start = Instant::now();
    let prepared = a.map.load(path)?;
    let prediction = predict(&prepared.map, &file_name(path), settings, progress).map_err(|e| match e {
        Error::Parameter { what, advice } => Error::content(path, what, advice),
        other => other,
    })?;
    let table = a.output.join(format!("{stem}.npz"));
    prediction.brdf.table().save(&table)?;
    let map = &prepared.map;
    let heights = height_preview(map, PREVIEW).png_bytes().map_err(|e| Error::io(path, "draw", e))?;
    Ok(Done {
        map: path.to_owned(),
        size: [map.width(), map.height()],
        pitch: [map.pitch_x, map.pitch_y],
        heights,
        preparation: prepared.report,
        prediction,
        table,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// CSV, chart, tiles and report over all maps that went through.
fn summarise(
    a: &Arguments,
    settings: &Settings,
    look: &TilesOptions,
    done: &[Done],
    failures: &[(PathBuf, Error)],
) -> anyhow::Result<Vec<PathBuf>> {
    let mut outputs: Vec<PathBuf> = done.iter().map(|d| d.table.clone()).collect();
    let csv_path = a.output.join("gloss.csv");
    write_bytes(&csv_path, csv::gloss_csv(done.iter().map(|d| &d.prediction)).as_bytes())?;
    outputs.push(csv_path);

    let points: Vec<GlossPoint> = done
        .iter()
        .map(|d| {
            let p = &d.prediction;
            let ray_gloss = p.ray_gloss.map(|g| g.map(|g| g.value));
            GlossPoint { name: p.name.clone(), sq: p.sq, gloss: p.gloss, holds: p.holds(), ray_gloss }
        })
        .collect();
    let chart_path = a.output.join("gloss_vs_roughness.svg");
    let svg = gloss_vs_roughness(&points, "Predicted gloss against surface roughness");
    write_bytes(&chart_path, svg.as_bytes())?;
    outputs.push(chart_path);

    let tiles: Vec<Tile> = done
        .iter()
        .map(|d| Tile {
            caption: caption(&d.prediction.name, Some(d.prediction.sq), d.prediction.gloss),
            brdf: &d.prediction.brdf,
        })
        .collect();
    let bar = Bar::new("tiles", 1);
    let picture = render_tiles(&tiles, look, &|share| bar.set(0, share))?;
    bar.finish();
    for name in ["tiles.png", "tiles.exr"] {
        let path = a.output.join(name);
        picture.save(&path)?;
        outputs.push(path);
    }
    let report = a.output.join("report.html");
    write_bytes(&report, report_page(settings, done, failures, &svg, &picture.picture().png_bytes()?).as_bytes())?;
    outputs.push(report);
    Ok(outputs)
}

/// Width of the picture of the heights in the report \[pixels\].
const PREVIEW: usize = 560;

/// Everything on one page.
fn report_page(settings: &Settings, done: &[Done], failures: &[(PathBuf, Error)], chart: &str, tiles: &[u8]) -> String {
    fn section(d: &Done) -> Section<'_> {
        Section {
            prediction: &d.prediction,
            size: d.size,
            pitch: d.pitch,
            preparation: d.preparation.to_string(),
            doubts: d.preparation.warnings.iter().map(ToString::to_string).collect(),
            table: file_name(&d.table),
            heights: d.heights.clone(),
        }
    }
    let sections = done.iter().map(section).collect();
    let failed = failures.iter().map(|(path, e)| (file_name(path), e.to_string())).collect();
    page(&Page { sections, settings, chart, tiles, failed })
}

/// The files to read: those named, and from a folder those that are or claim to be height maps, by name.
fn collect(arguments: &[PathBuf]) -> (Vec<PathBuf>, Vec<(PathBuf, Error)>) {
    let (mut paths, mut failures) = (Vec::new(), Vec::new());
    for argument in arguments {
        if !argument.is_dir() {
            paths.push(argument.clone());
            continue;
        }
        match std::fs::read_dir(argument) {
            Ok(entries) => {
                let mut found: Vec<PathBuf> =
                    entries.flatten().map(|e| e.path()).filter(|p| p.is_file() && is_candidate(p)).collect();
                found.sort();
                paths.extend(found);
            }
            Err(e) => failures.push((argument.clone(), Error::io(argument, "list", e))),
        }
    }
    (paths, failures)
}

/// File stems, with a number appended where two maps share one.
fn unique_stems(paths: &[PathBuf]) -> Vec<String> {
    let mut used = BTreeSet::new();
    paths
        .iter()
        .map(|path| {
            let stem = path.file_stem().map_or_else(|| "map".to_owned(), |s| s.to_string_lossy().into_owned());
            let mut name = stem.clone();
            let mut k = 2;
            while !used.insert(name.clone()) {
                name = format!("{stem}-{k}");
                k += 1;
            }
            name
        })
        .collect()
}

fn print_table(done: &[Done]) {
    if done.is_empty() {
        return;
    }
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::UTF8_BORDERS_ONLY);
    table.set_header([
        "map",
        "Sq nm",
        "Sdq",
        "missing %",
        "gloss 20 deg",
        "gloss 60 deg",
        "gloss 85 deg",
        "scattered by",
    ]);
    for d in done {
        let p = &d.prediction;
        let holds = p.holds();
        let gloss = |k: usize| {
            let g = p.gloss[k];
            format!("{:.2} +- {:.2}{}", g.value, g.standard_error, holds[k].mark())
        };
        table.add_row([
            p.name.clone(),
            format!("{:.2}", p.sq * 1e9),
            format!("{:.4}", p.sdq),
            format!("{:.3}", 100.0 * p.missing_fraction),
            gloss(0),
            gloss(1),
            gloss(2),
            p.method_summary(),
        ]);
    }
    for column in 1..7 {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(comfy_table::CellAlignment::Right);
        }
    }
    println!("{table}");
    println!("Gloss in GU (black glass n = 1.567 reads 100) +- one standard error of map and integration.");
    super::gloss::print_marks(done.iter().map(|d| &d.prediction));
}

/// One paragraph for all maps: the sentence of each value is in `--json`.
fn print_warnings(done: &[Done]) {
    let doubtful: Vec<&Prediction> = done.iter().map(|d| &d.prediction).filter(|p| !p.warnings.is_empty()).collect();
    if doubtful.is_empty() {
        return;
    }
    let width = doubtful.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
    eprintln!(
        "warning: rays do not hold where the Rayleigh parameter g = (4 pi Sq cos(theta) / wavelength)^2 is below 9: a share\n\
         exp(-g) of the light stays a mirror beam that rays turn into blur. There the value is that of the wave calculation\n\
         (marked ~); a value marked * stands on a calculation that does not hold:"
    );
    for p in doubtful {
        let parts: Vec<String> = ["20", "60", "85"]
            .iter()
            .enumerate()
            .filter(|&(k, _)| p.holds()[k] != Holds::Rays)
            .map(|(k, angle)| {
                let (g, value) = (p.rayleigh[k], p.gloss[k].value);
                match p.ray_gloss.filter(|_| p.wave[k]) {
                    Some(rays) => format!("{angle} deg: g {g:.2}, waves {value:.1}, rays {:.1} GU", rays[k].value),
                    None => format!("{angle} deg: g {g:.2}"),
                }
            })
            .collect();
        eprintln!("  {:<width$}  {}", p.name, parts.join("; "));
        for doubt in p.warnings.iter().filter(|w| w.is_doubt()) {
            eprintln!("  {:<width$}  {doubt}", "");
        }
    }
}

/// Why each incident angle was served as it was.
fn reasons(p: &Prediction) -> Vec<serde_json::Value> {
    let reason = |d: &Decision| json!({ "theta_i_deg": d.theta_i.to_degrees(), "reason": d.to_string() });
    p.decisions.iter().map(reason).collect()
}

fn as_json(done: &[Done], failures: &[(PathBuf, Error)], outputs: &[PathBuf], seconds: f64) -> serde_json::Value {
    let maps: Vec<_> = done
        .iter()
        .map(|d| {
            let p = &d.prediction;
            json!({
                "map": p.name, "Sq_m": p.sq, "Sdq": p.sdq, "missing_fraction": p.missing_fraction,
                "isotropic": p.isotropic, "method": p.method_summary(), "table": d.table.display().to_string(),
                "gloss": super::gloss::gloss_json(p.gloss, Some(p)), "seconds": d.seconds,
                "preparation": d.preparation, "reasons": reasons(p),
                "warnings": p.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "maps": maps,
        "failed": failures.iter().map(|(p, e)| json!({ "file": p.display().to_string(), "error": e.to_string() })).collect::<Vec<_>>(),
        "outputs": outputs.iter().map(|p| p.display().to_string()).collect::<Vec<_>>(),
        "seconds": seconds,
    })
}
