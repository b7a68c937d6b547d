//! Evaluation between the nodes: the honest f64 way that the sampler's fast one is measured by.

use super::Table;
use super::masking::Masking;
use super::nodes::{NodeWeights, Place};
use crate::math::{Estimate, direction};
use crate::scatter::cells::Stencil;
use crate::scatter::detectors::Detectors;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Cosines below this count as the horizon.
pub(crate) const HORIZON: f64 = 1e-9;

/// What is the same for every `wo` of one `wi`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Incident {
    pub wi: DVec3,
    pub place: Place,
    /// Cosine and sine of the turn into the frame of the cells.
    pub turn: [f64; 2],
    pub balance: f64,
    /// `L(cos_theta_i)` of the masking.
    pub masked: f64,
}

impl Incident {
    /// `cos_theta_i cos_theta_r / G`.
    #[inline(always)]
    pub fn cosines(&self, masking: &Masking, cos_theta_r: f64) -> f64 {
        (self.wi.z + self.masked) * cos_theta_r + self.wi.z * masking.times_cosine(cos_theta_r)
    }
}

impl Table {
    /// `f_r(wi, wo)` [1/sr] without the specular core; 0 at or below the horizon.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.estimate(wi, wo).value
    }

    /// `f_r(wi, wo)` [1/sr] with its standard error: map-to-map scatter and ray noise, errors of neighbouring cells
    /// taken as fully correlated. A cell that no ray met is known to three rays, the 95 % bound of an empty bin.
    pub fn estimate(&self, wi: DVec3, wo: DVec3) -> Estimate {
        if !(wi.z > HORIZON && wo.z > HORIZON) {
            return Estimate::exact(0.0);
        }
        let incident = self.incident(wi);
        let sum = wi + wo;
        let slope = incident.in_cells(-sum / sum.z);
        let stencil: Stencil = self.cells.stencil(slope.x, slope.y);
        let (mut t, mut error, mut unmet, mut floor, mut floor_error) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (node, weight) in self.finder.weights(&incident.place) {
            let range = self.node_range(node);
            let (density, relative) = (&self.density[range.clone()], &self.relative_error[range]);
            for (k, w) in stencil {
                t += weight * w * density[k];
                error += weight * w * density[k] * relative[k];
            }
            let facts = &self.nodes[node];
            if facts.one_ray > 0.0 && weight > 0.0 {
                for (k, w) in stencil {
                    let area =
                        if density[k] == 0.0 { self.cells.projected_solid_angle(k, incident.local()) } else { 0.0 };
                    unmet += if area > 0.0 { weight * w * 3.0 * facts.one_ray / area } else { 0.0 };
                }
            }
            floor += weight * facts.diffuse / PI;
            // The floor scatters from map to map as the whole albedo does.
            let relative = if facts.albedo > 0.0 { facts.albedo_error / facts.albedo } else { 0.0 };
            floor_error += weight * facts.diffuse / PI * relative;
        }
        let cos_beta = sum.length() / 2.0;
        let ch2 = (sum.z / sum.length()).powi(2);
        let cosines = incident.cosines(&self.masking, wo.z);
        let jacobian = incident.balance * self.material.reflectance(cos_beta) / (4.0 * cosines * ch2 * ch2);
        Estimate { value: t * jacobian + floor, standard_error: (error * jacobian + unmet).hypot(floor_error) }
    }

    /// Reflectance of the specular core for `wi`.
    pub fn core(&self, wi: DVec3) -> f64 {
        if wi.z <= HORIZON {
            return 0.0;
        }
        self.cores.share(self, &self.finder.place(wi), wi) * self.material.reflectance(wi.z)
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

    /// Albedo between the nodes: the floor straight, core and rest straight in their ratio to the Fresnel reflectance of the
    /// mean plane, which rises steeply towards the horizon.
    pub fn albedo(&self, wi: DVec3) -> f64 {
        self.albedo_estimate(wi).value
    }

    /// The same with its standard error.
    pub fn albedo_estimate(&self, wi: DVec3) -> Estimate {
        let phis = self.phi_i.len();
        let own = self.material.reflectance(wi.z);
        let mut sum = Estimate::exact(0.0);
        for (node, w) in self.node_weights(wi) {
            let facts = &self.nodes[node];
            let there = self.material.reflectance(self.theta_i[node / phis].cos());
            let ratio = if there > 0.0 { own / there } else { 1.0 };
            sum.value += w * (facts.diffuse + ratio * (facts.albedo - facts.diffuse));
            sum.standard_error += w * facts.albedo_error * ratio;
        }
        sum
    }

    /// Everything about `wi` that its many `wo` share; `wi` must be above the horizon.
    #[inline(always)]
    pub(crate) fn incident(&self, wi: DVec3) -> Incident {
        let place = self.finder.place(wi);
        let turn = if self.isotropic { place.azimuth } else { [1.0, 0.0] };
        Incident { wi, place, turn, balance: self.balance.at(&place, wi), masked: self.masking.times_cosine(wi.z) }
    }

    /// Up to four nodes around `wi` and their shares.
    pub(crate) fn node_weights(&self, wi: DVec3) -> NodeWeights {
        let wi = if wi.z > HORIZON { wi } else { direction(FRAC_PI_2 - 1e-6, 0.0) };
        self.finder.weights(&self.finder.place(wi))
    }
}

impl Incident {
    /// `v` in the frame of the cells: that of the source if isotropic, the map's otherwise.
    #[inline]
    pub fn in_cells(&self, v: DVec3) -> DVec3 {
        let [c, s] = self.turn;
        DVec3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z)
    }

    /// The source in the frame of the cells.
    pub fn local(&self) -> DVec3 {
        self.in_cells(self.wi)
    }

    /// The inverse of [`Incident::in_cells`].
    #[inline]
    pub fn out_of_cells(&self, v: DVec3) -> DVec3 {
        let [c, s] = self.turn;
        DVec3::new(c * v.x - s * v.y, c * v.y + s * v.x, v.z)
    }
}
