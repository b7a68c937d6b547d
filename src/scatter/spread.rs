//! From half-vector cells to any other detectors.

use super::cells::HalfVectorCells;
use super::detectors::Detectors;
use super::facing::facing;
use crate::math::reflect;
use crate::optics::Material;
use glam::DVec3;

/// Points along each side of a cell.
const POINTS: usize = 6;

/// Sends the energy of every half-vector cell, and of the specular core, to the detectors its mirror directions reach:
/// within a cell the density of slopes is taken as even, so that a point weighs `R(beta) cb / (ch ci)`.
///
/// Returns the energy per detector; the sum is that of `energy` and `core`.
pub fn spread(
    energy: &[f64],
    core: f64,
    cells: &HalfVectorCells,
    detectors: &dyn Detectors,
    wi: DVec3,
    material: &Material,
) -> Vec<f64> {
    let mut out = vec![0.0; detectors.len()];
    out[detectors.index(wi, reflect(wi, DVec3::Z))] += core;
    let middle = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    let mut points = Vec::with_capacity(POINTS * POINTS);
    for (cell, &energy) in energy.iter().enumerate().filter(|e| *e.1 > 0.0) {
        points.clear();
        for k in 0..POINTS * POINTS {
            let (p, q) = cells.slope_in(cell, middle(k % POINTS), middle(k / POINTS));
            if let Some(f) = facing(p, q, wi).filter(|f| f.wo.z > 0.0) {
                points.push((detectors.index(wi, f.wo), f.weight * material.reflectance(f.cos_beta)));
            }
        }
        let sum: f64 = points.iter().map(|p| p.1).sum();
        if sum > 0.0 {
            points.iter().for_each(|&(detector, weight)| out[detector] += energy * weight / sum);
        } else {
            // Light that bounced more than once, at the very horizon: its cell's middle, lifted to the horizon.
            let (p, q) = cells.slope_in(cell, 0.5, 0.5);
            let down = reflect(wi, crate::math::frame::normal_of_slope(p, q));
            let level = DVec3::new(down.x, down.y, 0.0).try_normalize().unwrap_or(DVec3::X);
            out[detectors.index(wi, level)] += energy;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::scatter::detectors::Rings;

    /// A density of slopes that scatters like a Lambert surface fills every detector by its projected solid angle.
    #[test]
    fn an_even_hemisphere_stays_even() {
        let (wi, cells) = (direction(0.6, 0.4), HalfVectorCells::new([0.0; 2], [0.5; 2], 0.0, 0.001));
        let energy: Vec<f64> = (0..cells.len()).map(|k| cells.projected_solid_angle(k, wi)).collect();
        let rings = Rings::equal_area(30).unwrap();
        let out = spread(&energy, 0.0, &cells, &rings, wi, &Material::Mirror);
        assert!((out.iter().sum::<f64>() / energy.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for (k, e) in out.iter().enumerate() {
            assert!((e / (std::f64::consts::PI / 30.0) - 1.0).abs() < 0.1, "{k}: {e}");
        }
        // The core goes to the mirror direction.
        let out =
            spread(&[0.0], 0.7, &HalfVectorCells::new([0.0; 2], [0.5; 2], 0.0, 0.1), &rings, wi, &Material::Mirror);
        assert_eq!(out[rings.index(wi, direction(0.6, 0.4 + std::f64::consts::PI))], 0.7);
    }
}
