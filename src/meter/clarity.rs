//! Image clarity by sliding combs: how sharply a surface mirrors a slit.
//!
//! `C = 100 (M - m) / (M + m)`, M and m the largest and smallest flux through a comb of equal bars and gaps as it slides
//! over the image of a slit (ASTM D5767 method B, JIS K 7374).

use crate::error::{Error, Result};
use crate::math::{Estimate, reflect};
use crate::meter::stop::{Shape, Stop};
use crate::optics::Brdf;
use glam::DVec3;
use sobol_burley::sample_4d;
use std::f64::consts::{PI, TAU};

/// Positions of the comb over one period, and points and repeats of the integration.
const POSITIONS: usize = 128;
const POINTS: u32 = 16384;
const REPEATS: u32 = 8;

/// The optics: slit, lens and combs.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageClarity {
    /// Angle of incidence \[rad\].
    pub theta_i: f64,
    /// Width and height of the slit \[m\] in the focal plane of the collimator.
    pub slit: [f64; 2],
    /// Focal length of both lenses \[m\].
    pub focal_length: f64,
    /// Full angle of the field that reaches the comb \[rad\].
    pub field: f64,
    /// Widths of the bars, equal to the gaps \[m\].
    pub combs: Vec<f64>,
}

impl Default for ImageClarity {
    /// 45 deg, slit 0.03 mm, combs 0.125 to 2 mm: third-party descriptions of the standard. Focal length 140 mm, slit height and
    /// field are chosen.
    fn default() -> Self {
        ImageClarity {
            theta_i: 45f64.to_radians(),
            slit: [0.03e-3, 1e-3],
            focal_length: 0.14,
            field: 10f64.to_radians(),
            combs: vec![0.125e-3, 0.25e-3, 0.5e-3, 1e-3, 2e-3],
        }
    }
}

impl ImageClarity {
    /// C in percent for each comb; 0 where nothing reaches it.
    ///
    /// # Errors
    /// `Error::Parameter` if a length is not positive or the field reaches below the horizon.
    pub fn measure(&self, brdf: &dyn Brdf, azimuth: f64) -> Result<Vec<Estimate>> {
        let lengths = self.slit.iter().chain(&self.combs).chain([&self.focal_length]);
        if self.combs.is_empty() || lengths.clone().any(|&l| !(l > 0.0 && l.is_finite())) {
            return Err(Error::parameter(
                "a length of the image clarity meter is not above 0",
                "give slit, focal length and combs in metres",
            ));
        }
        let slit = Shape::Rectangle(self.slit.map(|l| 2.0 * (0.5 * l / self.focal_length).atan()));
        slit.check("the slit of the image clarity meter")?;
        Shape::Disc(self.field).check("the field of the image clarity meter")?;
        let source = Stop::new(slit, self.theta_i, azimuth, 0.0);
        let receptor = Stop::new(Shape::Disc(self.field), self.theta_i, azimuth + PI, 0.0);
        if source.lowest().min(receptor.lowest()) <= 0.0 {
            return Err(Error::parameter(
                "the image clarity meter looks below the horizon",
                "make its angle or its field smaller",
            ));
        }
        let repeats: Vec<Vec<f64>> = (0..REPEATS).map(|seed| self.once(brdf, &source, &receptor, seed)).collect();
        let of = |k: usize| Estimate::from_repeats(&repeats.iter().map(|r| r[k]).collect::<Vec<_>>());
        Ok((0..self.combs.len()).map(of).collect())
    }

    /// One estimate per comb: the light folded to the comb's period, then the sliding window of half a period.
    fn once(&self, brdf: &dyn Brdf, source: &Stop, receptor: &Stop, seed: u32) -> Vec<f64> {
        let [axis, along, _] = receptor.axes();
        let [a, b] = source.half();
        let radius = receptor.shape().half_tangents()[0];
        let mut folded = vec![[0.0; POSITIONS]; self.combs.len()];
        let mut add = |wo: DVec3, flux: f64| {
            if receptor.contains(wo) && flux > 0.0 {
                let x = self.focal_length * wo.dot(along) / wo.dot(axis);
                for (bins, comb) in folded.iter_mut().zip(&self.combs) {
                    let phase = (x / (2.0 * comb)).rem_euclid(1.0);
                    bins[((phase * POSITIONS as f64) as usize).min(POSITIONS - 1)] += flux;
                }
            }
        };
        for k in 0..POINTS {
            let u = sample_4d(k, 0, seed).map(f64::from);
            let wi = source.direction([(2.0 * u[0] - 1.0) * a, (2.0 * u[1] - 1.0) * b]);
            let weight = wi.z * wi.dot(source.axes()[0]).powi(3);
            add(reflect(wi, DVec3::Z), weight * brdf.specular_core(wi));
            // Draws of the surface follow a narrow lobe, draws of the field a wide one (balance heuristic, Veach 1997).
            let by_field = |wo: DVec3| 1.0 / (PI * radius * radius * wo.dot(axis).powi(3));
            let share = |wo: DVec3| brdf.eval(wi, wo) * wo.z.max(0.0) / (brdf.pdf(wi, wo) + by_field(wo));
            if let Some(draw) = brdf.sample(wi, [u[2], u[3]]).filter(|d| !d.specular) {
                add(draw.wo, weight * share(draw.wo));
            }
            let (s, c) = (TAU * u[3]).sin_cos();
            let wo = receptor.direction([radius * u[2].sqrt() * c, radius * u[2].sqrt() * s]);
            add(wo, weight * share(wo));
        }
        folded.iter().map(contrast).collect()
    }
}

/// `100 (M - m) / (M + m)` over all positions of a window of half the period.
fn contrast(bins: &[f64; POSITIONS]) -> f64 {
    let through = |start: usize| (0..POSITIONS / 2).map(|k| bins[(start + k) % POSITIONS]).sum::<f64>();
    let (mut most, mut least) = (0.0f64, f64::INFINITY);
    for start in 0..POSITIONS {
        let flux = through(start);
        (most, least) = (most.max(flux), least.min(flux));
    }
    if most > 0.0 { 100.0 * (most - least) / (most + least) } else { 0.0 }
}
