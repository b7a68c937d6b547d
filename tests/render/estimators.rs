//! Every kind of shape, lamp and surroundings: closed forms, and one mean for all estimators.

use crate::closed_forms::{floor, grey, plain};
use crate::materials::Lambert;
use asperity::math::Estimate;
use asperity::math::frame::{DVec3, direction};
use asperity::model;
use asperity::optics::Brdf;
use asperity::render::{
    Camera, Coat, Cover, Disc, Environment, Estimator, Film, Mesh, Paint, Quad, Reflector, RenderOptions, Scene, Shape,
    Spectral, Sphere, exr_bytes, render, render_with_report, revolution, save_exr,
};
use std::f64::consts::PI;

fn options(side: usize, samples_per_pixel: u32) -> RenderOptions {
    RenderOptions { width: side, height: side, samples_per_pixel, ..RenderOptions::default() }
}

fn shoot(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Film {
    render(scene, camera, options, &|_| {}).unwrap()
}

/// Mean of the film in one channel.
fn mean(film: &Film, channel: usize) -> Estimate {
    let pixel = film.mean();
    Estimate { value: f64::from(pixel.radiance[channel]), standard_error: f64::from(pixel.standard_error[channel]) }
}

/// Sees a millimetre about the origin from `theta`.
fn close_up(theta: f64) -> Camera {
    let up = if theta < 0.1 { DVec3::Y } else { DVec3::Z };
    Camera::orthographic(direction(theta, 0.3), DVec3::ZERO, up, 1e-3, 1.0).unwrap()
}

/// Surroundings as they come from a file: one colour per pixel.
fn surroundings(width: usize, height: usize, radiance: impl Fn(usize, usize) -> [f32; 3]) -> Environment {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("e.exr");
    let mut small = Scene::new(DVec3::ONE).unwrap();
    small.add(Sphere::new(DVec3::Z, 0.1).unwrap(), plain(&Lambert(0.5)));
    let camera = Camera::perspective(DVec3::ZERO, DVec3::X, DVec3::Z, 1.0, width as f64 / height as f64).unwrap();
    let mut film = Film::new(width, height).unwrap();
    // A film is painted by pasting films of one pixel.
    for k in 0..width * height {
        let colour = DVec3::from(radiance(k % width, k / width).map(f64::from));
        let one = shoot(&Scene::new(colour).unwrap(), &camera, &options(1, 1));
        film.paste(&one, k % width, k / width);
    }
    save_exr(&film, "surroundings", &path).unwrap();
    Environment::new(&Film::load_exr(&path).unwrap().0, 1.0, 0.0).unwrap()
}

/// `E = pi L R^2 / (R^2 + h^2)` under the middle of a disc; the same square as quad and as mesh lights alike.
#[test]
fn discs_and_meshes_light_the_floor_as_they_should() {
    let (rho, radiance, h) = (0.5, 3.0, 0.8);
    let matt = Lambert(rho);
    let lit_by = |shape: Shape| {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        scene.add(floor(10.0), plain(&matt));
        scene.add_emitter(shape, grey(radiance)).unwrap();
        let side = Camera::orthographic(DVec3::new(5.0, 0.0, 0.5), DVec3::ZERO, DVec3::Z, 1e-3, 1.0).unwrap();
        mean(&shoot(&scene, &side, &options(24, 256)), 1)
    };
    let near = |got: Estimate, expected: f64| {
        assert!((got.value - expected).abs() <= 4.0 * got.standard_error, "{got:?}, expected {expected}");
        assert!((got.value / expected - 1.0).abs() < 2e-3, "{got:?}, expected {expected}");
    };
    let disc = Disc::new(h * DVec3::Z, -DVec3::Z, 0.5, 0.2).unwrap();
    let ring = |r: f64| r * r / (r * r + h * h);
    near(lit_by(disc.into()), rho * radiance * (ring(0.5) - ring(0.2)));
    let corners = [[-h, -h], [h, -h], [h, h], [-h, h]].map(|c| DVec3::new(c[0], c[1], h)).to_vec();
    let square = Mesh::new(corners, None, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    // As in closed_forms, X = Y = 1.
    let root = 2f64.sqrt();
    near(lit_by(square.into()), rho / PI * 4.0 * radiance / 2.0 * (2.0 / root * (1.0 / root).atan()));
}

/// Constant surroundings are a sky; those above the horizon alone light a floor as much.
#[test]
fn surroundings_light_as_a_sky_does() {
    let matt = Lambert(0.6);
    for below in [1.0, 0.0] {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        scene.add(floor(10.0), plain(&matt));
        scene.surround(surroundings(8, 4, |_, row| if row < 2 { [1.0, 2.0, 0.5] } else { [below; 3] }));
        for estimator in [Estimator::Mis, Estimator::Brdf, Estimator::Lights] {
            let film = shoot(&scene, &close_up(0.7), &RenderOptions { estimator, ..options(16, 256) });
            for (channel, radiance) in [1.0, 2.0, 0.5].into_iter().enumerate() {
                let got = mean(&film, channel);
                assert!((got.value / (0.6 * radiance) - 1.0).abs() < 2e-3, "{estimator:?} {got:?}");
            }
        }
    }
}

/// No light comes through the seams of a closed mesh, whatever shines outside.
#[test]
fn a_closed_mesh_is_dark_inside() {
    let matt = Lambert(0.9);
    let mut scene = Scene::new(DVec3::splat(100.0)).unwrap();
    scene.surround(surroundings(4, 2, |_, _| [50.0; 3]));
    let profile: Vec<[f64; 2]> =
        (0..=10).map(|k| PI * f64::from(k) / 10.0).map(|t| [t.sin().max(0.0), -t.cos()]).collect();
    let profile: Vec<[f64; 2]> =
        profile.iter().enumerate().map(|(k, p)| if k == 0 || k == 10 { [0.0, p[1]] } else { *p }).collect();
    scene.add(revolution(&profile, true).unwrap(), plain(&matt));
    scene.add_emitter(Sphere::new(3.0 * DVec3::X, 1.0).unwrap(), grey(1000.0)).unwrap();
    let inside = Camera::perspective(DVec3::new(0.2, 0.1, 0.3), DVec3::ZERO, DVec3::Y, 1.5, 1.0).unwrap();
    let film = shoot(&scene, &inside, &options(48, 64));
    assert!(film.pixels().iter().all(|p| p.radiance == [0.0; 3]));
}

/// A glossy floor and vase among a ring, a triangle, a ball and bright surroundings.
#[test]
fn all_estimators_have_the_same_mean_for_every_lamp() {
    let glossy = model::parse("beckmann:alpha=0.25,n=1.5", 550e-9).unwrap();
    let copper = Spectral::new(&|w| model::parse("ggx:alpha=0.3,material=cu", w)).unwrap();
    let mirror = model::parse("mirror", 550e-9).unwrap();
    let matt = Lambert(0.7);
    let mut scene = Scene::new(DVec3::splat(0.1)).unwrap();
    scene.surround(surroundings(8, 4, |x, y| if (x, y) == (2, 0) { [9.0, 5.0, 1.0] } else { [0.2, 0.3, 0.4] }));
    scene.add(floor(4.0), plain(glossy.as_ref()));
    scene.add(Quad::new(DVec3::new(-1.5, 1.0, 0.0), 3.0 * DVec3::X, DVec3::Z).unwrap(), plain(&matt));
    scene.add(Sphere::new(DVec3::new(-0.8, 0.2, 0.4), 0.4).unwrap(), plain(mirror.as_ref()));
    let vase = revolution(&[[0.0, 0.0], [0.3, 0.0], [0.4, 0.4], [0.2, 0.8]], true).unwrap();
    scene.add(vase, Cover::Plain(Coat::new(Reflector::Spectral(&copper), DVec3::ONE)));
    scene.add_emitter(Disc::new(DVec3::new(0.8, 0.0, 1.5), -DVec3::Z, 0.4, 0.1).unwrap(), grey(10.0)).unwrap();
    let corners = vec![DVec3::new(-1.0, -0.6, 1.0), DVec3::new(-1.0, 0.2, 1.0), DVec3::new(-0.4, -0.2, 1.4)];
    scene.add_emitter(Mesh::new(corners, None, vec![[0, 1, 2]]).unwrap(), grey(15.0)).unwrap();
    scene.add_emitter(Sphere::new(DVec3::new(0.7, -0.4, 0.3), 0.1).unwrap(), grey(30.0)).unwrap();
    let eye = DVec3::new(0.4, -2.5, 1.4);
    let camera = Camera::perspective(eye, DVec3::new(0.0, 0.2, 0.3), DVec3::Z, 0.7, 1.0).unwrap();
    let estimators = [Estimator::Mis, Estimator::Brdf, Estimator::Lights, Estimator::Uniform];
    let films = estimators.map(|estimator| {
        let seed = 10 + estimator as u64;
        shoot(&scene, &camera, &RenderOptions { estimator, seed, ..options(24, 1024) })
    });
    for channel in 0..3 {
        let all = films.each_ref().map(|film| mean(film, channel));
        assert!(all[0].standard_error < 0.01 * all[0].value, "{all:?}");
        for other in &all[1..] {
            let error = all[0].standard_error.hypot(other.standard_error);
            assert!((all[0].value - other.value).abs() <= 4.0 * error, "channel {channel}: {all:?}");
        }
    }
    // Direct light is less than all light, and the picture is not grey.
    let direct = shoot(&scene, &camera, &RenderOptions { estimator: Estimator::Direct, ..options(24, 256) });
    assert!(mean(&direct, 1).value < 0.97 * mean(&films[0], 1).value);
    let [red, blue] = [0, 2].map(|channel| mean(&films[0], channel).value);
    assert!((red / blue - 1.0).abs() > 0.02, "{red} {blue}");
}

/// Under a sky of radiance 1 a flat tile shows its albedo: 1 less what the model or the table documents as lost.
#[test]
fn a_furnace_shows_the_albedo() {
    let texts = ["lambert:rho=1", "mirror", "ggx:alpha=0.1,material=mirror", "ward:rho_s=1,alpha=0.2,form=bounded"];
    let mut brdfs: Vec<Box<dyn Brdf>> = texts.iter().filter_map(|text| model::parse(text, 550e-9).ok()).collect();
    assert!(brdfs.len() >= 3);
    brdfs.push(Box::new(mirror_table()));
    for (k, brdf) in brdfs.iter().enumerate() {
        for theta in [0.0, 0.5, 1.0] {
            let mut scene = Scene::new(DVec3::ONE).unwrap();
            scene.add(floor(1.0), plain(brdf.as_ref()));
            let albedo = brdf.albedo(theta);
            assert!(albedo > 0.85 && albedo < 1.0 + 1e-3, "{k}: {albedo}");
            for pixel in shoot(&scene, &close_up(theta), &options(12, 256)).pixels() {
                let (value, error) = (f64::from(pixel.radiance[1]), f64::from(pixel.standard_error[1]));
                // The albedo of a table is itself a sum over its cells, good to 1e-3.
                assert!((value - albedo).abs() <= 4.0 * error + 1e-3, "{k} at {theta}: {value} +- {error}, {albedo}");
            }
        }
    }
}

/// A rough perfect mirror, tabulated from facets.
fn mirror_table() -> asperity::sample::TableBrdf {
    use asperity::{heightmap, optics, sample, scatter, table};
    let grid = heightmap::synth::Grid { width: 256, height: 256, pitch: [0.5e-6, 0.5e-6] };
    let surface = heightmap::synth::Gaussian { sq: 0.3e-6, acl: 8e-6, seed: 4, exact: true };
    let map = heightmap::synth::gaussian(grid, surface).unwrap();
    let map = heightmap::level::level(&map, heightmap::Edges::Periodic).unwrap();
    let options = scatter::Options {
        method: scatter::Method::Geometric,
        material: optics::Material::parse("mirror", 550e-9).unwrap(),
        ..scatter::Options::default()
    };
    let scattered = scatter::scatter(&map, &options, &|_| ()).unwrap();
    sample::TableBrdf::new(table::Table::from_scatter(&scattered, table::Provenance::default())).unwrap()
}

/// A bright corner needs many paths, the rest few: a stop at an error saves them and keeps the mean.
#[test]
fn a_picture_stops_where_it_is_good_enough() {
    let matt = Lambert(0.5);
    let mut scene = Scene::new(DVec3::splat(0.5)).unwrap();
    scene.add(floor(4.0), plain(&matt));
    let wall = Quad::new(DVec3::new(-2.0, 0.5, 0.0), DVec3::X, DVec3::Z).unwrap();
    scene.add(wall, plain(&matt));
    scene.add_emitter(Sphere::new(DVec3::new(-1.5, 0.0, 0.3), 0.02).unwrap(), grey(900.0)).unwrap();
    let camera = Camera::perspective(DVec3::new(0.0, -4.0, 2.0), DVec3::ZERO, DVec3::Z, 0.8, 1.0).unwrap();
    let asked = RenderOptions { error: Some(0.02), ..options(64, 1024) };
    let stopped = render_with_report(&scene, &camera, &asked, &|_| {}).unwrap();
    let full = render_with_report(&scene, &camera, &options(64, 1024), &|_| {}).unwrap();
    let report = stopped.report;
    assert!(report.saved > 0.2 && full.report.saved == 0.0, "{report:?}");
    assert_eq!(report.samples, stopped.film.pixels().iter().map(|p| u64::from(p.samples)).sum::<u64>());
    assert!(report.worst_error <= 0.02 || report.unfinished > 0.0, "{report:?}");
    let [a, b] = [&stopped.film, &full.film].map(|f| mean(f, 1));
    assert!((a.value - b.value).abs() <= 4.0 * a.standard_error.hypot(b.standard_error), "{a:?} {b:?}");
    // The error that is reported is not too small: against many more paths the blocks differ by no more than they say.
    let truth = shoot(&scene, &camera, &RenderOptions { seed: 77, ..options(64, 4096) });
    let (mut error, mut said) = (0.0, 0.0);
    for (pixel, exact) in stopped.film.pixels().iter().zip(truth.pixels()) {
        error += f64::from(pixel.radiance[1] - exact.radiance[1]).powi(2);
        said += f64::from(pixel.standard_error[1]).powi(2) + f64::from(exact.standard_error[1]).powi(2);
    }
    assert!(error <= 1.1 * said, "{error} {said}");
    // A scene of one convex body under a sky needs two pieces of path.
    let mut lone = Scene::new(DVec3::ONE).unwrap();
    lone.add(Sphere::new(DVec3::ZERO, 1.0).unwrap(), plain(&matt));
    assert_eq!(render_with_report(&lone, &camera, &options(16, 16), &|_| {}).unwrap().report.longest_path, 2);
}

#[test]
fn one_and_three_threads_make_the_same_picture() {
    let glossy = model::parse("ggx:alpha=0.1,n=1.5", 550e-9).unwrap();
    let mut scene = Scene::new(DVec3::splat(0.3)).unwrap();
    scene.add(floor(4.0), plain(glossy.as_ref()));
    scene.add(Sphere::new(0.5 * DVec3::Z, 0.5).unwrap(), plain(glossy.as_ref()));
    scene.add_emitter(Disc::new(2.0 * DVec3::Z, -DVec3::Z, 0.2, 0.0).unwrap(), grey(30.0)).unwrap();
    let camera = Camera::perspective(DVec3::new(0.0, -4.0, 2.0), DVec3::ZERO, DVec3::Z, 0.6, 1.0).unwrap();
    for error in [None, Some(0.05)] {
        let asked = RenderOptions { error, ..options(40, 64) };
        let files = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            exr_bytes(&pool.install(|| shoot(&scene, &camera, &asked)), "").unwrap()
        });
        assert!(files[0] == files[1], "the picture depends on the number of threads");
    }
}

#[test]
fn surroundings_and_paints_are_checked() {
    let mut scene = Scene::new(DVec3::ZERO).unwrap();
    assert!(scene.add_emitter(floor(1.0), Paint::plain(DVec3::ZERO).unwrap()).is_err());
    let bad = RenderOptions { error: Some(1.5), ..options(2, 2) };
    assert!(render_with_report(&scene, &close_up(0.1), &bad, &|_| {}).unwrap_err().to_string().contains("error"));
}
