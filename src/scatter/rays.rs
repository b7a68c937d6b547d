//! Naive rays, the method of the paper: uniform illumination, first hit, reflect, count. Slow and honest.

use super::accumulator::{Accumulator, at_desks};
use super::beam::Beam;
use super::bounce::{Arrival, Departure, Walk};
use super::cascade::Cascade;
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::exits::{Beam as Exit, Exits};
use super::facet_sum::{Azimuth, turned_back};
use super::flights::Flights;
use super::glints::{self, Glints};
use super::quick_sums::QuickSums;
use super::selection::Selection;
use super::tally::CORE_SLOPE;
use crate::facets::Strides;
use crate::facets::ends::Ends;
use crate::facets::starts::Starts;
use crate::math::direction;
use crate::math::frame::sin_cos_turns;
use crate::math::random::{CounterRng, LANES};
use fearless_simd::Level;
use glam::DVec3;

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// Rays followed together.
const TOGETHER: usize = 2048;

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
    let first = [Light::new(walk, theta_i, azimuth.of(0.0), selection)];
    let (sin_theta, cos_theta) = theta_i.sin_cos();
    let light = |u: f64| {
        let (sin, cos) = sin_cos_turns(u);
        let wi = DVec3::new(sin_theta * cos, sin_theta * sin, cos_theta);
        Light::turned(walk, wi, [cos, sin], std::f64::consts::TAU * u, selection)
    };
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
                    let [a, b, c, _] = CounterRng::fours(seed, 1, some);
                    for (k, ray) in (some..all.end.min(some + LANES as u64)).enumerate() {
                        if ray == row.end {
                            row = patches.row_of(ray);
                        }
                        aims.push(patches.point(&row, ray, [a[k], b[k]]));
                        if azimuth == Azimuth::Averaged {
                            lights.push(light(c[k]));
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
    /// The same for lanes.
    lanes: glints::Light,
}

impl<'a> Light<'a> {
    /// Light from `theta_i` and an azimuth with its turn into the frame of the detectors.
    pub fn new(walk: &Walk<'a>, theta_i: f64, (phi, turn): (f64, f64), selection: &Selection) -> Self {
        let local = direction(theta_i, phi - turn);
        Light { local, ..Light::turned(walk, direction(theta_i, phi), [turn.cos(), turn.sin()], turn, selection) }
    }

    /// Light from `wi`, which `turn` brings to azimuth 0, and the cosine and sine of that.
    fn turned(walk: &Walk<'a>, wi: DVec3, [cos, sin]: [f64; 2], turn: f64, selection: &Selection) -> Self {
        Light {
            beam: Beam::new(walk.field, wi, selection.footprint),
            turn,
            local: DVec3::new(wi.x.hypot(wi.y), 0.0, wi.z),
            lanes: glints::Light { wi: wi.to_array().map(|x| x as f32), turn: [cos as f32, sin as f32] },
        }
    }
}

/// Rays that fall on a map together and are counted where they end.
pub struct Shower<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    cells: Option<CellLanes>,
    level: Level,
    starts: Starts,
    strides: Strides,
    ends: Ends,
    glints: Glints,
    cascade: Cascade,
    exits: Exits,
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
            level: Level::new(),
            starts: Starts::default(),
            strides: Strides::default(),
            ends: Ends::default(),
            exits: Exits::default(),
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
        let Shower {
            walk,
            detectors,
            cells,
            level,
            starts,
            strides,
            ends,
            glints,
            cascade,
            exits,
            flights,
            slow,
            fast,
        } = self;
        let field = walk.field;
        let light = |k: u32| &lights[if lights.len() == 1 { 0 } else { k as usize }];
        starts.n = 0;
        if let [light] = lights {
            light.beam.start(*level, aims, starts);
        } else {
            aims.iter().zip(lights).for_each(|(aim, light)| light.beam.start(*level, &[*aim], starts));
        }
        ends.clear();
        strides.follow(field, starts, ends);
        let mut unsure: Vec<u32> = ends.unsure.iter().map(|(id, _)| *id).collect();
        let hits = &mut ends.hits;
        if lights.iter().any(|light| light.beam.is_part()) {
            hits.retain(|hits, k| light(hits.id[k]).beam.lights([0, 1].map(|axis| hits.cell[axis][k] as usize)));
        }
        if let [light] = lights {
            glints.light_all(&light.lanes, hits.n);
        } else {
            glints.reserve(hits.n);
            for (k, &id) in hits.id[..hits.n].iter().enumerate() {
                glints.light(k, &light(id).lanes);
            }
        }
        glints.shine(field, hits, &walk.material);
        if let Some(cells) = cells {
            glints.locate(hits.n, cells, detectors.len());
        }
        let ids = hits.id[..hits.n].to_vec();
        cascade.begin(hits, glints);
        cascade.land(walk);
        fast.make_room(cascade.n);
        for (k, id) in ids.into_iter().enumerate() {
            let Light { local, lanes, .. } = light(id);
            let (bounces, energy) = (cascade.bounces[k], cascade.energy[k]);
            if bounces == 1 && cells.is_some() {
                fast.add_ray(1, glints.slot[k], energy);
            } else if bounces > 0 {
                let wo = cascade.direction.each_ref().map(|x| x[k]);
                exits.push(Exit { bounces, weight: 1, energy }, wo, *local, lanes.turn);
            } else {
                unsure.push(id);
            }
        }
        exits.leave(*detectors, cells.as_ref(), |beam, slot| fast.add_ray(beam.bounces, slot, beam.energy));
        let others = unsure.iter().filter_map(|&id| Some((id, light(id).beam.strike(aims[id as usize])?)));
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
