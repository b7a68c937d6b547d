//! The path tracer on the scene of the budget: four glossy spheres, six lamps, checker floor, depth 4, one core; the hierarchy
//! of a mesh; the picture with and without a stop at an error.

use asperity::math::frame::DVec3;
use asperity::model;
use asperity::render::{
    Camera, Coat, Cover, Estimator, Mesh, Paint, Quad, Reflector, RenderOptions, Scene, Sphere, render, revolution,
};
use asperity::scatter;
use asperity::table::{Provenance, Table};
use asperity::{heightmap, optics::Brdf, sample::TableBrdf};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const SIDE: usize = 256;
const PATHS: u32 = 16;

/// The scene; its camera sees spheres, floor and sky about as fig. 7 of the paper does.
fn scene<'a>(glossy: &[&'a dyn Brdf], matt: &'a model::Lambert) -> (Scene<'a>, Camera) {
    let mut scene = Scene::new(DVec3::splat(0.1)).expect("a sky");
    let coat = |x: f64| Coat::new(Reflector::Grey(matt), DVec3::splat(x));
    let floor = Quad::new(DVec3::new(-10.0, -10.0, 0.0), DVec3::X * 20.0, DVec3::Y * 20.0).expect("a floor");
    scene.add(floor, Cover::Checker([coat(0.8), coat(0.15)], 1.0));
    for (i, brdf) in glossy.iter().enumerate() {
        let centre = DVec3::new(2.2 * (i as f64 - 1.5), 0.0, 1.0);
        let cover = Cover::Plain(Coat::new(Reflector::Grey(*brdf), DVec3::ONE));
        scene.add(Sphere::new(centre, 1.0).expect("a sphere"), cover);
    }
    for i in 0..6 {
        let centre = DVec3::new(2.0 * (f64::from(i) - 2.5), -2.0, 6.0);
        let glow = Paint::plain(DVec3::splat(40.0)).expect("a paint");
        scene.add_emitter(Sphere::new(centre, 0.3).expect("a lamp"), glow).expect("a lamp");
    }
    let eye = DVec3::new(0.0, -9.0, 4.0);
    let camera = Camera::perspective(eye, 0.6 * DVec3::Z, DVec3::Z, 45f64.to_radians(), 1.0).expect("a camera");
    (scene, camera)
}

fn table(alpha: f64) -> TableBrdf {
    let grid = heightmap::synth::Grid { width: 512, height: 512, pitch: [0.5e-6, 0.5e-6] };
    let surface = heightmap::synth::Gaussian { sq: 0.5 * alpha * 10e-6, acl: 10e-6, seed: 1, exact: true };
    let map = heightmap::synth::gaussian(grid, surface).expect("a surface");
    let map = heightmap::level::level(&map, heightmap::Edges::Periodic).expect("a level map");
    let options = scatter::Options { method: scatter::Method::Geometric, ..scatter::Options::default() };
    let scattered = scatter::scatter(&map, &options, &|_| ()).expect("scattered light");
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).expect("a sampler")
}

fn four_spheres(c: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first use of the pool");
    let matt = model::Lambert { rho: 1.0 };
    let models = ["0.3", "0.1", "0.03", "0.01"]
        .map(|alpha| model::parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).expect("a model"));
    let tables = [0.17, 0.07, 0.02, 0.007].map(table);
    let by_model: Vec<&dyn Brdf> = models.iter().map(|m| m.as_ref()).collect();
    let by_table: Vec<&dyn Brdf> = tables.iter().map(|t| t as &dyn Brdf).collect();
    let white: Vec<&dyn Brdf> = vec![&matt; 4];
    let mut group = c.benchmark_group("four spheres, paths");
    group.sample_size(10).throughput(Throughput::Elements((SIDE * SIDE) as u64 * u64::from(PATHS)));
    let options = RenderOptions {
        width: SIDE,
        height: SIDE,
        samples_per_pixel: PATHS,
        max_reflections: 3,
        ..RenderOptions::default()
    };
    for (name, brdfs) in [("tables", &by_table), ("models", &by_model), ("matt", &white)] {
        let (scene, camera) = scene(brdfs, &matt);
        group.bench_function(name, |b| b.iter(|| render(&scene, &camera, &options, &|_| ()).expect("a film")));
    }
    let (scene, camera) = scene(&by_table, &matt);
    for (name, estimator) in [("tables, uniform", Estimator::Uniform), ("tables, direct", Estimator::Direct)] {
        let options = RenderOptions { estimator, ..options };
        group.bench_function(name, |b| b.iter(|| render(&scene, &camera, &options, &|_| ()).expect("a film")));
    }
    group.finish();
}

/// 1e5 triangles of a vase: building the hierarchy.
fn mesh(c: &mut Criterion) {
    let n = 9;
    let profile: Vec<[f64; 2]> =
        (0..n).map(|k| [0.3 + 0.2 * (1.7 * f64::from(k)).sin(), 0.25 * f64::from(k)]).collect();
    let vase = revolution(&profile, true).expect("a vase");
    let mut group = c.benchmark_group("mesh");
    group.sample_size(10).throughput(Throughput::Elements(vase.len() as u64));
    let still = glam::DAffine3::IDENTITY;
    group.bench_function("build", |b| b.iter(|| -> Mesh { vase.transformed(&still).expect("a vase") }));
    group.finish();
}

criterion_group!(scenes, four_spheres, mesh);
criterion_main!(scenes);
