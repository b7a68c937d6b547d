//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::accumulator::{Accumulator, at_desks};
use super::beam::Beam;
use super::bounce::{Arrival, Departure, Walk};
use super::cascade::{Cascade, Freed};
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::facet_sum::{Azimuth, turned_back};
use super::flights::Flights;
use super::glints::{self, Glint, Glints};
use super::quick_sums::QuickSums;
use super::selection::Selection;
use super::tally::CORE_SLOPE;
use crate::facets::Strides;
use crate::facets::packet::{End, Start};
use crate::math::direction;
use crate::math::random::{CounterRng, LANES};
use glam::DVec3;

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// Rays followed together.
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
    let light = |u: f64| Light::new(walk, theta_i, azimuth.of(u), selection);
    let first = [light(0.0)];
    let patches = Patches::new(rays, first[0].beam.aspect());
    let batches: Vec<u64> = (0..rays.div_ceil(BATCH)).filter(|&batch| selection.part.has(batch)).collect();
    let desks = at_desks(
        &batches,
        || Shower::new(walk, detectors),
        |shower, &batch| {
            let all = batch * BATCH..((batch + 1) * BATCH).min(rays);
            let mut row = patches.row_of(all.start);
            let (mut aims, mut lights) = (Vec::with_capacity(TOGETHER), Vec::new());
            for from in all.clone().step_by(TOGETHER) {
                aims.clear();
                lights.clear();
                for some in (from..(from + TOGETHER as u64).min(all.end)).step_by(LANES) {
                    for (ray, [a, b, c, _]) in (some..all.end).zip(CounterRng::fours(seed, 1, some)) {
                        if ray == row.end {
                            row = patches.row_of(ray);
                        }
                        aims.push(patches.point(&row, ray, [a, b]));
                        if azimuth == Azimuth::Averaged {
                            lights.push(light(c));
                        }
                    }
                }
                shower.fall(if lights.is_empty() { &first } else { &lights }, &aims);
            }
        },
    );
    let sums = desks.into_iter().map(Shower::sums);
    sums.reduce(Accumulator::merged).unwrap_or_else(|| Accumulator::new(detectors.len()))
}

/// Light of one azimuth.
pub struct Light<'a> {
    pub beam: Beam<'a>,
    /// Turn into the frame of the detectors, and the direction to the source in it.
    turn: f64,
    local: DVec3,
    /// The same for lanes, and the way of its rays.
    lanes: glints::Light,
    down: [f32; 3],
}

impl<'a> Light<'a> {
    /// Light from `theta_i` and an azimuth with its turn into the frame of the detectors.
    pub fn new(walk: &Walk<'a>, theta_i: f64, (phi, turn): (f64, f64), selection: &Selection) -> Self {
        let wi = direction(theta_i, phi);
        Light {
            beam: Beam::new(walk.field, wi, selection.footprint),
            turn,
            local: direction(theta_i, phi - turn),
            lanes: glints::Light { wi: wi.to_array().map(|x| x as f32), turn: [turn.cos() as f32, turn.sin() as f32] },
            down: wi.to_array().map(|x| -x as f32),
        }
    }
}

/// Rays that fall on a map together and are counted where they end.
pub struct Shower<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    cells: Option<CellLanes>,
    strides: Strides,
    glints: Glints,
    cascade: Cascade,
    flights: Flights<'w>,
    slow: Accumulator,
    fast: QuickSums,
}

impl<'w, D: Detectors + ?Sized> Shower<'w, D> {
    /// No ray yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        Shower {
            walk,
            detectors,
            cells: detectors.slope_cells().map(HalfVectorCells::lanes),
            strides: Strides::default(),
            glints: Glints::default(),
            cascade: Cascade::default(),
            flights: Flights::new(walk),
            slow: Accumulator::new(detectors.len()),
            fast: QuickSums::new(detectors),
        }
    }

    /// All that was counted.
    pub fn sums(self) -> Accumulator {
        self.slow.merged(self.fast.sums())
    }

    /// Follows and counts rays aimed at places in `[0, 1]^2` of what is lit, all of one light or each of its own.
    ///
    /// Where a ray meets the surface, what the facet does with it and whether its beam is free is worked out side by side in f32;
    /// what f32 cannot tell, and what meets the surface again, in f64.
    pub fn fall(&mut self, lights: &[Light], aims: &[[f64; 2]]) {
        let Shower { walk, detectors, cells, strides, glints, cascade, flights, slow, fast } = self;
        let field = walk.field;
        let (map, [_, top]) = (field.map(), field.height_range());
        let light = |k: u32| &lights[if lights.len() == 1 { 0 } else { k as usize }];
        let (mut strange, mut unsure) = (Vec::new(), Vec::new());
        let starts = aims.iter().zip(0..).filter_map(|(&u, id)| {
            let beam = &light(id).beam;
            let Some(start) = beam.start(beam.aim(u)) else {
                strange.push(id);
                return None;
            };
            let cell = start.map(|x| x as u32);
            let at = [(start[0] - f64::from(cell[0])) as f32, (start[1] - f64::from(cell[1])) as f32];
            Some(Start { id, cell, own: 0, at, z: top as f32, direction: light(id).down, end: f32::INFINITY })
        });
        glints.clear((lights.len() == 1).then_some(lights[0].lanes));
        strides.follow(field, starts, |id, end| match end {
            End::Hit(struck) if light(id).beam.lights(struck.cell) => {
                glints.push(id, &light(id).lanes, struck, field.clear_sines(struck.cell));
            }
            End::Hit(_) => {}
            End::Free | End::Unsure(_) => unsure.push(id),
        });
        glints.shine([map.pitch_x, map.pitch_y].map(|p| (1.0 / p) as f32), &walk.material);
        if let Some(cells) = cells {
            glints.locate(cells, detectors.len());
        }
        let index = |id: u32, beam: &Freed| {
            let Light { local, lanes, .. } = light(id);
            beam.detector(*detectors, cells.as_ref(), *local, lanes.turn)
        };
        let slot = |id: u32, glint: &Glint| match cells {
            Some(_) => glint.slot,
            None => index(id, &Freed { bounces: 1, wo: glint.wo, energy: glint.reflectance }),
        };
        for (k, (id, struck)) in glints.rays.iter().enumerate() {
            let glint = glints.get(k);
            if glint.is_free || !cascade.push(walk, k as u32, struck, glint.wo, glint.reflectance) {
                fast.add_ray(1, slot(*id, &glint), glint.reflectance);
            }
        }
        cascade.land(walk, |k, freed| {
            let (id, _) = glints.rays[k as usize];
            match freed {
                Some(beam) if beam.bounces == 1 => {
                    fast.add_ray(1, slot(id, &glints.get(k as usize)), beam.energy);
                }
                Some(beam) => fast.add_ray(beam.bounces, index(id, &beam), beam.energy),
                None => unsure.push(id),
            }
        });
        let strange = strange.iter().chain(&unsure);
        let others = strange.filter_map(|&id| Some((id, light(id).beam.strike(aims[id as usize])?)));
        let arrivals: Vec<(u32, Arrival)> = others.collect();
        for (k, (_, arrival)) in arrivals.iter().enumerate() {
            flights.start(k as u32, *arrival);
        }
        flights.land(&mut |k, end| {
            let (id, arrival) = &arrivals[k as usize];
            count(cells.as_ref(), *detectors, light(*id), arrival, end, slow);
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
    /// One over the number of rays.
    share: f64,
}

/// The rays of one row.
struct Row {
    start: u64,
    end: u64,
    /// One over the number of rays.
    share: f64,
}

impl Patches {
    fn new(rays: u64, aspect: f64) -> Self {
        let rows = (rays as f64 * aspect).sqrt().round();
        Patches { rays, rows: (rows as u64).clamp(1, rays.max(1)), share: 1.0 / rays as f64 }
    }

    fn row_of(&self, ray: u64) -> Row {
        let before = |row: u64| (u128::from(row) * u128::from(self.rays) / u128::from(self.rows)) as u64;
        let row = ((u128::from(ray + 1) * u128::from(self.rows) - 1) / u128::from(self.rays)) as u64;
        let (start, end) = (before(row), before(row + 1));
        Row { start, end, share: 1.0 / (end - start) as f64 }
    }

    /// The point at `jitter` of the patch of a ray.
    #[inline]
    fn point(&self, row: &Row, ray: u64, jitter: [f64; 2]) -> [f64; 2] {
        let across = (row.end - row.start) as f64;
        let down = (row.start as f64 + jitter[1] * across) * self.share;
        [((ray - row.start) as f64 + jitter[0]) * row.share, down]
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
