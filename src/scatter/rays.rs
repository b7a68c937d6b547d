//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::accumulator::Accumulator;
use super::beam::Beam;
use super::bounce::Walk;
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::facet_sum::{Azimuth, turned_back};
use super::selection::Selection;
use super::tally::CORE_SLOPE;
use crate::math::{direction, random::CounterRng};
use glam::DVec3;
use rayon::prelude::*;

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// `E_k = (1/N) sum of w_j over the rays that end in k`, `w_j` the product of R(beta) over the bounces of ray j
/// (physics of Westlund, Meyer and Hunt 2002, section 4.2.1).
///
/// The lit part of the mean plane, widened so that every lit facet is fully lit, is cut into `rays` patches of equal area; ray
/// number j is aimed at a random point of patch j, and N counts those that meet a lit facet first. Standard errors are those of
/// independent rays, which patches can only better. Ray number j has its own random stream: same seed, same
/// sums, for any number of threads or parts.
pub fn trace_rays<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    rays: u64,
    seed: u64,
    selection: &Selection,
) -> Accumulator {
    let light = |phi: f64, turn: f64| {
        let wi = direction(theta_i, phi);
        Light { beam: Beam::new(walk.field, wi, selection.footprint), turn, local: direction(theta_i, phi - turn) }
    };
    let (phi, turn) = azimuth.of(0.0);
    let first = light(phi, turn);
    let patches = Patches::new(rays, first.beam.aspect());
    let count = Count { walk, detectors, cells: detectors.slope_cells().map(HalfVectorCells::lanes) };
    (0..rays.div_ceil(BATCH))
        .into_par_iter()
        .filter(|&batch| selection.part.has(batch))
        .fold(
            || Accumulator::new(detectors.len()),
            |mut sum, batch| {
                let mut row = patches.row_of(batch * BATCH);
                for ray in batch * BATCH..((batch + 1) * BATCH).min(rays) {
                    if ray == row.end {
                        row = patches.row_of(ray);
                    }
                    let [a, b, c, _] = CounterRng::four(seed, 1, ray);
                    let u = patches.point(&row, ray, [a, b]);
                    match azimuth {
                        Azimuth::Fixed(_) => count.one(&first, u, &mut sum),
                        Azimuth::Averaged => {
                            let (phi, turn) = azimuth.of(c);
                            count.one(&light(phi, turn), u, &mut sum);
                        }
                    }
                }
                sum
            },
        )
        .reduce(|| Accumulator::new(detectors.len()), Accumulator::merged)
}

/// Light of one azimuth.
struct Light<'a> {
    beam: Beam<'a>,
    /// Turn into the frame of the detectors, and the direction to the source in it.
    turn: f64,
    local: DVec3,
}

struct Count<'a, D: Detectors + ?Sized> {
    walk: &'a Walk<'a>,
    detectors: &'a D,
    cells: Option<CellLanes>,
}

impl<D: Detectors + ?Sized> Count<'_, D> {
    /// Follows and counts the ray aimed at place `u`.
    fn one(&self, light: &Light, u: [f64; 2], sum: &mut Accumulator) {
        let Some(arrival) = light.beam.strike(u) else { return };
        let end = self.walk.follow(arrival);
        let Some((wo, energy)) = end.escaped else {
            sum.lost(1.0, end.lost);
            return;
        };
        match &self.cells {
            Some(cells) if end.bounces == 1 => {
                let (p, q) = arrival.slope;
                if p.abs() < CORE_SLOPE && q.abs() < CORE_SLOPE {
                    sum.core(1.0, energy);
                } else {
                    // The slope as the unfolded map has it.
                    let slope = turned_back(DVec3::new(p * arrival.flip[0], q * arrival.flip[1], 0.0), light.turn);
                    sum.escaped(cells.locate(slope.x as f32, slope.y as f32) as usize, 1, 1.0, energy);
                }
            }
            _ => {
                let detector = self.detectors.index(light.local, turned_back(wo, light.turn));
                sum.escaped(detector, end.bounces, 1.0, energy);
            }
        }
    }
}

/// The unit square in patches of equal area, in rows: as many as there are rays, whatever their number.
struct Patches {
    rays: u64,
    rows: u64,
}

/// The rays of one row.
struct Row {
    start: u64,
    end: u64,
}

impl Patches {
    fn new(rays: u64, aspect: f64) -> Self {
        let rows = (rays as f64 * aspect).sqrt().round();
        Patches { rays, rows: (rows as u64).clamp(1, rays.max(1)) }
    }

    fn row_of(&self, ray: u64) -> Row {
        let before = |row: u64| (u128::from(row) * u128::from(self.rays) / u128::from(self.rows)) as u64;
        let row = ((u128::from(ray + 1) * u128::from(self.rows) - 1) / u128::from(self.rays)) as u64;
        Row { start: before(row), end: before(row + 1) }
    }

    /// The point at `jitter` of the patch of a ray.
    #[inline]
    fn point(&self, row: &Row, ray: u64, jitter: [f64; 2]) -> [f64; 2] {
        let across = (row.end - row.start) as f64;
        [((ray - row.start) as f64 + jitter[0]) / across, (row.start as f64 + jitter[1] * across) / self.rays as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patches are disjoint, equal in area and leave nothing out.
    #[test]
    fn patches_tile_the_square() {
        for (rays, aspect) in [(1, 1.0), (7, 1.0), (1000, 0.1), (997, 3.0), (12, 1e-9), (12, 1e9)] {
            let patches = Patches::new(rays, aspect);
            let mut ray = 0;
            let mut bottom = 0.0;
            while ray < rays {
                let row = patches.row_of(ray);
                assert_eq!(row.start, ray);
                let mut right = 0.0;
                for ray in row.start..row.end {
                    let row = patches.row_of(ray);
                    let [low, high] = [[0.0; 2], [1.0; 2]].map(|jitter| patches.point(&row, ray, jitter));
                    assert!((low[0] - right).abs() < 1e-12 && (low[1] - bottom).abs() < 1e-12);
                    let area = (high[0] - low[0]) * (high[1] - low[1]);
                    assert!((area * rays as f64 - 1.0).abs() < 1e-9);
                    right = high[0];
                }
                assert!((right - 1.0).abs() < 1e-12);
                bottom = patches.point(&row, row.start, [0.0, 1.0])[1];
                ray = row.end;
            }
            assert!((bottom - 1.0).abs() < 1e-12);
        }
    }
}
