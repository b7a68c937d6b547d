//! Lookups and draws of a table beside their rivals, and what the draws are worth: `cargo bench --bench sampling`; size of
//! a table against its error as CSV at the end.
//!
//! One thread. A Gaussian surface of alpha 0.02 (Sq 0.1 um, autocorrelation length 10 um), n = 1.5, 13 incident angles, isotropic;
//! the same stretched threefold along y as an anisotropic table of 12 azimuths.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::frame::DVec3;
use asperity::math::random::CounterRng;
use asperity::math::{direction, reflect};
use asperity::model;
use asperity::optics::{Brdf, Material};
use asperity::sample::rivals::{CosineSampled, CumulativeSampled, UniformSampled};
use asperity::sample::{AliasTable, TableBrdf};
use asperity::scatter::{Method, Options, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime};
use std::hint::black_box;
use std::time::Duration;

fn map(sq: f64, pitch_y: f64) -> HeightMap {
    let grid = synth::Grid { width: 512, height: 512, pitch: [1e-6; 2] };
    let surface = synth::Gaussian { sq, acl: 10e-6, seed: 3, exact: true };
    let mut raw = synth::gaussian(grid, surface).expect("a surface");
    raw.pitch_y = pitch_y;
    level::keep_tilt(&raw, Edges::Periodic)
}

fn table(map: &HeightMap, symmetry: Symmetry, method: Method) -> TableBrdf {
    let options = Options { symmetry, method, material: Material::Dielectric { n: 1.5 }, ..Options::default() };
    let scattered = scatter(map, &options, &|_| ()).expect("a map with facets");
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).expect("a table")
}

/// Random pairs of directions near the lobe, and random numbers, to be used in turn.
fn queries(brdf: &dyn Brdf) -> Vec<(DVec3, DVec3, [f64; 2])> {
    let mut rng = CounterRng::new(2, 0, 0);
    (0..8192)
        .map(|_| {
            let wi = direction(1.3 * rng.uniform(), std::f64::consts::TAU * rng.uniform());
            let u = [rng.uniform(), rng.uniform()];
            let wo = brdf.sample(wi, u).map_or_else(|| reflect(wi, DVec3::Z), |s| s.wo);
            (wi, wo, [rng.uniform(), rng.uniform()])
        })
        .collect()
}

fn group<'a>(c: &'a mut Criterion, name: &str, elements: u64) -> BenchmarkGroup<'a, WallTime> {
    let mut g = c.benchmark_group(name);
    g.throughput(Throughput::Elements(elements));
    g
}

fn lookups(c: &mut Criterion) {
    let isotropic = table(&map(0.1e-6, 1e-6), Symmetry::Isotropic, Method::Geometric);
    let anisotropic = table(&map(0.1e-6, 3e-6), Symmetry::Anisotropic, Method::Facets);
    for (name, brdf) in [("isotropic", &isotropic), ("anisotropic", &anisotropic)] {
        let t = brdf.table();
        let nodes = t.theta_i().len() * t.phi_i().len();
        let name = format!("{name} table of {} x {nodes} cells, per call", t.cells().len());
        let queries = queries(brdf);
        let mut g = group(c, &name, queries.len() as u64);
        let draw =
            |b: &dyn Brdf| queries.iter().filter_map(|q| b.sample(q.0, q.2)).map(|s| s.weight + s.pdf).sum::<f64>();
        g.bench_function("sample with weight and pdf, one by one", |b| b.iter(|| draw(black_box(brdf))));
        let (sources, numbers): (Vec<DVec3>, Vec<[f64; 2]>) = queries.iter().map(|q| (q.0, q.2)).unzip();
        let mut drawn = vec![None; queries.len()];
        g.bench_function("sample with weight and pdf, in runs of 64", |b| {
            b.iter(|| black_box(brdf).sample_many(&sources, &numbers, black_box(&mut drawn)));
        });
        g.bench_function("eval", |b| b.iter(|| queries.iter().map(|q| brdf.eval(q.0, q.1)).sum::<f64>()));
        g.bench_function("pdf", |b| b.iter(|| queries.iter().map(|q| brdf.pdf(q.0, q.1)).sum::<f64>()));
        g.bench_function("eval and pdf", |b| {
            b.iter(|| {
                queries
                    .iter()
                    .map(|q| {
                        let (f, pdf) = brdf.eval_and_pdf(q.0, q.1);
                        f + pdf
                    })
                    .sum::<f64>()
            });
        });
        let exits: Vec<DVec3> = queries.iter().map(|q| q.1).collect();
        let mut found = vec![(0.0, 0.0); queries.len()];
        g.bench_function("eval and pdf, in runs of 64", |b| {
            b.iter(|| black_box(brdf).eval_and_pdf_many(&sources, &exits, black_box(&mut found)));
        });
        let cumulative = CumulativeSampled::new(brdf);
        g.bench_function("rival: cumulative inversion", |b| b.iter(|| draw(black_box(&cumulative))));
        g.bench_function("rival: cosine", |b| b.iter(|| draw(black_box(&CosineSampled(brdf)))));
        g.bench_function("rival: uniform", |b| b.iter(|| draw(black_box(&UniformSampled(brdf)))));
        g.finish();
    }
    let beckmann = model::parse("beckmann:alpha=0.02,n=1.5", 550e-9).expect("a model");
    let queries = queries(beckmann.as_ref());
    let mut g = group(c, "Beckmann by its formula, per call", queries.len() as u64);
    g.bench_function("sample with weight and pdf", |b| {
        b.iter(|| queries.iter().filter_map(|q| beckmann.sample(q.0, q.2)).map(|s| s.weight + s.pdf).sum::<f64>());
    });
    g.bench_function("eval", |b| b.iter(|| queries.iter().map(|q| beckmann.eval(q.0, q.1)).sum::<f64>()));
    g.finish();
}

fn building(c: &mut Criterion) {
    let mut rng = CounterRng::new(4, 0, 0);
    let weights: Vec<f64> = (0..1_000_000).map(|_| rng.uniform().powi(8)).collect();
    let mut g = c.benchmark_group("alias table of 1e6 cells");
    g.bench_function("build", |b| b.iter(|| AliasTable::new(black_box(&weights))));
    let alias = AliasTable::new(&weights).expect("weights");
    let bits: Vec<u64> = (0..8192).map(|_| (rng.uniform() * 1.8e19) as u64).collect();
    g.throughput(Throughput::Elements(bits.len() as u64));
    g.bench_function("draw", |b| b.iter(|| bits.iter().map(|&b| alias.draw(b).0).sum::<usize>()));
    g.finish();
}

/// Mean and variance of what one draw brings of a patch of sky of radiance 1.
fn worth(brdf: &dyn Brdf, wi: DVec3, sky: &dyn Fn(DVec3) -> f64, draws: u64) -> (f64, f64) {
    let mut rng = CounterRng::new(6, 0, 0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..draws {
        let brought = brdf.sample(wi, [rng.uniform(), rng.uniform()]).map_or(0.0, |s| s.weight * sky(s.wo));
        sum += brought;
        squares += brought * brought;
    }
    let n = draws as f64;
    (sum / n, squares / n - (sum / n).powi(2))
}

/// The variance of one draw by each way, for lobes of several widths that mirror a bright patch as wide as themselves.
fn variance(_: &mut Criterion) {
    println!("variance of one draw, lobe over a bright patch of 1.5 lobe widths at 45 deg; mirror facets");
    println!("lobe std     alias       cumulative  cosine      uniform     uniform / alias");
    for sq in [0.03e-6, 0.1e-6, 0.3e-6] {
        let options = Options {
            material: Material::Mirror,
            symmetry: Symmetry::Isotropic,
            method: Method::Geometric,
            ..Options::default()
        };
        let scattered = scatter(&map(sq, 1e-6), &options, &|_| ()).expect("a map with facets");
        let brdf = TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).expect("a table");
        // Out of the plane of incidence the lobe is sqrt(2) alpha cos(theta_i) wide, in it sqrt(2) alpha.
        let width = std::f64::consts::SQRT_2 * 2.0 * sq / 10e-6;
        let wi = direction(45f64.to_radians(), 0.4);
        let centre = reflect(wi, DVec3::Z);
        let cos = (1.5 * width).cos();
        let sky = move |wo: DVec3| if wo.dot(centre) > cos { 1.0 } else { 0.0 };
        let cumulative = CumulativeSampled::new(&brdf);
        let ways: [&dyn Brdf; 4] = [&brdf, &cumulative, &CosineSampled(&brdf), &UniformSampled(&brdf)];
        let found = ways.map(|way| worth(way, wi, &sky, 2_000_000));
        println!(
            "{:>5.2} deg    {:<10.3e}  {:<10.3e}  {:<10.3e}  {:<10.3e}  {:.0}   (means {:.4} {:.4} {:.4} {:.4})",
            width.to_degrees(),
            found[0].1,
            found[1].1,
            found[2].1,
            found[3].1,
            found[3].1 / found[0].1,
            found[0].0,
            found[1].0,
            found[2].0,
            found[3].0,
        );
    }
}

/// Mean absolute difference to a finer table relative to its energy, by its draws.
fn mean_difference(brdf: &TableBrdf, finer: &TableBrdf, theta_i: f64) -> f64 {
    let wi = direction(theta_i, 0.3);
    let mut rng = CounterRng::new(8, 0, 0);
    let (mut difference, mut sum) = (0.0, 0.0);
    for _ in 0..20_000 {
        if let Some(s) = finer.sample(wi, [rng.uniform(), rng.uniform()]).filter(|s| !s.specular) {
            difference += (brdf.eval(wi, s.wo) / finer.eval(wi, s.wo) - 1.0).abs() * s.weight;
            sum += s.weight;
        }
    }
    difference / sum
}

/// What a tolerance costs and what it buys, as CSV: the table keeps the angles that half the tolerance asks for.
fn sizes(_: &mut Criterion) {
    println!("alpha,tolerance,cells,theta_i,density_bytes,l1_20deg,l1_60deg,l1_84deg");
    for sq in [0.015e-6, 0.15e-6, 1.5e-6] {
        let map = map(sq, 1e-6);
        let tabulate = |tolerance: f64, fewest: bool| {
            let options =
                Options { tolerance, symmetry: Symmetry::Isotropic, method: Method::Facets, ..Options::default() };
            let table = Table::from_scatter(&scatter(&map, &options, &|_| ()).expect("facets"), Provenance::default());
            let all: Vec<usize> = (0..table.theta_i().len()).collect();
            let kept = if fewest { table.needed_theta_i(0.5 * tolerance) } else { all };
            TableBrdf::new(table.at_nodes(&kept, &[0])).expect("a table")
        };
        let finest = tabulate(6e-4, false);
        for tolerance in [0.08, 0.04, 0.02, 0.01, 0.005, 0.0025] {
            let brdf = tabulate(tolerance, true);
            let (cells, angles) = (brdf.table().cells().len(), brdf.table().theta_i().len());
            let [a, b, c] = [20.0f64, 60.0, 84.0].map(|t| mean_difference(&brdf, &finest, t.to_radians()));
            let alpha = 2.0 * sq / 10e-6;
            println!("{alpha:.3},{tolerance},{cells},{angles},{},{a:.5},{b:.5},{c:.5}", 8 * cells * angles);
        }
    }
}

criterion_group! {
    name = sampling;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .without_plots();
    targets = lookups, building, variance, sizes
}
criterion_main!(sampling);
