//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Walk};
use super::detectors::Detectors;
use super::facet_sum::{Azimuth, turned_back};
use super::selection::{Footprint, Selection};
use super::tally::CORE_SLOPE;
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
/// `rays` points are spread uniformly over the lit part of the mean plane, widened so that every lit facet is fully lit; N
/// counts those that meet a lit facet first. Ray number j has its own random stream: same seed, same sums, for any number
/// of threads or parts.
pub fn trace_rays<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    rays: u64,
    seed: u64,
    selection: &Selection,
) -> Accumulator {
    (0..rays.div_ceil(BATCH))
        .into_par_iter()
        .filter(|&batch| selection.part.has(batch))
        .fold(
            || Accumulator::new(detectors.len()),
            |mut sum, batch| {
                for ray in batch * BATCH..((batch + 1) * BATCH).min(rays) {
                    let mut rng = CounterRng::new(seed, 1, ray);
                    trace_one(walk, detectors, theta_i, azimuth, selection.footprint, &mut rng, &mut sum);
                }
                sum
            },
        )
        .reduce(|| Accumulator::new(detectors.len()), Accumulator::merged)
}

fn trace_one<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    footprint: Option<Footprint>,
    rng: &mut CounterRng,
    sum: &mut Accumulator,
) {
    let (phi, turn) = azimuth.of(rng.uniform());
    let wi = direction(theta_i, phi);
    let Some(Launch { ray, flip, aim }) = launch(walk, wi, footprint, rng) else { return };
    let Fate::Hit(hit) = walk.field.trace(ray, None) else { return };
    if let Some(lit) = footprint {
        // Of a repeated map only the copy that the rays are aimed at is lit.
        let lean = lean(walk, wi);
        let place = [0, 1].map(|k| aim[k] + lean[k] * hit.z);
        let inside = match walk.field.map().edges {
            Edges::Open => lit.holds(hit.cell),
            Edges::Mirrored | Edges::Periodic => {
                place.iter().all(|x| *x >= 0.0) && lit.holds(place.map(|x| x as usize))
            }
        };
        if !inside {
            return;
        }
    }
    let total = [flip[0] * hit.flip[0], flip[1] * hit.flip[1]];
    let arrival = Arrival {
        point: [hit.column, hit.row, hit.z],
        facet: (hit.cell, hit.upper),
        slope: hit.slope,
        back: wi * DVec3::new(total[0], total[1], 1.0),
        flip: total,
    };
    let end = walk.follow(arrival);
    let Some((wo, energy)) = end.escaped else {
        sum.lost(1.0, end.lost);
        return;
    };
    match detectors.slope_cells() {
        Some(cells) if end.bounces == 1 => {
            if hit.slope.0.abs().max(hit.slope.1.abs()) < CORE_SLOPE {
                sum.core(1.0, energy);
            } else {
                // The slope as the unfolded map has it.
                let slope = turned_back(DVec3::new(hit.slope.0 * total[0], hit.slope.1 * total[1], 0.0), turn);
                sum.escaped(cells.locate(slope.x, slope.y), 1, 1.0, energy);
            }
        }
        _ => {
            let detector = detectors.index(direction(theta_i, phi - turn), turned_back(wo, turn));
            sum.escaped(detector, end.bounces, 1.0, energy);
        }
    }
}

struct Launch {
    ray: Ray,
    /// Flips of the mirrored tile it starts in.
    flip: [f64; 2],
    /// Point of the mean plane it is aimed at, in samples of the unfolded map.
    aim: [f64; 2],
}

/// Samples travelled along the columns and rows per metre of height on the way to the source.
fn lean(walk: &Walk, wi: DVec3) -> [f64; 2] {
    let map = walk.field.map();
    [wi.x / wi.z / map.pitch_x, -wi.y / wi.z / map.pitch_y]
}

/// A ray towards a uniform point of the lit part of the mean plane, started above the highest facet; for an open map moved
/// to where it enters the map's outline.
fn launch(walk: &Walk, wi: DVec3, footprint: Option<Footprint>, rng: &mut CounterRng) -> Option<Launch> {
    let map = walk.field.map();
    let [lowest, highest] = walk.field.height_range();
    let size = walk.field.cells().map(|n| n as f64);
    let lean = lean(walk, wi);
    let lit = footprint.unwrap_or(Footprint::whole(walk.field.cells()));
    let lit = [lit.columns, lit.rows];
    let mut aim = [0.0; 2];
    for k in 0..2 {
        // A facet at height z is met by the ray aimed at its own place minus lean * z.
        let (mut from, mut to) = (lit[k][0] as f64, lit[k][1] as f64);
        // The whole of a repeated map is lit evenly already.
        if map.edges == Edges::Open || footprint.is_some() {
            from += (-lean[k] * highest).min(-lean[k] * lowest);
            to += (-lean[k] * highest).max(-lean[k] * lowest);
        }
        aim[k] = from + (to - from) * rng.uniform();
    }
    let start = [0, 1].map(|k| aim[k] + lean[k] * highest);
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
    Some(Launch { ray, flip, aim })
}
