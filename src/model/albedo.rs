//! Directional albedo by quadrature over half vectors, and its table over `theta_i`.

use crate::math::quadrature::gauss_legendre;
use crate::math::{direction, reflect};
use crate::optics::Brdf;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

/// Nodes of the table.
const NODES: usize = 65;
/// Directions round the lobe (trapezoid rule of a periodic function) and nodes along each.
const AROUND: usize = 256;
static ALONG: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(40));
/// Nodes along a lobe whose turn about its axis is integrated in closed form.
static FINE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(200));

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
            // Nodes crowd towards the tail, where t grows as the root of a logarithm.
            let rest = 0.5 * (1.0 - node);
            let v = v_max * (1.0 - rest.powi(3));
            let t = radius((v * v).min(1.0 - f64::EPSILON));
            let wh = DVec3::new(x * t, y * t, 1.0).normalize();
            let wo = reflect(wi, wh);
            if wo.z > 0.0 {
                sum += 3.0 * rest * rest * w * v * v_max * weight(wh, wo);
            }
        }
    }
    sum / AROUND as f64
}

/// `int max(0, cos_theta_r) du dchi / (2 pi)`: mean cosine of rays about the axis `r`, `1 - cos a = versine(u)` with
/// `u` and `chi` uniform.
pub fn ray_average(r: DVec3, versine: impl Fn(f64) -> f64) -> f64 {
    let horizontal = r.x.hypot(r.y);
    let mut sum = 0.0;
    for &(node, w) in FINE.iter() {
        // u = v^2 makes the angle smooth in v at the centre of the lobe.
        let v = (node + 1.0) / 2.0;
        let versine = versine((v * v).min(1.0 - f64::EPSILON));
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        // The mean of max(0, level - swing cos chi) round the axis, in closed form.
        let (level, swing) = ((1.0 - versine) * r.z, sin * horizontal);
        sum += w
            * v
            * if level >= swing {
                level
            } else if level <= -swing {
                0.0
            } else {
                let chi = (level / swing).acos();
                (level * (PI - chi) + swing * chi.sin()) / PI
            };
    }
    sum
}

/// `E(wi)`: mean weight of `draws` draws of the model itself, for models whose sampler is good but whose albedo has no
/// quadrature of its own.
///
/// The numbers are a lattice, so the result is the same every time; 16 thousand are right to about 3e-4 where weights
/// are of order 1.
pub fn sampled_average(brdf: &(impl Brdf + ?Sized), wi: DVec3, draws: usize) -> f64 {
    // Generators of the lattice: powers of the plastic number (Roberts, The unreasonable effectiveness of
    // quasirandom sequences, 2018).
    const A: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let weight = |k: usize| {
        let u = A.map(|a| (0.5 + a * k as f64).fract());
        brdf.sample(wi, u).map_or(0.0, |draw| draw.weight)
    };
    (0..draws).map(weight).sum::<f64>() / draws as f64
}

/// Draws of [`sampled_average`] for a model whose draw takes a tenth of a microsecond.
pub const DRAWS: usize = 16_384;

/// A function of `theta_i`, tabulated once and read by interpolation.
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
        let nodes: Vec<f64> = (0..NODES).map(value).collect();
        let step = coordinate(LAST) / (READINGS - 1) as f64;
        AlbedoTable { values: (0..READINGS).map(|k| between(&nodes, k as f64 * step)).collect() }
    }

    /// Value at `theta_i` \[rad\].
    pub fn at(&self, theta_i: f64) -> f64 {
        let s = coordinate(theta_i.abs().min(LAST)) * ((READINGS - 1) as f64 / coordinate(LAST));
        let k = (s as usize).min(READINGS - 2);
        let t = (s - k as f64).min(1.0);
        self.values[k] + t * (self.values[k + 1] - self.values[k])
    }
}

/// A function of `theta_i` read by its cosine, where an angle would cost more than the lookup: linear in `sqrt cos_theta`,
/// in which reflectances are smooth from the normal to the horizon.
#[derive(Debug, Clone)]
pub struct CosineTable {
    values: Vec<f64>,
}

/// Steps of a [`CosineTable`]: within a millionth of a smooth function.
const STEPS: usize = 4096;

impl CosineTable {
    /// Tabulates `value(theta_i)`.
    pub fn new(value: impl Fn(f64) -> f64) -> Self {
        let angle = |k: usize| (k as f64 / STEPS as f64).powi(2).acos();
        CosineTable { values: (0..=STEPS).map(|k| value(angle(k))).collect() }
    }

    /// Value at `cos_theta`, clamped to `[0, 1]`.
    #[inline]
    pub fn at(&self, cos_theta: f64) -> f64 {
        let s = cos_theta.clamp(0.0, 1.0).sqrt() * STEPS as f64;
        let k = (s as usize).min(STEPS - 1);
        let t = s - k as f64;
        self.values[k] + t * (self.values[k + 1] - self.values[k])
    }
}

/// Finely spaced values that are read linearly: a millionth from the polynomial they come from.
const READINGS: usize = 32 * (NODES - 1) + 1;

/// Lagrange's polynomial through the six nearest nodes, in the table's own coordinate.
fn between(nodes: &[f64], s: f64) -> f64 {
    let first = (s as usize).saturating_sub(STENCIL / 2 - 1).min(NODES - STENCIL);
    let node = |k: usize| if first + k == NODES - 1 { coordinate(LAST) } else { (first + k) as f64 };
    (0..STENCIL)
        .map(|k| {
            let others = (0..STENCIL).filter(|&j| j != k);
            nodes[first + k] * others.map(|j| (s - node(j)) / (node(k) - node(j))).product::<f64>()
        })
        .sum()
}

/// Nodes that one value is read from.
const STENCIL: usize = 6;

/// Last node: a hair above the horizon, where formulas still hold.
const LAST: f64 = FRAC_PI_2 - 1e-4;

/// The table's own coordinate: `theta = 90 deg (1 - (1 - s / (NODES - 1))^2)`, so that the spacing shrinks towards
/// grazing.
fn coordinate(theta: f64) -> f64 {
    (1.0 - (1.0 - theta / FRAC_PI_2).max(0.0).sqrt()) * (NODES - 1) as f64
}

/// Angle of node `k`.
fn node_angle(k: usize) -> f64 {
    let s = k as f64 / (NODES - 1) as f64;
    (FRAC_PI_2 * (1.0 - (1.0 - s) * (1.0 - s))).min(LAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel;

    #[test]
    fn read_by_the_cosine_as_by_the_angle() {
        let table = CosineTable::new(|theta| fresnel::dielectric(theta.cos(), 1.5));
        for k in 0..=9000 {
            let c = (f64::from(k) * 0.01).to_radians().cos();
            let want = fresnel::dielectric(c, 1.5);
            assert!((table.at(c) - want).abs() < 1e-6, "{k}: {} {want}", table.at(c));
        }
        assert!((table.at(1.0 + 1e-16) - 0.04).abs() < 1e-12 && (table.at(-1e-9) - 1.0).abs() < 1e-12);
    }
}
