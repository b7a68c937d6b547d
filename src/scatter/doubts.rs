//! Facets about which the lanes left a question open, answered many at a time.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Departure, Walk};
use super::cascade::Cascade;
use super::cells::{CellLanes, HalfVectorCells};
use super::detectors::Detectors;
use super::facet_sum::turned_back;
use super::facing::{Facing, facing};
use super::flights::Flights;
use super::lanes::{self, Glance, Lanes, Light};
use super::quick_sums::QuickSums;
use crate::facets::packet::{End, Start, Struck};
use crate::facets::visibility::Fate;
use crate::facets::{Strides, slopes};
use glam::DVec3;

/// Facets that are worth answering together.
const MANY: usize = 1024;

/// One run of cells and its light.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    pub row: usize,
    /// First column of the run.
    pub column: usize,
    pub phi: f64,
    /// Turn into the frame of the detectors.
    pub turn: f64,
    pub wi: DVec3,
    /// `wi` in the frame of the detectors.
    pub local: DVec3,
}

/// One facet, as the lanes left it.
#[derive(Clone, Copy)]
struct Doubtful {
    /// Its run, and its place there.
    run: u32,
    lane: u32,
    upper: bool,
    /// Weight and energy in steps, if it is known to be lit.
    steps: Option<[u32; 2]>,
    /// Detector of its own reflection.
    slot: u32,
}

/// Facets that wait for an answer, and where the answers go.
pub struct Doubts<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    cells: Option<CellLanes>,
    runs: Vec<Run>,
    facets: Vec<Doubtful>,
    /// Ways to the source, and out.
    sources: Vec<Start>,
    strides: Strides,
    cascade: Cascade,
    flights: Flights<'w>,
}

impl<'w, D: Detectors + ?Sized> Doubts<'w, D> {
    /// None yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        Doubts {
            walk,
            detectors,
            cells: detectors.slope_cells().map(HalfVectorCells::lanes),
            runs: Vec::new(),
            facets: Vec::new(),
            sources: Vec::new(),
            strides: Strides::default(),
            cascade: Cascade::default(),
            flights: Flights::new(walk),
        }
    }

    /// Takes the facets in doubt out of the `lanes` of a run.
    pub fn take(
        &mut self,
        run: &Run,
        light: &Light,
        upper: bool,
        lanes: &mut Lanes,
        slow: &mut Accumulator,
        fast: &mut QuickSums,
    ) {
        let before = self.facets.len();
        for group in 0..lanes.doubt.len() / 8 {
            let doubt: [u8; 8] = std::array::from_fn(|k| lanes.doubt[group * 8 + k]);
            if u64::from_ne_bytes(doubt) == 0 {
                continue;
            }
            for (k, doubt) in doubt.into_iter().enumerate() {
                if doubt != lanes::NONE {
                    self.take_one(run, light, group * 8 + k, upper, lanes, fast);
                }
            }
        }
        if self.facets.len() > before {
            self.runs.push(*run);
        }
        if self.facets.len() >= MANY {
            self.answer(slow, fast);
        }
    }

    fn take_one(&mut self, run: &Run, light: &Light, k: usize, upper: bool, lanes: &mut Lanes, fast: &mut QuickSums) {
        let field = self.walk.field;
        let cell = [run.column + k, run.row];
        let [a, b, c, d] = field.corners(cell[0], cell[1]);
        let (third, at) = if upper { (b, [2.0 / 3.0, 1.0 / 3.0]) } else { (c, [1.0 / 3.0, 2.0 / 3.0]) };
        let steps = [lanes.weight[k], lanes.energy[k]];
        let slot = lanes.slot[k];
        (lanes.weight[k], lanes.energy[k]) = (0, 0);
        let is_lit = lanes.doubt[k] == lanes::EXIT;
        let direction = if is_lit {
            let [px, py] = light.per_pitch;
            let (p, q) = if upper { (b - a, b - d) } else { (d - c, a - c) };
            Glance::new(light.wi, p * px, q * py).wo
        } else {
            light.wi
        };
        let z = (a + d + third) * (1.0 / 3.0);
        let id = self.facets.len() as u32;
        if is_lit {
            let facet = Struck { cell, upper, at, z, rise: [0.0; 2], start: [0; 2] };
            let reflectance = steps[1] as f32 / steps[0].max(1) as f32;
            if !self.cascade.push(self.walk, id, &facet, direction, reflectance) {
                return fast.add_beam(1, slot, steps);
            }
        } else {
            let end = field.reach_in_lanes(cell, z, direction).unwrap_or(0.0);
            let (cell, own) = (cell.map(|c| c as u32), 1 + u32::from(upper));
            self.sources.push(Start { id, cell, own, at, z, direction, end });
        }
        let (run, lane) = (self.runs.len() as u32, k as u32);
        self.facets.push(Doubtful { run, lane, upper, steps: is_lit.then_some(steps), slot });
    }

    /// Answers all questions.
    pub fn answer(&mut self, slow: &mut Accumulator, fast: &mut QuickSums) {
        let Doubts { walk, detectors, cells, runs, facets, sources, strides, cascade, flights } = self;
        let field = walk.field;
        let arrival = |facet: &Doubtful| arrival(walk, &runs[facet.run as usize], facet);
        strides.follow(field, sources.drain(..), |id, end| {
            let facet = &facets[id as usize];
            let Some((arrival, weight)) = arrival(facet) else { return };
            let hidden = match end {
                End::Free => false,
                End::Hit(_) => true,
                End::Unsure(_) => matches!(walk.onward(&arrival, arrival.back), Fate::Hit(_)),
            };
            if hidden {
                slow.shadowed(weight);
            } else {
                flights.start(id, arrival);
            }
        });
        cascade.land(walk, |id, freed| {
            let facet = &facets[id as usize];
            let [weight, energy] = facet.steps.unwrap_or_default();
            match freed {
                Some(beam) if beam.bounces == 1 => fast.add_beam(1, facet.slot, [weight, energy]),
                Some(beam) => {
                    let run = &runs[facet.run as usize];
                    let turn = [run.turn.cos() as f32, run.turn.sin() as f32];
                    let detector = beam.detector(*detectors, cells.as_ref(), run.local, turn);
                    let energy = (f64::from(weight) * f64::from(beam.energy)).round() as u32;
                    fast.add_beam(beam.bounces, detector, [weight, energy]);
                }
                None => {
                    if let Some((arrival, _)) = arrival(facet) {
                        flights.start(id, arrival);
                    }
                }
            }
        });
        flights.land(&mut |id, end| {
            let facet = &facets[id as usize];
            if let (Some([weight, energy]), 1, Some(_)) = (facet.steps, end.bounces, end.escaped) {
                return fast.add_beam(1, facet.slot, [weight, energy]);
            }
            if let Some((_, weight)) = arrival(facet) {
                add_end(*detectors, &runs[facet.run as usize], facet.slot as usize, weight, end, slow);
            }
        });
        facets.clear();
        runs.clear();
    }
}

/// A facet at its centroid in f64, and its weight; `None` if it just faces away.
fn arrival(walk: &Walk, run: &Run, facet: &Doubtful) -> Option<(Arrival, f64)> {
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
