//! Gloss: flux from the specimen over flux from flat black glass, times 100.
//!
//! `G = 100 Phi(specimen) / Phi(standard)`, both with the same finite source (ISO 2813; ASTM D523). The finite source matters: it
//! changes the standard's flux by +2e-5, +1.7e-4 and -5.9e-4 of itself at 20, 60 and 85 deg.

use super::flux::Path;
use super::geometry::Geometry;
use crate::math::Estimate;
use crate::optics::{Brdf, fresnel};
use sobol_burley::sample_4d;

/// Largest number of points a replicate may use: the length of the low-discrepancy sequence.
const LONGEST: u32 = 1 << 16;

/// How hard to try.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Source azimuths [rad] to average over; one for an isotropic surface.
    pub azimuths: Vec<f64>,
    /// Stop when the standard error is below this [gloss units].
    pub tolerance: f64,
    /// Points of the first round, per replicate and azimuth; doubled until the tolerance is met.
    pub points: u32,
    /// Points to give up at, per replicate and azimuth; at most 65536.
    pub max_points: u32,
    /// Independently scrambled point sets, 2 or more, whose scatter is the standard error.
    pub replicates: u32,
    /// Same seed, same result to the last bit.
    pub seed: u32,
}

impl Default for Options {
    /// Within 0.05 gloss units: a standard error below 0.01.
    fn default() -> Self {
        Options { azimuths: vec![0.0], tolerance: 0.01, points: 256, max_points: 16384, replicates: 8, seed: 1 }
    }
}

impl Options {
    /// A quick look, within about 0.5 gloss units: for the repeats over sub-areas, whose own scatter is larger.
    pub fn quick() -> Self {
        Options { tolerance: 0.1, points: 128, max_points: 1024, ..Self::default() }
    }

    /// Source azimuths to average over [rad].
    pub fn with_azimuths(self, azimuths: impl Into<Vec<f64>>) -> Self {
        Options { azimuths: azimuths.into(), ..self }
    }
}

/// `G = 100 Phi(specimen) / Phi(standard)` in gloss units, with the standard error of the integration.
///
/// The error covers the integration only, not the surface: 0 for a specular core, which is integrated exactly. The
/// result is deterministic. NaN if `geometry` fails [`Geometry::validate`], if there is no azimuth, or if the receptor
/// sees nothing of the standard. Source: ISO 2813:2014; estimator as in [`super::flux`].
pub fn gloss(brdf: &dyn Brdf, geometry: &Geometry, options: &Options) -> Estimate {
    let nan = Estimate { value: f64::NAN, standard_error: f64::NAN };
    if geometry.validate().is_err() || options.azimuths.is_empty() {
        return nan;
    }
    let paths: Vec<Path> = options.azimuths.iter().map(|&phi| Path::new(geometry, phi)).collect();
    // The standard is always read at the specular angle, also for a receptor beside it.
    let specular = Geometry { offset: 0.0, ..geometry.clone() };
    let standard = Path::new(&specular, 0.0).core(|wi| fresnel::dielectric(wi.z, geometry.standard_index));
    let scale = 100.0 / (standard * paths.len() as f64);
    let core: f64 = paths.iter().map(|p| p.core(|wi| brdf.specular_core(wi))).sum();

    let replicates = options.replicates.max(2);
    let max_points = options.max_points.clamp(1, LONGEST);
    let mut sums = vec![0.0; replicates as usize];
    let (mut done, mut target) = (0, options.points.clamp(1, max_points));
    loop {
        for (replicate, sum) in (0..).zip(&mut sums) {
            let seed = options.seed.wrapping_mul(0x9E37_79B9).wrapping_add(replicate);
            for index in done..target {
                let u = sample_4d(index, 0, seed).map(f64::from);
                *sum += paths.iter().map(|p| p.estimate(brdf, u)).sum::<f64>();
            }
        }
        done = target;
        let values: Vec<f64> = sums.iter().map(|sum| scale * (core + sum / f64::from(done))).collect();
        let estimate = Estimate::from_repeats(&values);
        // Written so that a NaN from the BRDF ends the loop as well.
        let unfinished = estimate.standard_error > options.tolerance;
        if !unfinished || done >= max_points {
            return estimate;
        }
        target = done.saturating_mul(2).min(max_points);
    }
}
