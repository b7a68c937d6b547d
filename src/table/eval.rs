//! Evaluation between the nodes.

use super::Table;
use super::build::interpolate;
use crate::math::{Estimate, frame, half_vector, slope_of_half_vector};
use crate::scatter::cells::Stencil;
use glam::DVec3;
use std::f64::consts::TAU;

/// Nodes that surround an incident direction and their weights, which sum to 1.
pub type NodeWeights = [(usize, f64); 4];

/// Cosines below this count as the horizon.
const HORIZON: f64 = 1e-9;

/// What is the same for every `wo` of one `wi`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Incident {
    pub wi: DVec3,
    pub nodes: NodeWeights,
    /// Cosine and sine of the turn into the frame of the cells.
    turn: [f64; 2],
    pub balance: f64,
}

impl Table {
    /// `f_r(wi, wo)` [1/sr] without the specular core; 0 at or below the horizon.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !(wi.z > HORIZON && wo.z > HORIZON) {
            return 0.0;
        }
        self.eval_from(&self.incident(wi), wo)
    }

    /// `f_r(wi, wo)` [1/sr] with its standard error: map-to-map scatter and ray noise, errors of neighbouring cells
    /// taken as fully correlated.
    pub fn estimate(&self, wi: DVec3, wo: DVec3) -> Estimate {
        if !(wi.z > HORIZON && wo.z > HORIZON) {
            return Estimate::exact(0.0);
        }
        let incident = self.incident(wi);
        let (jacobian, stencil) = self.locate(&incident, wo);
        let (mut t, mut error) = (0.0, 0.0);
        for (node, weight) in incident.nodes {
            let range = self.node_range(node);
            let (density, relative) = (&self.density[range.clone()], &self.relative_error[range]);
            for (k, w) in stencil {
                t += weight * w * density[k];
                error += weight * w * density[k] * relative[k];
            }
        }
        Estimate { value: t * jacobian, standard_error: error * jacobian }
    }

    /// Reflectance of the specular core for `wi`.
    pub fn core(&self, wi: DVec3) -> f64 {
        if wi.z <= HORIZON {
            return 0.0;
        }
        let share: f64 = self.node_weights(wi).iter().map(|&(node, w)| w * self.nodes[node].core_share).sum();
        share * self.material.reflectance(wi.z)
    }

    /// Relative standard error of the specular core, and whether the nodes that serve `wi` are those of the wave calculation.
    pub fn wave_at(&self, wi: DVec3) -> (f64, bool) {
        let (mut error, mut core, mut wave) = (0.0, 0.0, 0.0);
        for (node, weight) in self.node_weights(wi) {
            let node = &self.nodes[node];
            error += weight * node.core_share * node.core_error;
            core += weight * node.core_share;
            wave += weight * node.wave;
        }
        (if core > 0.0 { error / core } else { 0.0 }, wave > 0.5)
    }

    /// Albedo at the nodes nearest to `wi`, interpolated.
    pub fn albedo(&self, wi: DVec3) -> f64 {
        self.node_weights(wi).iter().map(|&(node, w)| w * self.nodes[node].albedo).sum()
    }

    /// Everything about `wi` that its many `wo` share; `wi` must be above the horizon.
    #[inline]
    pub(crate) fn incident(&self, wi: DVec3) -> Incident {
        let r = (wi.x * wi.x + wi.y * wi.y).sqrt();
        let turn = if self.isotropic && r > 0.0 { [wi.x / r, wi.y / r] } else { [1.0, 0.0] };
        Incident { wi, nodes: self.node_weights(wi), turn, balance: self.balance.at(wi) }
    }

    /// `f_r` [1/sr] for `wo` above the horizon.
    #[inline]
    pub(crate) fn eval_from(&self, incident: &Incident, wo: DVec3) -> f64 {
        let (jacobian, stencil) = self.locate(incident, wo);
        jacobian * self.density_at(incident, &stencil)
    }

    /// `T` interpolated over the nodes.
    #[inline]
    pub(crate) fn density_at(&self, incident: &Incident, stencil: &Stencil) -> f64 {
        let mut t = 0.0;
        for (node, weight) in incident.nodes {
            if weight > 0.0 {
                t += weight * interpolate(&self.density[self.node_range(node)], stencil);
            }
        }
        t
    }

    /// Up to four nodes around `wi`, linear in tan(theta_i) as the lit area is; beyond the first and last angle the
    /// nearest node.
    #[inline]
    pub(crate) fn node_weights(&self, wi: DVec3) -> NodeWeights {
        let (t0, t1, u) = bracket(&self.tangents, (wi.x * wi.x + wi.y * wi.y).sqrt() / wi.z);
        let phis = self.phi_i.len();
        if phis == 1 {
            return [(t0, 1.0 - u), (t1, u), (t0, 0.0), (t1, 0.0)];
        }
        let phi = frame::phi(wi);
        let above = self.phi_i.partition_point(|&p| p <= phi);
        let (p0, p1) = ((above + phis - 1) % phis, above % phis);
        let gap = (self.phi_i[p1] - self.phi_i[p0]).rem_euclid(TAU);
        let v = if gap > 0.0 { (phi - self.phi_i[p0]).rem_euclid(TAU) / gap } else { 0.0 };
        [
            (t0 * phis + p0, (1.0 - u) * (1.0 - v)),
            (t1 * phis + p0, u * (1.0 - v)),
            (t0 * phis + p1, (1.0 - u) * v),
            (t1 * phis + p1, u * v),
        ]
    }

    /// `b R(beta) / (4 ci co ch^4)` and the stencil of the half vector.
    #[inline]
    fn locate(&self, incident: &Incident, wo: DVec3) -> (f64, Stencil) {
        let wi = incident.wi;
        let wh = half_vector(wi, wo);
        let ch2 = wh.z * wh.z;
        let jacobian = incident.balance * self.material.reflectance(wh.dot(wi)) / (4.0 * wi.z * wo.z * ch2 * ch2);
        let (p, q) = slope_of_half_vector(incident.in_cells(wh));
        (jacobian, self.cells.stencil(p, q))
    }
}

impl Incident {
    /// `v` in the frame of the cells: that of the source if isotropic, the map's otherwise.
    #[inline]
    pub fn in_cells(&self, v: DVec3) -> DVec3 {
        let [c, s] = self.turn;
        DVec3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z)
    }

    /// The inverse of [`Incident::in_cells`].
    #[inline]
    pub fn out_of_cells(&self, v: DVec3) -> DVec3 {
        let [c, s] = self.turn;
        DVec3::new(c * v.x - s * v.y, c * v.y + s * v.x, v.z)
    }
}

/// Neighbours of `x` in a rising list and the share of the upper one; clamped at both ends.
#[inline]
pub(super) fn bracket(list: &[f64], x: f64) -> (usize, usize, f64) {
    let above = list.partition_point(|&v| v <= x);
    if above == 0 {
        (0, 0, 0.0)
    } else if above == list.len() {
        (above - 1, above - 1, 0.0)
    } else {
        (above - 1, above, (x - list[above - 1]) / (list[above] - list[above - 1]))
    }
}
