//! The diffuse floor: what of a lobe is the same in every direction.

use crate::scatter::facing::facing;
use crate::scatter::{HalfVectorCells, Tally};
use glam::DVec3;
use std::f64::consts::PI;

/// Rings of equal projected solid angle over the hemisphere, and patches of each.
const RINGS: usize = 12;
const SECTORS: usize = 16;

/// A floor below this share of the escaped energy is left in the rest: no scene needs it.
const LEAST: f64 = 1e-3;

/// Diffuse albedo of a tally: `F = pi min over patches of (f + 2 SE)`, over 192 patches of equal projected solid angle.
///
/// The largest constant that the data do not contradict anywhere. A single cell is not asked, only patches of the hemisphere,
/// and each with its counting error, so that cells empty or low by chance do not pull the floor to zero; a patch without
/// a hit allows three hits, the 95 % bound of an empty bin. Where a lobe really ends, patches with many hits nearby
/// and none within say so. `projected` are the projected solid angles of the cells.
pub(super) fn diffuse_albedo(
    cells: &HalfVectorCells,
    tally: &Tally,
    facets: &[f64],
    projected: &[f64],
    wi: DVec3,
) -> f64 {
    if tally.incident <= 0.0 {
        return 0.0;
    }
    let mut energy = [0.0; RINGS * SECTORS];
    let mut squares = [0.0; RINGS * SECTORS];
    let mut area = [0.0; RINGS * SECTORS];
    let mut escaped = 0.0;
    for k in 0..cells.len() {
        if projected[k] <= 0.0 && tally.energy[k] <= 0.0 {
            continue;
        }
        let share = tally.energy[k] / tally.incident;
        // A density has no beams: its facets are what was counted.
        let square = if tally.beams > 0 {
            tally.energy_squared[k] / tally.incident.powi(2)
        } else if facets[k] > 0.0 {
            share * share / facets[k]
        } else {
            0.0
        };
        escaped += share;
        let seen: Vec<usize> = cells
            .points(k)
            .iter()
            .filter_map(|point| facing(point.p, point.q, wi).filter(|f| f.wo.z > 0.0).map(|f| patch(f.wo)))
            .collect();
        for &at in &seen {
            let part = 1.0 / seen.len() as f64;
            energy[at] += share * part;
            squares[at] += square * part;
            area[at] += projected[k] * part;
        }
    }
    // Weight of one hit, for patches without any.
    let hits = if tally.beams > 0 { tally.beams as f64 } else { facets.iter().sum::<f64>() };
    let one = escaped / hits.max(1.0);
    let total: f64 = area.iter().sum();
    let mut floor = f64::INFINITY;
    for at in 0..RINGS * SECTORS {
        // A patch that the cells hardly reach, at the very horizon, says nothing.
        if area[at] < 0.25 * total / (RINGS * SECTORS) as f64 {
            continue;
        }
        let most = if energy[at] > 0.0 { energy[at] + 2.0 * squares[at].sqrt() } else { 3.0 * one };
        floor = floor.min(most / area[at]);
    }
    let albedo = floor * PI;
    if albedo.is_finite() && albedo > LEAST * escaped { albedo.min(escaped) } else { 0.0 }
}

/// Patch of a direction: `sin^2(theta)` cut evenly, and the azimuth.
fn patch(wo: DVec3) -> usize {
    let ring = (((1.0 - wo.z * wo.z) * RINGS as f64) as usize).min(RINGS - 1);
    let turn = super::nodes::turn(wo.x, wo.y) / 4.0;
    ring * SECTORS + ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
}
