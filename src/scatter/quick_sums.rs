//! Sums of beams that left for good, small enough that adding one takes a few clock ticks.

use super::accumulator::Accumulator;
use super::detectors::Detectors;
use super::lanes::{HEAVIEST_BITS, Lanes, STEP_BITS, steps};
use super::tally::BOUNCES;
use crate::facets::row_sight::RUN;

/// Squares are of energies in steps of `2^-SQUARE_BITS`.
const SQUARE_BITS: u32 = 18;

/// Facets after which a sum of squares might overflow, with room for beams that are added later than their facets.
const FULL: usize = (1 << (64 - 2 * (SQUARE_BITS + HEAVIEST_BITS))) - (1 << 14);

/// Facets of one slot: steps of energy, their squares, facets, beams. One cache access for all four.
type Bin = [u64; 4];

/// Sums of whole numbers over runs of facets, poured into an [`Accumulator`] before they overflow and at the end.
pub struct QuickSums {
    bins: Vec<Bin>,
    /// Of beams that bounced twice, and of those that bounced more often; empty until needed.
    later: [Vec<Bin>; BOUNCES - 1],
    /// Slots that are detectors; the core and the missing facets follow.
    detectors: usize,
    by_slope: bool,
    weight: u64,
    shadow: u64,
    facets: usize,
    sums: Accumulator,
}

impl QuickSums {
    /// Nothing yet.
    pub fn new<D: Detectors + ?Sized>(detectors: &D) -> Self {
        QuickSums {
            bins: vec![[0; 4]; detectors.len() + Lanes::EXTRA_SLOTS],
            later: [const { Vec::new() }; BOUNCES - 1],
            detectors: detectors.len(),
            by_slope: detectors.slope_cells().is_some(),
            weight: 0,
            shadow: 0,
            facets: 0,
            sums: Accumulator::new(detectors.len()),
        }
    }

    /// Makes room for so many facets or rays that are to be added next.
    pub fn make_room(&mut self, n: usize) {
        self.facets += n;
        if self.facets > FULL {
            self.pour();
            self.facets = n;
        }
    }

    /// Adds the facets of a run.
    pub fn add(&mut self, lanes: &Lanes) {
        self.make_room(RUN);
        for k in 0..RUN {
            let (weight, energy) = (lanes.weight[k], u64::from(lanes.energy[k]));
            let root = energy >> (STEP_BITS - SQUARE_BITS);
            let bin = &mut self.bins[lanes.slot[k] as usize];
            bin[0] += energy;
            bin[1] += root * root;
            bin[2] += 1;
            bin[3] += u64::from(weight > 0);
        }
        let sum = |steps: &[u32; RUN]| steps.iter().map(|&w| u64::from(w)).sum::<u64>();
        self.weight += sum(&lanes.weight);
        self.shadow += sum(&lanes.shadow);
    }

    /// Adds the beam of a facet that was added without it, weight and energy in steps, after so many bounces.
    #[inline]
    pub fn add_beam(&mut self, bounces: u32, slot: u32, [weight, energy]: [u32; 2]) {
        let bins = match bounces {
            1 => &mut self.bins,
            _ => {
                let bins = &mut self.later[(bounces as usize).min(BOUNCES) - 2];
                if bins.is_empty() {
                    *bins = vec![[0; 4]; self.detectors];
                }
                bins
            }
        };
        let root = u64::from(energy >> (STEP_BITS - SQUARE_BITS));
        let bin = &mut bins[slot as usize];
        bin[0] += u64::from(energy);
        bin[1] += root * root;
        bin[3] += u64::from(weight > 0);
        self.weight += u64::from(weight);
    }

    /// Adds a ray of weight 1, for which there is room, and the share of its energy that is left after so many bounces.
    #[inline]
    pub fn add_ray(&mut self, bounces: u32, slot: u32, energy: f32) {
        self.add_beam(bounces, slot, [1 << STEP_BITS, steps(energy)]);
    }

    /// All that was added.
    pub fn sums(mut self) -> Accumulator {
        self.pour();
        self.sums
    }

    fn pour(&mut self) {
        self.sums.arrived_steps(std::mem::take(&mut self.weight), STEP_BITS);
        self.sums.shadowed_steps(std::mem::take(&mut self.shadow), STEP_BITS);
        for (slot, bin) in self.bins.iter_mut().enumerate() {
            let [energy, squares, facets, beams] = std::mem::take(bin);
            let detector = (slot < self.detectors).then_some(slot);
            if beams > 0 {
                self.sums.bounced(1, detector, beams, (energy, STEP_BITS), (squares, 2 * SQUARE_BITS));
            }
            if let (Some(cell), true, true) = (detector, self.by_slope, facets > 0) {
                self.sums.asked(cell, facets);
            }
        }
        for (bins, bounces) in self.later.iter_mut().zip(2..) {
            for (detector, bin) in bins.iter_mut().enumerate() {
                let [energy, squares, _, beams] = std::mem::take(bin);
                if beams > 0 {
                    let (energy, squares) = ((energy, STEP_BITS), (squares, 2 * SQUARE_BITS));
                    self.sums.bounced(bounces, Some(detector), beams, energy, squares);
                }
            }
        }
    }
}
