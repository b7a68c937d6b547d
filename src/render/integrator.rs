//! Path tracing: the rendering equation by random walks from the camera.

use super::camera::Camera;
use super::film::{Film, Pixel, Tally};
use super::scene::{Finish, Id, LightSample, Material, Scene};
use super::shape::Ray;
use super::stream::{PathStream, PixelStream, SobolTable};
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How light from emitters is found at each reflection. All three have the same mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// Follow [`crate::optics::brdf::Brdf::sample`] and count the emitters it meets: best for mirrors.
    Brdf,
    /// Draw a point on an emitter and ask whether it is seen: best for small lamps over matt surfaces.
    Light,
    /// Both, weighted by the balance heuristic.
    Both,
}

/// Size and effort of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Pixels across and down.
    pub width: usize,
    pub height: usize,
    /// Paths per pixel; a power of 2 uses the evenness of the Sobol points best.
    pub samples_per_pixel: u32,
    /// Same seed, same picture, for any number of threads.
    pub seed: u64,
    /// Reflections after which a path ends.
    pub max_reflections: u32,
    pub strategy: Strategy,
    /// Up to this many lights are all asked at the first reflection, which decides how noisy a picture looks;
    /// after it, or with more lights than this, one is drawn at random.
    pub lights_asked: usize,
}

impl Default for RenderOptions {
    fn default() -> Self {
        RenderOptions {
            width: 640,
            height: 480,
            samples_per_pixel: 256,
            seed: 1,
            max_reflections: 8,
            strategy: Strategy::Both,
            lights_asked: 8,
        }
    }
}

/// Reflections before Russian roulette may end a path.
const SURE_REFLECTIONS: u32 = 3;

/// `L_o = L_e + integral of f_r L_i cos_theta dw` in every pixel (Kajiya, SIGGRAPH 1986), averaged over the pixel's area.
///
/// Emitters are found by drawing from the BRDF and from the emitters, combined by the balance heuristic (Veach and
/// Guibas, SIGGRAPH 1995); draws from the specular core count alone. Paths start at the camera, so a BRDF is asked
/// with `wi` towards the camera: it must be reciprocal. `progress` is called from any thread with the finished
/// fraction after each row.
///
/// # Errors
/// `Error::Parameter` if the options are out of range or a BRDF returned something that is not a number.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Film> {
    if options.samples_per_pixel == 0 {
        return Err(Error::parameter("a picture needs at least one sample per pixel", "try 256"));
    }
    let mut film = Film::new(options.width, options.height)?;
    let table = SobolTable::new(options.samples_per_pixel);
    let rows_done = AtomicUsize::new(0);
    film.pixels_mut().par_chunks_mut(options.width).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let numbers = PixelStream::new(&table, options.seed, (y * options.width + x) as u64);
            *pixel = expose(scene, camera, options, [x, y], numbers);
        }
        let done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(done as f64 / options.height as f64);
    });
    let finite = |p: &Pixel| p.radiance.iter().chain(&p.standard_error).all(|v| v.is_finite());
    if let Some(i) = film.pixels().iter().position(|p| !finite(p)) {
        return Err(Error::parameter(
            format!("the radiance of pixel ({}, {}) is not a finite number", i % options.width, i / options.width),
            "check that the BRDF of every material is finite and its sampling weights are bounded",
        ));
    }
    Ok(film)
}

fn expose(scene: &Scene, camera: &Camera, options: &RenderOptions, at: [usize; 2], mut numbers: PixelStream) -> Pixel {
    let mut tally = Tally::default();
    let (column, row) = (at[0] as f64, at[1] as f64);
    let (step_x, step_y) = (1.0 / options.width as f64, 1.0 / options.height as f64);
    for index in 0..options.samples_per_pixel {
        let mut stream = numbers.path(index);
        let [dx, dy] = stream.pair();
        let ray = camera.ray((column + dx) * step_x, (row + dy) * step_y);
        tally.add(trace(scene, ray, &mut stream, options));
    }
    tally.pixel()
}

/// Radiance that arrives against `ray` [W/(m2 sr)], from one random path.
fn trace(scene: &Scene, mut ray: Ray, stream: &mut PathStream, options: &RenderOptions) -> DVec3 {
    let mut radiance = DVec3::ZERO;
    let mut throughput = DVec3::ONE;
    let mut leaving = None;
    // Density of the BRDF draw that made the ray; none for a camera ray or a mirror, which no light sample rivals.
    let mut drawn: Option<f64> = None;
    for reflection in 0.. {
        let Some(hit) = scene.closest(&ray, leaving) else {
            return radiance + throughput * scene.sky;
        };
        let material = match scene.finish(hit.id) {
            Finish::Emits(light) => {
                let (emitted, pdf) = scene.meet_light(*light, &ray, hit.t);
                let weight = drawn.map_or(1.0, |drawn| {
                    // The rival draw was made where the ray started, one reflection ago.
                    let all = asks_all(scene, options, reflection - 1);
                    let rival = if all { pdf } else { pdf * scene.light_probability(*light) };
                    emitter_weight(drawn, rival, options.strategy)
                });
                return radiance + weight * throughput * emitted;
            }
            Finish::Reflects(material) => material,
        };
        if reflection == options.max_reflections {
            return radiance;
        }
        let Some(spot) = Spot::new(scene, hit.id, ray.at(hit.t), -ray.direction) else {
            return radiance;
        };
        let tint = material.tint.colour(|| scene.uv(hit.id, spot.point));
        let u_brdf = stream.pair();
        if options.strategy != Strategy::Brdf {
            let mut direct = DVec3::ZERO;
            let mut count = |light: Option<LightSample>| {
                direct += light.map_or(DVec3::ZERO, |l| from_light(scene, material, &spot, &l, options.strategy));
            };
            if asks_all(scene, options, reflection) {
                (0..scene.light_count()).for_each(|i| count(scene.sample_light(i, spot.point, stream.pair())));
            } else {
                count(scene.sample_any_light(spot.point, stream.pair()));
            }
            radiance += throughput * tint * direct;
        }
        let Some(draw) = material.brdf.sample(spot.seen, u_brdf) else {
            return radiance;
        };
        throughput *= tint * draw.weight;
        if reflection >= SURE_REFLECTIONS {
            let survival = throughput.max_element().min(1.0);
            if stream.lonely() >= survival {
                return radiance;
            }
            throughput /= survival;
        }
        ray = Ray { origin: spot.point, direction: spot.to_world(draw.wo) };
        leaving = Some(hit.id);
        drawn = (!draw.specular).then_some(draw.pdf);
    }
    radiance
}

/// Share of the BRDF draw in an emitter that both strategies find: `p_brdf / (p_brdf + p_light)`.
#[inline]
fn emitter_weight(pdf: f64, rival: f64, strategy: Strategy) -> f64 {
    match strategy {
        Strategy::Brdf => 1.0,
        // From inside a sphere no light sample is drawn: the BRDF must find it alone.
        Strategy::Light => f64::from(rival <= 0.0),
        Strategy::Both => 1.0 / (1.0 + rival / pdf),
    }
}

/// Whether the light samples at this reflection come from every light or from one drawn among them.
#[inline]
fn asks_all(scene: &Scene, options: &RenderOptions, reflection: u32) -> bool {
    reflection == 0 && scene.light_count() <= options.lights_asked
}

/// `f_r L cos_theta / (p_light + p_brdf)` of one draw towards the lights; without `p_brdf` if lights stand alone.
#[inline]
fn from_light(scene: &Scene, material: &Material, spot: &Spot, light: &LightSample, strategy: Strategy) -> DVec3 {
    let wo = spot.to_local(light.direction);
    if wo.z <= 0.0 || light.radiance == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let f_r = material.brdf.eval(spot.seen, wo);
    // The BRDF is cheaper than the shadow ray, and a narrow lobe is 0 almost everywhere.
    if f_r == 0.0 {
        return DVec3::ZERO;
    }
    let ray = Ray { origin: spot.point, direction: light.direction };
    if scene.is_blocked(&ray, light.distance, spot.id, light.id) {
        return DVec3::ZERO;
    }
    let rival = if strategy == Strategy::Both { material.brdf.pdf(spot.seen, wo) } else { 0.0 };
    light.radiance * (f_r * wo.z / (light.pdf + rival))
}

/// A point of a surface with the frame of its BRDF: z is the normal on the side that is seen.
struct Spot {
    id: Id,
    point: DVec3,
    /// Direction to the viewer in the local frame.
    seen: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl Spot {
    /// `None` if the surface is seen exactly edge-on.
    #[inline]
    fn new(scene: &Scene, id: Id, point: DVec3, to_viewer: DVec3) -> Option<Self> {
        let (front, x) = scene.frame(id, point);
        let z = if front.dot(to_viewer) < 0.0 { -front } else { front };
        let mut spot = Spot { id, point, seen: DVec3::Z, x, y: z.cross(x), z };
        spot.seen = spot.to_local(to_viewer);
        (spot.seen.z > 0.0).then_some(spot)
    }

    #[inline]
    fn to_local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.x), w.dot(self.y), w.dot(self.z))
    }

    #[inline]
    fn to_world(&self, w: DVec3) -> DVec3 {
        w.x * self.x + w.y * self.y + w.z * self.z
    }
}
