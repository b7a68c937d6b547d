//! The diffuse floor: what of a lobe is the same in every direction.

use crate::scatter::facing::facing;
use crate::scatter::{HalfVectorCells, Tally};
use glam::DVec3;
use std::f64::consts::PI;

/// Rings of equal projected solid angle over the hemisphere, and patches of each.
const RINGS: usize = 12;
const SECTORS: usize = 16;
/// Wide patches along both.
const WIDE: usize = 4;

/// A floor below this share of the escaped energy is left in the rest: no scene needs it.
const LEAST: f64 = 1e-3;

/// Diffuse albedo of a tally: pi times the largest constant that lies under the data.
///
/// The least mean of sixteen wide patches of the hemisphere, unless one of the 192 narrow ones they are made of contradicts it: by
/// more than two standard errors below, or empty where three hits or more would be due (the 95 % bound of an empty bin).
/// Single cells are not asked, so those that are empty or low by chance do not pull the floor to zero; and without
/// light in every wide patch there is none. `projected` are the projected solid angles of the cells.
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
    let mut wide = [[0.0; 2]; WIDE * WIDE];
    let mut floor = f64::INFINITY;
    for at in 0..RINGS * SECTORS {
        let group = at / SECTORS * WIDE / RINGS * WIDE + at % SECTORS * WIDE / SECTORS;
        wide[group][0] += energy[at];
        wide[group][1] += area[at];
        // A patch that the cells hardly reach, at the very horizon, says nothing by itself.
        if area[at] >= 0.25 * total / (RINGS * SECTORS) as f64 {
            let most = if energy[at] > 0.0 { energy[at] + 2.0 * squares[at].sqrt() } else { 3.0 * one };
            floor = floor.min(most / area[at]);
        }
    }
    for [energy, area] in wide {
        floor = floor.min(if area > 0.0 { energy / area } else { f64::INFINITY });
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
