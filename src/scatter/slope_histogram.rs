//! One pass over the facets that serves every incident direction for which nothing is hidden.

use super::cells::{HalfVectorCells, cell_weight};
use super::tally::{CORE_SLOPE, Tally};
use crate::facets::slopes;
use crate::heightmap::HeightMap;
use crate::optics::Material;
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

impl SlopeDensity {
    /// Counts the facets of `map` into `cells`. `isotropic` averages every ring over its sectors.
    pub fn measure(map: &HeightMap, cells: &HalfVectorCells, isotropic: bool) -> Self {
        let (nx, ny) = slopes::cells(map);
        let n = cells.len();
        let across = SUBAREAS_PER_AXIS;
        // The extra slot of each sub-area counts the core.
        let counts: Vec<Vec<u64>> = (0..across)
            .into_par_iter()
            .map(|band| {
                let mut counts = vec![0u64; across * (n + 1)];
                for row in band * ny / across..(band + 1) * ny / across {
                    slopes::visit_row(map, row, |f| {
                        let cell = if f.p.abs().max(f.q.abs()) < CORE_SLOPE { n } else { cells.locate(f.p, f.q) };
                        counts[f.column * across / nx * (n + 1) + cell] += 1;
                    });
                }
                counts
            })
            .collect();
        let per_subarea: Vec<&[u64]> = counts.iter().flat_map(|band| band.chunks(n + 1)).collect();
        let mut total = vec![0u64; n + 1];
        for counts in &per_subarea {
            total.iter_mut().zip(*counts).for_each(|(t, c)| *t += c);
        }
        let density_of = |counts: &[u64]| {
            let facets = counts.iter().sum::<u64>() as f64;
            let mut density: Vec<f64> = (0..n).map(|k| counts[k] as f64 / (facets * cells.area(k))).collect();
            if isotropic {
                average_rings(cells, &mut density);
            }
            density
        };
        SlopeDensity {
            density: density_of(&total),
            core: total[n] as f64 / total.iter().sum::<u64>() as f64,
            subareas: per_subarea.iter().filter(|c| c.iter().any(|&x| x > 0)).map(|c| density_of(c)).collect(),
        }
    }

    /// Tally for `wi` when no facet hides another: `E_k = P_k * integral R(beta) cb / (ch ci) dp dq / sum`.
    ///
    /// Beams whose mirror direction lies below the horizon would meet the surface again; they are `lost`.
    pub fn tally(&self, cells: &HalfVectorCells, wi: DVec3, material: &Material) -> Tally {
        let mut tally = Tally::new(cells.len());
        for (k, &density) in self.density.iter().enumerate() {
            if density > 0.0 {
                let (reflected, all) = cell_weight(cells, k, wi, material);
                let (seen, _) = cell_weight(cells, k, wi, &Material::Mirror);
                tally.energy[k] = density * reflected;
                tally.incident += density * all;
                tally.absorbed += density * (seen - reflected);
                tally.lost += density * (all - seen);
            }
        }
        let reflectance = material.reflectance(wi.z);
        tally.core = self.core * reflectance;
        tally.incident += self.core;
        tally.absorbed += self.core * (1.0 - reflectance);
        // Whatever is counted beyond unit area was counted twice.
        tally.shadowed = (tally.incident - 1.0).max(0.0);
        tally
    }
}

/// Replaces every ring by its mean: exact averaging over the azimuth of the source.
pub fn average_rings(cells: &HalfVectorCells, values: &mut [f64]) {
    for ring in 0..cells.sectors.len() {
        let range = cells.cells_of_ring(ring);
        let mean = values[range.clone()].iter().sum::<f64>() / range.len() as f64;
        values[range].fill(mean);
    }
}
