//! The pictures of the paper, at reduced sizes: what they must show, read off as radiance.

use asperity::figure::{Figure, Settings, noise};
use asperity::render::stage::{Backdrop, Stage};
use asperity::render::{Camera, Estimator, Film, RenderOptions, Scene, render};
use glam::DVec3;
use std::sync::{Arc, LazyLock, OnceLock};

fn small(width: usize, samples: u32) -> Settings {
    Settings { width: Some(width), samples: Some(samples), ..Settings::default() }
}

/// Surfaces are dear: each figure is prepared once for all tests.
fn prepared(name: &'static str) -> Arc<Figure> {
    type Slot = (&'static str, OnceLock<Arc<Figure>>);
    static READY: LazyLock<Vec<Slot>> =
        LazyLock::new(|| Figure::names().into_iter().map(|name| (name, OnceLock::new())).collect());
    let slot = &READY.iter().find(|(n, _)| *n == name).unwrap().1;
    slot.get_or_init(|| Arc::new(Figure::prepare(name, &|_| ()).unwrap())).clone()
}

fn shot(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Film {
    render(scene, camera, options, &|_| ()).unwrap()
}

/// Light that arrives at `point` from around `axis`: (direction, radiance, solid angle). Nothing is reflected.
fn arriving(scene: &Scene, point: DVec3, axis: DVec3) -> Vec<(DVec3, DVec3, f64)> {
    const SIDE: usize = 900;
    let field = 76f64.to_radians();
    let camera = Camera::perspective(point, point + axis, DVec3::Y, field, 1.0).unwrap();
    let options = RenderOptions {
        width: SIDE,
        height: SIDE,
        samples_per_pixel: 4,
        max_reflections: 0,
        ..RenderOptions::default()
    };
    let film = shot(scene, &camera, &options);
    let step = 2.0 * (0.5 * field).tan() / SIDE as f64;
    let pixel = |(k, p): (usize, &asperity::render::Pixel)| {
        let (x, y) = ((k % SIDE) as f64 + 0.5, (k / SIDE) as f64 + 0.5);
        let direction = camera.ray(x / SIDE as f64, y / SIDE as f64).direction;
        (direction, DVec3::from(p.radiance.map(f64::from)), step * step * direction.dot(axis).powi(3))
    };
    film.pixels().iter().enumerate().map(pixel).collect()
}

/// Where the lamp is mirrored, the tiles send `sum f_r L cos_theta_i dw`, plus the mirror beam of the specular core: a sum
/// over 0.8 million directions against the path tracer.
#[test]
fn radiance_read_off_the_tiles_is_f_r_times_the_light() {
    let figure = prepared("fig8");
    let scene = figure.scene().unwrap();
    let stage = Stage::new(2, Backdrop::Chart).unwrap();
    let full = figure.options(&Settings::default(), Estimator::Mis);
    for tile in 0..2 {
        // The mirror image of the lamp in the plane of the tiles.
        let (eye, lamp) = (stage.eye(), stage.lamp(tile));
        let image = DVec3::new(lamp.x, lamp.y, -lamp.z);
        let point = eye + (image - eye) * (eye.z / (eye.z - image.z));
        // One pixel of the picture at full size, in 16 x 16 parts.
        let pixel = 2.0
            * ((figure.camera(full.width as f64 / full.height as f64).unwrap().ray(0.5, 0.5).direction).cross(
                figure
                    .camera(full.width as f64 / full.height as f64)
                    .unwrap()
                    .ray(0.5 + 0.5 / full.width as f64, 0.5)
                    .direction,
            ))
            .length()
            .asin();
        let camera = Camera::perspective(eye, point, DVec3::Z, pixel, 1.0).unwrap();
        let options = RenderOptions { width: 16, height: 16, samples_per_pixel: 4096, ..full };
        let read = shot(&scene, &camera, &options).mean();
        let brdf = figure.finishes()[tile].grey().unwrap();
        let wo = (eye - point).normalize();
        let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
        let light = arriving(&scene, point, mirror);
        let sum: DVec3 = light
            .iter()
            .filter(|(wi, ..)| wi.z > 0.0)
            .map(|(wi, radiance, solid_angle)| brdf.eval(*wi, wo) * wi.z * *solid_angle * *radiance)
            .sum();
        let nearest = light.iter().max_by(|a, b| a.0.dot(mirror).total_cmp(&b.0.dot(mirror))).unwrap();
        let expected = sum + brdf.specular_core(mirror) * nearest.1;
        for channel in 0..3 {
            let (got, error) = (f64::from(read.radiance[channel]), f64::from(read.standard_error[channel]));
            assert!(error < 2e-3 * got, "tile {tile}: {got} +- {error}");
            let off = got / expected[channel] - 1.0;
            assert!(
                off.abs() < 0.01,
                "tile {tile}, channel {channel}: {got} read, {} expected, {off}",
                expected[channel]
            );
        }
    }
}

/// The largest ratio of a pixel to the median of its eight neighbours.
fn worst_firefly(film: &Film) -> (f64, usize, usize) {
    let brightness = |x: usize, y: usize| film.pixel(x, y).unwrap().radiance.iter().map(|v| f64::from(*v)).sum::<f64>();
    let mut worst = (0.0, 0, 0);
    for y in 1..film.height() - 1 {
        for x in 1..film.width() - 1 {
            let mut around: Vec<f64> =
                (0..9).filter(|k| *k != 4).map(|k| brightness(x + k % 3 - 1, y + k / 3 - 1)).collect();
            around.sort_by(f64::total_cmp);
            let median = 0.5 * (around[3] + around[4]);
            let ratio = brightness(x, y) / median.max(f64::MIN_POSITIVE);
            if ratio > worst.0 {
                worst = (ratio, x, y);
            }
        }
    }
    worst
}

#[test]
fn no_pixel_stands_far_above_its_neighbours() {
    for name in Figure::names() {
        let figure = prepared(name);
        let picture = figure.render(&small(160, 40), &|_| ()).unwrap();
        for (estimator, film) in picture.films() {
            // Uniform directions are there to be noisy; direct light alone leaves lamps on black spheres: edges, not noise.
            if *estimator != Estimator::Mis {
                continue;
            }
            let (ratio, x, y) = worst_firefly(film);
            assert!(ratio < 50.0, "{name}, {}: pixel ({x}, {y}) is {ratio} times its neighbours", estimator.name());
            let mean = film.mean().radiance;
            assert!(mean.iter().all(|v| *v > 0.01), "{name}: mean radiance {mean:?}");
        }
    }
}

#[test]
fn alias_sampling_is_far_less_noisy_than_uniform_sampling() {
    let figure = prepared("fig7");
    let list = noise(&figure, &small(72, 160), 1024, &|_| ()).unwrap();
    let gain = list[0].mean_square / list[1].mean_square;
    assert!(gain > 30.0, "{list:?}");
    // The same light: the mean of both modes is that of the reference.
    let scene = figure.scene().unwrap();
    let mean = |estimator: Estimator| {
        let options = figure.options(&small(48, 160), estimator);
        let camera = figure.camera(options.width as f64 / options.height as f64).unwrap();
        shot(&scene, &camera, &options).mean()
    };
    let (uniform, alias, direct) = (mean(Estimator::Uniform), mean(Estimator::Mis), mean(Estimator::Direct));
    for k in 0..3 {
        let error = f64::from(uniform.standard_error[k]).hypot(f64::from(alias.standard_error[k]));
        assert!((f64::from(uniform.radiance[k]) - f64::from(alias.radiance[k])).abs() < 4.0 * error);
        assert!(direct.radiance[k] < 0.9 * alias.radiance[k]);
    }
    assert!(noise(&prepared("fig11"), &small(40, 1), 2, &|_| ()).is_err());
}

/// The floor is mirrored in the lower half of the glossiest sphere, unless only the lamps are asked for.
#[test]
fn the_floor_is_missing_in_direct_light_only() {
    let figure = prepared("fig7");
    let picture = figure.render(&small(160, 16), &|_| ()).unwrap();
    let below = |estimator: Estimator| {
        let film = &picture.films().iter().find(|(e, _)| *e == estimator).unwrap().1;
        // The lower third of the rightmost sphere, in front of its foot.
        let (x, y) = (film.width() * 84 / 100, film.height() * 66 / 100);
        let row: Vec<f64> = (x - 6..x + 6).map(|x| f64::from(film.pixel(x, y).unwrap().radiance[1])).collect();
        row.iter().sum::<f64>() / row.len() as f64
    };
    let (direct, alias) = (below(Estimator::Direct), below(Estimator::Mis));
    assert!(direct < 0.05 * alias, "{direct} {alias}");
    let folder = tempfile::tempdir().unwrap();
    let written = picture.save(&folder.path().join("fig7.exr")).unwrap();
    let names: Vec<String> = written.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(names, ["fig7.exr", "fig7-direct.exr", "fig7-uniform.exr", "fig7-mis.exr"]);
    let (film, notes) = Film::load_exr(&written[3]).unwrap();
    assert_eq!(&film, &picture.films()[2].1);
    assert!(notes.comment.unwrap().contains("render fig7"));
}

#[test]
fn figures_do_not_depend_on_threads() {
    let bytes = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            prepared("fig14").render(&small(80, 4), &|_| ()).unwrap().sheet().picture().png_bytes().unwrap()
        })
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn captions_say_what_the_meter_reads() {
    let first =
        |name: &'static str| -> Vec<String> { prepared(name).captions().iter().map(|c| c[0].clone()).collect() };
    assert_eq!(
        first("fig11"),
        ["20\u{b0} gloss 80.0", "20\u{b0} gloss 60.0", "20\u{b0} gloss 40.0", "20\u{b0} gloss 20.0"]
    );
    assert_eq!(first("fig12"), ["2\u{b0} haze 10.0", "2\u{b0} haze 60.0", "2\u{b0} haze 110.0", "2\u{b0} haze 160.0"]);
    assert_eq!(first("fig14"), ["first-surface 20\u{b0} gloss 10.0", "first-surface 20\u{b0} gloss 60.0"]);
    assert_eq!(first("fig8"), ["Sq 201 nm", "Sq 805 nm"]);
    let error = Figure::prepare("fig10", &|_| ()).err().unwrap().to_string();
    assert!(error.contains("fig10") && error.contains("fig14"), "{error}");
    let dark = Settings { exposure: Some(0.0), ..small(80, 1) };
    assert!(prepared("fig13").render(&dark, &|_| ()).err().unwrap().to_string().contains("exposure"));
}
