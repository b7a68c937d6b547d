//! Energy between the nodes of a table.

use super::Table;
use super::mesh::Mesh;
use super::nodes::{Place, at_turn, turn};
use crate::math::direction;
use crate::scatter::axis::{at_least, at_most, nearest};
use glam::DVec3;
use rayon::prelude::*;

/// Steps between two neighbouring nodes, in the share of the second.
pub(crate) const STEPS: usize = 4;
/// Steps in cosine from the last node to the horizon.
const BEYOND: usize = 16;
/// Azimuths of an anisotropic table, evenly in turn.
const AZIMUTHS: usize = 24;

/// `b(wi) = (energy interpolated between the nodes) / (energy of the interpolated density)`, mirror facets.
///
/// The weight of a facet is linear in tan(theta_i) only until it turns its back to the source, so densities that keep
/// the energy at two nodes do not quite keep it between them, and not at all beyond the last one. What the core takes beyond
/// the straight line between its nodes, the rest gives. The glossy rest is multiplied by `b`, which is 1 at the nodes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Balance {
    azimuths: usize,
    /// `[interval][step][azimuth]`, then `[step][azimuth]` beyond the last node.
    factor: Vec<f64>,
    intervals: usize,
    /// Steps in all.
    steps: usize,
    /// Cosine of the last node.
    last_cos: f64,
    last_tangent: f64,
    /// Energy a mirror surface would send out at each node.
    pub own: Vec<f64>,
}

/// Energy a mirror surface would send out at each node.
pub(crate) fn mirror_energies(table: &Table) -> Vec<f64> {
    own(table, &mesh(table))
}

/// Quadrature over all cells that hold something at any node.
pub(crate) fn mesh(table: &Table) -> Mesh<'_> {
    Mesh::new(&table.cells, &filled(table), &table.masking)
}

/// As [`mesh`], of fewer points.
pub(crate) fn coarse_mesh(table: &Table) -> Mesh<'_> {
    Mesh::coarse(&table.cells, &filled(table), &table.masking)
}

fn filled(table: &Table) -> Vec<bool> {
    let n = table.cells.len();
    (0..n).map(|k| table.density.iter().skip(k).step_by(n).any(|&t| t != 0.0)).collect()
}

fn own(table: &Table, mesh: &Mesh) -> Vec<f64> {
    let phis = table.phi_i.len();
    (0..table.nodes.len())
        .into_par_iter()
        .map(|node| {
            let values = mesh.values(&table.density[table.node_range(node)]);
            let wi = direction(table.theta_i[node / phis], table.phi_i[node % phis]);
            mesh.mirror_energy(&values, &values, 0.0, wi)
        })
        .collect()
}

/// `integral of f_r cos_theta_r dw` at each of the directions, core and floor included: what the interpolated table reflects.
pub(crate) fn albedos(table: &Table, directions: &[DVec3]) -> Vec<f64> {
    let mesh = mesh(table);
    directions
        .iter()
        .map(|&wi| {
            let incident = table.incident(wi);
            let mut density = vec![0.0; table.cells.len()];
            let mut floor = 0.0;
            for (node, weight) in table.finder.weights(&incident.place) {
                if weight > 0.0 {
                    density.iter_mut().zip(&table.density[table.node_range(node)]).for_each(|(d, t)| *d += weight * t);
                    floor += weight * table.nodes[node].diffuse;
                }
            }
            let rest = incident.balance * mesh.energy(&mesh.values(&density), incident.local(), &table.material);
            table.core(wi) + floor + rest
        })
        .collect()
}

impl Balance {
    /// Integrates the table over its cells at angles between and beyond its nodes.
    pub fn of(table: &Table) -> Balance {
        let mesh = mesh(table);
        let own = own(table, &mesh);
        let azimuths = if table.isotropic { 1 } else { AZIMUTHS };
        let intervals = table.theta_i.len() - 1;
        let last = table.theta_i[intervals];
        // `b` of one azimuth at all steps: of every interval, then beyond.
        let along = |azimuth: usize| -> Vec<f64> {
            let [x, y] = at_turn(azimuth as f64 * 4.0 / azimuths as f64);
            let wi = |cos: f64, sin: f64| DVec3::new(sin * x, sin * y, cos);
            let place = table.finder.place(wi(0.5f64.sqrt(), 0.5f64.sqrt()));
            let phis = table.phi_i.len();
            // Density, energy and core of a polar angle's nodes, interpolated to this azimuth.
            let at = |theta: usize| -> (Vec<f64>, f64, f64) {
                let [a, b] = place.phi.map(|p| theta * phis + p);
                let mix = |x: f64, y: f64| x + place.v * (y - x);
                let mut density = table.density[table.node_range(a)].to_vec();
                if place.v > 0.0 {
                    density.iter_mut().zip(&table.density[table.node_range(b)]).for_each(|(x, y)| *x = mix(*x, *y));
                }
                let core = mix(table.nodes[a].core_share, table.nodes[b].core_share);
                (mesh.values(&density), mix(own[a], own[b]), core)
            };
            let ratio = |wanted: f64, held: f64| if held > 1e-9 * wanted { wanted / held } else { 0.0 };
            let mut factors = Vec::with_capacity(intervals * STEPS + BEYOND + 1);
            let (mut low, mut low_own, mut low_core) = at(0);
            for t in 0..intervals {
                let (high, high_own, high_core) = at(t + 1);
                let tangents = [table.theta_i[t].tan(), table.theta_i[t + 1].tan()];
                for step in 0..STEPS {
                    let u = step as f64 / STEPS as f64;
                    let tangent = tangents[0] + u * (tangents[1] - tangents[0]);
                    let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
                    let wi = wi(cos, tangent * cos);
                    let held = mesh.mirror_energy(&low, &high, u, wi);
                    // Core and rest together run straight; the core has its own law, and the rest has what it leaves.
                    let core = table.cores.share(table, &table.finder.place(wi), wi);
                    let left = low_core + u * (high_core - low_core) - core;
                    factors.push(ratio((low_own + u * (high_own - low_own) + left).max(0.0), held));
                }
                (low, low_own, low_core) = (high, high_own, high_core);
            }
            for step in (0..=BEYOND).rev() {
                // At the very horizon a facet that faces the source has an infinite weight, and `b` is zero.
                let cos = last.cos() * step as f64 / BEYOND as f64;
                let held = || mesh.mirror_energy(&low, &low, 0.0, wi(cos, (1.0 - cos * cos).sqrt()));
                factors.push(if step == 0 { 0.0 } else { ratio(low_own, held()) });
            }
            factors
        };
        let columns: Vec<Vec<f64>> = (0..azimuths).into_par_iter().map(along).collect();
        let steps = columns[0].len() - 1;
        let factor = (0..columns[0].len()).flat_map(|k| columns.iter().map(move |c| c[k])).collect();
        Balance { azimuths, factor, intervals, steps, last_cos: last.cos(), last_tangent: last.tan(), own }
    }

    /// Step of the polar angle, and the share of the next one. Steps run on from interval to interval and over the last
    /// node towards the horizon.
    #[inline(always)]
    fn step(&self, theta: usize, upper: f64, tangent: f64, cos_theta_i: f64) -> (usize, f64) {
        let x = if tangent > self.last_tangent || self.intervals == 0 {
            let beyond = 1.0 - cos_theta_i / self.last_cos;
            (self.intervals * STEPS) as f64 + at_most(at_least(beyond, 0.0), 1.0) * BEYOND as f64
        } else {
            (theta as f64 + upper) * STEPS as f64
        };
        let (step, whole) = nearest(at_most(at_least(x - 0.5, 0.0), (self.steps - 1) as f64));
        (step, x - whole)
    }

    /// `b` of a table that does not depend on the azimuth, at the share `upper` of the interval `theta`.
    #[inline(always)]
    pub fn of_isotropic(&self, theta: usize, upper: f64, tangent: f64, cos_theta_i: f64) -> f64 {
        let (step, u) = self.step(theta, upper, tangent, cos_theta_i);
        let rows = &self.factor[step..step + 2];
        rows[0] + u * (rows[1] - rows[0])
    }

    /// Factors `[step][azimuth]`, [`STEPS`] to an interval and on to the horizon; how many azimuths; and how many steps
    /// lie beyond the last node.
    pub fn steps(&self) -> (&[f64], usize, usize) {
        (&self.factor, self.azimuths, BEYOND)
    }

    /// `b(wi)`, interpolated.
    #[inline(always)]
    pub fn at(&self, place: &Place, wi: DVec3) -> f64 {
        if self.azimuths == 1 {
            return self.of_isotropic(place.theta, place.u, place.tangent, wi.z);
        }
        let (step, u) = self.step(place.theta, place.u, place.tangent, wi.z);
        let rows = &self.factor[step * self.azimuths..(step + 2) * self.azimuths];
        // A table of one azimuth leaves the turn alone, but its balance has all of them.
        let turn = if place.turn > 0.0 { place.turn } else { turn(wi.x, wi.y) };
        let y = turn * (self.azimuths as f64 / 4.0);
        let (k, whole) = nearest(at_most(at_least(y - 0.5, 0.0), (self.azimuths - 1) as f64));
        let v = y - whole;
        let next = if k + 1 < self.azimuths { k + 1 } else { 0 };
        let low = rows[k] + v * (rows[next] - rows[k]);
        let high = rows[self.azimuths + k] + v * (rows[self.azimuths + next] - rows[self.azimuths + k]);
        low + u * (high - low)
    }
}
