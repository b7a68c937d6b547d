//! Energy between the nodes of a table.

use super::Table;
use super::build::interpolate;
use super::eval::bracket;
use crate::math::{direction, frame};
use crate::scatter::facing::facing;
use glam::DVec3;
use rayon::prelude::*;

/// Steps between two neighbouring nodes.
const STEPS: usize = 4;
/// Angles behind the last node \[deg\], as far as they lie behind it.
const BEYOND: [f64; 6] = [86.0, 88.0, 89.0, 89.5, 89.8, 89.95];
/// Azimuths of an anisotropic table.
const AZIMUTHS: usize = 24;

/// `b(wi) = (energy interpolated between the nodes) / (energy of the interpolated density)`, mirror facets.
///
/// The weight of a facet is linear in tan(theta_i) only until it turns its back to the source, so densities that keep
/// the energy at two nodes do not quite keep it between them, and not at all beyond the last one. `f_r` is
/// multiplied by `b`, which is 1 at the nodes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Balance {
    /// Tangents of the incident angles.
    tangents: Vec<f64>,
    azimuths: usize,
    /// `[theta][azimuth]`.
    factor: Vec<f64>,
    /// Energy a mirror surface would send out at each node.
    pub own: Vec<f64>,
}

impl Balance {
    /// Integrates the table over its cells at angles between and beyond its nodes.
    pub fn of(table: &Table) -> Balance {
        Self::integrate(table, true)
    }

    /// The energies at the nodes alone, at a small part of the cost.
    pub fn own_of(table: &Table) -> Vec<f64> {
        Self::integrate(table, false).own
    }

    fn integrate(table: &Table, between_nodes: bool) -> Balance {
        let mut theta_i = Vec::new();
        for pair in table.theta_i.windows(2) {
            theta_i.extend((0..STEPS).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / STEPS as f64));
        }
        let last = table.theta_i[table.theta_i.len() - 1];
        theta_i.push(last);
        theta_i.extend(BEYOND.map(f64::to_radians).into_iter().filter(|&t| t > last));
        let azimuths = if table.isotropic { 1 } else { AZIMUTHS };
        // Most cells are empty at every node: their points add nothing and are left out.
        let n = table.cells.len();
        let filled: Vec<bool> = (0..n).map(|k| table.density.iter().skip(k).step_by(n).any(|&t| t != 0.0)).collect();
        let points: Vec<_> = (0..n)
            .flat_map(|k| table.cells.points(k))
            .map(|point| (point, table.cells.stencil(point.p, point.q)))
            .filter(|(_, stencil)| stencil.iter().any(|&(k, w)| w > 0.0 && filled[k]))
            .collect();
        // Energy a mirror surface would send out for `wi` if its density were that of the weighted nodes.
        let energy = |wi: DVec3, nodes: &[(usize, f64)]| -> f64 {
            points
                .iter()
                .map(|(point, stencil)| match facing(point.p, point.q, wi) {
                    Some(f) if f.wo.z > 0.0 => {
                        let t: f64 = nodes
                            .iter()
                            .filter(|n| n.1 > 0.0)
                            .map(|&(n, w)| w * interpolate(&table.density[table.node_range(n)], stencil))
                            .sum();
                        t * point.area * f.weight
                    }
                    _ => 0.0,
                })
                .sum()
        };
        let phis = table.phi_i.len();
        let own: Vec<f64> = (0..table.nodes.len())
            .into_par_iter()
            .map(|n| energy(direction(table.theta_i[n / phis], table.phi_i[n % phis]), &[(n, 1.0)]))
            .collect();
        let directions = if between_nodes { theta_i.len() * azimuths } else { 0 };
        let factor = (0..directions)
            .into_par_iter()
            .map(|k| {
                let phi = (k % azimuths) as f64 / azimuths as f64 * std::f64::consts::TAU;
                let wi = direction(theta_i[k / azimuths], phi);
                let nodes = table.node_weights(wi);
                let wanted: f64 = nodes.iter().map(|&(n, w)| w * own[n]).sum();
                let held = energy(wi, &nodes);
                // A tilted surface seen from behind shows nothing.
                if held > 1e-9 * wanted { wanted / held } else { 0.0 }
            })
            .collect();
        Balance { tangents: theta_i.iter().map(|t| t.tan()).collect(), azimuths, factor, own }
    }

    /// `b(wi)`, interpolated.
    #[inline]
    pub fn at(&self, wi: DVec3) -> f64 {
        let (t0, t1, u) = bracket(&self.tangents, (wi.x * wi.x + wi.y * wi.y).sqrt() / wi.z);
        if self.azimuths == 1 {
            return self.factor[t0] + u * (self.factor[t1] - self.factor[t0]);
        }
        let x = frame::phi(wi) / std::f64::consts::TAU * self.azimuths as f64;
        let (k, v) = (x as usize % self.azimuths, x.fract());
        let next = (k + 1) % self.azimuths;
        let row = |t: usize| {
            let row = &self.factor[t * self.azimuths..];
            row[k] + v * (row[next] - row[k])
        };
        row(t0) + u * (row(t1) - row(t0))
    }
}
