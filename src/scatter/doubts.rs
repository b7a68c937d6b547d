//! Facets about which the lanes left a question open, answered many at a time.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Departure, Walk};
use super::cascade::Cascade;
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::exits::{Beam, Exits};
use super::facet_sum::turned_back;
use super::facing::{Facing, facing};
use super::flights::Flights;
use super::lanes::{self, Lanes};
use super::quick_sums::QuickSums;
use crate::facets::ends::Ends;
use crate::facets::row_sight::RUN;
use crate::facets::starts::{Start, Starts, WIDTH, make_room};
use crate::facets::visibility::Fate;
use crate::facets::{Strides, slopes};
use fearless_simd::{Level, Select, Simd, SimdBase, SimdInt, SimdMask, dispatch, f32x16, mask32x16, u32x16};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Facets that are worth answering together.
const MANY: usize = 4096;

/// One run of cells and its light.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    pub row: usize,
    /// First column of the run.
    pub column: usize,
    /// Turn into the frame of the detectors.
    pub turn: f64,
    pub wi: DVec3,
    /// `wi` in the frame of the detectors.
    pub local: DVec3,
    /// Cosine and sine of the turn.
    pub turned: [f32; 2],
}

/// A facet of a run.
#[derive(Clone, Copy)]
struct Place {
    run: u32,
    lane: u32,
    upper: bool,
}

/// Centroids of the lower and the upper facet in their cell.
const CENTROIDS: [[f32; 2]; 2] = [[1.0 / 3.0, 2.0 / 3.0], [2.0 / 3.0, 1.0 / 3.0]];

/// Facets that are lit but whose beams may be blocked, in columns with room for a vector at their ends; facet number `k` is beam
/// number `k` of the cascade.
#[derive(Default)]
struct Lit {
    cascade: Cascade,
    /// Run and lane.
    place: Vec<u32>,
    upper: Vec<u32>,
    /// In steps.
    weight: Vec<u32>,
    /// In steps, after the first reflection.
    energy: Vec<u32>,
    /// Detector of the own reflection.
    slot: Vec<u32>,
}

/// Facets that wait for an answer, and where the answers go.
pub struct Doubts<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    cells: Option<CellLanes>,
    level: Level,
    runs: Vec<Run>,
    lit: Lit,
    /// Facets of which it is not known whether they are lit, with the detectors of their own reflections; their ways to the source
    /// and how these ended.
    unknown: Vec<(Place, u32)>,
    sources: Starts,
    ends: Ends,
    strides: Strides,
    exits: Exits,
    flights: Flights<'w>,
    /// What is being followed in f64: detectors of the own reflections, and steps of weight and energy of those known to be lit.
    slow: Vec<(Place, u32, Option<[u32; 2]>)>,
}

impl<'w, D: Detectors + ?Sized> Doubts<'w, D> {
    /// None yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        Doubts {
            walk,
            detectors,
            cells: detectors.slope_cells().map(HalfVectorCells::lanes),
            level: Level::new(),
            runs: Vec::new(),
            lit: Lit::default(),
            unknown: Vec::new(),
            sources: Starts::default(),
            ends: Ends::default(),
            strides: Strides::default(),
            exits: Exits::default(),
            flights: Flights::new(walk),
            slow: Vec::new(),
        }
    }

    /// Takes the facets in doubt out of the `lanes` of a run.
    pub fn take(&mut self, run: &Run, upper: bool, lanes: &mut Lanes, slow: &mut Accumulator, fast: &mut QuickSums) {
        let worst = lanes.doubt.iter().fold(lanes::NONE, |worst, &doubt| worst.max(doubt));
        if worst == lanes::NONE {
            return;
        }
        let number = self.runs.len() as u32;
        self.runs.push(*run);
        self.lit.reserve(RUN);
        let lit = &mut self.lit;
        dispatch!(self.level, simd => take_lit(simd, run, number, upper, lanes, lit));
        if worst == lanes::ALL {
            for k in (0..RUN).filter(|&k| lanes.doubt[k] == lanes::ALL) {
                let id = self.unknown.len() as u32;
                self.unknown.push((Place { run: number, lane: k as u32, upper }, lanes.slot[k]));
                self.sources.push(&Start {
                    id,
                    cell: [run.column + k, run.row].map(|x| x as u32),
                    own: 1 + u32::from(upper),
                    at: CENTROIDS[usize::from(upper)],
                    z: lanes.z[k],
                    direction: run.wi.to_array().map(|x| x as f32),
                    end: 0.0,
                });
            }
        }
        if self.lit.cascade.n + self.unknown.len() >= MANY {
            self.answer(slow, fast);
        }
    }

    /// Answers all questions.
    pub fn answer(&mut self, slow: &mut Accumulator, fast: &mut QuickSums) {
        self.look_for_sources(slow);
        let Doubts { walk, detectors, cells, runs, lit, exits, flights, slow: waiting, .. } = self;
        let arrival = |place: &Place| arrival(walk, &runs[place.run as usize], place);
        let cascade = &mut lit.cascade;
        cascade.land(walk);
        for k in 0..cascade.n {
            let (weight, bounces) = (lit.weight[k], cascade.bounces[k]);
            if bounces == 1 {
                fast.add_beam(1, lit.slot[k], [weight, lit.energy[k]]);
                continue;
            }
            let place =
                Place { run: lit.place[k] / RUN as u32, lane: lit.place[k] % RUN as u32, upper: lit.upper[k] == 1 };
            if bounces > 1 {
                let run = &runs[place.run as usize];
                let wo = cascade.direction.each_ref().map(|x| x[k]);
                exits.push(Beam { bounces, weight, energy: cascade.energy[k] }, wo, run.local, run.turned);
            } else if let Some((arrival, _)) = arrival(&place) {
                flights.start(waiting.len() as u32, arrival);
                waiting.push((place, lit.slot[k], Some([weight, lit.energy[k]])));
            }
        }
        cascade.clear();
        exits.leave(*detectors, cells.as_ref(), |beam, slot| {
            fast.add_beam(beam.bounces, slot, [beam.weight, (f64::from(beam.energy) + 0.5) as u32]);
        });
        flights.land(&mut |id, end| {
            let (place, slot, steps) = &waiting[id as usize];
            if let (Some(steps), 1, Some(_)) = (steps, end.bounces, end.escaped) {
                return fast.add_beam(1, *slot, *steps);
            }
            if let Some((_, weight)) = arrival(place) {
                add_end(*detectors, &runs[place.run as usize], *slot as usize, weight, end, slow);
            }
        });
        waiting.clear();
        runs.clear();
    }

    /// Finds out which of the unknown facets see the source; those that do are to be followed in f64.
    fn look_for_sources(&mut self, slow: &mut Accumulator) {
        let Doubts { walk, runs, unknown, sources, ends, strides, flights, slow: waiting, .. } = self;
        if unknown.is_empty() {
            return;
        }
        sources.keep_doubtful(self.level, walk.field);
        ends.clear();
        strides.follow(walk.field, sources, ends);
        sources.n = 0;
        let mut hidden = vec![Some(false); unknown.len()];
        ends.hits.id[..ends.hits.n].iter().for_each(|&id| hidden[id as usize] = Some(true));
        ends.unsure.iter().for_each(|&(id, _)| hidden[id as usize] = None);
        for ((place, slot), hidden) in unknown.drain(..).zip(hidden) {
            let run = &runs[place.run as usize];
            let Some((arrival, weight)) = arrival(walk, run, &place) else { continue };
            if hidden.unwrap_or_else(|| matches!(walk.onward(&arrival, arrival.back), Fate::Hit(_))) {
                slow.shadowed(weight);
            } else {
                flights.start(waiting.len() as u32, arrival);
                waiting.push((place, slot, None));
            }
        }
    }
}

impl Lit {
    fn reserve(&mut self, more: usize) {
        self.cascade.reserve(more);
        let n = self.cascade.n + more;
        let Lit { cascade: _, place, upper, weight, energy, slot } = self;
        [place, upper, weight, energy, slot].into_iter().for_each(|column| make_room(column, n));
    }
}

/// Takes the beams that may be blocked out of the lanes of run `number`.
#[simd]
fn take_lit<S: Simd>(simd: S, run: &Run, number: u32, upper: bool, lanes: &mut Lanes, lit: &mut Lit) {
    const COUNT: [u32; WIDTH] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    let Lit { cascade, place, upper: uppers, weight, energy, slot } = lit;
    let count = u32x16::from_slice(simd, &COUNT);
    let splat = |x: u32| u32x16::splat(simd, x);
    for from in (0..RUN).step_by(WIDTH) {
        let to = from + WIDTH;
        let open = u32x16::from_slice(simd, &lanes.doubt[from..to]).simd_eq(lanes::EXIT);
        let bits = open.to_bitmask();
        if bits == 0 {
            continue;
        }
        let mask = mask32x16::from_bitmask(simd, bits);
        let (k, n) = (cascade.n, cascade.starts.n);
        let starts = &mut cascade.starts;
        let packed = |x: &[f32; RUN]| simd.compress_f32x16(f32x16::from_slice(simd, &x[from..to]), mask);
        let packed_words = |x: &[u32; RUN]| simd.compress_u32x16(u32x16::from_slice(simd, &x[from..to]), mask);
        let lane = simd.compress_u32x16(count + from as u32, mask);
        (lane + number * RUN as u32).store_slice(&mut place[k..k + WIDTH]);
        splat(u32::from(upper)).store_slice(&mut uppers[k..k + WIDTH]);
        packed_words(&lanes.weight).store_slice(&mut weight[k..k + WIDTH]);
        packed_words(&lanes.slot).store_slice(&mut slot[k..k + WIDTH]);
        let steps = packed_words(&lanes.energy);
        steps.store_slice(&mut energy[k..k + WIDTH]);
        steps.to_float::<f32x16<S>>().store_slice(&mut cascade.energy[k..k + WIDTH]);
        splat(1).store_slice(&mut cascade.bounces[k..k + WIDTH]);

        (count + k as u32).store_slice(&mut starts.id[n..n + WIDTH]);
        (lane + run.column as u32).store_slice(&mut starts.cell[0][n..n + WIDTH]);
        splat(run.row as u32).store_slice(&mut starts.cell[1][n..n + WIDTH]);
        splat(1 + u32::from(upper)).store_slice(&mut starts.own[n..n + WIDTH]);
        for axis in 0..2 {
            let at = f32x16::splat(simd, CENTROIDS[usize::from(upper)][axis]);
            at.store_slice(&mut starts.at[axis][n..n + WIDTH]);
        }
        packed(&lanes.z).store_slice(&mut starts.z[n..n + WIDTH]);
        for axis in 0..3 {
            let wo = packed(&lanes.wo[axis]);
            wo.store_slice(&mut starts.direction[axis][n..n + WIDTH]);
            wo.store_slice(&mut cascade.direction[axis][k..k + WIDTH]);
        }
        let beams = bits.count_ones() as usize;
        (cascade.n, starts.n) = (k + beams, n + beams);
        for steps in [&mut lanes.weight, &mut lanes.energy] {
            let left = open.select(splat(0), u32x16::from_slice(simd, &steps[from..to]));
            left.store_slice(&mut steps[from..to]);
        }
    }
}

/// A facet at its centroid in f64, and its weight; `None` if it just faces away.
fn arrival(walk: &Walk, run: &Run, facet: &Place) -> Option<(Arrival, f64)> {
    let map = walk.field.map();
    let cell = [run.column + facet.lane as usize, run.row];
    let corners = walk.field.corners(cell[0], cell[1]).map(f64::from);
    let slope = slopes::of_corners(corners, map.pitch_x, map.pitch_y)[usize::from(facet.upper)];
    let Facing { weight, .. } = facing(slope.0, slope.1, run.wi)?;
    let (u, v) = if facet.upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
    let third = corners[if facet.upper { 1 } else { 2 }];
    let point = [cell[0] as f64 + u, cell[1] as f64 + v, (corners[0] + corners[3] + third) / 3.0];
    Some((Arrival { point, facet: (cell, facet.upper), slope, back: run.wi, flip: [1.0; 2] }, weight))
}

/// Counts the beam of one facet where it ended; `slot` is the detector of its own reflection.
fn add_end<D: Detectors + ?Sized>(
    detectors: &D,
    run: &Run,
    slot: usize,
    weight: f64,
    end: Departure,
    sum: &mut Accumulator,
) {
    let Some((wo, energy)) = end.escaped else {
        sum.lost(weight, end.lost);
        return;
    };
    match detectors.slope_cells() {
        Some(cells) if end.bounces == 1 && slot < cells.len() => sum.escaped(slot, 1, weight, energy),
        Some(_) if end.bounces == 1 => sum.core(weight, energy),
        _ => {
            let detector = detectors.index(run.local, turned_back(wo, run.turn));
            sum.escaped(detector, end.bounces, weight, energy);
        }
    }
}
