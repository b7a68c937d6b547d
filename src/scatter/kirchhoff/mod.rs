//! The wave answer: the phase integral of the map itself (scalar Kirchhoff, tangent plane).
//!
//! With `v = k (wi + wo)`, `v_z = k (cos_theta_i + cos_theta_r)`, window `W` and `A = integral of W^2 dx dy`:
//!
//! `f_r = R(beta) cos^2(beta) / (lambda^2 cos^2(theta_h) cos_theta_i cos_theta_r) |I|^2 / A`,
//! `I = integral of W exp(-j v_z h) exp(-j v_xy . x) dx dy`
//!
//! (Beckmann and Spizzichino 1963, chapter 3, for the map itself instead of a random process). The half vector has the
//! slope `(p, q) = -v_xy / v_z` and `cos(beta) cos(theta_h) = (cos_theta_i + cos_theta_r) / 2`, so the same formula reads
//!
//! `f_r = R(beta) T / (4 cos_theta_i cos_theta_r cos^4(theta_h))`, `T(p, q; v_z) = |I|^2 v_z^2 / (4 pi^2 A)`:
//!
//! `T` takes the place of the density of facet slopes, its integral over the slope plane at fixed `v_z` is 1 (Parseval), and for
//! `v_z Sq >> 1` it becomes that density. One Fourier transform per `v_z` gives `T` at every slope, for every incident
//! direction that has this `v_z` somewhere in its lobe. The mean of `exp(-j v_z h)` is taken out first: its square is the
//! share of light in the coherent mirror beam, which no detector but the specular core can hold.

mod coherent;
mod density;
mod field;
mod phase;
mod series;
mod slices;
mod slots;
mod validity;
mod windows;

pub use coherent::Coherent;
pub use density::WaveDensity;
pub use field::WaveField;
pub use phase::Spectrum;
pub use series::beckmann_spizzichino;
pub use slices::Slices;
pub use validity::{SMALLEST_FOR_RAYS, TangentPlane, rayleigh_parameter};
pub use windows::{Window, Windows};

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The light of the wave calculation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Wavelength \[m\].
    #[serde(rename = "wavelength_m")]
    pub wavelength: f64,
    /// Full width of the band of wavelengths to average over \[m\]; 0 for one wavelength.
    #[serde(rename = "band_m")]
    pub band: f64,
    /// Full angle of the source to average over \[rad\]; 0 for a point. A glossmeter averages over its own source stop, so
    /// a table for it needs none.
    #[serde(rename = "source_rad")]
    pub source: f64,
}

impl Default for Wave {
    fn default() -> Self {
        Wave { wavelength: 550e-9, band: 0.0, source: 0.0 }
    }
}

impl Wave {
    /// `k = 2 pi / lambda` [1/m].
    pub fn wave_number(&self) -> f64 {
        std::f64::consts::TAU / self.wavelength
    }

    /// Directions of the source about its middle `wi` and their weights: exact for cubics over the disc (Stroud 1971, S2 3-1 with
    /// centre).
    pub fn source_points(&self, wi: DVec3) -> Vec<(DVec3, f64)> {
        if self.source <= 0.0 {
            return vec![(wi, 1.0)];
        }
        let (a, b) = crate::math::frame::tangents(wi);
        let radius = (0.5 * self.source).tan() * (2.0f64 / 3.0).sqrt();
        let mut points = vec![(wi, 0.25)];
        for k in 0..6 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 6.0).sin_cos();
            let from = (wi + radius * (cos * a + sin * b)).normalize();
            // The part of a source below the horizon lights nothing.
            if from.z > 0.0 {
                points.push((from, 0.125));
            }
        }
        points
    }

    /// Relative wave numbers of the band: at equal steps over it, enough that the speckles of neighbouring ones overlap for a
    /// surface of rms height `sq` \[m\].
    fn band_members(&self, sq: f64) -> Vec<f64> {
        let half = 0.5 * self.band / self.wavelength;
        if half <= 0.0 {
            return vec![1.0];
        }
        let phase = 2.0 * half * 2.0 * self.wave_number() * sq;
        let n = (phase.ceil() as usize).clamp(3, 24);
        (0..n).map(|k| 1.0 / (1.0 + half * (2.0 * (k as f64 + 0.5) / n as f64 - 1.0))).collect()
    }
}
