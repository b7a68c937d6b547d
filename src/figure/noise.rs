//! How noisy a picture is: root-mean-square error of each mode against a reference of many more paths.

use super::figures::{Figure, Settings};
use super::spheres;
use crate::error::{Error, Result};
use crate::render::{Estimator, Film, render};

/// Error of one estimator [W/(m2 sr)] over the pixels of the spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    pub estimator: Estimator,
    /// Mean over pixels and channels of the squared difference from the reference.
    pub mean_square: f64,
    /// The same for each sphere from left to right.
    pub of_sphere: [f64; 4],
    /// Mean radiance of the reference over the same pixels.
    pub mean: f64,
}

impl Noise {
    /// Root-mean-square error [W/(m2 sr)].
    pub fn rms(&self) -> f64 {
        self.mean_square.sqrt()
    }
}

/// Renders `fig7` by uniform and by alias sampling and compares both with alias sampling of `reference` paths a pixel
/// and another seed, whose own error is part of the result: choose many more paths than the pictures have.
///
/// # Errors
/// `Error::Parameter` for another figure or options out of range.
pub fn noise(
    figure: &Figure,
    settings: &Settings,
    reference: u32,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Noise>> {
    if figure.name() != "fig7" {
        return Err(Error::parameter("only fig7 compares ways of sampling", "ask for the noise of fig7"));
    }
    let scene = figure.scene()?;
    let shot = |estimator: Estimator, settings: &Settings, from: f64, share: f64| {
        let options = figure.options(settings, estimator);
        let camera = figure.camera(options.width as f64 / options.height as f64)?;
        render(&scene, &camera, &options, &|done| progress(from + share * done))
    };
    let seed = settings.seed.unwrap_or(1);
    let many = Settings { samples: Some(reference), seed: Some(seed + 1), error: None, ..*settings };
    let truth = shot(Estimator::Mis, &many, 0.0, 0.9)?;
    let modes = [Estimator::Uniform, Estimator::Mis];
    let camera = figure.camera(truth.width() as f64 / truth.height() as f64)?;
    let place = |i: usize| {
        let (x, y) = ((i % truth.width()) as f64 + 0.5, (i / truth.width()) as f64 + 0.5);
        spheres::sphere_at(&camera, x / truth.width() as f64, y / truth.height() as f64)
    };
    let spheres: Vec<Option<usize>> = (0..truth.pixels().len()).map(place).collect();
    let mut list = Vec::new();
    for (k, estimator) in modes.into_iter().enumerate() {
        let film = shot(estimator, settings, 0.9 + 0.05 * k as f64, 0.05)?;
        list.push(compare(estimator, &film, &truth, &spheres));
    }
    Ok(list)
}

fn compare(estimator: Estimator, film: &Film, truth: &Film, spheres: &[Option<usize>]) -> Noise {
    let (mut squares, mut counts, mut total) = ([0.0; 4], [0.0f64; 4], 0.0);
    for ((pixel, exact), sphere) in film.pixels().iter().zip(truth.pixels()).zip(spheres) {
        let Some(k) = *sphere else { continue };
        for (a, b) in pixel.radiance.iter().zip(exact.radiance) {
            squares[k] += f64::from(a - b).powi(2);
            counts[k] += 1.0;
            total += f64::from(b);
        }
    }
    let all: f64 = counts.iter().sum::<f64>().max(1.0);
    Noise {
        estimator,
        mean_square: squares.iter().sum::<f64>() / all,
        of_sphere: [0, 1, 2, 3].map(|k| squares[k] / counts[k].max(1.0)),
        mean: total / all,
    }
}
