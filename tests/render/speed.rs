//! Not a test but a clock: `cargo test --release --test render -- --ignored --nocapture speed`.

use crate::closed_forms::{floor, grey, plain};
use crate::materials::{Beckmann, Lambert};
use asperity::math::frame::DVec3;
use asperity::render::{Camera, Material, Paint, Pattern, RenderOptions, Scene, Sphere, render};
use std::time::Instant;

/// Four glossy spheres, six lamps, checker floor, depth 4.
#[test]
#[ignore = "a measurement"]
fn speed_of_four_spheres() {
    let glossy = [0.01, 0.03, 0.1, 0.3].map(|alpha| Beckmann { alpha, n: 1.5 });
    let matt = Lambert(0.8);
    let mut scene = Scene::new(DVec3::splat(0.1)).unwrap();
    let chess = Paint::new(Pattern::Checker { columns: 20, rows: 20 }, DVec3::ONE, DVec3::splat(0.2)).unwrap();
    scene.add(floor(20.0), Material { brdf: &matt, tint: chess });
    for (i, brdf) in glossy.iter().enumerate() {
        let x = 2.2 * (i as f64 - 1.5);
        scene.add(Sphere::new(DVec3::new(x, 0.0, 1.0), 1.0).unwrap(), plain(brdf));
    }
    for i in 0..6 {
        let centre = DVec3::new(2.0 * (f64::from(i) - 2.5), -2.0, 6.0);
        scene.add_emitter(Sphere::new(centre, 0.3).unwrap(), grey(40.0)).unwrap();
    }
    let camera = Camera::perspective(DVec3::new(0.0, -9.0, 4.0), DVec3::Z, DVec3::Z, 0.6, 2.0).unwrap();
    let shape =
        RenderOptions { width: 400, height: 200, samples_per_pixel: 64, max_reflections: 4, ..Default::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for lights_asked in [0, 8] {
        let options = RenderOptions { lights_asked, ..shape };
        for _ in 0..3 {
            let start = Instant::now();
            pool.install(|| render(&scene, &camera, &options, &|_| {})).unwrap();
            let rate = 400.0 * 200.0 * 64.0 / start.elapsed().as_secs_f64() / 1e6;
            println!("lights_asked {lights_asked}: {rate:.2} million samples/s on one core");
        }
    }
}
