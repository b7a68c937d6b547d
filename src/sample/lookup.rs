//! One lookup of a table: `f_r` and pdf, in numbers prepared for it.

use super::table_brdf::{HORIZON, TableBrdf};
use crate::scatter::axis::at_most;
use crate::table::{Incident, Place};
use glam::{DVec3, Vec4};
use std::f64::consts::PI;

impl TableBrdf {
    /// What the nodes around `wi` say about core and floor, blended: the numbers of [`TableBrdf::facts`].
    #[inline(always)]
    pub(super) fn blend(&self, place: &Place) -> Vec4 {
        if self.glossy {
            return Vec4::ZERO;
        }
        let phis = self.table.phi_i.len();
        let next = (place.theta + 1).min(self.table.theta_i.len() - 1);
        let mix = |phi: usize| {
            let [a, b] = [place.theta, next].map(|theta| self.facts[theta * phis + phi]);
            a + place.u as f32 * (b - a)
        };
        let near = mix(place.phi[0]);
        if phis == 1 { near } else { near + place.v as f32 * (mix(place.phi[1]) - near) }
    }

    /// Everything about `wi` that its many `wo` share; `wi` must be above the horizon.
    #[inline(always)]
    pub(super) fn incident<const ISO: bool>(&self, wi: DVec3) -> Incident {
        if ISO { self.sources.incident(&self.table.finder, wi) } else { self.table.incident(wi) }
    }

    /// `cos_theta_i cos_theta_r / G`.
    #[inline(always)]
    pub(super) fn cosines(&self, incident: &Incident, cos_theta_r: f64) -> f64 {
        let cos_theta_i = incident.wi.z;
        (cos_theta_i + incident.masked) * cos_theta_r + cos_theta_i * self.sources.masked(cos_theta_r)
    }

    /// `f_r` and pdf of `wo` for a `wi`.
    #[inline(always)]
    pub(super) fn both(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        if !(wi.z > HORIZON && wo.z > HORIZON) {
            (0.0, 0.0)
        } else if self.plain {
            self.found::<true>(&self.incident::<true>(wi), wo)
        } else {
            self.found_of_any(wi, wo)
        }
    }

    /// The same of any table, above the horizon; a call of its own, so that the plain one stays small.
    #[inline(never)]
    fn found_of_any(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        if self.table.isotropic {
            self.with_floor(&self.incident::<true>(wi), wo, Self::found::<true>)
        } else {
            self.with_floor(&self.incident::<false>(wi), wo, Self::found::<false>)
        }
    }

    #[inline(always)]
    fn with_floor(
        &self,
        incident: &Incident,
        wo: DVec3,
        found: impl Fn(&Self, &Incident, DVec3) -> (f64, f64),
    ) -> (f64, f64) {
        let (rest, pdf) = found(self, incident, wo);
        let blend = self.blend(&incident.place);
        (rest + f64::from(blend.z), pdf + f64::from(blend.y) * wo.z / PI)
    }

    /// The same of the glossy rest alone, both above the horizon.
    #[inline(always)]
    fn found<const ISO: bool>(&self, incident: &Incident, wo: DVec3) -> (f64, f64) {
        let sum = incident.wi + wo;
        let length2 = sum.length_squared();
        // One division for all that is divided by.
        let cosines = 4.0 * self.cosines(incident, wo.z);
        let inverse = 1.0 / (cosines * sum.z);
        let per_z = inverse * cosines;
        let slope = incident.in_cells(sum * -per_z);
        let found = self.slabs.at::<ISO>(&incident.place, [slope.x, slope.y]);
        // cos_beta = |wi + wo| / 2 and cos_theta_h = sum.z / |wi + wo|.
        let steepness = length2 * per_z * per_z;
        let reflectance = self.table.material.reflectance_of_square(at_most(0.25 * length2, 1.0));
        let density = f64::from(found.density);
        let rest = incident.balance * reflectance * density * steepness * steepness * inverse * sum.z;
        let pdf = f64::from(found.draws) * 0.5 * steepness * per_z;
        (rest, pdf)
    }
}
