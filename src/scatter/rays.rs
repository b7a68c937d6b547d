//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::accumulator::{Accumulator, at_desks};
use super::beam::Beam;
use super::bounce::{Arrival, Departure, Walk};
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::facet_sum::{Azimuth, turned_back};
use super::flights::Flights;
use super::selection::Selection;
use super::tally::CORE_SLOPE;
use crate::facets::Packet;
use crate::facets::visibility::Fate;
use crate::math::{direction, random::CounterRng};
use glam::DVec3;

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// Rays followed side by side.
const TOGETHER: usize = 512;

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
    let batches: Vec<u64> = (0..rays.div_ceil(BATCH)).filter(|&batch| selection.part.has(batch)).collect();
    let new = || (Accumulator::new(detectors.len()), Shower::new(walk, detectors));
    let desks = at_desks(&batches, new, |(sum, shower), &batch| {
        let all = batch * BATCH..((batch + 1) * BATCH).min(rays);
        let mut row = patches.row_of(all.start);
        let mut lights = Vec::new();
        for some in all.clone().step_by(TOGETHER) {
            let some = some..(some + TOGETHER as u64).min(all.end);
            let mut aims = [[0.0; 3]; TOGETHER];
            for (ray, aim) in some.clone().zip(&mut aims) {
                if ray == row.end {
                    row = patches.row_of(ray);
                }
                let [a, b, c, _] = CounterRng::four(seed, 1, ray);
                let [x, y] = patches.point(&row, ray, [a, b]);
                *aim = [x, y, c];
            }
            let aims = &aims[..(some.end - some.start) as usize];
            match azimuth {
                Azimuth::Fixed(_) => shower.fall(aims.iter().map(|&[x, y, _]| (&first, [x, y])), sum),
                Azimuth::Averaged => {
                    lights.clear();
                    lights.extend(aims.iter().map(|aim| {
                        let (phi, turn) = azimuth.of(aim[2]);
                        light(phi, turn)
                    }));
                    shower.fall(lights.iter().zip(aims).map(|(light, &[x, y, _])| (light, [x, y])), sum);
                }
            }
        }
    });
    let sums = desks.into_iter().map(|(sum, _)| sum);
    sums.reduce(Accumulator::merged).unwrap_or_else(|| Accumulator::new(detectors.len()))
}

/// Light of one azimuth.
pub struct Light<'a> {
    pub beam: Beam<'a>,
    /// Turn into the frame of the detectors, and the direction to the source in it.
    pub turn: f64,
    pub local: DVec3,
}

/// Rays that fall on a map together and are counted where they end.
pub struct Shower<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    cells: Option<CellLanes>,
    packet: Packet,
    flights: Flights<'w>,
}

impl<'w, D: Detectors + ?Sized> Shower<'w, D> {
    /// No ray yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        let cells = detectors.slope_cells().map(HalfVectorCells::lanes);
        Shower { walk, detectors, cells, packet: Packet::default(), flights: Flights::new(walk) }
    }

    /// Follows and counts rays, each from its light and aimed at a place in `[0, 1]^2` of what is lit.
    pub fn fall<'l>(&mut self, rays: impl Iterator<Item = (&'l Light<'l>, [f64; 2])>, sum: &mut Accumulator) {
        let field = self.walk.field;
        let mut launched = Vec::with_capacity(TOGETHER);
        for (light, u) in rays {
            let aim = light.beam.aim(u);
            if let Some((ray, flip)) = light.beam.launch(aim) {
                self.packet.push(field, ray, None);
                launched.push((light, aim, flip));
            }
        }
        let mut struck = Vec::with_capacity(launched.len());
        for (&(light, aim, flip), fate) in launched.iter().zip(self.packet.trace(field)) {
            if let Fate::Hit(hit) = fate
                && let Some(arrival) = light.beam.arrive(aim, flip, hit)
            {
                self.flights.start(struck.len() as u32, arrival);
                struck.push((light, arrival));
            }
        }
        let (cells, detectors) = (&self.cells, self.detectors);
        self.flights.land(&mut |number, end| {
            let (light, arrival) = struck[number as usize];
            count(cells.as_ref(), detectors, light, &arrival, end, sum);
        });
    }
}

/// Counts a ray where it ended.
fn count<D: Detectors + ?Sized>(
    cells: Option<&CellLanes>,
    detectors: &D,
    light: &Light,
    arrival: &Arrival,
    end: Departure,
    sum: &mut Accumulator,
) {
    let Some((wo, energy)) = end.escaped else {
        sum.lost(1.0, end.lost);
        return;
    };
    match cells {
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
            let detector = detectors.index(light.local, turned_back(wo, light.turn));
            sum.escaped(detector, end.bounces, 1.0, energy);
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
