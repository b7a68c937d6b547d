//! `asperity bench`: time against error of every method, what auto chooses, how cost grows, the budgets.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::source::file_name;
use crate::bench::surface::{Surface, budget_map, gaussian};
use crate::bench::{self, Machine, Plan, budgets, choice, families, scaling};
use crate::chart::Drawing;
use crate::heightmap::HeightMap;
use crate::output::write_bytes;
use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

#[derive(Args)]
pub struct Arguments {
    /// Height map to scatter off, or with --choice several [default: a synthetic map; with --choice the bundled series]
    #[arg(value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// Time for all methods together, such as 60s or 5min [default: 60s; for --scaling 4min]
    #[arg(long, value_parser = duration, value_name = "TIME")]
    budget: Option<Duration>,
    /// Folder for the results; made if absent
    #[arg(short, long, value_name = "DIR", default_value = "bench")]
    output: PathBuf,
    /// Show what auto takes at several tolerances, and what costlier methods would have changed
    #[arg(long, conflicts_with_all = ["scaling", "budgets"])]
    choice: bool,
    /// Tolerances of --choice [default: 5%,1%,0.1%]
    #[arg(long, value_delimiter = ',', value_parser = super::quantity::tolerance, requires = "choice", value_name = "LIST")]
    tolerance: Vec<f64>,
    /// Measure cost against map size, rays, incident angles and threads
    #[arg(long, conflicts_with = "budgets")]
    scaling: bool,
    /// Largest map of --scaling, points per side
    #[arg(long, default_value_t = 8192, value_name = "POINTS")]
    largest: usize,
    /// Measure every budget of the design on one thread
    #[arg(long)]
    budgets: bool,
    /// Runs per effort
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..1000))]
    repeats: u32,
    /// Same seed, same errors
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    map: MapOptions,
    /// One size of --scaling, in a process of its own so that its memory is its own
    #[arg(long, hide = true)]
    one_size: Option<usize>,
}

/// `60s`, `2min` or a plain number of seconds.
fn duration(text: &str) -> Result<Duration, String> {
    let (number, scale) = match text.trim() {
        t if t.ends_with("min") => (&t[..t.len() - 3], 60.0),
        t if t.ends_with('s') => (&t[..t.len() - 1], 1.0),
        t => (t, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(v) if v > 0.0 && v * scale < 1e6 => Ok(Duration::from_secs_f64(v * scale)),
        _ => Err(format!("`{text}` is no time; write 60s or 5min")),
    }
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    if let Some(side) = a.one_size {
        return print_json(&json!(scaling::one_size(side)?));
    }
    if a.maps.len() > 1 && !a.choice {
        bail!("one map is measured at a time; --choice takes several");
    }
    if (a.scaling || a.budgets) && !a.maps.is_empty() {
        bail!("--scaling and --budgets measure a map of their own; leave the MAP out");
    }
    std::fs::create_dir_all(&a.output).with_context(|| format!("cannot make the folder {}", a.output.display()))?;
    let machine = Machine::here(a.seed);
    if a.choice {
        chosen(a, &machine, json)
    } else if a.scaling {
        scaled(a, &machine, json)
    } else if a.budgets {
        budgeted(a, &machine, json)
    } else {
        evidence(a, &machine, json)
    }
}

/// Writes a drawing as .svg and .png.
fn save(drawing: &Drawing, folder: &Path, stem: &str, outputs: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    let svg = folder.join(format!("{stem}.svg"));
    write_bytes(&svg, drawing.to_svg().as_bytes())?;
    let png = folder.join(format!("{stem}.png"));
    drawing.to_raster().save_png(&png)?;
    outputs.extend([svg, png]);
    Ok(())
}

fn save_text(text: &str, folder: &Path, name: &str, outputs: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    let path = folder.join(name);
    write_bytes(&path, text.as_bytes())?;
    outputs.push(path);
    Ok(())
}

fn say_wrote(outputs: &[PathBuf]) {
    outputs.iter().for_each(|path| println!("wrote {}", path.display()));
}

fn evidence(a: &Arguments, machine: &Machine, json: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let (map, name) = match a.maps.first() {
        Some(path) => (a.map.load(path)?.map, file_name(path)),
        None => (budget_map(1024)?, "synthetic Gaussian map".to_owned()),
    };
    let surface = Surface::new(&map, &name)?;
    let about = surface.describe();
    let bar = Bar::new("references", 1);
    // The reference of scattering grows with the budget, whatever the machine: the same budget, the same errors.
    let budget = a.budget.unwrap_or(Duration::from_secs(60));
    let rays = (budget.as_secs_f64() * 2.5e5).clamp(1e5, 1e8) as u64;
    let material = families::Material::new(surface, rays)?;
    let families = families::all(&material, &|share| bar.set(0, share))?;
    bar.finish();
    let bar = Bar::new("methods", 1);
    let plan = Plan {
        budget: budget.saturating_sub(start.elapsed()).max(budget / 4),
        repeats: a.repeats as usize,
        seed: a.seed,
    };
    let rungs = bench::run(&families, &plan, &|share| bar.set(0, share));
    bar.finish();
    let mut outputs = Vec::new();
    save_text(&bench::rungs_csv(&rungs, machine), &a.output, "bench.csv", &mut outputs)?;
    let references: Vec<_> = families
        .iter()
        .map(|f| json!({ "family": f.id, "reference": f.reference.text, "reference_error": f.reference.noise }))
        .collect();
    let equal_time: Vec<_> = families.iter().filter_map(|f| bench::equal_time(f, &rungs)).collect();
    let whole = json!({
        "machine": machine, "surface": about, "references": references, "equal_time": equal_time, "rungs": rungs
    });
    save_text(&serde_json::to_string_pretty(&whole)?, &a.output, "bench.json", &mut outputs)?;
    save(&bench::accuracy_chart(&families, &rungs, &about, machine), &a.output, "accuracy_vs_time", &mut outputs)?;
    save(&bench::counts_chart(&families, &rungs, &about, machine), &a.output, "scatter_counts", &mut outputs)?;
    if json {
        return print_json(&whole);
    }
    println!("{about}\n{machine}");
    let mut table = table(["family", "method", "effort", "time", "error", ""]);
    for r in best(&rungs) {
        let mark = if r.default { "default" } else { "" };
        table.add_row([
            r.family.clone(),
            r.method.clone(),
            format!("{} {}", short(r.effort), r.effort_of),
            seconds(r.seconds[1]),
            format!("{} +- {:.1e} {}", short(r.error), r.error_se, r.unit),
            mark.to_owned(),
        ]);
    }
    println!("{table}\nThe costliest rung of each method that fitted in, and the defaults; all rungs in the CSV.");
    for found in &equal_time {
        println!("{}: {found}", found.family);
    }
    say_wrote(&outputs);
    println!("{:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// The last rung of every method and the default ones.
fn best(rungs: &[bench::Rung]) -> impl Iterator<Item = &bench::Rung> {
    rungs.iter().enumerate().filter_map(|(k, r)| {
        let last = rungs.get(k + 1).is_none_or(|next| (&next.family, &next.method) != (&r.family, &r.method));
        (last || r.default).then_some(r)
    })
}

fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        format!("{value:.1e}")
    } else if value.fract() == 0.0 {
        format!("{value}")
    } else {
        format!("{value:.3}")
    }
}

fn seconds(value: f64) -> String {
    match value {
        v if v < 1e-6 => format!("{:.0} ns", v * 1e9),
        v if v < 1e-3 => format!("{:.1} us", v * 1e6),
        v if v < 1.0 => format!("{:.2} ms", v * 1e3),
        v => format!("{v:.2} s"),
    }
}

fn table<const N: usize>(head: [&str; N]) -> comfy_table::Table {
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::UTF8_BORDERS_ONLY);
    table.set_header(head);
    table
}

/// The bundled series of heightmaps/, made again so that no file is needed.
fn bundled() -> anyhow::Result<Vec<(String, HeightMap)>> {
    let series = [3u32, 50, 100, 150, 201, 402, 805];
    let make = |(k, sq): (usize, u32)| {
        let map = gaussian(1024, 0.6e-6, f64::from(sq) * 1e-9, 20e-6, k as u64 + 1)?;
        Ok((format!("epoxy-{sq:03}nm"), map))
    };
    series.into_iter().enumerate().map(make).collect()
}

fn chosen(a: &Arguments, machine: &Machine, json: bool) -> anyhow::Result<()> {
    let maps = if a.maps.is_empty() {
        bundled()?
    } else {
        let load = |path: &PathBuf| Ok((file_name(path), a.map.load(path)?.map));
        a.maps.iter().map(load).collect::<crate::error::Result<_>>()?
    };
    let tolerances = if a.tolerance.is_empty() { &choice::TOLERANCES[..] } else { &a.tolerance };
    let bar = Bar::new("choice", maps.len());
    let mut rows = Vec::new();
    for (k, (name, map)) in maps.iter().enumerate() {
        rows.extend(choice::choose(map, name, tolerances)?);
        bar.set(k, 1.0);
    }
    bar.finish();
    let mut outputs = Vec::new();
    save_text(&choice::csv(&rows, machine), &a.output, "choice.csv", &mut outputs)?;
    if json {
        return print_json(&json!({ "machine": machine, "rows": rows }));
    }
    println!("{machine}");
    let mut shown = table([
        "map",
        "tolerance",
        "theta_i",
        "g",
        "auto takes",
        "time",
        "next costlier",
        "moves",
        "off facets",
        "off count",
        "map",
        "off waves",
        "",
    ]);
    let percent = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{:.3} %", 100.0 * v));
    for r in &rows {
        shown.add_row([
            r.map.clone(),
            format!("{} %", short(100.0 * r.tolerance)),
            format!("{:.0} deg", r.theta_i_deg),
            short(r.rayleigh_g),
            r.taken.clone(),
            seconds(r.seconds),
            r.next.clone().unwrap_or_else(|| "none".to_owned()),
            percent(r.next_moves),
            percent(r.from_facets),
            percent(r.from_count),
            percent(Some(r.map_error)),
            match r.waves_agree {
                None => percent(r.from_waves),
                Some(_) => format!("{} ± {:.3}", percent(r.from_waves), 100.0 * r.map_error.hypot(r.waves_error)),
            },
            match (r.within, r.resolved, r.waves_agree) {
                (false, _, _) => "BEYOND".to_owned(),
                (true, _, Some(false)) => "waves".to_owned(),
                (true, false, _) => "cells".to_owned(),
                (true, true, _) => String::new(),
            },
        ]);
    }
    println!(
        "{shown}\nShares of the light that lie in other Klems patches: of the next costlier method, of every facet with its \
         visibility in the same cells, of the same facets counted without a table, of another map of the surface, of waves ± what \
         chance makes of both. Time of the table of all angles."
    );
    let count = |test: fn(&choice::Row) -> bool| rows.iter().filter(|r| test(r)).count();
    println!(
        "{} of {} choices lie beyond their tolerance of the costliest method of their kind, every facet or the finest waves; the \
         cells of {} move more than that and than another map would. Of {} choices of rays where waves hold, {} are further \
         from them than the tolerance and twice the chance.",
        count(|r| !r.within),
        rows.len(),
        count(|r| !r.resolved),
        count(|r| r.waves_agree.is_some()),
        count(|r| r.waves_agree == Some(false))
    );
    say_wrote(&outputs);
    Ok(())
}

fn scaled(a: &Arguments, machine: &Machine, json: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let sides: Vec<usize> = [256, 512, 1024, 2048, 4096, 8192].into_iter().filter(|s| *s <= a.largest).collect();
    let bar = Bar::new("scaling", sides.len() + 1);
    let mut costs = Vec::new();
    let program = std::env::current_exe().context("the program cannot find itself")?;
    let mut last = 0.0;
    for (k, &side) in sides.iter().enumerate() {
        // Four times the points take four times as long.
        let budget = a.budget.unwrap_or(Duration::from_secs(240));
        if start.elapsed().as_secs_f64() + 4.0 * last > budget.as_secs_f64() {
            eprintln!("note: {side} points per side and more do not fit into the budget; raise --budget");
            break;
        }
        let begun = Instant::now();
        let done = Command::new(&program)
            .args(["bench", "--threads", &machine.threads.to_string(), "--one-size", &side.to_string()])
            .output()
            .context("cannot start a process of one size")?;
        if !done.status.success() {
            bail!("a map of {side} points per side failed: {}", String::from_utf8_lossy(&done.stderr).trim());
        }
        costs.extend(serde_json::from_slice::<Vec<scaling::Cost>>(&done.stdout)?);
        last = begun.elapsed().as_secs_f64();
        bar.set(k, 1.0);
    }
    let mut threads: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < machine.cores).collect();
    threads.push(machine.cores);
    costs.extend(scaling::other_lengths(&threads, &|share| bar.set(sides.len(), share))?);
    bar.finish();
    if !costs.iter().any(|c| c.work.starts_with("peak")) {
        eprintln!("note: this system does not tell the peak memory of a process; it is not measured");
    }
    let mut outputs = Vec::new();
    save_text(&scaling::csv(&costs, machine), &a.output, "scaling.csv", &mut outputs)?;
    save(&scaling::chart(&costs, machine), &a.output, "scaling", &mut outputs)?;
    if json {
        return print_json(&json!({ "machine": machine, "costs": costs }));
    }
    println!("{machine}");
    let mut shown = table(["along", "at", "work", "cost"]);
    for c in &costs {
        let value = if c.unit == "B" { format!("{:.1} MB", 1e-6 * c.value) } else { seconds(c.value) };
        shown.add_row([c.along.clone(), short(c.at), c.work.clone(), value]);
    }
    println!("{shown}");
    say_wrote(&outputs);
    Ok(())
}

fn budgeted(a: &Arguments, machine: &Machine, json: bool) -> anyhow::Result<()> {
    let bar = Bar::new("budgets", 1);
    let rows = budgets::measure(a.repeats as usize, &|share| bar.set(0, share))?;
    bar.finish();
    let mut outputs = Vec::new();
    save_text(&budgets::csv(&rows, machine), &a.output, "budgets.csv", &mut outputs)?;
    if json {
        return print_json(&json!({ "machine": machine, "budgets": rows }));
    }
    println!("{machine}");
    let mut shown = table(["work", "threads", "budget", "measured", ""]);
    for r in &rows {
        shown.add_row([
            r.work.clone(),
            r.threads.to_string(),
            format!("{} {}", r.budget, r.unit),
            format!("{:.2} {}", r.measured, r.unit),
            if r.met { "met".to_owned() } else { "MISSED".to_owned() },
        ]);
    }
    println!("{shown}");
    say_wrote(&outputs);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        assert_eq!(duration("60s"), Ok(Duration::from_secs(60)));
        assert_eq!(duration("2min"), Ok(Duration::from_secs(120)));
        assert_eq!(duration("1.5"), Ok(Duration::from_millis(1500)));
        for bad in ["", "s", "-3s", "soon", "0s", "nans"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
        assert_eq!(seconds(0.0123), "12.30 ms");
        assert_eq!(short(1e7), "1.0e7");
    }
}
