//! Scenes whose radiance can be written down.

use crate::materials::{Beckmann, Lambert, Mirror};
use asperity::math::frame::{DVec3, direction};
use asperity::optics::brdf::Brdf;
use asperity::render::{Camera, Estimator, Film, Material, Paint, Pattern, Quad, RenderOptions, Scene, Sphere, render};

pub fn grey(x: f64) -> Paint {
    Paint::plain(DVec3::splat(x)).unwrap()
}

pub fn plain(brdf: &dyn Brdf) -> Material<'_> {
    Material { brdf, tint: grey(1.0) }
}

/// A square of the given side in the plane z = 0, facing up.
pub fn floor(side: f64) -> Quad {
    Quad::new(DVec3::new(-side / 2.0, -side / 2.0, 0.0), side * DVec3::X, side * DVec3::Y).unwrap()
}

fn options(side: usize, samples_per_pixel: u32) -> RenderOptions {
    RenderOptions { width: side, height: side, samples_per_pixel, ..RenderOptions::default() }
}

fn shoot(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Film {
    render(scene, camera, options, &|_| {}).unwrap()
}

/// Mean of the film in green with its standard error.
fn mean(film: &Film) -> (f64, f64) {
    let n = film.pixels().len() as f64;
    let sum: f64 = film.pixels().iter().map(|p| f64::from(p.radiance[1])).sum();
    let variance: f64 = film.pixels().iter().map(|p| f64::from(p.standard_error[1]).powi(2)).sum();
    (sum / n, variance.sqrt() / n)
}

/// A camera that sees a patch of a millimetre about the origin from `theta`.
fn close_up(theta: f64) -> Camera {
    Camera::orthographic(direction(theta, 0.3), DVec3::ZERO, DVec3::Z, 1e-3, 1.0).unwrap()
}

/// Under a sky of radiance 1 a surface that absorbs nothing has radiance 1, in the gap between two balls too.
#[test]
fn a_white_furnace_shows_nothing() {
    let white = Lambert(1.0);
    let mut scene = Scene::new(DVec3::ONE).unwrap();
    scene.add(Sphere::new(DVec3::new(-1.0, 0.0, 0.0), 1.0).unwrap(), plain(&white));
    scene.add(Sphere::new(DVec3::new(1.0, 0.0, 0.0), 1.0).unwrap(), plain(&white));
    let camera = Camera::perspective(8.0 * DVec3::Y, DVec3::ZERO, DVec3::Z, 0.5, 1.0).unwrap();
    let deep = RenderOptions { max_reflections: 1000, ..options(24, 64) };
    for pixel in shoot(&scene, &camera, &deep).pixels() {
        for (value, error) in pixel.radiance.iter().zip(pixel.standard_error) {
            assert!((value - 1.0).abs() <= 4.0 * error + 1e-6, "{value} +- {error}");
        }
    }
    let mut mirrors = Scene::new(DVec3::ONE).unwrap();
    mirrors.add(Sphere::new(DVec3::ZERO, 1.0).unwrap(), plain(&Mirror));
    mirrors.add(floor(20.0), plain(&Mirror));
    let high = Camera::perspective(DVec3::new(0.0, -6.0, 3.0), DVec3::ZERO, DVec3::Z, 0.8, 1.0).unwrap();
    let film = shoot(&mirrors, &high, &RenderOptions { max_reflections: 1000, ..options(24, 16) });
    assert!(film.pixels().iter().all(|p| p.radiance == [1.0; 3] && p.standard_error == [0.0; 3] && p.samples == 16));
}

/// A ball of radiance L and angular radius a at theta gives `E = pi L sin^2 a cos theta`, and `rho E / pi` to the camera.
#[test]
fn a_ball_lamp_lights_the_floor_as_it_should() {
    let (rho, radiance) = (0.6, 25.0);
    let matt = Lambert(rho);
    for (degrees, sin_a) in [(0.0f64, 0.3f64), (40.0, 0.1), (70.0, 0.02)] {
        let theta = degrees.to_radians();
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        scene.add(floor(10.0), plain(&matt));
        let ball = Sphere::new(3.0 * direction(theta, 0.0), 3.0 * sin_a).unwrap();
        scene.add_emitter(ball, grey(radiance)).unwrap();
        let camera = Camera::orthographic(direction(0.9, 2.0), DVec3::ZERO, DVec3::Z, 1e-3, 1.0).unwrap();
        let (value, error) = mean(&shoot(&scene, &camera, &options(32, 256)));
        let expected = rho * radiance * sin_a * sin_a * theta.cos();
        assert!((value - expected).abs() <= 4.0 * error, "{degrees} deg: {value} +- {error}, expected {expected}");
        assert!((value / expected - 1.0).abs() < 2e-3, "{degrees} deg: {value}, expected {expected}");
    }
}

/// A square lamp of side 2 h facing the floor at height h: `E = 4 L sum` of the corner formula,
/// `E_corner = L / 2 (X / sqrt(1 + X^2) atan(Y / sqrt(1 + X^2)) + same with X and Y exchanged)`, X = Y = 1.
#[test]
fn a_square_lamp_lights_the_floor_as_it_should() {
    let (rho, radiance, h) = (0.5, 3.0, 0.8);
    let matt = Lambert(rho);
    let mut scene = Scene::new(DVec3::ZERO).unwrap();
    scene.add(floor(10.0), plain(&matt));
    let lamp = Quad::new(DVec3::new(-h, -h, h), 2.0 * h * DVec3::Y, 2.0 * h * DVec3::X).unwrap();
    scene.add_emitter(lamp, grey(radiance)).unwrap();
    let side = DVec3::new(5.0, 0.0, 0.5);
    let camera = Camera::orthographic(side, DVec3::ZERO, DVec3::Z, 1e-3, 1.0).unwrap();
    let (value, error) = mean(&shoot(&scene, &camera, &options(32, 256)));
    let root = 2f64.sqrt();
    let irradiance = 4.0 * radiance / 2.0 * (2.0 / root * (1.0 / root).atan());
    let expected = rho * irradiance / std::f64::consts::PI;
    assert!((value - expected).abs() <= 4.0 * error, "{value} +- {error}, expected {expected}");
    assert!((value / expected - 1.0).abs() < 2e-3);
}

/// A mirror shows the lamp with the radiance of the lamp, and only its front.
#[test]
fn a_mirror_shows_the_radiance_of_the_lamp() {
    let mut scene = Scene::new(DVec3::new(0.1, 0.2, 0.3)).unwrap();
    scene.add(floor(1.0), plain(&Mirror));
    let theta = 50f64.to_radians();
    let ball = Sphere::new(direction(theta, 0.3 + std::f64::consts::PI), 0.2).unwrap();
    scene.add_emitter(ball, Paint::plain(DVec3::new(5.0, 6.0, 7.0)).unwrap()).unwrap();
    for estimator in [Estimator::Brdf, Estimator::Lights, Estimator::Mis] {
        let seen = shoot(&scene, &close_up(theta), &RenderOptions { estimator, ..options(4, 16) });
        assert!(seen.pixels().iter().all(|p| p.radiance == [5.0, 6.0, 7.0]));
        let missed = shoot(&scene, &close_up(theta + 0.4), &options(4, 16));
        assert!(missed.pixels().iter().all(|p| p.radiance == [0.1, 0.2, 0.3]));
    }
    let mut behind = Scene::new(DVec3::ONE).unwrap();
    behind.add_emitter(floor(1.0), grey(5.0)).unwrap();
    let below = Camera::orthographic(-DVec3::Z, DVec3::ZERO, DVec3::Y, 1e-3, 1.0).unwrap();
    assert!(shoot(&behind, &below, &options(2, 4)).pixels().iter().all(|p| p.radiance == [0.0; 3]));
}

/// A glossy floor under a checker and a ball, with a matt wall: the mean may not depend on how light is found.
#[test]
fn all_strategies_have_the_same_mean() {
    let glossy = Beckmann { alpha: 0.25, n: 1.5 };
    let matt = Lambert(0.7);
    let mut scene = Scene::new(DVec3::splat(0.2)).unwrap();
    scene.add(floor(4.0), plain(&glossy));
    let wall = Quad::new(DVec3::new(-2.0, -1.0, 0.0), 2.0 * DVec3::Y, 1.5 * DVec3::Z).unwrap();
    scene.add(wall, plain(&matt));
    let checker = Paint::new(Pattern::Checker { columns: 3, rows: 4 }, DVec3::splat(9.0), DVec3::splat(1.0)).unwrap();
    let panel = Quad::new(DVec3::new(1.2, -1.0, 0.1), 2.0 * DVec3::Y, 1.5 * DVec3::Z).unwrap();
    let panel_front = Quad::new(DVec3::new(1.2, -1.0, 0.1), 1.5 * DVec3::Z, 2.0 * DVec3::Y).unwrap();
    assert!(panel.normal().x > 0.0 && panel_front.normal().x < 0.0);
    scene.add_emitter(panel_front, checker).unwrap();
    scene.add_emitter(Sphere::new(DVec3::new(0.0, 0.5, 1.5), 0.3).unwrap(), grey(20.0)).unwrap();
    let camera = Camera::perspective(DVec3::new(-1.8, 0.0, 0.9), DVec3::ZERO, DVec3::Z, 0.7, 1.0).unwrap();
    let estimates: Vec<(f64, f64)> = [Estimator::Brdf, Estimator::Lights, Estimator::Mis]
        .into_iter()
        .enumerate()
        .map(|(i, estimator)| {
            let options = RenderOptions { estimator, seed: 10 + i as u64, ..options(24, 1024) };
            mean(&shoot(&scene, &camera, &options))
        })
        .collect();
    let (value, error) = estimates[2];
    assert!(error < 0.01 * value);
    for (other, other_error) in &estimates[..2] {
        assert!((value - other).abs() <= 4.0 * error.hypot(*other_error), "{estimates:?}");
        assert!(error <= *other_error, "the combination must not be worse: {estimates:?}");
    }
}

#[test]
fn impossible_pictures_are_refused() {
    let scene = Scene::new(DVec3::ONE).unwrap();
    assert!(render(&scene, &close_up(0.5), &options(0, 1), &|_| {}).is_err());
    assert!(render(&scene, &close_up(0.5), &options(1, 0), &|_| {}).is_err());
    let broken = Lambert(f64::NAN);
    let mut scene = Scene::new(DVec3::ONE).unwrap();
    scene.add(floor(1.0), plain(&broken));
    let message = render(&scene, &close_up(0.5), &options(2, 1), &|_| {}).unwrap_err().to_string();
    assert!(message.contains("pixel (0, 0)"), "{message}");
    assert!(Scene::new(DVec3::splat(-1.0)).is_err());
}
