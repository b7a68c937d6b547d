//! Times of the wave calculation: `cargo bench --bench kirchhoff`. One thread; Gaussian map of 1024 x 1024 points, Sq 0.1 um,
//! autocorrelation length 10 um, pitch 0.5 um, 550 nm.

use asperity::facets::SlopeStatistics;
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::optics::Material;
use asperity::scatter::kirchhoff::{Coherent, Spectrum, WaveField, Windows};
use asperity::scatter::{HalfVectorCells, Method, Options, Wave, scatter};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const GLASS: Material = Material::Dielectric { n: 1.5 };

fn map(edges: Edges) -> HeightMap {
    let grid = synth::Grid { width: 1024, height: 1024, pitch: [0.5e-6; 2] };
    let surface = synth::Gaussian { sq: 0.1e-6, acl: 10e-6, seed: 1, exact: true };
    level::keep_tilt(&synth::gaussian(grid, surface).expect("a usable grid"), edges)
}

fn one_slice(c: &mut Criterion) {
    let map = map(Edges::Periodic);
    let window = &Windows::choose(&map).list[0];
    let v_z = 2e7;
    let mut g = c.benchmark_group("1 one v_z, per point");
    g.sample_size(10).throughput(Throughput::Elements(1 << 20));
    g.bench_function("mean of the phase factor", |b| b.iter(|| Coherent::measure(black_box(&map), v_z)));
    let mean = Coherent::measure(&map, v_z).mean;
    g.bench_function("phase integral by FFT", |b| b.iter(|| Spectrum::measure(black_box(&map), window, v_z, mean)));
    g.finish();
}

fn all_angles(c: &mut Criterion) {
    let mut g = c.benchmark_group("2 1024 x 1024, all incident angles");
    g.sample_size(10);
    for (name, edges) in [("periodic", Edges::Periodic), ("16 Hann windows", Edges::Open)] {
        let map = map(edges);
        let statistics = SlopeStatistics::measure(&map).expect("facets");
        let field = WaveField::new(&map, &statistics, Wave::default());
        let core = field.lobe_core(field.v_z(1.0, 1.0), &statistics, true);
        let cells = HalfVectorCells::for_core(&statistics, core, true, 0.01);
        let range = [88f64.to_radians().cos(), 1.0];
        g.bench_function(format!("windows, {name}"), |b| b.iter(|| Windows::choose(black_box(&map))));
        g.bench_function(format!("width of the lobe, {name}"), |b| {
            b.iter(|| field.lobe_core(field.v_z(1.0, 1.0), &statistics, true));
        });
        g.bench_function(format!("slices into cells, {name}"), |b| {
            b.iter(|| field.density(black_box(&cells), true, range, &|_| ()));
        });
        let density = field.density(&cells, true, range, &|_| ());
        let hiding = statistics.hiding();
        g.bench_function(format!("one incident angle, {name}"), |b| {
            b.iter(|| density.tally(black_box(&cells), direction(1.0, 0.0), 0.5, &GLASS, &hiding));
        });
        let options = Options { method: Method::Kirchhoff, ..Options::default() };
        g.bench_function(format!("scatter, 14 angles, {name}"), |b| {
            b.iter(|| scatter(black_box(&map), &options, &|_| ()).expect("a usable map"));
        });
    }
    g.finish();
}

fn one_thread(c: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool yet");
    one_slice(c);
    all_angles(c);
}

criterion_group!(benches, one_thread);
criterion_main!(benches);
