//! Exact sums of beam weights: added in any order, on any thread, in any number of parts, they come out the same.

use super::tally::{BOUNCES, Tally};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Weights are counted in steps of 2^-40, up to 2^23: the projected area of a facet of slope 10^4 lit at 89.9 deg.
const STEP_BITS: u32 = 40;
const STEPS_PER_UNIT: f64 = (1u64 << STEP_BITS) as f64;
/// Squares of weights, in steps of 2^-60.
const SQUARE_SHIFT: u32 = 20;
const SQUARE_STEPS_PER_UNIT: f64 = (1u64 << 60) as f64;

/// Beams that ended in one detector after one number of bounces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
struct Bin {
    hits: u64,
    energy: i128,
    squared: i128,
}

/// What the beams of one incident direction became, in fixed point.
///
/// Sums of integers do not depend on their order, so merging is associative and exact, and `incident = escaped + absorbed
/// + lost` holds to the last bit. [`Accumulator::tally`] turns the sums into numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Accumulator {
    /// Per number of bounces (1, 2, 3 and more) and detector; the later two are empty until needed.
    bins: [Vec<Bin>; BOUNCES],
    core: i128,
    incident: i128,
    absorbed: i128,
    lost: i128,
    shadowed: i128,
    beams: u64,
    /// Facets per half-vector cell that were asked, hidden or not; empty for other detectors and for rays.
    asked: Vec<u64>,
}

/// A weight in steps; what exceeds 2^23 counts as 2^23.
#[inline]
fn steps(weight: f64) -> i64 {
    (weight * STEPS_PER_UNIT + 0.5) as i64
}

impl Accumulator {
    /// Nothing yet, over so many detectors.
    pub fn new(detectors: usize) -> Self {
        Accumulator {
            bins: [vec![Bin::default(); detectors], Vec::new(), Vec::new()],
            core: 0,
            incident: 0,
            absorbed: 0,
            lost: 0,
            shadowed: 0,
            beams: 0,
            asked: Vec::new(),
        }
    }

    /// A beam of `weight` of which the share `energy` left for `detector` after `bounces`; the rest is absorbed.
    #[inline]
    pub fn escaped(&mut self, detector: usize, bounces: u32, weight: f64, energy: f64) {
        let (incident, escaped) = self.arrived(weight, energy);
        let bin = &mut self.bins_after(bounces)[detector];
        bin.hits += 1;
        bin.energy += escaped;
        bin.squared += (escaped * escaped) >> SQUARE_SHIFT;
        self.absorbed += incident - escaped;
    }

    #[inline]
    fn bins_after(&mut self, bounces: u32) -> &mut [Bin] {
        let which = (bounces.max(1) as usize).min(BOUNCES) - 1;
        if self.bins[which].is_empty() {
            self.bins[which] = vec![Bin::default(); self.bins[0].len()];
        }
        &mut self.bins[which]
    }

    /// A beam of `weight` of which the share `energy` left as the specular core; the rest is absorbed.
    #[inline]
    pub fn core(&mut self, weight: f64, energy: f64) {
        let (incident, escaped) = self.arrived(weight, energy);
        self.core += escaped;
        self.absorbed += incident - escaped;
    }

    /// A beam of `weight` of which the share `energy` was lost; the rest is absorbed.
    #[inline]
    pub fn lost(&mut self, weight: f64, energy: f64) {
        let (incident, lost) = self.arrived(weight, energy);
        self.lost += lost;
        self.absorbed += incident - lost;
    }

    #[inline]
    fn arrived(&mut self, weight: f64, energy: f64) -> (i128, i128) {
        let incident = i128::from(steps(weight));
        self.incident += incident;
        self.beams += 1;
        (incident, i128::from(steps(weight * energy)))
    }

    /// A facet of projected area `weight` that the source does not see.
    #[inline]
    pub fn shadowed(&mut self, weight: f64) {
        self.shadowed += i128::from(steps(weight));
    }

    /// So many facets of a half-vector cell were asked.
    #[inline]
    pub fn asked(&mut self, cell: usize, facets: u64) {
        if self.asked.is_empty() {
            self.asked = vec![0; self.bins[0].len()];
        }
        self.asked[cell] += facets;
    }

    /// Beams of so much weight, whose escaped energy is added apart by [`Accumulator::bounced`]; in steps of `2^-bits`.
    pub fn arrived_steps(&mut self, weight: u64, bits: u32) {
        let weight = i128::from(weight) << (STEP_BITS - bits);
        self.incident += weight;
        self.absorbed += weight;
    }

    /// Facets of so much projected area that the source does not see, in steps of `2^-bits`.
    pub fn shadowed_steps(&mut self, weight: u64, bits: u32) {
        self.shadowed += i128::from(weight) << (STEP_BITS - bits);
    }

    /// So many beams that left for a detector, or as the specular core, after `bounces`: sums of their energies and of their
    /// squares, each with the bits of its step.
    pub fn bounced(
        &mut self,
        bounces: u32,
        detector: Option<usize>,
        beams: u64,
        energy: (u64, u32),
        squared: (u64, u32),
    ) {
        let energy = i128::from(energy.0) << (STEP_BITS - energy.1);
        match detector {
            Some(detector) => {
                let bin = &mut self.bins_after(bounces)[detector];
                bin.hits += beams;
                bin.energy += energy;
                bin.squared += i128::from(squared.0) << (2 * STEP_BITS - SQUARE_SHIFT - squared.1);
            }
            None => self.core += energy,
        }
        self.absorbed -= energy;
        self.beams += beams;
    }

    /// Number of detectors.
    pub fn detectors(&self) -> usize {
        self.bins[0].len()
    }

    /// Adds a part over the same detectors; the order of parts does not matter.
    pub fn merge(&mut self, other: &Accumulator) {
        for (a, b) in self.bins.iter_mut().zip(&other.bins) {
            if a.is_empty() {
                a.clone_from(b);
                continue;
            }
            for (a, b) in a.iter_mut().zip(b) {
                a.hits += b.hits;
                a.energy += b.energy;
                a.squared += b.squared;
            }
        }
        self.core += other.core;
        self.incident += other.incident;
        self.absorbed += other.absorbed;
        self.lost += other.lost;
        self.shadowed += other.shadowed;
        self.beams += other.beams;
        if self.asked.is_empty() {
            self.asked.clone_from(&other.asked);
        } else {
            self.asked.iter_mut().zip(&other.asked).for_each(|(a, b)| *a += b);
        }
    }

    /// The sum of two parts, for `reduce`.
    pub fn merged(mut self, other: Accumulator) -> Accumulator {
        self.merge(&other);
        self
    }

    /// The sums as numbers.
    pub fn tally(&self) -> Tally {
        let number = |steps: i128| steps as f64 / STEPS_PER_UNIT;
        let n = self.detectors();
        let mut tally = Tally::new(n);
        tally.by_bounce = vec![[0.0; BOUNCES]; n];
        tally.hits = vec![0; n];
        for k in 0..n {
            let (mut energy, mut squared) = (0, 0);
            for (b, bins) in self.bins.iter().enumerate() {
                let Some(bin) = bins.get(k) else { continue };
                energy += bin.energy;
                squared += bin.squared;
                tally.hits[k] += bin.hits;
                tally.by_bounce[k][b] = number(bin.energy);
            }
            tally.energy[k] = number(energy);
            tally.energy_squared[k] = squared as f64 / SQUARE_STEPS_PER_UNIT;
        }
        let bounced = |b: usize| self.bins[b].iter().map(|bin| bin.energy).sum::<i128>();
        tally.bounces = [number(bounced(0) + self.core), number(bounced(1)), number(bounced(2))];
        tally.multiple = number(bounced(1) + bounced(2));
        tally.core = number(self.core);
        tally.incident = number(self.incident);
        tally.absorbed = number(self.absorbed);
        tally.lost = number(self.lost);
        tally.shadowed = number(self.shadowed) / number(self.incident).max(f64::MIN_POSITIVE);
        tally.beams = self.beams;
        tally.asked.clone_from(&self.asked);
        tally
    }
}

/// Works off `items` on all threads, each item at a free desk: as many desks are set up as threads are at work, not as many
/// as there are pieces of work. Which item meets which desk is left to chance, so what lies on the desks must be sums that do
/// not depend on it.
pub fn at_desks<I: Sync, T: Send>(items: &[I], new: impl Fn() -> T + Sync, work: impl Fn(&mut T, &I) + Sync) -> Vec<T> {
    let free = Mutex::new(Vec::new());
    let desks = || free.lock().unwrap_or_else(PoisonError::into_inner);
    items.par_iter().for_each(|item| {
        let desk = desks().pop();
        let mut desk = desk.unwrap_or_else(&new);
        work(&mut desk, item);
        desks().push(desk);
    });
    free.into_inner().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    /// Random beams, of which those with `n % of == part` are added.
    fn run(part: u64, of: u64) -> Accumulator {
        let mut sum = Accumulator::new(7);
        for n in (0..5000).filter(|n| n % of == part) {
            let mut rng = CounterRng::new(3, 0, n);
            let (weight, energy) = (20.0 * rng.uniform().powi(6), rng.uniform());
            match n % 11 {
                0 => sum.lost(weight, energy),
                1 => sum.core(weight, energy),
                2 => sum.shadowed(weight),
                _ => sum.escaped((n * 13 % 7) as usize, 1 + (n % 5) as u32, weight, energy),
            }
            sum.asked((n % 7) as usize, 1);
        }
        sum
    }

    #[test]
    fn parts_merge_to_the_same_bits_in_any_order() {
        let whole = run(0, 1);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| run(k, 4));
        assert_eq!(a.clone().merged(b.clone()).merged(c.clone()).merged(d.clone()), whole);
        assert_eq!(d.merged(b.merged(a.merged(c))), whole);
        assert_eq!(Accumulator::new(7).merged(whole.clone()), whole);
    }

    #[test]
    fn numbers_are_the_sums_of_the_weights() {
        let tally = run(0, 1).tally();
        let book = tally.book();
        assert!((book.escaped + book.absorbed + book.lost - 1.0).abs() < 1e-15);
        let mut energy = [0.0; 7];
        let mut squared = [0.0; 7];
        let mut hits = [0; 7];
        for n in 0..5000u64 {
            let mut rng = CounterRng::new(3, 0, n);
            let (weight, share) = (20.0 * rng.uniform().powi(6), rng.uniform());
            if n % 11 > 2 {
                let k = (n * 13 % 7) as usize;
                energy[k] += weight * share;
                squared[k] += (weight * share).powi(2);
                hits[k] += 1;
            }
        }
        for k in 0..7 {
            assert!((tally.energy[k] / energy[k] - 1.0).abs() < 1e-12);
            assert!((tally.energy_squared[k] / squared[k] - 1.0).abs() < 1e-12);
            assert_eq!(tally.hits[k], hits[k]);
            assert!((tally.by_bounce[k].iter().sum::<f64>() - tally.energy[k]).abs() < 1e-12);
        }
        assert!((tally.bounces.iter().sum::<f64>() / tally.incident - book.escaped).abs() < 1e-15);
        assert!(tally.multiple > 0.0 && tally.shadowed > 0.0 && tally.core > 0.0);
    }

    /// Nothing a facet can weigh breaks the book: huge, tiny, not a number.
    #[test]
    fn the_book_closes_for_absurd_weights() {
        for weight in [1e-30, 1e30, f64::INFINITY, f64::NAN] {
            let mut sum = Accumulator::new(1);
            sum.escaped(0, 1, weight, 0.3);
            sum.lost(weight, 0.9);
            let tally = sum.tally();
            assert_eq!(tally.energy[0] + tally.absorbed + tally.lost, tally.incident, "{weight}");
        }
    }
}
