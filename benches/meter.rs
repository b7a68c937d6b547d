//! Times of the light meter, one thread: `cargo bench --bench meter`; and its error against time, `-- curve`.
//!
//! Targets: three gloss angles of a table to 0.05 GU in 20 ms, of a closed-form model in 10 ms, of a map of 1024 x 1024
//! samples by its facets in 60 ms.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::meter::{Azimuths, Geometry, Options, appearance, facet_gloss, gloss, standards, traced_gloss};
use asperity::model::parse;
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::scatter;
use asperity::table::{Provenance, Table};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};

fn map(side: usize) -> HeightMap {
    let grid = synth::Grid { width: side, height: side, pitch: [0.5e-6; 2] };
    let surface = synth::Gaussian { sq: 0.2e-6, acl: 10e-6, seed: 1, exact: true };
    level::keep_tilt(&synth::gaussian(grid, surface).expect("a usable grid"), Edges::Periodic)
}

fn table() -> TableBrdf {
    let scattered = scatter::scatter(&map(512), &scatter::Options::default(), &|_| ()).expect("a usable map");
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).expect("a usable table")
}

fn readings(c: &mut Criterion) {
    let three = Geometry::standard_three();
    let options = Options::default();
    let mut group = c.benchmark_group("gloss at 20, 60, 85 deg");
    for text in ["beckmann:alpha=0.02,n=1.5", "ggx:alpha=0.1,n=1.5", "ward:rho_s=0.05,alpha=0.02", "lambert:rho=1"] {
        let brdf = parse(text, 550e-9).expect(text);
        group.bench_function(text, |b| b.iter(|| three.clone().map(|g| gloss(black_box(&*brdf), &g, &options))));
    }
    let brdf = table();
    group.bench_function("table", |b| b.iter(|| three.clone().map(|g| gloss(black_box(&brdf), &g, &options))));
    let (map, glass) = (map(1024), Material::Dielectric { n: 1.5 });
    group.bench_function("facets of 1024 x 1024, all azimuths", |b| {
        b.iter(|| facet_gloss(black_box(&map), &glass, &three, &Azimuths::All).expect("facets"));
    });
    group.bench_function("facets of 1024 x 1024, one azimuth", |b| {
        b.iter(|| facet_gloss(black_box(&map), &glass, &three, &Azimuths::At(vec![0.0])).expect("facets"));
    });
    // At 85 deg light bounces again on this map: 400 000 facets ask for source and receptor.
    let options = scatter::Options::default();
    group.bench_function("facets of 1024 x 1024, all azimuths, asked where it matters", |b| {
        b.iter(|| traced_gloss(black_box(&map), &three, &Azimuths::All, &options).expect("facets"));
    });
    group.finish();
    let options = Options::default();
    let brdf = parse("beckmann:alpha=0.02,n=1.5", 550e-9).expect("a model");
    c.bench_function("the usual set of readings of a model", |b| b.iter(|| appearance(&*brdf, &options)));
}

/// Largest error over the three angles against the reference of independent quadrature, and the time it took.
fn curve(_: &mut Criterion) {
    let meters = ["gloss-20", "gloss-60", "gloss-85"].map(|name| standards::by_name(name).expect(name));
    let cases = [
        ("beckmann:alpha=0.002,n=1.567", [99.9933, 100.0007, 99.9912]),
        ("beckmann:alpha=0.02,n=1.567", [29.8026, 82.1901, 77.6384]),
        ("ggx:alpha=0.1,n=1.567", [1.6196, 15.2255, 11.0390]),
    ];
    println!("model, integrator, milliseconds, largest error in GU, largest claimed error in GU");
    for (text, want) in cases {
        let brdf: Box<dyn Brdf> = parse(text, 587.6e-9).expect(text);
        for tolerance in [1.0, 0.3, 0.1, 0.03, 0.01] {
            for by_drawing in [true, false] {
                let options = Options { tolerance, points: 32, max_points: 65536, ..Options::default() };
                let start = Instant::now();
                let got = meters.each_ref().map(|m| {
                    let read = if by_drawing { m.measure(&*brdf, &options) } else { m.subdivide(&*brdf, &options) };
                    read.expect("a sound instrument")[0].estimate
                });
                let time = start.elapsed().as_secs_f64() * 1e3;
                let error = got.iter().zip(want).map(|(e, w)| (e.value - w).abs()).fold(0.0, f64::max);
                let claimed = got.iter().map(|e| e.standard_error).fold(0.0, f64::max);
                let name = if by_drawing { "half vectors" } else { "subdivision" };
                println!("{text}, {name}, {time:.2}, {error:.4}, {claimed:.4}");
            }
        }
    }
}

fn all(c: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first use of the pool");
    if std::env::args().any(|a| a == "curve") { curve(c) } else { readings(c) }
}

criterion_group! {
    name = meter;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .without_plots();
    targets = all
}
criterion_main!(meter);
