//! Time of one evaluation, density and draw of every model: `cargo bench --bench models`.
//!
//! One thread. Directions are drawn beforehand: half of them within the lobe by the model's own sampler, half over the
//! whole hemisphere, at angles of incidence from 0 to 85 deg.

use asperity::math::{direction, random::CounterRng};
use asperity::model::{MODELS, parse};
use asperity::optics::Brdf;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

const PAIRS: usize = 1024;

/// Forms beside the examples of the registry.
const MORE: [&str; 10] = [
    "oren-nayar:rho=0.8,sigma=20deg,form=qualitative",
    "phong:rho_s=0.5,exponent=100.5,form=original",
    "lafortune:c_xy=-1.1,c_z=1.01,exponent=15.6,c_xy2=-1.06,c_z2=0.66,exponent2=88.9,c_xy3=-1.01,c_z3=1.0,exponent3=184",
    "ward:rho_s=0.5,alpha_x=0.1,alpha_y=0.3,form=duer",
    "ward:rho_s=0.5,alpha=0.2,form=bounded",
    "beckmann:alpha=0.3,material=cu",
    "ggx:alpha_x=0.1,alpha_y=0.3,material=cu",
    "he-torrance:sigma=0.05um,tau=3um,n=1.5",
    "he-torrance:sigma=1um,tau=15um,n=1.5",
    "layered:ggx:alpha=0.1,n=1.5,over=lambert:rho=0.5",
];

fn pairs(brdf: &dyn Brdf) -> Vec<(DVec3, DVec3)> {
    let mut rng = CounterRng::new(1, 0, 0);
    let mut pairs = Vec::new();
    while pairs.len() < PAIRS {
        let wi = direction(85f64.to_radians() * rng.uniform(), TAU * rng.uniform());
        let own = pairs.len() % 2 == 0;
        let u = [rng.uniform(), rng.uniform()];
        let wo = match brdf.sample(wi, u) {
            Some(draw) if own => draw.wo,
            _ => direction(u[0].sqrt().asin(), TAU * u[1]),
        };
        pairs.push((wi, wo));
    }
    pairs
}

fn models(c: &mut Criterion) {
    let texts = MODELS.iter().map(|m| m.example).chain(MORE);
    let all: Vec<_> = texts
        .map(|text| {
            let brdf = parse(text, 550e-9).expect(text);
            let pairs = pairs(brdf.as_ref());
            // The tables behind the albedo are not what is timed.
            black_box(brdf.albedo(0.5));
            (text, brdf, pairs)
        })
        .collect();
    type Work = fn(&dyn Brdf, DVec3, DVec3) -> f64;
    let draw: Work = |b, wi, wo| b.sample(wi, [wo.z.fract(), (wo.x + 1.0) * 0.49]).map_or(0.0, |s| s.weight);
    let kinds: [(&str, Work); 3] =
        [("eval", |b, wi, wo| b.eval(wi, wo)), ("pdf", |b, wi, wo| b.pdf(wi, wo)), ("sample", draw)];
    for (kind, work) in kinds {
        let mut group = c.benchmark_group(kind);
        group.throughput(Throughput::Elements(PAIRS as u64));
        group.sample_size(10).warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_millis(200));
        for (text, brdf, pairs) in &all {
            group.bench_function(*text, |b| {
                b.iter(|| pairs.iter().map(|&(wi, wo)| work(black_box(brdf.as_ref()), wi, wo)).sum::<f64>());
            });
        }
    }
}

criterion_group!(benches, models);
criterion_main!(benches);
