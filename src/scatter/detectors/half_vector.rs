//! The cells of the slope plane seen as detectors.

use super::{Bounds, Detectors};
use crate::math::{frame, half_vector};
use crate::scatter::cells::HalfVectorCells;
use crate::scatter::facing::facing;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Steps along each side of a cell when its box in theta and phi is sought.
const STEPS: usize = 8;
/// Points along each side of a cell that the horizon cuts.
const CUT: usize = 32;

impl Detectors for HalfVectorCells {
    fn len(&self) -> usize {
        HalfVectorCells::len(self)
    }

    #[inline]
    fn index(&self, wi: DVec3, wo: DVec3) -> usize {
        self.locate_pair(wi, wo)
    }

    #[inline]
    fn slope_cells(&self) -> Option<&HalfVectorCells> {
        Some(self)
    }

    /// `integral over the cell of 4 cos(beta) cos(theta_r) cos^3(theta_h) dp dq` above the horizon: by the points of
    /// [`HalfVectorCells::points`], by many more where the horizon cuts the cell.
    fn projected_solid_angle(&self, index: usize, wi: DVec3) -> f64 {
        let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(a, b)| self.slope_in(index, a, b));
        let points = self.points(index).map(|point| (point.p, point.q, point.area));
        let whole = points.iter().map(|&(p, q, _)| (p, q)).chain(corners).all(|(p, q)| jacobian(p, q, wi) > 0.0);
        if whole {
            return points.iter().map(|&(p, q, area)| area * jacobian(p, q, wi)).sum();
        }
        let middle = |k: usize| (k as f64 + 0.5) / CUT as f64;
        let sum: f64 = (0..CUT * CUT)
            .map(|k| {
                let (p, q) = self.slope_in(index, middle(k % CUT), middle(k / CUT));
                jacobian(p, q, wi)
            })
            .sum();
        sum * self.area(index) / (CUT * CUT) as f64
    }

    /// Polar angle and azimuth of the half vector.
    fn bounds(&self, index: usize) -> Bounds {
        let middle = frame::phi(normal_at(self, index, 0.5, 0.5));
        let mut theta = [PI, 0.0f64];
        let mut phi = [middle, middle];
        let step = |k: usize| k as f64 / STEPS as f64;
        for k in 0..=STEPS {
            for [a, b] in [[step(k), 0.0], [step(k), 1.0], [0.0, step(k)], [1.0, step(k)]] {
                let n = normal_at(self, index, a, b);
                let t = frame::theta(n);
                theta = [theta[0].min(t), theta[1].max(t)];
                let p = middle + (frame::phi(n) - middle + PI).rem_euclid(TAU) - PI;
                phi = [phi[0].min(p), phi[1].max(p)];
            }
        }
        let holds_the_pole = self.locate(0.0, 0.0) == index;
        if holds_the_pole {
            return Bounds { theta: [0.0, theta[1]], phi: [0.0, TAU] };
        }
        Bounds { theta, phi }
    }
}

/// `dOmega_p / dp dq` of the mirror direction of a facet of slope `(p, q)`; 0 if it lies below the horizon.
fn jacobian(p: f64, q: f64, wi: DVec3) -> f64 {
    match facing(p, q, wi) {
        Some(f) if f.wo.z > 0.0 => 4.0 * f.cos_beta * f.wo.z * half_vector(wi, f.wo).z.powi(3),
        _ => 0.0,
    }
}

fn normal_at(cells: &HalfVectorCells, index: usize, a: f64, b: f64) -> DVec3 {
    let (p, q) = cells.slope_in(index, a, b);
    frame::normal_of_slope(p, q)
}
