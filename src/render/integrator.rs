//! Path tracing: the rendering equation by random walks from the camera.

use super::camera::Camera;
use super::exposure::render_with_report;
use super::film::Film;
use super::scene::Scene;
use crate::error::{Error, Result};

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
