//! Energy per cell and the book that must close.

use crate::math::Estimate;

/// Facets flatter than this (rad) are the specular core: no lobe that f64 heights can hold is narrower.
pub const CORE_SLOPE: f64 = 1e-6;

/// Energies are kept apart by number of bounces: 1, 2, 3 and more.
pub const BOUNCES: usize = 3;

/// What the light of one incident direction became. Energies are sums of beam weights, to be divided by `incident`.
///
/// Beams are summed in an [`Accumulator`](super::Accumulator); a density or a wave is written here directly.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Escaped energy per detector, specular core excluded.
    pub energy: Vec<f64>,
    /// Sum of squared weights per detector, for the standard error.
    pub energy_squared: Vec<f64>,
    /// `energy` by number of bounces; empty if the method does not go by beams.
    pub by_bounce: Vec<[f64; BOUNCES]>,
    /// Beams per detector; empty if the method does not go by beams.
    pub hits: Vec<u64>,
    /// Escaped energy by number of bounces over all detectors and the core.
    pub bounces: [f64; BOUNCES],
    /// Escaped energy of the specular core.
    pub core: f64,
    /// Energy of all beams that met the surface.
    pub incident: f64,
    /// Energy refracted into the material.
    pub absorbed: f64,
    /// Energy still under way after the last bounce allowed, or gone through a gap or over the border downwards.
    pub lost: f64,
    /// Part of the escaped energy that was reflected more than once.
    pub multiple: f64,
    /// Projected facet area hidden from the source, relative to the lit area.
    pub shadowed: f64,
    /// Beams counted.
    pub beams: u64,
    /// Facets of each cell that were asked, hidden or not; empty if the method does not go by facets.
    pub asked: Vec<u64>,
}

/// Shares of the incident energy; they sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyBook {
    pub escaped: f64,
    pub absorbed: f64,
    pub lost: f64,
}

impl Tally {
    /// An empty tally over so many detectors.
    pub fn new(detectors: usize) -> Self {
        Tally {
            energy: vec![0.0; detectors],
            energy_squared: vec![0.0; detectors],
            by_bounce: Vec::new(),
            hits: Vec::new(),
            bounces: [0.0; BOUNCES],
            core: 0.0,
            incident: 0.0,
            absorbed: 0.0,
            lost: 0.0,
            multiple: 0.0,
            shadowed: 0.0,
            beams: 0,
            asked: Vec::new(),
        }
    }

    /// `escaped + absorbed + lost = 1`.
    pub fn book(&self) -> EnergyBook {
        let n = if self.incident > 0.0 { self.incident } else { 1.0 };
        EnergyBook {
            escaped: (self.energy.iter().sum::<f64>() + self.core) / n,
            absorbed: self.absorbed / n,
            lost: self.lost / n,
        }
    }

    /// Share of the incident energy that left after 1, 2, 3 and more bounces.
    pub fn bounce_fractions(&self) -> [f64; BOUNCES] {
        let n = if self.incident > 0.0 { self.incident } else { 1.0 };
        self.bounces.map(|b| b / n)
    }

    /// Share of the incident energy in a cell; standard error `sqrt(<w^2> - <w>^2) / sqrt(N)` of N independent beams.
    /// A tally made from a density instead of beams has no such error.
    pub fn fraction(&self, cell: usize) -> Estimate {
        if self.incident <= 0.0 {
            return Estimate::exact(0.0);
        }
        if self.beams == 0 {
            return Estimate::exact(self.energy[cell] / self.incident);
        }
        let n = self.beams as f64;
        let mean_incident = self.incident / n;
        let mean = self.energy[cell] / n;
        let variance = (self.energy_squared[cell] / n - mean * mean).max(0.0) / n;
        Estimate { value: mean / mean_incident, standard_error: variance.sqrt() / mean_incident }
    }
}
