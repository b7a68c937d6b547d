//! From tallies to a table that keeps the energy of every node.

use super::balance::Balance;
use super::core::Cores;
use super::floor::diffuse_albedo;
use super::masking::Masking;
use super::mesh::Mesh;
use super::nodes::Nodes;
use super::{Node, Provenance, Table};
use crate::math::direction;
use crate::optics::Material;
use crate::scatter::cells::HalfVectorCells;
use crate::scatter::detectors::Detectors;
use crate::scatter::{Method, Scatter, Tally};
use glam::DVec3;
use rayon::prelude::*;

/// A cell of which less than this share has its mirror direction above the horizon says too little about its density: that
/// of the node of the next smaller angle stands in, or that of all facets, so that a lobe interpolated between nodes
/// does not fade.
const SEEN_ENOUGH: f64 = 0.05;

impl Table {
    /// Splits every tally into specular core, diffuse floor and glossy rest, and tabulates the rest:
    /// `T_k = (E_k - F W_k / pi) / integral over cell k of R(beta) G cb / (ch ci) dp dq`, `F` the albedo of the floor and `W_k` the
    /// projected solid angle of the cell; then made consistent with interpolation: the mean of the interpolated `T` over
    /// each cell equals `T_k` to second order, and core + floor + rest is exactly the escaped energy of each incident direction.
    pub fn from_scatter(scatter: &Scatter, provenance: Provenance) -> Table {
        let cells = &scatter.cells;
        let n = cells.len();
        let mut table = Table {
            cells: cells.clone(),
            isotropic: scatter.isotropic,
            material: scatter.material,
            theta_i: scatter.theta_i.clone(),
            finder: Nodes::new(&scatter.theta_i, &scatter.phi_i),
            phi_i: scatter.phi_i.clone(),
            density: Vec::new(),
            relative_error: Vec::new(),
            subarea_ratio: ratios(&scatter.density.subareas, &scatter.density.density),
            speckle_ratio: scatter.wave.as_ref().map_or_else(Vec::new, |w| ratios(&w.replicates, &mean(&w.replicates))),
            masking: Masking::of(&scatter.statistics),
            nodes: Vec::new(),
            balance: Balance::default(),
            cores: Cores::default(),
            steps: None,
            provenance,
        };
        let scatter_of = [&table.subarea_ratio, &table.speckle_ratio].map(|ratio| relative_scatter(ratio, n));
        let phis = scatter.phi_i.len();
        let facets: Vec<f64> =
            (0..n).map(|k| scatter.density.density[k] * cells.area(k) * scatter.statistics.facets as f64).collect();
        let mut raw: Vec<Vec<f64>> = Vec::with_capacity(scatter.theta_i.len() * phis);
        for (t, row) in scatter.tallies.iter().enumerate() {
            let wave = scatter.decisions.get(t).is_some_and(|d| d.wave);
            let by_subarea = &scatter_of[usize::from(wave)];
            for (p, tally) in row.iter().enumerate() {
                let wi = direction(scatter.theta_i[t], scatter.phi_i[p]);
                let mut node = node_of(tally, &scatter.material, wi);
                let projected: Vec<f64> = (0..n).map(|k| cells.projected_solid_angle(k, wi)).collect();
                // A wave's halo is speckle: no cell of it is low for want of hits.
                node.diffuse = if wave { 0.0 } else { diffuse_albedo(cells, tally, &facets, &projected, wi) };
                let below = t.checked_sub(1).map(|below| raw[below * phis + p].as_slice());
                let mut density = cell_densities(scatter, &table.masking, tally, wi, node.diffuse, &projected, below);
                if scatter.isotropic {
                    density = (0..n).map(|k| 0.5 * (density[k] + density[cells.mirrored(k)])).collect();
                }
                table.relative_error.extend((0..n).map(|k| relative_error(scatter, tally, k, by_subarea[k])));
                table.nodes.push(Node {
                    wave: f64::from(u8::from(wave)),
                    core_error: scatter.core_error.get(t).copied().unwrap_or(0.0),
                    ..node
                });
                raw.push(density);
            }
        }
        raw.par_iter_mut().for_each(|density| keep_cell_means(cells, density));
        let filled: Vec<bool> = (0..n).map(|k| raw.iter().any(|density| density[k] > 0.0)).collect();
        let mesh = Mesh::new(cells, &filled, &table.masking);
        raw.par_iter_mut().enumerate().for_each(|(node, density)| {
            let wi = direction(table.theta_i[node / phis], table.phi_i[node % phis]);
            let held = mesh.energy(&mesh.values(density), wi, &scatter.material);
            let wanted = table.nodes[node].rest(&scatter.material, wi.z);
            let scale = if held > 0.0 { wanted / held } else { 0.0 };
            density.iter_mut().for_each(|t| *t *= scale);
        });
        table.density = raw.concat();
        let spread: Vec<f64> = table.subarea_albedo_spread();
        for (node, spread) in table.nodes.iter_mut().zip(spread) {
            node.albedo_error = node.albedo_error.hypot(spread);
        }
        table.cores = Cores::of(&table);
        table.balance = Balance::of(&table);
        table
    }

    /// Standard error of each node's albedo from the sub-areas.
    fn subarea_albedo_spread(&self) -> Vec<f64> {
        let phis = self.phi_i.len();
        (0..self.nodes.len())
            .map(|node| {
                let wi = direction(self.theta_i[node / phis], self.phi_i[node % phis]);
                let base = &self.density[self.node_range(node)];
                let weights: Vec<(f64, f64)> = (0..base.len())
                    .map(|k| self.masking.cell_weight(&self.cells, k, wi, &self.material))
                    .map(|weight| (weight.reflected, weight.lit))
                    .collect();
                let albedos: Vec<f64> = self
                    .ratios_of(node)
                    .iter()
                    .map(|ratio| {
                        let (mut reflected, mut lit) = (0.0, 0.0);
                        for k in 0..base.len() {
                            reflected += base[k] * ratio[k] * weights[k].0;
                            lit += base[k] * ratio[k] * weights[k].1;
                        }
                        if lit > 0.0 { reflected / lit } else { 0.0 }
                    })
                    .collect();
                crate::math::Estimate::from_repeats(&albedos).standard_error
            })
            .collect()
    }
}

/// `T` of the glossy rest per cell.
///
/// A facet sum knows which facets it asked: multiplying what they reflect at once by (density of all facets) / (density of those
/// asked) leaves it only the visible share to estimate. Where none was asked Smith's share stands in. Light that bounced more
/// than once comes from other facets than those of its cell and is taken as it is.
fn cell_densities(
    scatter: &Scatter,
    masking: &Masking,
    tally: &Tally,
    wi: DVec3,
    diffuse: f64,
    projected: &[f64],
    below: Option<&[f64]>,
) -> Vec<f64> {
    let cells = &scatter.cells;
    let asked: u64 = tally.asked.iter().sum();
    let hemisphere: f64 = projected.iter().sum();
    (0..cells.len())
        .map(|k| {
            if cells.is_border(k) {
                return 0.0;
            }
            let weight = masking.cell_weight(cells, k, wi, &scatter.material);
            if weight.seen < SEEN_ENOUGH * cells.area(k) || weight.reflected <= 0.0 {
                return below.map_or_else(|| scatter.density.density[k], |b| b[k]);
            }
            let energy = match tally.asked.get(k) {
                None => share(tally, k),
                Some(&n) => {
                    let [first, later @ ..] = tally.by_bounce[k].map(|e| e / tally.incident.max(f64::MIN_POSITIVE));
                    let density = scatter.density.density[k];
                    let at_once = if n > 0 {
                        let asked_density = n as f64 / (asked as f64 * cells.area(k));
                        first * density * (1.0 - scatter.density.core).recip() / asked_density
                    } else {
                        density * weight.reflected
                    };
                    at_once + later.iter().sum::<f64>()
                }
            };
            (energy - diffuse * projected[k] / hemisphere).max(0.0) / weight.reflected
        })
        .collect()
}

/// One step of the iteration `T <- T + (T_k - mean of interpolated T over cell k)`: linear interpolation of cell means
/// widens a lobe by a quarter of the squared cell width, this takes the widening back. Over half a cell the straight line to
/// the neighbour's value has the mean 3/4 and 1/4, so the mean over the cell weighs 1/8, 3/4, 1/8 along each axis, and
/// `T_k - mean` is a sum of flows `w (T_k - T_j)` from each neighbour j. A cell that would give more than it has gives what it
/// has: cut off at zero instead, the flows would add light wherever single facets stand alone.
pub(super) fn keep_cell_means(cells: &HalfVectorCells, density: &mut [f64]) {
    let row = cells.row_length();
    let [side, corner] = [0.125 * 0.75, 0.125 * 0.125];
    let flows = [(1, side), (row, side), (row + 1, corner), (row - 1, corner)];
    let given: Vec<f64> = (0..density.len())
        .map(|k| {
            if cells.is_border(k) {
                return 0.0;
            }
            let to = |j: usize, w: f64| if cells.is_border(j) { 0.0 } else { w * (density[j] - density[k]).max(0.0) };
            flows.iter().map(|&(step, w)| to(k - step, w) + to(k + step, w)).sum()
        })
        .collect();
    let part = |k: usize| if given[k] > density[k] { density[k] / given[k] } else { 1.0 };
    let limited: Vec<f64> = (0..density.len())
        .map(|k| {
            if cells.is_border(k) {
                return density[k];
            }
            let from = |j: usize, w: f64| {
                let flow = w * (density[k] - density[j]);
                // What lies beyond the border takes nothing, and gives nothing.
                match flow {
                    f if f > 0.0 => f * if cells.is_border(j) { 1.0 } else { part(j) },
                    f => f * part(k),
                }
            };
            let flow: f64 = flows.iter().map(|&(step, w)| from(k - step, w) + from(k + step, w)).sum();
            // A cell that gives all it has may be left with less than nothing by rounding.
            (density[k] + flow).max(0.0)
        })
        .collect();
    density.copy_from_slice(&limited);
}

/// Share of the incident energy that a cell received.
fn share(tally: &Tally, cell: usize) -> f64 {
    if tally.incident > 0.0 { tally.energy[cell] / tally.incident } else { 0.0 }
}

/// Relative standard error of a cell: map-to-map scatter, the counting error of rays, and for a facet sum that of the
/// visible share, `sqrt(hidden / n)` for n facets asked.
fn relative_error(scatter: &Scatter, tally: &Tally, cell: usize, by_subarea: Option<f64>) -> f64 {
    let energy = tally.energy[cell];
    let counting = if energy > 0.0 { tally.energy_squared[cell].sqrt() / energy } else { 0.0 };
    let asked = tally.asked.get(cell).copied().unwrap_or(0);
    match by_subarea {
        Some(s) if scatter.method == Method::Rays => s.hypot(counting),
        Some(s) if asked > 0 => {
            let hidden = (tally.shadowed + tally.multiple / tally.incident.max(f64::MIN_POSITIVE)).min(1.0);
            s.hypot((hidden / asked as f64).sqrt())
        }
        Some(s) => s,
        None => counting,
    }
}

/// Density of each part over that of the whole; 1 where the whole has none.
pub(super) fn ratios(parts: &[Vec<f64>], whole: &[f64]) -> Vec<Vec<f64>> {
    parts.iter().map(|part| part.iter().zip(whole).map(|(s, w)| if *w > 0.0 { s / w } else { 1.0 }).collect()).collect()
}

fn mean(parts: &[Vec<f64>]) -> Vec<f64> {
    let mut mean = vec![0.0; parts.first().map_or(0, Vec::len)];
    for part in parts {
        mean.iter_mut().zip(part).for_each(|(m, p)| *m += p / parts.len() as f64);
    }
    mean
}

/// Standard error of the mean over sub-areas, relative; `None` where the map has no single-bounce facet.
pub(super) fn relative_scatter(ratios: &[Vec<f64>], cells: usize) -> Vec<Option<f64>> {
    (0..cells)
        .map(|k| {
            let values: Vec<f64> = ratios.iter().map(|r| r[k]).collect();
            let e = crate::math::Estimate::from_repeats(&values);
            (e.standard_error > 0.0).then_some(e.standard_error)
        })
        .collect()
}

fn node_of(tally: &Tally, material: &Material, wi: DVec3) -> Node {
    let book = tally.book();
    let reflectance = material.reflectance(wi.z);
    let incident = if tally.incident > 0.0 { tally.incident } else { 1.0 };
    let squares: f64 = tally.energy_squared.iter().sum();
    Node {
        core_share: if reflectance > 0.0 { tally.core / incident / reflectance } else { 0.0 },
        albedo: book.escaped,
        // Only rays scatter; the squares of a slope-density tally are zero.
        albedo_error: if tally.beams > 0 {
            let n = tally.beams as f64;
            (squares / n - (book.escaped * incident / n).powi(2)).max(0.0).sqrt() / n.sqrt() * n / incident
        } else {
            0.0
        },
        one_ray: if tally.beams > 0 { book.escaped / tally.beams as f64 } else { 0.0 },
        absorbed: book.absorbed,
        lost: book.lost,
        diffuse: 0.0,
        multiple: tally.multiple / incident,
        shadowed: tally.shadowed,
        ..Node::default()
    }
}
