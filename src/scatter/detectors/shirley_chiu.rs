//! A square grid bent over the hemisphere: the cells of Radiance's tensor trees.

use super::equal_angle::MOST;
use super::{Bounds, Detectors};
use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// `2^k x 2^k` cells of equal projected solid angle `pi / 4^k`: a square grid mapped to the disc of direction cosines by
/// concentric squares to concentric circles (Shirley and Chiu, J. Graphics Tools 2(3), 45, 1997).
///
/// Cell `(i, j)` counts from the corner where both coordinates are least and has index `j 2^k + i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShirleyChiu {
    side: usize,
}

impl ShirleyChiu {
    /// `4^k` cells.
    ///
    /// # Errors
    /// `Error::Parameter` if `k` exceeds 10.
    pub fn new(k: u32) -> Result<Self> {
        match 4usize.checked_pow(k) {
            Some(cells) if cells <= MOST => Ok(ShirleyChiu { side: 1 << k }),
            _ => Err(Error::parameter(format!("4^{k} cells are too many"), "give shirley-chiu:K with K from 0 to 10")),
        }
    }

    /// Edges of the cell in the square `[-1, 1]^2`: `a` from, to, `b` from, to.
    fn square(&self, index: usize) -> [[f64; 2]; 2] {
        let edge = |k: usize| 2.0 * k as f64 / self.side as f64 - 1.0;
        [index % self.side, index / self.side].map(|k| [edge(k), edge(k + 1)])
    }
}

/// Point of the square `[-1, 1]^2` at radius `r` and angle `phi` of the unit disc.
fn square_of_disc(r: f64, phi: f64) -> [f64; 2] {
    // Quarters centred on the axes; in each the radius is one coordinate and the angle runs along the other.
    let turned = if phi < -FRAC_PI_4 { phi + TAU } else { phi };
    let quarter = ((turned + FRAC_PI_4) / FRAC_PI_2).floor();
    let along = r * (turned - quarter * FRAC_PI_2) / FRAC_PI_4;
    match quarter as i32 {
        0 => [r, along],
        1 => [-along, r],
        2 => [-r, -along],
        _ => [along, -r],
    }
}

/// Angle in the disc of a point of the square; the centre has none.
fn phi_of_square([a, b]: [f64; 2]) -> Option<f64> {
    if a == 0.0 && b == 0.0 {
        None
    } else if a.abs() > b.abs() {
        Some(FRAC_PI_4 * b / a + if a < 0.0 { PI } else { 0.0 })
    } else {
        Some(FRAC_PI_2 - FRAC_PI_4 * a / b + if b < 0.0 { PI } else { 0.0 })
    }
}

impl Detectors for ShirleyChiu {
    fn len(&self) -> usize {
        self.side * self.side
    }

    fn index(&self, _wi: DVec3, wo: DVec3) -> usize {
        let [a, b] = square_of_disc(wo.x.hypot(wo.y).min(1.0), wo.y.atan2(wo.x));
        let cell = |x: f64| (((x + 1.0) / 2.0 * self.side as f64) as usize).min(self.side - 1);
        cell(b) * self.side + cell(a)
    }

    fn projected_solid_angle(&self, _index: usize, _wi: DVec3) -> f64 {
        PI / self.len() as f64
    }

    fn bounds(&self, index: usize) -> Bounds {
        let [a, b] = self.square(index);
        if self.side == 1 {
            return Bounds { theta: [0.0, FRAC_PI_2], phi: [0.0, TAU] };
        }
        // Radius and angle are both extreme in corners; angles are told from the middle of the cell so as not to wrap.
        let middle = phi_of_square([0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])]).unwrap_or(0.0);
        let mut theta = [FRAC_PI_2, 0.0];
        let mut phi = [middle, middle];
        for corner in [[a[0], b[0]], [a[0], b[1]], [a[1], b[0]], [a[1], b[1]]] {
            let t = corner[0].abs().max(corner[1].abs()).asin();
            theta = [f64::min(theta[0], t), f64::max(theta[1], t)];
            if let Some(p) = phi_of_square(corner) {
                let p = middle + (p - middle + PI).rem_euclid(TAU) - PI;
                phi = [f64::min(phi[0], p), f64::max(phi[1], p)];
            }
        }
        Bounds { theta, phi }
    }
}
