//! From the bins of a Fourier transform to half-vector cells.

use super::phase::Spectrum;
use crate::scatter::cells::HalfVectorCells;
use crate::scatter::rings::Rings;
use rayon::prelude::*;

/// Tasks that share the rows of a transform; each keeps its own list of slots.
const TASKS: usize = 16;

/// Points along each side of a bin: enough that each stands for a sixteenth of a cell's width at most.
const PER_CELL: f64 = 16.0;
const MOST_POINTS: usize = 8;

/// Farther from the centre than so many bins every cell is wider than `PER_CELL` bins.
const NEAR: f64 = 100.0;

/// What is counted: cells, or for an isotropic table rings that are spread over the cells afterwards.
pub(super) struct Slots<'a> {
    pub cells: &'a HalfVectorCells,
    rings: Option<Rings>,
}

impl<'a> Slots<'a> {
    pub fn new(cells: &'a HalfVectorCells, isotropic: bool) -> Self {
        Slots { cells, rings: isotropic.then(|| Rings::new(cells)) }
    }

    pub fn len(&self) -> usize {
        self.rings.as_ref().map_or(self.cells.len(), Rings::len)
    }

    #[inline]
    fn place(&self, p: f64, q: f64) -> usize {
        match &self.rings {
            Some(rings) => rings.ring(p, q),
            None => self.cells.locate(p, q),
        }
    }

    /// Energy per slot, `groups` lists one after the other; `group` says to which a bin belongs.
    pub fn count(&self, spectrum: &Spectrum, groups: usize, group: impl Fn(usize, usize) -> usize + Sync) -> Vec<f64> {
        let [columns, rows] = spectrum.size;
        let n = self.len();
        let [wide, high] = spectrum.bin();
        let bin = wide.max(high);
        let core = self.cells.width[0].min(self.cells.width[1]);
        let all_wide = core > PER_CELL * bin;
        let share = rows.div_ceil(TASKS);
        let starts: Vec<usize> = (0..rows).step_by(share).collect();
        let parts: Vec<Vec<f64>> = starts
            .into_par_iter()
            .map(|start| {
                let mut energy = vec![0.0; groups * n];
                for r in start..(start + share).min(rows) {
                    for c in 0..columns {
                        let e = f64::from(spectrum.energy[r * columns + c]);
                        if e == 0.0 {
                            continue;
                        }
                        let (p, q) = spectrum.slope(r, c);
                        let list = &mut energy[group(r, c) * n..][..n];
                        if all_wide || p.hypot(q) > NEAR * bin {
                            list[self.place(p, q)] += e;
                            continue;
                        }
                        let width = self.cells.area(self.cells.locate(p, q)).sqrt();
                        let side = ((PER_CELL * bin / width).ceil() as usize).clamp(1, MOST_POINTS);
                        let part = e / (side * side) as f64;
                        let offset = |k: usize| (k as f64 + 0.5) / side as f64 - 0.5;
                        for j in 0..side {
                            for i in 0..side {
                                list[self.place(p + wide * offset(i), q + high * offset(j))] += part;
                            }
                        }
                    }
                }
                energy
            })
            .collect();
        let mut total = vec![0.0; groups * n];
        for part in parts {
            total.iter_mut().zip(part).for_each(|(t, e)| *t += e);
        }
        total
    }

    /// Density per unit slope area and cell whose integral is 1; all zero if nothing was counted.
    pub fn density(&self, energy: &[f64]) -> Vec<f64> {
        let total: f64 = energy.iter().sum();
        if total <= 0.0 {
            return vec![0.0; self.cells.len()];
        }
        match &self.rings {
            Some(rings) => rings.spread(self.cells, energy, total),
            None => energy.iter().enumerate().map(|(k, e)| e / (total * self.cells.area(k))).collect(),
        }
    }
}
