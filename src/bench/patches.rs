//! Where the light of one incident direction goes: shares of it in the 145 patches of Klems, counted facet by facet or read
//! from a table.

use crate::math::{Estimate, direction, reflect};
use crate::scatter::bounce::Walk;
use crate::scatter::detectors::{Bounds, Detectors, Rings};
use crate::scatter::facet_sum::{Azimuth, facet_sum, turned_back};
use crate::scatter::facing::facing;
use crate::scatter::{Footprint, Selection, Tally};
use crate::table::Table;
use glam::DVec3;
use rayon::prelude::*;

/// Places of a map along each axis whose scatter tells the error of the whole.
const PLACES: usize = 4;

/// Points at which a table is read for one incident direction, about.
const READINGS: usize = 1 << 20;
/// The same where the patches of many tables are compared with each other.
const FEWER_READINGS: usize = 1 << 16;

/// Mean of `|x|` of a normal error, in standard deviations: `sqrt(2 / pi)`.
const MEAN_SIZE: f64 = 0.797_884_560_802_865_4;

/// The patches in the frame of the source.
struct FromSource {
    patches: Rings,
    phi_i: f64,
}

impl Detectors for FromSource {
    fn len(&self) -> usize {
        self.patches.len()
    }

    fn index(&self, wi: DVec3, wo: DVec3) -> usize {
        self.patches.index(wi, turned_back(wo, self.phi_i))
    }

    fn projected_solid_angle(&self, index: usize, wi: DVec3) -> f64 {
        self.patches.projected_solid_angle(index, wi)
    }

    fn bounds(&self, index: usize) -> Bounds {
        self.patches.bounds(index)
    }
}

/// Every selected facet with its visibility, straight into the patches.
pub fn counted(walk: &Walk, theta_i: f64, phi_i: f64, selection: &Selection) -> Vec<f64> {
    let detectors = FromSource { patches: Rings::klems(), phi_i };
    shares(&facet_sum(walk, &detectors, theta_i, Azimuth::Fixed(phi_i), selection).tally())
}

/// Expected distance, `1/2 sum E|a_k - b_k| / sum b_k`, between the light counted on the map and that of the surface it is a
/// sample of, the source at azimuth 0: from the scatter of [`PLACES`] squared places of the map, errors taken as normal.
pub fn counted_by_places(walk: &Walk, theta_i: f64) -> f64 {
    let whole = Footprint::whole(walk.field.cells());
    let places: Vec<Vec<f64>> = (0..PLACES * PLACES)
        .map(|k| whole.piece(k % PLACES, k / PLACES, PLACES))
        .filter(|place| !place.is_empty())
        .map(|place| counted(walk, theta_i, 0.0, &Selection { footprint: Some(place), ..Selection::default() }))
        .filter(|shares| shares.iter().any(|&e| e > 0.0))
        .collect();
    chance(&places)
}

/// The same for the light of a table: from its sub-areas, where waves served from groups of speckles.
pub fn tabulated_by_subareas(table: &Table, theta_i: &[f64]) -> Vec<f64> {
    let parts: Vec<Table> = (0..table.subareas()).map(|k| table.of_subarea(k)).collect();
    theta_i
        .iter()
        .map(|&t| chance(&parts.iter().map(|part| read(part, t, 0.0, FEWER_READINGS)).collect::<Vec<_>>()))
        .collect()
}

/// `1/2 sum E|a_k - b_k| / sum b_k` between the mean of repeats and what they scatter about.
fn chance(repeats: &[Vec<f64>]) -> f64 {
    let patch = |k: usize| Estimate::from_repeats(&repeats.iter().map(|shares| shares[k]).collect::<Vec<_>>());
    let patches = (0..repeats.first().map_or(0, Vec::len)).map(patch);
    let (sum, error) = patches.fold((0.0, 0.0), |(s, e), p| (s + p.value, e + p.standard_error));
    0.5 * MEAN_SIZE * error / sum.max(f64::MIN_POSITIVE)
}

/// Share of the incident energy per detector of a tally.
pub fn shares(tally: &Tally) -> Vec<f64> {
    let incident = tally.incident.max(f64::MIN_POSITIVE);
    let mut shares: Vec<f64> = tally.energy.iter().map(|e| e / incident).collect();
    // An exactly flat facet: the light of the mirror direction.
    shares[0] += tally.core / incident;
    shares
}

/// `integral of f_r cos_theta_r dw` over every patch by midpoints in the slope plane, finer than the cells of the table; the
/// mirror beam included.
pub fn tabulated(table: &Table, theta_i: f64, phi_i: f64) -> Vec<f64> {
    read(table, theta_i, phi_i, READINGS)
}

/// At about so many points.
fn read(table: &Table, theta_i: f64, phi_i: f64, points: usize) -> Vec<f64> {
    let (patches, cells) = (Rings::klems(), table.cells());
    let wi = direction(theta_i, phi_i);
    // The cells of an isotropic table lie in the frame of the source.
    let turn = if table.is_isotropic() { phi_i } else { 0.0 };
    let local = turned_back(wi, turn);
    // Even, so that no point lies on the kinks of the interpolation.
    let side = 2 * ((points as f64 / cells.len() as f64).sqrt() / 2.0).ceil().max(1.0) as usize;
    let middle = |k: usize| (k as f64 + 0.5) / side as f64;
    let row = cells.row_length();
    let mut energy = (0..cells.len() / row)
        .into_par_iter()
        .map(|line| {
            let mut energy = vec![0.0; patches.len()];
            for cell in line * row..(line + 1) * row {
                let area = cells.area(cell) / (side * side) as f64;
                for k in 0..side * side {
                    let (p, q) = cells.slope_in(cell, middle(k % side), middle(k / side));
                    let Some(f) = facing(p, q, local).filter(|f| f.wo.z > 0.0) else { continue };
                    let wo = turned_back(f.wo, -turn);
                    // dw = 4 cos(beta) cos^3(theta_h) dp dq
                    let cos_h = (1.0 + p * p + q * q).sqrt().recip();
                    let solid_angle = 4.0 * f.cos_beta * cos_h.powi(3) * area;
                    energy[patches.index(wi, turned_back(wo, phi_i))] += table.eval(wi, wo) * wo.z * solid_angle;
                }
            }
            energy
        })
        .collect::<Vec<_>>()
        .into_iter()
        .fold(vec![0.0; patches.len()], |sum, part| sum.iter().zip(part).map(|(a, b)| a + b).collect());
    energy[patches.index(wi, turned_back(reflect(wi, DVec3::Z), phi_i))] += table.core(wi);
    energy
}
