//! The budgets of the design, measured here and now on one thread.

use super::families::rendering::{SceneFile, options};
use super::families::sampling;
use super::stopwatch::median_of;
use super::surface::{GLASS, Surface, WAVELENGTH, budget_map};
use crate::error::{Error, Result};
use crate::facets::HeightField;
use crate::math::random::{CounterRng, LANES};
use crate::math::{direction, reflect};
use crate::meter::{self, Azimuths, Geometry, facet_gloss, gloss};
use crate::model;
use crate::optics::Brdf;
use crate::render::{Estimator, Tile, TilesOptions, render_tiles};
use crate::sample::TableBrdf;
use crate::scatter::facet_sum::{Azimuth, facet_sum};
use crate::scatter::rays::{Light, Shower, trace_rays};
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::{HalfVectorCells, Selection};
use glam::DVec3;
use serde::Serialize;
use std::fmt::Write;

/// Work with a limit.
struct Budget {
    work: &'static str,
    limit: f64,
    unit: &'static str,
    /// More is better.
    at_least: bool,
    threads: usize,
    measure: fn(&Bench) -> Result<f64>,
}

/// What the budgets measure with.
struct Bench<'a> {
    surface: Surface<'a>,
    cells: HalfVectorCells,
    table: TableBrdf,
    repeats: usize,
}

/// One budget and what was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub work: String,
    pub budget: f64,
    pub measured: f64,
    pub unit: String,
    pub threads: usize,
    pub met: bool,
}

const fn at_most(work: &'static str, limit: f64, unit: &'static str, measure: fn(&Bench) -> Result<f64>) -> Budget {
    Budget { work, limit, unit, at_least: false, threads: 1, measure }
}

/// Every budget; a new one is a line here.
const BUDGETS: [Budget; 19] = [
    at_most("slope distribution of 1024 x 1024, all incident angles", 2.5, "ms", slope_density),
    at_most("facet sum with visibility, 45 deg, per facet", 6.0, "ns", |b| facets(b, 45.0)),
    at_most("facet sum with visibility, 60 deg, per facet", 15.0, "ns", |b| facets(b, 60.0)),
    at_most("facet sum with visibility, 75 deg, per facet", 60.0, "ns", |b| facets(b, 75.0)),
    at_most("naive rays in map order, 20 deg, per ray", 40.0, "ns", |b| ordered_rays(b, 20.0)),
    at_most("naive rays in map order, 60 deg, per ray", 40.0, "ns", |b| ordered_rays(b, 60.0)),
    at_most("naive rays in random order, 60 deg, per ray", 120.0, "ns", |b| random_rays(b, 60.0)),
    at_most("block pyramid of 4096 x 4096", 150.0, "ms", pyramid),
    at_most("alias sample with pdf and weight, in runs of 64 (sample_many)", 15.0, "ns", draws),
    at_most("alias sample with pdf and weight, one by one (sample)", 15.0, "ns", single_draws),
    at_most("BRDF lookup", 30.0, "ns", lookups),
    at_most("BRDF lookup with its pdf, one by one (eval_and_pdf)", 45.0, "ns", lookups_with_pdf),
    at_most("BRDF lookup with its pdf, in runs of 64 (eval_and_pdf_many)", 45.0, "ns", many_lookups),
    at_most("gloss of a table, three angles", 20.0, "ms", table_gloss),
    at_most("gloss of a closed form, three angles", 10.0, "ms", model_gloss),
    at_most("gloss of a 1024 x 1024 map by its facets, three angles", 60.0, "ms", map_gloss),
    at_most("model evaluation, Beckmann n = 1.5", 60.0, "ns", model_lookups),
    Budget {
        work: "path tracing, four spheres, six lamps, depth 4",
        limit: 5.0,
        unit: "M paths/s",
        at_least: true,
        threads: 1,
        measure: paths,
    },
    Budget {
        work: "tiles picture 800 x 400, three tiles",
        limit: 5.0,
        unit: "s",
        at_least: false,
        threads: 2,
        measure: tiles,
    },
];

/// Measures every budget: medians of `repeats` after a warm-up, on as many threads as the budget says.
///
/// # Errors
/// `Error::Parameter` if a thread pool cannot be made.
pub fn measure(repeats: usize, progress: &dyn Fn(f64)) -> Result<Vec<Row>> {
    let map = budget_map(1024)?;
    let surface = Surface::new(&map, "map of the budgets")?;
    let cells = HalfVectorCells::for_lobe(&surface.statistics, true, 0.01);
    let bench = Bench { surface, cells, table: sampling::table()?, repeats };
    let mut rows = Vec::new();
    for (k, b) in BUDGETS.iter().enumerate() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(b.threads).build();
        let pool = pool.map_err(|e| Error::parameter(format!("no threads: {e}"), "give --threads a smaller number"))?;
        let measured = pool.install(|| (b.measure)(&bench))?;
        rows.push(Row {
            work: b.work.to_owned(),
            budget: b.limit,
            measured,
            unit: b.unit.to_owned(),
            threads: b.threads,
            met: if b.at_least { measured >= b.limit } else { measured <= b.limit },
        });
        progress((k + 1) as f64 / BUDGETS.len() as f64);
    }
    Ok(rows)
}

/// One row per budget.
pub fn csv(rows: &[Row], machine: &super::Machine) -> String {
    let mut csv = format!("# {machine}\nwork,unit,threads,budget,measured,met\n");
    for r in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(csv, "\"{}\",{},{},{},{:.4},{}", r.work, r.unit, r.threads, r.budget, r.measured, r.met);
    }
    csv
}

fn slope_density(b: &Bench) -> Result<f64> {
    Ok(1e3 * median_of(2 * b.repeats, || SlopeDensity::measure(b.surface.map, &b.cells, true)))
}

fn facets(b: &Bench, theta_deg: f64) -> Result<f64> {
    let walk = b.surface.walk();
    let sum = || facet_sum(&walk, &b.cells, theta_deg.to_radians(), Azimuth::Fixed(0.0), &Selection::default());
    Ok(1e9 * median_of(b.repeats, sum) / b.surface.statistics.facets as f64)
}

fn ordered_rays(b: &Bench, theta_deg: f64) -> Result<f64> {
    const RAYS: u64 = 1 << 20;
    let (walk, all) = (b.surface.walk(), Selection::default());
    let rays = || trace_rays(&walk, &b.cells, theta_deg.to_radians(), Azimuth::Fixed(0.0), RAYS, 1, &all);
    Ok(1e9 * median_of(b.repeats, rays) / RAYS as f64)
}

fn random_rays(b: &Bench, theta_deg: f64) -> Result<f64> {
    const RAYS: u64 = 1 << 18;
    const TOGETHER: u64 = 512;
    let walk = b.surface.walk();
    let light = [Light::new(&walk, theta_deg.to_radians(), (0.0, 0.0), &Selection::default())];
    let rays = || {
        let mut shower = Shower::new(&walk, &b.cells);
        let mut aims = Vec::with_capacity(TOGETHER as usize);
        for from in (0..RAYS).step_by(TOGETHER as usize) {
            aims.clear();
            for some in (from..from + TOGETHER).step_by(LANES) {
                let [x, y, ..] = CounterRng::fours(1, 0, some);
                aims.extend(x.into_iter().zip(y).map(|(x, y)| [x, y]));
            }
            shower.fall(&light, &aims);
        }
        shower.sums()
    };
    Ok(1e9 * median_of(b.repeats, rays) / RAYS as f64)
}

fn pyramid(b: &Bench) -> Result<f64> {
    let map = super::scaling::tiled(b.surface.map, 4);
    Ok(1e3 * median_of(b.repeats.min(5), || HeightField::new(&map)))
}

/// Directions near the lobe and random numbers, in cache.
fn queries(brdf: &dyn Brdf) -> Vec<(DVec3, DVec3, [f64; 2])> {
    let mut rng = CounterRng::new(2, 0, 0);
    (0..8192)
        .map(|_| {
            let wi = direction(1.3 * rng.uniform(), std::f64::consts::TAU * rng.uniform());
            let drawn = brdf.sample(wi, [rng.uniform(), rng.uniform()]);
            let wo = drawn.map_or_else(|| reflect(wi, DVec3::Z), |s| s.wo);
            (wi, wo, [rng.uniform(), rng.uniform()])
        })
        .collect()
}

fn draws(b: &Bench) -> Result<f64> {
    let list = queries(&b.table);
    let (wi, u): (Vec<DVec3>, Vec<[f64; 2]>) = list.iter().map(|q| (q.0, q.2)).unzip();
    let drawn = std::cell::RefCell::new(vec![None; list.len()]);
    let draw = || b.table.sample_many(&wi, &u, &mut drawn.borrow_mut());
    Ok(1e9 * median_of(2 * b.repeats, draw) / list.len() as f64)
}

fn single_draws(b: &Bench) -> Result<f64> {
    let list = queries(&b.table);
    let draw = || list.iter().filter_map(|q| b.table.sample(q.0, q.2)).map(|s| s.weight + s.pdf).sum::<f64>();
    Ok(1e9 * median_of(2 * b.repeats, draw) / list.len() as f64)
}

fn many_lookups(b: &Bench) -> Result<f64> {
    let list = queries(&b.table);
    let (wi, wo): (Vec<DVec3>, Vec<DVec3>) = list.iter().map(|q| (q.0, q.1)).unzip();
    let found = std::cell::RefCell::new(vec![(0.0, 0.0); list.len()]);
    let look_up = || b.table.eval_and_pdf_many(&wi, &wo, &mut found.borrow_mut());
    Ok(1e9 * median_of(2 * b.repeats, look_up) / list.len() as f64)
}

fn lookups_of(brdf: &dyn Brdf, repeats: usize) -> f64 {
    let list = queries(brdf);
    let sum = || list.iter().map(|q| brdf.eval(q.0, q.1)).sum::<f64>();
    1e9 * median_of(2 * repeats, sum) / list.len() as f64
}

fn lookups(b: &Bench) -> Result<f64> {
    Ok(lookups_of(&b.table, b.repeats))
}

fn lookups_with_pdf(b: &Bench) -> Result<f64> {
    let list = queries(&b.table);
    let both = |q: &(DVec3, DVec3, [f64; 2])| {
        let (f_r, pdf) = b.table.eval_and_pdf(q.0, q.1);
        f_r + pdf
    };
    Ok(1e9 * median_of(2 * b.repeats, || list.iter().map(both).sum::<f64>()) / list.len() as f64)
}

fn model_lookups(b: &Bench) -> Result<f64> {
    Ok(lookups_of(&*model::parse("beckmann:alpha=0.1,n=1.5", WAVELENGTH)?, b.repeats))
}

fn three_angles(brdf: &dyn Brdf, repeats: usize) -> f64 {
    let options = meter::Options::default();
    1e3 * median_of(repeats, || Geometry::standard_three().map(|g| gloss(brdf, &g, &options)))
}

fn table_gloss(b: &Bench) -> Result<f64> {
    Ok(three_angles(&b.table, b.repeats))
}

fn model_gloss(b: &Bench) -> Result<f64> {
    Ok(three_angles(&*model::parse("beckmann:alpha=0.02,n=1.5", WAVELENGTH)?, b.repeats))
}

fn map_gloss(b: &Bench) -> Result<f64> {
    let three = Geometry::standard_three();
    Ok(1e3 * median_of(b.repeats, || facet_gloss(b.surface.map, &GLASS, &three, &Azimuths::All)))
}

fn paths(b: &Bench) -> Result<f64> {
    const SIZE: [usize; 2] = [200, 100];
    const PATHS: u32 = 16;
    let scene = SceneFile::new()?;
    let materials = scene.materials()?;
    let options = options(SIZE, PATHS, 1, Estimator::Mis);
    let seconds = median_of(b.repeats, || scene.picture(&materials, &options));
    Ok(1e-6 * (SIZE[0] * SIZE[1]) as f64 * f64::from(PATHS) / seconds)
}

fn tiles(b: &Bench) -> Result<f64> {
    let tile = |name: &str| Tile { caption: vec![name.to_owned()], brdf: &b.table };
    let list = ["one", "two", "three"].map(tile);
    let options = TilesOptions { panel_width: 266, ..TilesOptions::default() };
    Ok(median_of(1, || render_tiles(&list, &options, &|_| ())))
}
