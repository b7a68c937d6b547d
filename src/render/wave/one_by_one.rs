//! One path after the other: what the waves must find, by the shortest way to write it down.

use super::super::camera::Camera;
use super::super::integrator::{Estimator, RenderOptions};
use super::super::light::LightSample;
use super::super::material::{Coat, odd_cell};
use super::super::rays::{Column, WAVE};
use super::super::reach::{Asking, Asks, Pick, Scratch};
use super::super::scene::{Finish, Hit, Id, Scene};
use super::super::shape::Ray;
use super::super::spectral::ColourDraw;
use super::super::spot::Spot;
use super::super::stream::{PathStream, PixelStream, SobolTable};
use super::turn::SURE_REFLECTIONS;
use crate::math::frame::DVec3;
use crate::model;
use crate::optics::Brdf;
use crate::render::{
    Cover, Disc, Environment, Film, Mesh, Paint, Pattern, Pixel, Quad, Reflector, Spectral, Sphere, render_with_report,
};
use fearless_simd::{Level, dispatch};
use std::f64::consts::TAU;

/// First surface along a ray: every quad and sphere is asked, one by one.
fn closest(scene: &Scene, ray: &Ray, leaving: Option<Id>) -> Option<Hit> {
    let (mut hit, mut t) = (None, f64::INFINITY);
    let quads = scene.solids.quads.iter().enumerate().map(|(i, quad)| {
        let id = Id::Quad(i as u32);
        (id, if leaving == Some(id) { None } else { quad.intersect(ray, f64::INFINITY) })
    });
    let spheres = scene.solids.spheres.iter().enumerate().map(|(i, sphere)| {
        let id = Id::Sphere(i as u32);
        let again = leaving == Some(id);
        (id, if again { sphere.intersect_again(ray, f64::INFINITY) } else { sphere.intersect(ray, f64::INFINITY) })
    });
    for (id, met) in quads.chain(spheres) {
        if let Some(nearer) = met.filter(|&nearer| nearer < t) {
            t = nearer;
            hit = Some(Hit { t, id, weights: [0.0; 2] });
        }
    }
    scene.nearer(ray, leaving, t).or(hit)
}

/// Whether anything but its start and `target` stands before `distance`.
fn blocked(scene: &Scene, ray: &Ray, distance: f64, leaving: Id, target: Option<Id>) -> bool {
    let quads = scene.solids.quads.iter().enumerate().any(|(i, quad)| {
        let id = Id::Quad(i as u32);
        leaving != id && target != Some(id) && quad.intersect(ray, distance).is_some()
    });
    let spheres = scene.solids.spheres.iter().enumerate().any(|(i, sphere)| {
        let id = Id::Sphere(i as u32);
        if leaving == id {
            return sphere.intersect_again(ray, distance).is_some();
        }
        target != Some(id) && sphere.intersect(ray, distance).is_some()
    });
    quads || spheres || scene.hides(ray, distance, Some(leaving), target)
}

/// The light that is asked at one point.
fn pick(scene: &Scene, at: &Asking, u: f64) -> Pick {
    let wide = |v: DVec3| [v.x, v.y, v.z].map(|x| -> Column<f64> { [x; WAVE] });
    let (point, normal) = (wide(at.point), wide(at.normal));
    let (asks, mut picks) = (Asks { len: 1, point: &point, normal: &normal, u: &[u; WAVE] }, [Pick::default(); WAVE]);
    dispatch!(Level::new(), simd => scene.lights.reaches.pick(simd, asks, &mut Scratch::default(), &mut picks));
    picks[0]
}

/// A draw among all lights.
fn sample_any(scene: &Scene, at: &Asking, u: [f64; 2]) -> (Pick, Option<LightSample>) {
    let pick = pick(scene, at, u[0]);
    if !(pick.chance > 0.0) {
        return (pick, None);
    }
    let rest = ((u[0] - pick.start) / pick.chance).clamp(0.0, 1.0 - f64::EPSILON);
    let sample = scene.lights.sample(pick.light as usize, at.point, [rest, u[1]]);
    (pick, sample.map(|s| LightSample { pdf: pick.chance * s.pdf, ..s }))
}

fn eval(coat: &Coat, wi: DVec3, wo: DVec3) -> (DVec3, f64) {
    let mut found = [(DVec3::ZERO, 0.0)];
    coat.evaluate(&[wi], &[wo], &mut found, &mut Vec::new());
    found[0]
}

/// Directions uniform over the hemisphere, with a share for the specular core.
fn uniform(coat: &Coat, wi: DVec3, u: [f64; 2]) -> ColourDraw {
    let share = coat.core_share();
    if u[0] < share {
        return coat.core_draw(wi);
    }
    let z = (u[0] - share) / (1.0 - share);
    let (s, c) = (TAU * u[1]).sin_cos();
    let wo = DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z);
    let pdf = coat.uniform_pdf();
    ColourDraw { wo, weight: eval(coat, wi, wo).0 * (z / pdf), pdf, specular: false }
}

/// Radiance that arrives against `ray`, and the number of straight pieces of the path.
fn trace(scene: &Scene, mut ray: Ray, stream: &mut PathStream, options: &RenderOptions) -> (DVec3, u32) {
    let (mut radiance, mut throughput) = (DVec3::ZERO, DVec3::ONE);
    let (mut leaving, mut first_weight, mut reflection) = (None, 1.0, 0);
    let mut drawn: Option<(f64, Asking, f32)> = None;
    let last = if options.estimator == Estimator::Direct { 1 } else { options.max_reflections };
    let weight = |drawn: Option<(f64, Asking, f32)>, light: usize, own: f64| {
        let Some((pdf, at, total)) = drawn.filter(|_| options.estimator != Estimator::Brdf) else { return 1.0 };
        let chance = dispatch!(Level::new(), simd => scene.lights.reaches.chance(simd, light, &at, total));
        match options.estimator {
            Estimator::Lights => f64::from(chance * own <= 0.0),
            _ => pdf / (pdf + chance * own),
        }
    };
    loop {
        let Some(hit) = closest(scene, &ray, leaving) else {
            radiance += throughput * scene.sky;
            if let Some((light, met)) = scene.lights.surroundings(ray.direction) {
                radiance += weight(drawn, light, met.pdf) * throughput * met.radiance;
            }
            break;
        };
        let cover = match scene.finish(hit.id) {
            Finish::Emits(light) => {
                let met = scene.meet_light(light, &ray, &hit);
                radiance += weight(drawn, light, met.pdf) * throughput * met.radiance;
                break;
            }
            Finish::Reflects(cover) => scene.cover(cover),
        };
        if reflection >= last {
            break;
        }
        let Some(spot) = Spot::new(scene, &hit, ray.at(hit.t), -ray.direction) else { break };
        let point = ray.at(hit.t);
        let (coat, tint) = match cover {
            Cover::Plain(coat) => (coat, coat.tint()),
            Cover::Painted(coat, paint) => (coat, coat.tint() * paint.colour(|| scene.uv(hit.id, hit.weights, point))),
            Cover::Checker(coats, size) => {
                let coat = &coats[usize::from(odd_cell(scene.place_in(hit.id, point), 1.0 / size))];
                (coat, coat.tint())
            }
        };
        let at = Asking { point, normal: spot.z };
        let u = stream.pair();
        let mut total = 0.0;
        if options.estimator != Estimator::Brdf && !coat.is_delta() {
            let (pick, light) = sample_any(scene, &at, stream.pair());
            total = pick.total;
            if let Some(light) = light {
                let wo = spot.to_local(light.direction);
                let shadow = Ray { origin: point, direction: light.direction };
                if wo.z > 0.0
                    && spot.plane.dot(light.direction) > 0.0
                    && !blocked(scene, &shadow, light.distance, hit.id, light.id)
                {
                    let (f_r, pdf) = eval(coat, spot.seen, wo);
                    let rival = match options.estimator {
                        Estimator::Lights => 0.0,
                        Estimator::Uniform => coat.uniform_pdf(),
                        _ => pdf,
                    };
                    radiance += throughput * tint * light.radiance * f_r * (wo.z / (light.pdf + rival));
                }
            }
        }
        let draw = if options.estimator == Estimator::Uniform {
            Some(uniform(coat, spot.seen, u))
        } else {
            coat.sample(spot.seen, u)
        };
        let Some(draw) = draw else { break };
        throughput *= draw.weight * tint;
        if throughput == DVec3::ZERO {
            break;
        }
        if reflection == 0 {
            first_weight = throughput.max_element();
        }
        if reflection >= SURE_REFLECTIONS {
            let survival = (throughput.max_element() / first_weight).min(1.0);
            if stream.lonely() >= survival {
                break;
            }
            throughput /= survival;
        }
        let wo = draw.wo;
        let direction = wo.x * spot.x + wo.y * spot.z.cross(spot.x) + wo.z * spot.z;
        if !(spot.plane.dot(direction) > 0.0) {
            break;
        }
        ray = Ray { origin: point, direction };
        leaving = Some(hit.id);
        reflection += 1;
        drawn = (!draw.specular).then_some((draw.pdf, at, total));
    }
    (radiance, reflection + 1)
}

/// Mean radiance of every pixel, row by row.
fn picture(scene: &Scene, camera: &Camera, options: &RenderOptions) -> (Vec<DVec3>, u32) {
    let table = SobolTable::new(options.samples_per_pixel);
    let (width, height) = (options.width, options.height);
    let mut longest = 0;
    let pixels = (0..width * height).map(|k| {
        let numbers = PixelStream::new(&table, options.seed, k as u64, 0);
        let mut sum = DVec3::ZERO;
        for index in 0..options.samples_per_pixel {
            let mut stream = numbers.path(index);
            let [dx, dy] = stream.pair();
            let (x, y) = ((k % width) as f64 + dx, (k / width) as f64 + dy);
            let ray = camera.ray(x / width as f64, y / height as f64);
            let (radiance, pieces) = trace(scene, ray, &mut stream, options);
            sum += radiance;
            longest = longest.max(pieces);
        }
        sum / f64::from(options.samples_per_pixel)
    });
    (pixels.collect(), longest)
}

/// Every kind of shape, lamp and finish.
fn furnished<'a>(brdfs: &'a [Box<dyn Brdf>], copper: &'a Spectral, surrounded: bool) -> Scene<'a> {
    let coat = |k: usize, tint: f64| Coat::new(Reflector::Grey(brdfs[k].as_ref()), DVec3::new(tint, 0.9 * tint, 0.6));
    let quad = |corner: [f64; 3], u: [f64; 3], v: [f64; 3]| Quad::new(corner.into(), u.into(), v.into()).unwrap();
    let mut scene = Scene::new(DVec3::new(0.1, 0.15, 0.2)).unwrap();
    let floor = quad([-4.0, -5.0, 0.0], [9.0, 0.0, 0.0], [1.0, 8.0, 0.0]);
    scene.add(floor, Cover::Checker([coat(0, 0.8), coat(1, 0.5)], 0.7));
    let paint = Paint::new(Pattern::Grid { columns: 3, rows: 2, line: 0.3 }, DVec3::ONE, DVec3::splat(0.2)).unwrap();
    scene.add(quad([-4.0, 2.5, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 4.0]), Cover::Painted(coat(2, 1.0), paint));
    scene.add(Sphere::new(DVec3::new(-1.6, 0.0, 0.8), 0.8).unwrap(), Cover::Plain(coat(2, 0.9)));
    scene.add(Sphere::new(DVec3::new(0.2, -0.3, 0.7), 0.7).unwrap(), Cover::Plain(coat(3, 0.9)));
    let spectral = Coat::new(Reflector::Spectral(copper), DVec3::ONE);
    scene.add(Sphere::new(DVec3::new(1.8, 0.2, 0.9), 0.6).unwrap(), Cover::Plain(spectral));
    // The room of some rays is the inside of a sphere.
    scene.add(Sphere::new(DVec3::new(0.0, 0.0, 1.0), 30.0).unwrap(), Cover::Plain(coat(4, 0.7)));
    scene.add(
        Disc::new(DVec3::new(0.5, 1.5, 1.8), DVec3::new(0.2, -1.0, -0.4), 0.7, 0.2).unwrap(),
        Cover::Plain(coat(3, 1.0)),
    );
    let profile = [[0.3, 0.0], [0.5, 0.4], [0.2, 0.9]];
    let vase = crate::render::revolution(&profile, true).unwrap();
    let aside = glam::DAffine3::from_translation(DVec3::new(-0.4, -1.6, 0.0));
    scene.add(vase.transformed(&aside).unwrap(), Cover::Plain(coat(1, 0.8)));
    let white = |x: f64| Paint::plain(DVec3::new(x, 0.8 * x, 0.5 * x)).unwrap();
    scene.add_emitter(Sphere::new(DVec3::new(-1.5, -2.0, 3.5), 0.4).unwrap(), white(20.0)).unwrap();
    scene.add_emitter(Sphere::new(DVec3::new(2.0, -1.0, 3.0), 0.2).unwrap(), white(50.0)).unwrap();
    let lit = Paint::new(Pattern::Checker { columns: 3, rows: 2 }, DVec3::splat(9.0), DVec3::ONE).unwrap();
    scene.add_emitter(quad([-1.0, 1.0, 3.8], [0.0, 1.0, 0.0], [1.5, 0.0, 0.0]), lit).unwrap();
    scene.add_emitter(Disc::new(DVec3::new(3.0, 1.0, 2.0), -DVec3::X, 0.5, 0.0).unwrap(), white(6.0)).unwrap();
    let corners = vec![DVec3::new(-3.0, 0.0, 1.0), DVec3::new(-3.0, 1.0, 1.0), DVec3::new(-3.0, 0.5, 2.0)];
    scene.add_emitter(Mesh::new(corners, None, vec![[0, 1, 2]]).unwrap(), white(8.0)).unwrap();
    if surrounded {
        let mut film = Film::new(8, 4).unwrap();
        for (k, pixel) in film.pixels_mut().iter_mut().enumerate() {
            *pixel = Pixel { radiance: [0.1 + k as f32 * 0.02, 0.3, 0.2], ..Pixel::default() };
        }
        scene.surround(Environment::new(&film, 1.0, 0.4).unwrap());
    }
    scene
}

/// The same paths with the same numbers: but for rounding, which sends one in thousands another way, the same pixels.
#[test]
fn waves_show_what_one_path_after_the_other_shows() {
    let names =
        ["lambert:rho=0.7", "lambert:rho=1", "ggx:alpha=0.25,n=1.5", "beckmann:alpha=0.08,material=al", "mirror"];
    let brdfs: Vec<Box<dyn Brdf>> = names.iter().map(|name| model::parse(name, 550e-9).unwrap()).collect();
    let copper = Spectral::new(&|w| model::parse("ggx:alpha=0.3,material=cu", w)).unwrap();
    let eye = DVec3::new(0.3, -6.0, 2.2);
    let camera = Camera::perspective(eye, DVec3::new(0.0, 0.0, 0.9), DVec3::Z, 0.8, 1.5).unwrap();
    for (name, estimator) in Estimator::NAMES {
        let scene = furnished(&brdfs, &copper, name != "lights");
        let (width, height, samples_per_pixel) = (36, 24, 12);
        let options =
            RenderOptions { width, height, samples_per_pixel, estimator, seed: 3, ..RenderOptions::default() };
        let waves = render_with_report(&scene, &camera, &options, &|_| ()).unwrap();
        let (pixels, longest) = picture(&scene, &camera, &options);
        let mean = pixels.iter().sum::<DVec3>() / pixels.len() as f64;
        assert!(mean.min_element() > 0.05, "{name}: {mean}");
        let differs = |(wave, path): &(&Pixel, &DVec3)| {
            let wave = DVec3::from(wave.radiance.map(f64::from));
            (wave - **path).abs().max_element() > 1e-6 * (path.max_element() + mean.max_element())
        };
        let different = waves.film.pixels().iter().zip(&pixels).filter(differs).count();
        assert!(different <= pixels.len() / 200, "{name}: {different} of {} pixels", pixels.len());
        assert_eq!(waves.report.longest_path, longest, "{name}");
    }
}
