//! One pass over the facets that serves every incident direction for which nothing is hidden.

use super::cells::HalfVectorCells;
use super::facing::facing;
use super::lanes::{self, Lanes};
use super::rings::Rings;
use super::tally::Tally;
use crate::facets::distribution::Hiding;
use crate::facets::slopes;
use crate::heightmap::HeightMap;
use crate::optics::Material;
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use rayon::prelude::*;

/// Sub-areas along each axis: their scatter is the map-to-map error.
pub const SUBAREAS_PER_AXIS: usize = 4;

/// Density of facets in the slope plane: `P_k = count_k / (M area_k)`, for the map and for its sub-areas.
#[derive(Debug, Clone)]
pub struct SlopeDensity {
    /// Density per unit slope area and cell, specular core excluded.
    pub density: Vec<f64>,
    /// Share of the facets that are the specular core.
    pub core: f64,
    /// The same densities for each sub-area that has facets.
    pub subareas: Vec<Vec<f64>>,
}

/// Moves the counts of both halves of each sub-area to the sums, which have no slot for missing facets.
fn pour(counts: &mut [u32], sums: &mut [u64], size: usize) {
    for (both, sums) in counts.chunks_mut(2 * size).zip(sums.chunks_mut(size + 1 - Lanes::EXTRA_SLOTS)) {
        let (even, odd) = both.split_at(size);
        sums.iter_mut().zip(even.iter().zip(odd)).for_each(|(sum, (a, b))| *sum += u64::from(*a) + u64::from(*b));
        both.fill(0);
    }
}

impl SlopeDensity {
    /// Counts the facets of `map` into `cells`; `isotropic`: into rings, which are then spread over the cells.
    pub fn measure(map: &HeightMap, cells: &HalfVectorCells, isotropic: bool) -> Self {
        let (nx, ny) = slopes::cells(map);
        let rings = isotropic.then(|| Rings::new(cells));
        let n = rings.as_ref().map_or(cells.len(), Rings::len);
        let across = SUBAREAS_PER_AXIS;
        let level = Level::new();
        let ring_lanes = rings.as_ref().map(Rings::lanes);
        let cell_lanes = cells.lanes();
        // Counts of the places and of the core for each sub-area of a band.
        let counts: Vec<Vec<u64>> = (0..across)
            .into_par_iter()
            .map(|band| {
                let size = n + Lanes::EXTRA_SLOTS;
                // Neighbours often fall into the same place; counting them apart does not wait for the last sum.
                let mut counts = vec![0u32; 2 * across * size];
                let mut sums = vec![0u64; across * (n + 1)];
                let mut slots = vec![0u32; nx];
                for row in band * ny / across..(band + 1) * ny / across {
                    slopes::visit_lanes(map, row..row + 1, |p, q| {
                        match ring_lanes {
                            Some(at) => dispatch!(level, simd =>
                                lanes::slots(simd, p, q, |p, q| at.ring(p, q), n as u32, &mut slots)),
                            None => dispatch!(level, simd =>
                                lanes::slots(simd, p, q, |p, q| cell_lanes.locate(p, q), n as u32, &mut slots)),
                        }
                        for (k, both) in counts.chunks_mut(2 * size).enumerate() {
                            let (even, odd) = both.split_at_mut(size);
                            let mut pairs = slots[k * nx / across..(k + 1) * nx / across].chunks_exact(2);
                            for pair in &mut pairs {
                                even[pair[0] as usize] += 1;
                                odd[pair[1] as usize] += 1;
                            }
                            pairs.remainder().iter().for_each(|&slot| even[slot as usize] += 1);
                        }
                    });
                    // Long before a count could overflow.
                    if row % 1024 == 1023 {
                        pour(&mut counts, &mut sums, size);
                    }
                }
                pour(&mut counts, &mut sums, n + Lanes::EXTRA_SLOTS);
                sums
            })
            .collect();
        let per_subarea: Vec<&[u64]> = counts.iter().flat_map(|band| band.chunks(n + 1)).collect();
        let mut total = vec![0u64; n + 1];
        for counts in &per_subarea {
            total.iter_mut().zip(*counts).for_each(|(t, c)| *t += c);
        }
        let density_of = |counts: &[u64]| {
            let facets = counts.iter().sum::<u64>() as f64;
            match &rings {
                Some(rings) => {
                    let counts: Vec<f64> = counts[..n].iter().map(|&c| c as f64).collect();
                    rings.spread(cells, &counts, facets)
                }
                None => (0..n).map(|k| counts[k] as f64 / (facets * cells.area(k))).collect(),
            }
        };
        SlopeDensity {
            density: density_of(&total),
            core: total[n] as f64 / total.iter().sum::<u64>() as f64,
            subareas: per_subarea.iter().filter(|c| c.iter().any(|&x| x > 0)).map(|c| density_of(c)).collect(),
        }
    }

    /// `E_k = P_k * integral G R(beta) cb / (ch ci) dp dq / sum`, with Smith's masking-shadowing G of the measured slopes.
    ///
    /// What G hides, or mirrors below the horizon, would meet the surface again: it is `lost`, and its share says
    /// whether this shortcut may be taken.
    pub fn tally(&self, cells: &HalfVectorCells, wi: DVec3, material: &Material, hiding: &Hiding) -> Tally {
        let mut tally = Tally::new(cells.len());
        let mut facing_area = 0.0;
        let mut escaping = 0.0;
        for (k, &density) in self.density.iter().enumerate() {
            if density == 0.0 {
                continue;
            }
            for point in cells.points(k) {
                let Some(f) = facing(point.p, point.q, wi) else { continue };
                let beam = density * point.area * f.weight;
                facing_area += beam;
                if f.wo.z > 0.0 {
                    let seen = beam * hiding.visible(wi.z, f.wo.z);
                    let reflected = seen * material.reflectance(f.cos_beta);
                    escaping += seen;
                    tally.energy[k] += reflected;
                    tally.absorbed += seen - reflected;
                }
            }
        }
        let reflectance = material.reflectance(wi.z);
        tally.core = self.core * reflectance;
        tally.absorbed += self.core * (1.0 - reflectance);
        // Facing area beyond the illuminated area is counted twice by facets hidden behind others.
        let lambda = hiding.lambda(wi.z);
        tally.incident = facing_area / (1.0 + lambda) + self.core;
        tally.lost = (tally.incident - self.core - escaping).max(0.0);
        // What the quadrature rounds differently from Lambda must not open the book.
        tally.incident = tally.lost + escaping + self.core;
        tally.shadowed = lambda;
        tally.bounces[0] = tally.energy.iter().sum::<f64>() + tally.core;
        tally
    }
}
