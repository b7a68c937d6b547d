//! Directional albedo by quadrature over half vectors, and its table over `theta_i`.

use crate::math::quadrature::gauss_legendre;
use crate::math::{direction, frame::theta, reflect};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

/// Nodes of the table. The spacing shrinks towards grazing, where shadowing turns over within a degree.
const NODES: usize = 65;
/// Directions round the lobe (trapezoid rule of a periodic function) and nodes along each.
const AROUND: usize = 256;
static ALONG: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(40));

/// `E(wi) = int w(wh, wo) dc dchi / (2 pi)`: mean weight of half vectors drawn from a slope distribution.
///
/// Slopes are `(alpha_x t cos chi, alpha_y t sin chi)` with `t = radius(c)` the inverse of the radial
/// distribution function and `chi` uniform. Along a fixed `chi` the reflected ray is above the horizon exactly
/// for `t` below one root of a quadratic, so the integrand has no jump inside the domain: five digits, checked
/// against reference quadratures in `tests/models.rs`.
pub fn half_vector_average(
    alpha: [f64; 2],
    wi: DVec3,
    radius: impl Fn(f64) -> f64,
    distribution: impl Fn(f64) -> f64,
    weight: impl Fn(DVec3, DVec3) -> f64,
) -> f64 {
    let mut sum = 0.0;
    for k in 0..AROUND {
        let (s, c) = (TAU * (k as f64 + 0.5) / AROUND as f64).sin_cos();
        let (x, y) = (alpha[0] * c, alpha[1] * s);
        // 2 (ci + t b) > ci (1 + t^2 m): above the horizon below the positive root t.
        let (b, m) = (x * wi.x + y * wi.y, x * x + y * y);
        let limit = (b + (b * b + wi.z * wi.z * m).sqrt()) / (wi.z * m);
        // c = v^2 makes t smooth in v at the centre of the lobe.
        let v_max = distribution(limit).sqrt();
        for &(node, w) in ALONG.iter() {
            let v = v_max * (node + 1.0) / 2.0;
            let t = radius((v * v).min(1.0 - f64::EPSILON));
            let wh = DVec3::new(x * t, y * t, 1.0).normalize();
            let wo = reflect(wi, wh);
            if wo.z > 0.0 {
                sum += w * v * v_max * weight(wh, wo);
            }
        }
    }
    sum / AROUND as f64
}

/// A function of `theta_i`, tabulated once and read by cubic interpolation.
#[derive(Debug, Clone)]
pub struct AlbedoTable {
    values: Vec<f64>,
}

impl AlbedoTable {
    /// Tabulates `albedo(wi)`; `azimuths` incident azimuths are averaged (1 for an isotropic surface).
    pub fn new(azimuths: usize, albedo: impl Fn(DVec3) -> f64) -> Self {
        let value = |k: usize| {
            let sum: f64 =
                (0..azimuths).map(|a| albedo(direction(node_angle(k), TAU * a as f64 / azimuths as f64))).sum();
            sum / azimuths as f64
        };
        AlbedoTable { values: (0..NODES).map(value).collect() }
    }

    /// Value at `theta_i` [rad] by Catmull and Rom's cubic in the table's own coordinate.
    pub fn at(&self, theta_i: f64) -> f64 {
        let theta_i = theta(direction(theta_i, 0.0)).clamp(0.0, FRAC_PI_2);
        let s = (1.0 - (1.0 - theta_i / FRAC_PI_2).max(0.0).sqrt()) * (NODES - 1) as f64;
        let k = (s as usize).min(NODES - 2);
        let f = s - k as f64;
        let (v, last) = (&self.values, NODES - 1);
        // At the ends the missing neighbour continues the last step.
        let before = if k > 0 { v[k - 1] } else { 2.0 * v[0] - v[1] };
        let after = if k + 2 <= last { v[k + 2] } else { 2.0 * v[last] - v[last - 1] };
        let (a, b) = (v[k], v[k + 1]);
        let (da, db) = ((b - before) / 2.0, (after - a) / 2.0);
        let (f2, f3) = (f * f, f * f * f);
        (2.0 * f3 - 3.0 * f2 + 1.0) * a + (f3 - 2.0 * f2 + f) * da + (3.0 * f2 - 2.0 * f3) * b + (f3 - f2) * db
    }
}

/// `theta = 90 deg (1 - (1 - s)^2)`, ending a hair above the horizon where formulas still hold.
fn node_angle(k: usize) -> f64 {
    let s = k as f64 / (NODES - 1) as f64;
    (FRAC_PI_2 * (1.0 - (1.0 - s) * (1.0 - s))).min(FRAC_PI_2 - 1e-4)
}
