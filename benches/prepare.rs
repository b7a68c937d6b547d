//! Preparing a map of 4096 x 4096 points on one thread: median times, and the peak memory of levelling.
//!
//! `cargo bench --bench prepare`

use asperity::heightmap::{Edges, HeightMap, RawMap, despike, fill, filter, form, level, noise};
use criterion::{BatchSize, Criterion};
use ndarray::Array2;
use std::hint::black_box;

const SIDE: usize = 4096;

/// Roughness on a tilt at 76 mm; every `gap`-th point is missing.
fn raw(gap: usize) -> RawMap {
    let mut state = 1u64;
    let heights = Array2::from_shape_fn((SIDE, SIDE), |(r, c)| {
        // A linear congruence is rough enough and costs nothing.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let rough = (state >> 40) as f64 * 1e-14;
        if gap > 0 && (r * SIDE + c).is_multiple_of(gap) { f64::NAN } else { 0.076 + 1e-9 * (3 * c + r) as f64 + rough }
    });
    RawMap { heights, pitch_x: 0.5e-6, pitch_y: 0.5e-6, format: "bench", notes: vec![] }
}

/// Peak and present resident memory in MB, where the system tells.
fn memory() -> Option<[f64; 2]> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let field = |name: &str| {
        let line = status.lines().find(|l| l.starts_with(name))?;
        Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024e-6)
    };
    Some([field("VmHWM")?, field("VmRSS")?])
}

fn levelling(c: &mut Criterion) {
    let whole = raw(0);
    let before = memory();
    let map = level::level(&whole, Edges::Open).unwrap();
    if let (Some([_, now]), Some([peak, _])) = (before, memory()) {
        let heights = (SIDE * SIDE * 4) as f64 * 1e-6;
        println!(
            "levelling: peak {peak:.0} MB in all, {:.0} MB beyond the f64 heights; the f32 heights are {heights:.0} MB",
            peak - now
        );
    }
    c.bench_function("level, f64 heights", |b| b.iter(|| level::level(black_box(&whole), Edges::Open)));
    let copy = |map: &HeightMap| map.clone();
    c.bench_function("level again, f32 heights", |b| {
        b.iter_batched_ref(|| copy(&map), level::level_again, BatchSize::PerIteration);
    });
    drop(whole);
    let gappy = raw(97);
    c.bench_function("level, f64 heights, 1 % missing", |b| b.iter(|| level::level(black_box(&gappy), Edges::Open)));
}

fn rest(c: &mut Criterion) {
    let gappy = raw(97);
    for (name, form) in [("polynomial of degree 4", form::Form::Polynomial(4)), ("sphere", form::Form::Sphere)] {
        c.bench_function(name, |b| b.iter(|| form::remove(black_box(&gappy), form, Edges::Open)));
    }
    c.bench_function("despike 3 x 3", |b| {
        b.iter_batched_ref(
            || gappy.clone(),
            |raw| despike::despike(raw, despike::Despike::default()),
            BatchSize::PerIteration,
        );
    });
    let map = level::level(&gappy, Edges::Open).unwrap();
    drop(gappy);
    c.bench_function("fill 1 % single points", |b| {
        b.iter_batched_ref(|| map.clone(), |m| fill::fill(m, fill::Fill::default()), BatchSize::PerIteration);
    });
    for (name, cut_off) in [("S-filter of 5 pitches", 2.5e-6), ("L-filter of 1600 pitches", 0.8e-3)] {
        c.bench_function(name, |b| {
            b.iter_batched_ref(
                || map.clone(),
                |m| filter::gaussian(m, cut_off, filter::Pass::Long),
                BatchSize::PerIteration,
            );
        });
    }
    c.bench_function("slopes against noise", |b| b.iter(|| noise::slope_noise(black_box(&map), 1e-9, None)));
}

fn main() {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    threads.install(|| {
        let mut criterion = Criterion::default().sample_size(10).configure_from_args();
        levelling(&mut criterion);
        rest(&mut criterion);
        criterion.final_summary();
    });
}
