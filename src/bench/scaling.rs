//! How cost grows with the map, the rays, the incident angles and the threads; and the memory it takes.

use super::stopwatch::{median_of, timed};
use super::surface::{GLASS, Surface, budget_map};
use crate::chart::Drawing;
use crate::chart::panels::{Mark, Panel, Quantity, Series, panels};
use crate::error::{Error, Result};
use crate::facets::HeightField;
use crate::heightmap::HeightMap;
use crate::math::direction;
use crate::scatter::facet_sum::{Azimuth, facet_sum};
use crate::scatter::rays::trace_rays;
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::{HalfVectorCells, Method, Options, Scatter, Selection, scatter};
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// One measured cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// `map side`, `rays`, `incident angles` or `threads`.
    pub along: String,
    pub at: f64,
    pub work: String,
    /// Seconds, or bytes for memory.
    pub value: f64,
    pub unit: String,
}

fn cost(along: &str, at: f64, work: &str, value: f64, unit: &str) -> Cost {
    Cost { along: along.into(), at, work: work.into(), value, unit: unit.into() }
}

/// The periodic map side by side with itself, `times` across and down: the same statistics at any size.
pub fn tiled(map: &HeightMap, times: usize) -> HeightMap {
    let (h, w) = map.heights.dim();
    let heights = Array2::from_shape_fn((h * times, w * times), |(r, c)| map.heights[(r % h, c % w)]);
    HeightMap { heights, ..map.clone() }
}

/// Times of a map of `side` points across, and the memory that its facets take beyond its heights, where the system tells.
///
/// To be called once per process: the peak of the memory is that of the process.
///
/// # Errors
/// `Error::Parameter` if `side` is not 256 times a power of two.
pub fn one_size(side: usize) -> Result<Vec<Cost>> {
    let times = side / 256;
    if !side.is_multiple_of(256) || times == 0 {
        return Err(Error::parameter(format!("{side} is no size to measure"), "take a multiple of 256"));
    }
    let map = tiled(&budget_map(256)?, times);
    let before = resident();
    let surface = Surface::new(&map, "tiled")?;
    let cells = HalfVectorCells::for_lobe(&surface.statistics, true, 0.01);
    let walk = surface.walk();
    let at = side as f64;
    let sum = |degrees: f64| facet_sum(&walk, &cells, degrees.to_radians(), Azimuth::Fixed(0.0), &Selection::default());
    let density = || SlopeDensity::measure(&map, &cells, true);
    // Everything once as a run would do it; the repeats hold a second pyramid.
    let first = [timed(density).1, 0.0, timed(|| sum(45.0)).1, timed(|| sum(75.0)).1];
    let heights = (side * side * 4) as f64;
    let mut costs = vec![cost("map side", at, "heights alone", heights, "B")];
    if let (Some([_, then]), Some([peak, _])) = (before, resident()) {
        costs.push(cost("map side", at, "peak with the heights", (peak - then).max(0.0) + heights, "B"));
        costs.push(cost("map side", at, "peak beside the heights", (peak - then).max(0.0), "B"));
    }
    // The first run of a small map pays for waking the threads.
    let again = |first: f64, work: &dyn Fn() -> f64| if side <= 1024 { work() } else { first };
    let seconds = [
        ("slope distribution, all angles", again(first[0], &|| median_of(3, density))),
        ("block pyramid", median_of(if side <= 1024 { 3 } else { 1 }, || HeightField::new(&map))),
        ("facet sum at 45\u{b0}", again(first[2], &|| median_of(3, || sum(45.0)))),
        ("facet sum at 75\u{b0}", again(first[3], &|| median_of(3, || sum(75.0)))),
    ];
    costs.extend(seconds.iter().map(|(work, t)| cost("map side", at, work, *t, "s")));
    costs.push(cost("map side", at, "Kirchhoff at 45\u{b0}", timed(|| waves(&map)).1, "s"));
    Ok(costs)
}

/// The wave lobe of one incident angle; nothing in it can be refused for a map of facets.
fn waves(map: &HeightMap) -> Option<Scatter> {
    let theta_i = vec![45f64.to_radians()];
    let options = Options { method: Method::Kirchhoff, material: GLASS, theta_i, ..Options::default() };
    scatter(map, &options, &|_| ()).ok()
}

/// Peak and present resident memory of this process \[bytes\], where the system tells.
fn resident() -> Option<[f64; 2]> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let field = |name: &str| {
        let line = status.lines().find(|l| l.starts_with(name))?;
        Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0)
    };
    Some([field("VmHWM")?, field("VmRSS")?])
}

/// Cost against the number of rays, of incident angles and of threads on the map of the budgets.
///
/// # Errors
/// `Error::Parameter` if a pool of threads cannot be made.
pub fn other_lengths(threads: &[usize], progress: &dyn Fn(f64)) -> Result<Vec<Cost>> {
    let map = budget_map(1024)?;
    let surface = Surface::new(&map, "map of the budgets")?;
    let (walk, cells, all) = (surface.walk(), &surface.cells, Selection::default());
    let sixty = 60f64.to_radians();
    let mut costs = Vec::new();
    for rays in [1e4, 1e5, 1e6, 1e7] {
        let trace = || trace_rays(&walk, cells, sixty, Azimuth::Fixed(0.0), rays as u64, 1, &all);
        costs.push(cost("rays", rays, "naive rays at 60\u{b0}", timed(trace).1, "s"));
    }
    progress(0.4);
    let hiding = surface.statistics.hiding();
    for angles in [1u32, 2, 4, 8, 16, 32] {
        let theta = |k: u32| (75.0 * f64::from(k) / f64::from(angles)).to_radians();
        let sums =
            || (0..angles).map(|k| facet_sum(&walk, cells, theta(k), Azimuth::Fixed(0.0), &all)).collect::<Vec<_>>();
        let tallies = || {
            let density = SlopeDensity::measure(&map, cells, true);
            (0..angles).map(|k| density.tally(cells, direction(theta(k), 0.0), &GLASS, &hiding)).collect::<Vec<_>>()
        };
        costs.push(cost("incident angles", f64::from(angles), "facet sum, 0 to 75\u{b0}", timed(sums).1, "s"));
        costs.push(cost("incident angles", f64::from(angles), "slope distribution", timed(tallies).1, "s"));
    }
    progress(0.8);
    for &n in threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
        let pool = pool.map_err(|e| Error::parameter(format!("no threads: {e}"), "give --threads a smaller number"))?;
        let sum = || pool.install(|| facet_sum(&walk, cells, sixty, Azimuth::Fixed(0.0), &all));
        costs.push(cost("threads", n as f64, "facet sum at 60\u{b0}", median_of(3, sum), "s"));
        let trace = || pool.install(|| trace_rays(&walk, cells, sixty, Azimuth::Fixed(0.0), 1 << 20, 1, &all));
        costs.push(cost("threads", n as f64, "2^20 naive rays", median_of(3, trace), "s"));
    }
    progress(1.0);
    Ok(costs)
}

/// One row per cost.
pub fn csv(costs: &[Cost], machine: &super::Machine) -> String {
    let mut csv = format!("# {machine}\nalong,at,work,value,unit\n");
    for c in costs {
        // Writing to a string cannot fail.
        let _ = writeln!(csv, "{},{},\"{}\",{:.4e},{}", c.along, c.at, c.work, c.value, c.unit);
    }
    csv
}

/// Cost along each of the four lengths, and memory.
pub fn chart(costs: &[Cost], machine: &super::Machine) -> Drawing {
    let panel = |title: &str, along: &str, unit: &str, note: &str, x: &str, guide: Option<(f64, String)>| {
        let own: Vec<&Cost> = costs.iter().filter(|c| c.along == along && c.unit == unit).collect();
        let mut works: Vec<&str> = Vec::new();
        own.iter().for_each(|c| {
            if !works.contains(&c.work.as_str()) {
                works.push(&c.work);
            }
        });
        let series = |work: &&str| Series {
            label: (*work).to_owned(),
            marks: own.iter().filter(|c| c.work == **work).map(|c| Mark { x: [c.at; 3], y: [c.value; 3] }).collect(),
            chosen: None,
        };
        let (quantity, name) = match unit {
            "B" => (Quantity::Bytes, "memory"),
            _ => (Quantity::Seconds, "time"),
        };
        Panel {
            title: title.to_owned(),
            note: note.to_owned(),
            x: (Quantity::Count, x.to_owned()),
            y: (quantity, name.to_owned()),
            series: works.iter().map(series).collect(),
            guide,
            floor: None,
        }
    };
    let surface = "Sdq 0.16, pitch 0.5 \u{b5}m, the map of 256 points tiled; Kirchhoff: one angle";
    let linear = |text: &str, slope: f64| Some((slope, text.to_owned()));
    let list = vec![
        panel(
            "Size of the map: time",
            "map side",
            "s",
            surface,
            "points per side",
            linear("in step with the points", 2.0),
        ),
        panel(
            "Size of the map: memory",
            "map side",
            "B",
            "slope distribution, block pyramid, facet sums; the map itself apart",
            "points per side",
            None,
        ),
        panel("Rays", "rays", "s", "1024 x 1024 points, 60\u{b0}", "rays", linear("in step with the rays", 1.0)),
        panel(
            "Incident angles",
            "incident angles",
            "s",
            "1024 x 1024 points; the slope distribution is counted once for all",
            "incident angles",
            linear("in step with the angles", 1.0),
        ),
        panel("Threads", "threads", "s", "1024 x 1024 points", "threads", linear("in step with the threads", -1.0)),
    ];
    panels("Cost against size", &list, &[format!("{machine}.")])
}
