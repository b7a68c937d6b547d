//! Path tracing: the rendering equation by random walks from the camera.

use super::camera::Camera;
use super::exposure::render_with_report;
use super::film::Film;
use super::light::{Asking, LightSample};
use super::material::Coat;
use super::scene::{Finish, Scene};
use super::shape::Ray;
use super::spot::Spot;
use super::stream::PathStream;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use fearless_simd::Simd;

/// How light from emitters is found at each reflection. All but [`Estimator::Direct`] have the same mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// `brdf` and `lights` together, weighted by the balance heuristic.
    Mis,
    /// Follow [`crate::optics::brdf::Brdf::sample`] and count the emitters it meets: best for mirrors.
    Brdf,
    /// Draw a point on an emitter and ask whether it is seen: best for small lamps over matt surfaces.
    Lights,
    /// As `mis` with directions uniform over the hemisphere instead of those of the BRDF.
    Uniform,
    /// As `mis`, but paths end at the first reflection: light that comes by way of other surfaces is missing.
    Direct,
}

impl Estimator {
    /// All of them with their names.
    pub const NAMES: [(&'static str, Estimator); 5] = [
        ("mis", Estimator::Mis),
        ("brdf", Estimator::Brdf),
        ("lights", Estimator::Lights),
        ("uniform", Estimator::Uniform),
        ("direct", Estimator::Direct),
    ];

    /// Reads a name such as `mis`.
    ///
    /// # Errors
    /// `Error::Parameter` with the names there are.
    pub fn parse(name: &str) -> Result<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, e)| *e).ok_or_else(|| {
            Error::parameter(format!("estimator `{name}` is unknown"), "write mis, brdf, lights, uniform or direct")
        })
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, e)| *e == self).map_or("", |(n, _)| n)
    }
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
    pub estimator: Estimator,
    /// Share of its radiance at which a block of pixels stops before it has had all its paths, see
    /// [`render_with_report`]; `None` gives every pixel all paths.
    pub error: Option<f64>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        RenderOptions {
            width: 640,
            height: 480,
            samples_per_pixel: 256,
            seed: 1,
            max_reflections: 8,
            estimator: Estimator::Mis,
            error: None,
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
/// fraction after each block of pixels.
///
/// # Errors
/// `Error::Parameter` if the options are out of range or a BRDF returned something that is not a number.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Film> {
    Ok(render_with_report(scene, camera, options, progress)?.film)
}

/// How the ray that is followed was drawn: what the light samples at its start must be weighed against.
#[derive(Clone, Copy)]
struct Drawn {
    pdf: f64,
    at: Asking,
}

/// Radiance that arrives against `ray` [W/(m2 sr)], from one random path, and the number of its straight pieces.
#[inline(always)]
pub(super) fn trace<S: Simd>(
    simd: S,
    scene: &Scene,
    mut ray: Ray,
    stream: &mut PathStream,
    options: &RenderOptions,
) -> (DVec3, u32) {
    let mut radiance = DVec3::ZERO;
    let mut throughput = DVec3::ONE;
    let mut leaving = None;
    // None for a camera ray or a mirror, which no light sample rivals.
    let mut drawn: Option<Drawn> = None;
    let last = if options.estimator == Estimator::Direct { 1 } else { options.max_reflections };
    let mut first_weight = 1.0;
    let mut reflection = 0;
    loop {
        let Some(hit) = scene.closest(simd, &ray, leaving) else {
            radiance += throughput * scene.sky;
            if let Some((light, met)) = scene.lights.surroundings(ray.direction) {
                let weight = emitter_weight(simd, scene, options, drawn, light, met.pdf);
                radiance += weight * throughput * met.radiance;
            }
            break;
        };
        let cover = match scene.finish(hit.id) {
            Finish::Emits(light) => {
                let met = scene.meet_light(light, &ray, &hit);
                let weight = emitter_weight(simd, scene, options, drawn, light, met.pdf);
                radiance += weight * throughput * met.radiance;
                break;
            }
            Finish::Reflects(cover) => scene.cover(cover),
        };
        if reflection >= last {
            break;
        }
        let Some(spot) = Spot::new(scene, &hit, ray.at(hit.t), -ray.direction) else {
            break;
        };
        let coat = cover.at(|| scene.uv(&hit, spot.point), || scene.place_in(&hit, spot.point));
        let at = Asking { point: spot.point, normal: spot.z };
        let u_brdf = stream.pair();
        if options.estimator != Estimator::Brdf
            && !coat.is_delta()
            && let Some(light) = scene.lights.sample_any(simd, &at, stream.pair())
        {
            radiance += throughput * from_light(simd, scene, &coat, &spot, &light, options.estimator);
        }
        let draw = if options.estimator == Estimator::Uniform {
            coat.sample_uniformly(spot.seen, u_brdf)
        } else {
            coat.sample(spot.seen, u_brdf)
        };
        let Some(draw) = draw else { break };
        throughput *= draw.weight;
        if throughput == DVec3::ZERO {
            break;
        }
        if reflection == 0 {
            first_weight = throughput.max_element();
        }
        if reflection >= SURE_REFLECTIONS {
            // Measured by what was left after the first reflection: dim surfaces deserve long paths too.
            let survival = (throughput.max_element() / first_weight).min(1.0);
            if stream.lonely() >= survival {
                break;
            }
            throughput /= survival;
        }
        let direction = spot.to_world(draw.wo);
        if !spot.leaves(direction) {
            break;
        }
        ray = Ray { origin: spot.point, direction };
        leaving = Some(hit.id);
        reflection += 1;
        drawn = (!draw.specular).then_some(Drawn { pdf: draw.pdf, at });
    }
    (radiance, reflection + 1)
}

/// Share of the BRDF draw in an emitter that both strategies find: `p_brdf / (p_brdf + p_light)`.
#[inline(always)]
fn emitter_weight<S: Simd>(
    simd: S,
    scene: &Scene,
    options: &RenderOptions,
    drawn: Option<Drawn>,
    light: usize,
    own: f64,
) -> f64 {
    let Some(drawn) = drawn else { return 1.0 };
    if options.estimator == Estimator::Brdf {
        return 1.0;
    }
    let rival = scene.lights.chance(simd, light, &drawn.at) * own;
    match options.estimator {
        // From inside a sphere no light sample is drawn: the BRDF must find it alone.
        Estimator::Lights => f64::from(rival <= 0.0),
        _ => 1.0 / (1.0 + rival / drawn.pdf),
    }
}

/// `f_r L cos_theta / (p_light + p_brdf)` of one draw towards the lights; without `p_brdf` if lights stand alone.
#[inline(always)]
fn from_light<S: Simd>(
    simd: S,
    scene: &Scene,
    coat: &Coat,
    spot: &Spot,
    light: &LightSample,
    estimator: Estimator,
) -> DVec3 {
    let wo = spot.to_local(light.direction);
    if wo.z <= 0.0 || light.radiance == DVec3::ZERO || !spot.leaves(light.direction) {
        return DVec3::ZERO;
    }
    let (f_r, pdf) = coat.eval_and_pdf(spot.seen, wo);
    // The BRDF is cheaper than the shadow ray, and a narrow lobe is 0 almost everywhere.
    if f_r == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let ray = Ray { origin: spot.point, direction: light.direction };
    if scene.is_blocked(simd, &ray, light.distance, spot.id, light.id) {
        return DVec3::ZERO;
    }
    let rival = match estimator {
        Estimator::Lights => 0.0,
        Estimator::Uniform => coat.uniform_pdf(),
        _ => pdf,
    };
    light.radiance * f_r * (wo.z / (light.pdf + rival))
}
