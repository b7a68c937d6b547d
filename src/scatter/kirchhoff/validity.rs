//! Where rays stop to hold, and where the tangent plane does.

use crate::facets::SlopeStatistics;
use crate::heightmap::HeightMap;
use rayon::prelude::*;

/// Below this Rayleigh parameter more than 1e-4 of the reflected light is a coherent mirror beam that rays
/// know nothing of: `exp(-9) = 1.2e-4`.
pub const SMALLEST_FOR_RAYS: f64 = 9.0;

/// `g = (4 pi Sq cos_theta / lambda)^2` at specular reflection; `exp(-g)` of the reflectance is coherent.
///
/// `sq` and `wavelength` in the same unit, `theta` in rad.
/// Source: Beckmann and Spizzichino 1963, chapter 5; He et al., SIGGRAPH 1991.
pub fn rayleigh_parameter(sq: f64, theta: f64, wavelength: f64) -> f64 {
    (4.0 * std::f64::consts::PI * sq * theta.cos() / wavelength).powi(2)
}

/// What the tangent-plane approximation and its sampling ask of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentPlane {
    /// Radius of curvature \[m\]: one over the root-mean-square second derivative along x or y, the smaller.
    pub radius: f64,
    pitch: f64,
}

impl TangentPlane {
    /// Second differences of all runs of three measured points.
    pub fn measure(map: &HeightMap) -> Self {
        let (rows, columns) = map.heights.dim();
        let second = |a: f32, b: f32, c: f32, pitch: f64| {
            let d = (f64::from(a) - 2.0 * f64::from(b) + f64::from(c)) / (pitch * pitch);
            if d.is_nan() { (0.0, 0.0) } else { (d * d, 1.0) }
        };
        let add = |s: (f64, f64), t: (f64, f64)| (s.0 + t.0, s.1 + t.1);
        let sums: Vec<[(f64, f64); 2]> = (0..rows)
            .into_par_iter()
            .map(|r| {
                let row = map.heights.row(r);
                let along = (1..columns.saturating_sub(1))
                    .map(|c| second(row[c - 1], row[c], row[c + 1], map.pitch_x))
                    .fold((0.0, 0.0), add);
                let down = if r > 0 && r + 1 < rows {
                    let (above, below) = (map.heights.row(r - 1), map.heights.row(r + 1));
                    (0..columns).map(|c| second(above[c], row[c], below[c], map.pitch_y)).fold((0.0, 0.0), add)
                } else {
                    (0.0, 0.0)
                };
                [along, down]
            })
            .collect();
        let rms = |k: usize| {
            let (sum, n) = sums.iter().map(|s| s[k]).fold((0.0, 0.0), add);
            if n > 0.0 { (sum / n).sqrt() } else { 0.0 }
        };
        TangentPlane { radius: 1.0 / rms(0).max(rms(1)).max(1e-30), pitch: map.pitch_x.max(map.pitch_y) }
    }

    /// `4 pi r cos_theta / lambda`, to be well above 1 (Brekhovskikh 1952).
    pub fn brekhovskikh(&self, theta: f64, wavelength: f64) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * theta.cos() / wavelength
    }

    /// Share of the facets steeper than `lambda / (2 d (cos_theta_i + cos_theta_r))` at specular reflection: from one point
    /// to the next their phase changes by more than half a turn, so their light is put at a wrong angle.
    pub fn undersampled(&self, statistics: &SlopeStatistics, theta: f64, wavelength: f64) -> f64 {
        statistics.share_steeper(wavelength / (4.0 * self.pitch * theta.cos()))
    }
}
