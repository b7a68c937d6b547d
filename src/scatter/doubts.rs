//! Facets about which the lanes left a question open, answered many at a time.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Departure, Walk};
use super::detectors::Detectors;
use super::facet_sum::turned_back;
use super::facing::{Facing, facing};
use super::first_bounces::FirstBounces;
use super::flights::Flights;
use super::lanes::{self, Glance, Lanes, Light};
use crate::facets::packet::{End, Start};
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
    runs: Vec<Run>,
    facets: Vec<Doubtful>,
    /// Ways to the source, and out.
    sources: Vec<Start>,
    exits: Vec<Start>,
    strides: Strides,
    flights: Flights<'w>,
}

impl<'w, D: Detectors + ?Sized> Doubts<'w, D> {
    /// None yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        Doubts {
            walk,
            detectors,
            runs: Vec::new(),
            facets: Vec::new(),
            sources: Vec::new(),
            exits: Vec::new(),
            strides: Strides::default(),
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
        fast: &mut FirstBounces,
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

    fn take_one(
        &mut self,
        run: &Run,
        light: &Light,
        k: usize,
        upper: bool,
        lanes: &mut Lanes,
        fast: &mut FirstBounces,
    ) {
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
        let end = match field.end_of_way(cell, z, direction) {
            Some(end) => end,
            None if is_lit => return fast.add_beam(slot, steps),
            None => 0.0,
        };
        let start = Start {
            id: self.facets.len() as u32,
            cell: cell.map(|c| c as u32),
            own: 1 + u32::from(upper),
            at,
            z,
            direction,
            end,
        };
        (if is_lit { &mut self.exits } else { &mut self.sources }).push(start);
        let (run, lane) = (self.runs.len() as u32, k as u32);
        self.facets.push(Doubtful { run, lane, upper, steps: is_lit.then_some(steps), slot });
    }

    /// Answers all questions.
    pub fn answer(&mut self, slow: &mut Accumulator, fast: &mut FirstBounces) {
        let Doubts { walk, detectors, runs, facets, sources, exits, strides, flights } = self;
        let field = walk.field;
        let arrival = |facet: &Doubtful| arrival(walk, &runs[facet.run as usize], facet);
        strides.follow(field, sources.drain(..), |id, end| {
            let facet = &facets[id as usize];
            let Some((arrival, weight, _)) = arrival(facet) else { return };
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
        let mut ended = |id: u32, end: Departure| {
            let facet = &facets[id as usize];
            let run = &runs[facet.run as usize];
            if let Some((_, weight, _)) = arrival(facet) {
                add_end(*detectors, run, facet.slot as usize, weight, end, slow);
            }
        };
        strides.follow(field, exits.drain(..), |id, end| {
            let facet = &facets[id as usize];
            let steps = facet.steps.unwrap_or_default();
            if let End::Free = end {
                return fast.add_beam(facet.slot, steps);
            }
            let Some((arrival, _, wo)) = arrival(facet) else { return };
            let ray = arrival.onward(wo);
            let fate = match end {
                End::Hit(struck) => Fate::Hit(field.meet(&ray, struck.cell, struck.upper)),
                _ => walk.onward(&arrival, wo),
            };
            if wo.z > 0.0 && matches!(fate, Fate::Escaped(_)) {
                fast.add_beam(facet.slot, steps);
            } else {
                flights.go_on(id, arrival, &fate, &mut ended);
            }
        });
        flights.land(&mut ended);
        facets.clear();
        runs.clear();
    }
}

/// A facet at its centroid in f64, its weight and mirror direction; `None` if it just faces away.
fn arrival(walk: &Walk, run: &Run, facet: &Doubtful) -> Option<(Arrival, f64, DVec3)> {
    let map = walk.field.map();
    let cell = [run.column + facet.lane as usize, run.row];
    let corners = walk.field.corners(cell[0], cell[1]).map(f64::from);
    let slope = slopes::of_corners(corners, map.pitch_x, map.pitch_y)[usize::from(facet.upper)];
    let Facing { weight, wo, .. } = facing(slope.0, slope.1, run.wi)?;
    let (u, v) = if facet.upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
    let third = corners[if facet.upper { 1 } else { 2 }];
    let point = [cell[0] as f64 + u, cell[1] as f64 + v, (corners[0] + corners[3] + third) / 3.0];
    Some((Arrival { point, facet: (cell, facet.upper), slope, back: run.wi, flip: [1.0; 2] }, weight, wo))
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
