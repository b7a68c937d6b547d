//! Numbers of ISO 25178-2 on a 4096 x 4096 map, one thread. Budget: Sq + Sa + Sdq + Sdr together <= 0.15 s.

use asperity::heightmap::parameters::{Gradient, Heights};
use asperity::heightmap::{Edges, HeightMap};
use criterion::{Criterion, criterion_group, criterion_main};

/// A rough map from a cheap hash: the numbers do not depend on what the heights are.
fn rough_map() -> HeightMap {
    let heights = ndarray::Array2::from_shape_fn((4096, 4096), |(r, c)| {
        let x = (r as u32).wrapping_mul(0x9E37_79B9) ^ (c as u32).wrapping_mul(0x85EB_CA6B);
        1e-7 * (x.wrapping_mul(0xC2B2_AE35) >> 8) as f32 / 16_777_216.0
    });
    HeightMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, edges: Edges::Open, removed_slopes: [0.0; 2] }
}

fn parameters(c: &mut Criterion) {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    let map = rough_map();
    let mut group = c.benchmark_group("parameters_4096");
    group.sample_size(20);
    group.bench_function("Sq Sa Ssk Sku Sp Sv", |b| b.iter(|| one_thread.install(|| Heights::measure(&map))));
    group.bench_function("Sdq Sdr", |b| b.iter(|| one_thread.install(|| Gradient::measure(&map))));
    group.bench_function("Sq Sa Sdq Sdr together", |b| {
        b.iter(|| one_thread.install(|| (Heights::measure(&map), Gradient::measure(&map))));
    });
    group.finish();
}

criterion_group!(benches, parameters);
criterion_main!(benches);
