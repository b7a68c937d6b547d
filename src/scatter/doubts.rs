//! Facets about which the lanes left a question open, answered many at a time.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Departure, Walk};
use super::detectors::Detectors;
use super::facet_sum::turned_back;
use super::facing::{Facing, facing};
use super::first_bounces::FirstBounces;
use super::flights::Flights;
use super::lanes::{self, Lanes};
use crate::facets::visibility::Fate;
use crate::facets::{Packet, slopes};
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
struct Doubtful {
    arrival: Arrival,
    /// Mirror direction.
    wo: DVec3,
    weight: f64,
    /// Weight and energy in steps, as the lanes have them if it is known to be lit.
    steps: Option<[u32; 2]>,
    /// Detector of its own reflection.
    slot: u32,
    turn: f64,
    local: DVec3,
}

/// Facets that wait for an answer, and where the answers go.
pub struct Doubts<'w, D: Detectors + ?Sized> {
    walk: &'w Walk<'w>,
    detectors: &'w D,
    facets: Vec<Doubtful>,
    sources: Packet,
    exits: Packet,
    flights: Flights<'w>,
}

impl<'w, D: Detectors + ?Sized> Doubts<'w, D> {
    /// None yet.
    pub fn new(walk: &'w Walk<'w>, detectors: &'w D) -> Self {
        Doubts {
            walk,
            detectors,
            facets: Vec::new(),
            sources: Packet::default(),
            exits: Packet::default(),
            flights: Flights::new(walk),
        }
    }

    /// Takes the facets in doubt out of a run of lanes.
    pub fn take(&mut self, run: &Run, upper: bool, lanes: &mut Lanes, slow: &mut Accumulator, fast: &mut FirstBounces) {
        for group in 0..lanes.doubt.len() / 8 {
            if lanes.doubt[group * 8..group * 8 + 8].iter().all(|&d| d == lanes::NONE) {
                continue;
            }
            for k in group * 8..group * 8 + 8 {
                if lanes.doubt[k] != lanes::NONE {
                    self.take_one(run, k, upper, lanes);
                }
            }
        }
        if self.facets.len() >= MANY {
            self.answer(slow, fast);
        }
    }

    fn take_one(&mut self, run: &Run, k: usize, upper: bool, lanes: &mut Lanes) {
        let field = self.walk.field;
        let map = field.map();
        let cell = [run.column + k, run.row];
        let corners = field.corners(cell[0], cell[1]).map(f64::from);
        let slope = slopes::of_corners(corners, map.pitch_x, map.pitch_y)[usize::from(upper)];
        let Some(Facing { weight, wo, .. }) = facing(slope.0, slope.1, run.wi) else { return };
        let (u, v) = if upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
        let third = corners[if upper { 1 } else { 2 }];
        let point = [cell[0] as f64 + u, cell[1] as f64 + v, (corners[0] + corners[3] + third) / 3.0];
        let arrival = Arrival { point, facet: (cell, upper), slope, back: run.wi, flip: [1.0, 1.0] };
        let steps = (lanes.doubt[k] == lanes::EXIT).then_some([lanes.weight[k], lanes.energy[k]]);
        (lanes.weight[k], lanes.energy[k]) = (0, 0);
        if steps.is_none() {
            self.sources.push(field, arrival.onward(run.wi), Some(arrival.facet));
        }
        let (slot, turn, local) = (lanes.slot[k], run.turn, run.local);
        self.facets.push(Doubtful { arrival, wo, weight, steps, slot, turn, local });
    }

    /// Answers all questions.
    pub fn answer(&mut self, slow: &mut Accumulator, fast: &mut FirstBounces) {
        let field = self.walk.field;
        // First who is lit, then whose beams are free.
        let mut sights = self.sources.trace(field).iter();
        self.facets.retain(|facet| {
            let hidden = facet.steps.is_none() && matches!(sights.next(), Some(Fate::Hit(_)));
            if hidden {
                slow.shadowed(facet.weight);
            }
            !hidden
        });
        for facet in &self.facets {
            self.exits.push(field, facet.arrival.onward(facet.wo), Some(facet.arrival.facet));
        }
        let (facets, detectors) = (&self.facets, self.detectors);
        let mut ended = |k: u32, end: Departure| add_end(detectors, &facets[k as usize], end, slow);
        for (k, (facet, fate)) in facets.iter().zip(self.exits.trace(field)).enumerate() {
            match (facet.steps, fate) {
                (Some(steps), Fate::Escaped(_)) if facet.wo.z > 0.0 => fast.add_beam(facet.slot, steps),
                _ => self.flights.go_on(k as u32, facet.arrival, fate, &mut ended),
            }
        }
        self.flights.land(&mut ended);
        self.facets.clear();
    }
}

/// Counts the beam of one facet where it ended.
fn add_end<D: Detectors + ?Sized>(detectors: &D, facet: &Doubtful, end: Departure, sum: &mut Accumulator) {
    let Some((wo, energy)) = end.escaped else {
        sum.lost(facet.weight, end.lost);
        return;
    };
    let slot = facet.slot as usize;
    match detectors.slope_cells() {
        Some(cells) if end.bounces == 1 && slot < cells.len() => sum.escaped(slot, 1, facet.weight, energy),
        Some(_) if end.bounces == 1 => sum.core(facet.weight, energy),
        _ => {
            let detector = detectors.index(facet.local, turned_back(wo, facet.turn));
            sum.escaped(detector, end.bounces, facet.weight, energy);
        }
    }
}
