//! Pixels: four glossy spheres over a chequered floor under six lamps, by every estimator that has the full answer.

use crate::bench::method::{Answer, Distance, Family, Method, Reference};
use crate::error::Result;
use crate::model;
use crate::render::description::Materials;
use crate::render::{Description, Estimator, Film, RenderOptions, render};
use std::path::Path;

/// The scene of the budget of the path tracer.
const SCENE: &str = include_str!("four_spheres.toml");

/// Pixels across and down.
const SIZE: [usize; 2] = [64, 32];

/// Paths per pixel of the reference.
const REFERENCE_PATHS: u32 = 2048;

/// The scene, parsed.
pub struct SceneFile(Description);

impl SceneFile {
    /// Reads the scene that comes with the program.
    ///
    /// # Errors
    /// As [`Description::parse`].
    pub fn new() -> Result<Self> {
        Ok(SceneFile(Description::parse(SCENE, Path::new("four_spheres.toml"))?))
    }

    /// Its materials; all of them are models.
    ///
    /// # Errors
    /// As [`Description::materials`].
    pub fn materials(&self) -> Result<Materials> {
        self.0.materials(&|wanted| model::parse(wanted.source, wanted.wavelength), &|_| ())
    }

    /// A picture of the scene.
    ///
    /// # Errors
    /// As [`render`].
    pub fn picture(&self, materials: &Materials, options: &RenderOptions) -> Result<Film> {
        let camera = self.0.camera(options.width as f64 / options.height as f64)?;
        render(&self.0.build(materials)?.scene, &camera, options, &|_| ())
    }
}

/// Small picture of paths of at most four pieces.
pub fn options(size: [usize; 2], paths: u32, seed: u64, estimator: Estimator) -> RenderOptions {
    RenderOptions {
        width: size[0],
        height: size[1],
        samples_per_pixel: paths,
        seed,
        max_reflections: 3,
        estimator,
        ..RenderOptions::default()
    }
}

/// Green of every pixel that is not a lamp.
fn values(film: &Film, lamps: &[bool]) -> Vec<f64> {
    film.pixels().iter().zip(lamps).filter(|p| !p.1).map(|(p, _)| f64::from(p.radiance[1])).collect()
}

/// Samples per pixel against the error of the pixels.
///
/// # Errors
/// As [`render`].
pub fn family<'a>(scene: &'a SceneFile, materials: &'a Materials) -> Result<Family<'a>> {
    let reference = scene.picture(materials, &options(SIZE, REFERENCE_PATHS, 0xfeed, Estimator::Mis))?;
    // A pixel that sees a lamp is as bright as all others together and says nothing about the estimator.
    let brightest = 0.5 * 40.0;
    let lamps: Vec<bool> = reference.pixels().iter().map(|p| f64::from(p.radiance[1]) > brightest).collect();
    let wanted = values(&reference, &lamps);
    let squares = |list: &mut dyn Iterator<Item = f64>| list.map(|v| v * v).sum::<f64>();
    let errors = reference.pixels().iter().zip(&lamps).filter(|p| !p.1).map(|(p, _)| f64::from(p.standard_error[1]));
    let noise = (squares(&mut errors.into_iter()) / squares(&mut wanted.iter().copied())).sqrt();
    let method = |name: &'static str, estimator: Estimator| {
        let lamps = lamps.clone();
        Method::new(name, "paths per pixel", [1.0, 4.0, 16.0, 64.0, 256.0], move |paths, seed| -> Answer {
            let film = scene.picture(materials, &options(SIZE, paths as u32, seed, estimator));
            film.map_or_else(|_| vec![f64::NAN; lamps.len()], |film| values(&film, &lamps)).into()
        })
        .random()
    };
    Ok(Family {
        id: "render".into(),
        title: "Pixels of a picture".into(),
        error: "relative error of the pixels (rms)",
        distance: Distance::Relative,
        reference: Reference {
            text: format!(
                "four glossy spheres, six lamps, chequered floor, {} x {} pixels, against {REFERENCE_PATHS} paths per pixel",
                SIZE[0], SIZE[1]
            ),
            values: wanted,
            noise,
        },
        methods: vec![
            method("BRDF and lamps (MIS)", Estimator::Mis).taken_at(256.0),
            method("BRDF only", Estimator::Brdf),
            method("lamps only", Estimator::Lights),
            method("uniform and lamps", Estimator::Uniform),
        ],
    })
}
