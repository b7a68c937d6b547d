//! Times of every stage, per facet, ray, sample or lookup: `cargo bench`.
//!
//! One thread, so that the figures are those of one core. The map is Gaussian: Sq 0.8 um, autocorrelation length 10 um,
//! pitch 0.5 um (Sdq 0.16), n = 1.5.

use asperity::facets::{HeightField, SlopeStatistics};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::math::random::{CounterRng, LANES};
use asperity::optics::Material;
use asperity::render::{Tile, TilesOptions, render_tiles};
use asperity::sample::TableBrdf;
use asperity::scatter::Selection;
use asperity::scatter::bounce::Walk;
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::rays::{Light, Shower, trace_rays};
use asperity::scatter::slope_histogram::SlopeDensity;
use asperity::scatter::{self, HalfVectorCells};
use asperity::table::{Provenance, Table};
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use std::hint::black_box;
use std::time::Duration;

const GLASS: Material = Material::Dielectric { n: 1.5 };

fn map(side: usize) -> HeightMap {
    let grid = synth::Grid { width: side, height: side, pitch: [0.5e-6; 2] };
    let surface = synth::Gaussian { sq: 0.8e-6, acl: 10e-6, seed: 1, exact: true };
    level::keep_tilt(&synth::gaussian(grid, surface).expect("a usable grid"), Edges::Periodic)
}

fn table() -> TableBrdf {
    let scattered = scatter::scatter(&map(512), &scatter::Options::default(), &|_| ()).expect("a usable map");
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).expect("a usable table")
}

/// A named group whose figures are read per element.
fn group<'a>(c: &'a mut Criterion, name: &str, elements: u64) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(elements));
    group
}

fn slopes(c: &mut Criterion) {
    let map = map(1024);
    let statistics = SlopeStatistics::measure(&map).expect("facets");
    let cells = HalfVectorCells::for_lobe(&statistics, true, 0.01);
    let facets = statistics.facets;
    let mut g = group(c, "1 slopes, per facet of 1024 x 1024 samples", facets);
    g.bench_function("moments and histograms", |b| b.iter(|| SlopeStatistics::measure(black_box(&map))));
    g.bench_function("density over half-vector cells", |b| {
        b.iter(|| SlopeDensity::measure(black_box(&map), &cells, true));
    });
    let density = SlopeDensity::measure(&map, &cells, true);
    let hiding = statistics.hiding();
    g.finish();
    let mut g = group(c, "2 one incident angle from the density, per cell", cells.len() as u64);
    g.bench_function("tally", |b| {
        b.iter(|| density.tally(&cells, black_box(direction(0.8, 0.0)), &GLASS, &hiding));
    });
    g.finish();
}

fn scattering(c: &mut Criterion) {
    let map = map(1024);
    let statistics = SlopeStatistics::measure(&map).expect("facets");
    let cells = HalfVectorCells::for_lobe(&statistics, true, 0.01);
    let field = HeightField::new(&map);
    let walk = Walk { field: &field, material: GLASS, max_bounces: 8, steepest: statistics.steepest };
    let mut g = group(c, "3 facet sum with visibility, per facet", statistics.facets);
    for degrees in [20, 45, 60, 75] {
        let theta_i = f64::from(degrees).to_radians();
        g.bench_with_input(BenchmarkId::from_parameter(format!("{degrees} deg")), &theta_i, |b, &theta_i| {
            b.iter(|| facet_sum(&walk, &cells, theta_i, Azimuth::Fixed(0.0), &Selection::default()));
        });
        g.bench_with_input(
            BenchmarkId::from_parameter(format!("{degrees} deg, all azimuths")),
            &theta_i,
            |b, &theta_i| {
                b.iter(|| facet_sum(&walk, &cells, theta_i, Azimuth::Averaged, &Selection::default()));
            },
        );
    }
    g.finish();
    let rays = 1 << 20;
    let mut g = group(c, "4 naive rays in map order, per ray", rays);
    for degrees in [20, 45, 60, 75] {
        let theta_i = f64::from(degrees).to_radians();
        g.bench_with_input(BenchmarkId::from_parameter(format!("{degrees} deg")), &theta_i, |b, &theta_i| {
            b.iter(|| trace_rays(&walk, &cells, theta_i, Azimuth::Fixed(0.0), rays, 1, &Selection::default()));
        });
    }
    g.finish();
    let mut g = group(c, "4 naive rays in random order, per ray", rays);
    for degrees in [20, 45, 60, 75] {
        let theta_i = f64::from(degrees).to_radians();
        let light = [Light::new(&walk, theta_i, (0.0, 0.0), &Selection::default())];
        g.bench_with_input(BenchmarkId::from_parameter(format!("{degrees} deg")), &light, |b, light| {
            b.iter(|| {
                let mut shower = Shower::new(&walk, &cells);
                let mut aims = Vec::with_capacity(512);
                for from in (0..rays).step_by(512) {
                    aims.clear();
                    for some in (from..from + 512).step_by(LANES) {
                        let [x, y, ..] = CounterRng::fours(1, 0, some);
                        aims.extend(x.into_iter().zip(y).map(|(x, y)| [x, y]));
                    }
                    shower.fall(light, &aims);
                }
                shower.sums()
            });
        });
    }
    g.finish();
    let mut g = group(c, "5 height field, per sample of the map", (map.width() * map.height()) as u64);
    g.bench_function("build", |b| b.iter(|| HeightField::new(black_box(&map))));
    g.finish();
}

fn rendering(c: &mut Criterion) {
    let brdf = table();
    let options = TilesOptions { panel_width: 64, samples_per_pixel: 16, ..TilesOptions::default() };
    let (width, height) = (64, 67);
    let mut g = group(c, "6 rendering, per path", width * height * 16);
    g.bench_function("one tile with a table", |b| {
        b.iter(|| {
            let tile = Tile { caption: vec!["bench".into()], brdf: &brdf };
            render_tiles(&[tile], &options, &|_| ()).expect("a picture")
        });
    });
    g.finish();
}

fn all(c: &mut Criterion) {
    // The pipeline runs in parallel by itself; here every figure is to be that of one core.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first use of the pool");
    slopes(c);
    scattering(c);
    rendering(c);
}

criterion_group! {
    name = pipeline;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .without_plots();
    targets = all
}
criterion_main!(pipeline);
