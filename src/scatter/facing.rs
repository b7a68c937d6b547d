//! One facet and one source: projected area, incidence angle, mirror direction.

use super::cells::HalfVectorCells;
use crate::math::frame;
use crate::optics::Material;
use glam::DVec3;

/// What a facet of slope `(p, q)` does with light from `wi`.
#[derive(Debug, Clone, Copy)]
pub struct Facing {
    /// Projected area per unit plan area over cos(theta_i): `cb / (ch ci) = 1 - tan(theta_i) (p cos phi_i + q sin phi_i)`.
    pub weight: f64,
    /// Cosine of the incidence angle on the facet.
    pub cos_beta: f64,
    /// Mirror direction.
    pub wo: DVec3,
}

/// Weight, incidence angle and mirror direction of a facet; `None` if it faces away from `wi`.
#[inline]
pub fn facing(p: f64, q: f64, wi: DVec3) -> Option<Facing> {
    let lean = wi.z - p * wi.x - q * wi.y;
    if lean <= 0.0 {
        return None;
    }
    let n = frame::normal_of_slope(p, q);
    Some(Facing { weight: lean / wi.z, cos_beta: lean * n.z, wo: frame::reflect(wi, n) })
}

/// `integral over a cell of R(beta) cb / (ch ci) dp dq` over the part whose mirror direction is above the
/// horizon, and the same without that condition and without R.
pub fn cell_weight(cells: &HalfVectorCells, cell: usize, wi: DVec3, material: &Material) -> (f64, f64) {
    let (mut seen, mut all) = (0.0, 0.0);
    for point in cells.points(cell) {
        if let Some(f) = facing(point.p, point.q, wi) {
            all += point.area * f.weight;
            if f.wo.z > 0.0 {
                seen += point.area * f.weight * material.reflectance(f.cos_beta);
            }
        }
    }
    (seen, all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{direction, half_vector};

    /// Against the projected area written with the normal.
    #[test]
    fn facing_weight_is_the_projected_area() {
        let wi = direction(1.0, 0.7);
        let f = facing(0.2, -0.1, wi).unwrap();
        let n = frame::normal_of_slope(0.2, -0.1);
        assert!((f.weight - n.dot(wi) / (n.z * wi.z)).abs() < 1e-14);
        assert!((f.cos_beta - n.dot(wi)).abs() < 1e-14);
        assert!((half_vector(wi, f.wo) - n).length() < 1e-14);
        assert!(facing(10.0, 0.0, direction(1.0, 0.0)).is_none());
    }
}
