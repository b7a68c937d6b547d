//! The path tracer on the scene of the budget: four glossy spheres, six lamps, checker floor, depth 4, one core.

use asperity::math::frame::DVec3;
use asperity::model::{self, Lambert};
use asperity::render::{Camera, Material, Paint, Pattern, Quad, RenderOptions, Scene, Sphere, render};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const WIDTH: usize = 200;
const HEIGHT: usize = 100;
const PATHS: u32 = 16;

fn four_spheres(c: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first use of the pool");
    let glossy = ["0.01", "0.03", "0.1", "0.3"]
        .map(|alpha| model::parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).expect("a model"));
    let matt = Lambert { rho: 0.8 };
    let mut scene = Scene::new(DVec3::splat(0.1)).expect("a sky");
    let chess = Paint::new(Pattern::Checker { columns: 20, rows: 20 }, DVec3::ONE, DVec3::splat(0.2)).expect("a paint");
    let floor = Quad::new(DVec3::new(-10.0, -10.0, 0.0), DVec3::X * 20.0, DVec3::Y * 20.0).expect("a floor");
    scene.add(floor, Material { brdf: &matt, tint: chess });
    for (i, brdf) in glossy.iter().enumerate() {
        let centre = DVec3::new(2.2 * (i as f64 - 1.5), 0.0, 1.0);
        let tint = Paint::plain(DVec3::ONE).expect("a paint");
        scene.add(Sphere::new(centre, 1.0).expect("a sphere"), Material { brdf: brdf.as_ref(), tint });
    }
    for i in 0..6 {
        let centre = DVec3::new(2.0 * (f64::from(i) - 2.5), -2.0, 6.0);
        let glow = Paint::plain(DVec3::splat(40.0)).expect("a paint");
        scene.add_emitter(Sphere::new(centre, 0.3).expect("a lamp"), glow).expect("a lamp");
    }
    let camera = Camera::perspective(DVec3::new(0.0, -9.0, 4.0), DVec3::Z, DVec3::Z, 0.6, 2.0).expect("a camera");
    let mut group = c.benchmark_group("four spheres, per path");
    group.sample_size(10).throughput(Throughput::Elements((WIDTH * HEIGHT) as u64 * u64::from(PATHS)));
    for (name, lights_asked) in [("one light drawn", 0), ("every light asked", 8)] {
        let options = RenderOptions {
            width: WIDTH,
            height: HEIGHT,
            samples_per_pixel: PATHS,
            max_reflections: 4,
            lights_asked,
            ..RenderOptions::default()
        };
        group.bench_function(name, |b| b.iter(|| render(&scene, &camera, &options, &|_| ()).expect("a film")));
    }
    group.finish();
}

criterion_group!(scenes, four_spheres);
criterion_main!(scenes);
