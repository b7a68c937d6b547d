//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::bounce::{Arrival, Walk};
use super::cells::HalfVectorCells;
use super::facet_sum::{Azimuth, turned_back};
use super::tally::{CORE_SLOPE, Tally};
use crate::facets::visibility::{Fate, Ray};
use crate::heightmap::Edges;
use crate::math::{direction, random::CounterRng};
use glam::DVec3;
use rayon::prelude::*;

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// `E_k = (1/N) sum of w_j over the rays that end in k`, `w_j` the product of R(beta) over the bounces of ray j
/// (physics of Westlund, Meyer and Hunt 2002, section 4.2.1).
///
/// `rays` points are spread uniformly over the mean plane, widened so that every facet is fully lit; N counts those
/// that meet the surface. Ray number j has its own random stream: same seed, same tally, for any number of threads.
pub fn trace_rays(walk: &Walk, cells: &HalfVectorCells, theta_i: f64, azimuth: Azimuth, rays: u64, seed: u64) -> Tally {
    let batches: Vec<u64> = (0..rays.div_ceil(BATCH)).collect();
    let parts: Vec<Tally> = batches
        .into_par_iter()
        .map(|batch| {
            let mut tally = Tally::new(cells.len());
            for ray in batch * BATCH..((batch + 1) * BATCH).min(rays) {
                let mut rng = CounterRng::new(seed, 1, ray);
                trace_one(walk, cells, theta_i, azimuth, &mut rng, &mut tally);
            }
            tally
        })
        .collect();
    Tally::merged(cells.len(), parts)
}

fn trace_one(
    walk: &Walk,
    cells: &HalfVectorCells,
    theta_i: f64,
    azimuth: Azimuth,
    rng: &mut CounterRng,
    tally: &mut Tally,
) {
    let (phi, turn) = azimuth.of(rng.uniform());
    let wi = direction(theta_i, phi);
    let Some((ray, flip)) = launch(walk, wi, rng) else { return };
    let Fate::Hit(hit) = walk.field.trace(ray, None) else { return };
    let total = [flip[0] * hit.flip[0], flip[1] * hit.flip[1]];
    let arrival = Arrival {
        point: [hit.column, hit.row, hit.z],
        facet: (hit.cell, hit.upper),
        slope: hit.slope,
        back: wi * DVec3::new(total[0], total[1], 1.0),
        flip: total,
    };
    tally.incident += 1.0;
    tally.beams += 1;
    let end = walk.follow(arrival);
    tally.absorbed += end.absorbed;
    tally.lost += end.lost;
    let Some((wo, energy)) = end.escaped else { return };
    if end.bounces > 1 {
        tally.multiple += energy;
        tally.add(cells.locate_pair(direction(theta_i, phi - turn), turned_back(wo, turn)), energy);
    } else if hit.slope.0.abs().max(hit.slope.1.abs()) < CORE_SLOPE {
        tally.core += energy;
    } else {
        // The slope as the unfolded map has it.
        let slope = turned_back(DVec3::new(hit.slope.0 * total[0], hit.slope.1 * total[1], 0.0), turn);
        tally.add(cells.locate(slope.x, slope.y), energy);
    }
}

/// A ray towards a uniform point of the mean plane, started above the highest facet; for an open map moved to where
/// it enters the map's outline. Also the flips of the mirrored tile it starts in.
fn launch(walk: &Walk, wi: DVec3, rng: &mut CounterRng) -> Option<(Ray, [f64; 2])> {
    let map = walk.field.map();
    let [lowest, highest] = walk.field.height_range();
    let size = walk.field.cells().map(|n| n as f64);
    // Samples travelled along the columns and rows per metre of height on the way to the source.
    let lean = [wi.x / wi.z / map.pitch_x, -wi.y / wi.z / map.pitch_y];
    let mut start = [0.0; 2];
    for k in 0..2 {
        // A facet at height z is met by the ray aimed at its own place minus lean * z.
        let (mut from, mut to) = (0.0, size[k]);
        if map.edges == Edges::Open {
            from += (-lean[k] * highest).min(-lean[k] * lowest);
            to += (-lean[k] * highest).max(-lean[k] * lowest);
        }
        start[k] = from + (to - from) * rng.uniform() + lean[k] * highest;
    }
    let mut ray = Ray { column: start[0], row: start[1], z: highest, direction: -wi };
    let mut flip = [1.0, 1.0];
    match map.edges {
        Edges::Periodic => {
            ray.column = ray.column.rem_euclid(size[0]);
            ray.row = ray.row.rem_euclid(size[1]);
        }
        Edges::Mirrored => {
            for (k, place) in [&mut ray.column, &mut ray.row].into_iter().enumerate() {
                let folded = place.rem_euclid(2.0 * size[k]);
                *place = if folded > size[k] { 2.0 * size[k] - folded } else { folded };
                flip[k] = if folded > size[k] { -1.0 } else { 1.0 };
            }
            ray.direction *= DVec3::new(flip[0], flip[1], 1.0);
        }
        Edges::Open => {
            // Enter the outline from the side if the start lies outside it.
            let drop = |place: f64, k: usize| {
                let outside = if place < 0.0 { place } else { (place - size[k]).max(0.0) };
                if outside == 0.0 { 0.0 } else { outside / lean[k] }
            };
            let fall = drop(ray.column, 0).max(drop(ray.row, 1));
            if fall > 0.0 {
                ray.column -= lean[0] * fall;
                ray.row -= lean[1] * fall;
                ray.z -= fall;
                let slack = 1e-9 * size[0].max(size[1]);
                if ray.column < -slack || ray.column > size[0] + slack || ray.row < -slack || ray.row > size[1] + slack
                {
                    return None;
                }
                ray.column = ray.column.clamp(0.0, size[0]);
                ray.row = ray.row.clamp(0.0, size[1]);
                // Under the surface's border: this ray passes below the measured sheet.
                if walk.field.height_at(ray.column, ray.row).is_some_and(|h| ray.z < h) {
                    return None;
                }
            }
        }
    }
    Some((ray, flip))
}
