//! One draw from a table: node, branch, cell, place under its hat, mirror direction.

use super::slabs::Found;
use super::table_brdf::{HORIZON, TableBrdf};
use crate::optics::BrdfSample;
use crate::scatter::axis::{at_least, at_most};
use crate::table::{Incident, not_below};
use glam::{DVec3, Vec4};
use std::f64::consts::PI;

impl TableBrdf {
    /// A draw whose cell, column and row, comes from `draw(node, u)`, with what is left of `u`.
    #[inline(always)]
    pub(super) fn sample_by(
        &self,
        wi: DVec3,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        if !(wi.z > HORIZON) {
            None
        } else if self.plain {
            self.drawn::<true, true>(&self.incident::<true>(wi), u, draw)
        } else {
            self.drawn_of_any(wi, u, draw)
        }
    }

    /// The same of any table, above the horizon; a call of its own, so that the plain one stays small.
    #[inline(never)]
    fn drawn_of_any(
        &self,
        wi: DVec3,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        if self.table.isotropic {
            self.drawn::<true, false>(&self.incident::<true>(wi), u, draw)
        } else {
            self.drawn::<false, false>(&self.incident::<false>(wi), u, draw)
        }
    }

    #[inline(always)]
    fn drawn<const ISO: bool, const PLAIN: bool>(
        &self,
        incident: &Incident,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        let wi = incident.wi;
        let place = &incident.place;
        let blend = if PLAIN { Vec4::ZERO } else { self.blend(place) };
        // The second number picks the node and its branch, and what is left of it the place inside the cell.
        let phis = if ISO { 1 } else { self.table.phi_i.len() };
        let (upper, mut left) = self.table.finder.choose(place, wi.z, u[1]);
        let mut phi = place.phi[0];
        if phis > 1 {
            let (second, rest) = choose(place.v, left);
            (phi, left) = (place.phi[second], rest);
        }
        let theta = (place.theta + upper).min(self.table.theta_i.len() - 1);
        let node = theta * phis + phi;
        if !PLAIN {
            let [core, floor] = [self.facts[node].x, self.facts[node].y].map(f64::from);
            if left < core {
                return Some(BrdfSample {
                    wo: DVec3::new(-wi.x, -wi.y, wi.z),
                    weight: self.table.core(wi) / f64::from(blend.x),
                    pdf: f64::INFINITY,
                    specular: true,
                });
            }
            if left < core + floor {
                return self.sample_floor(incident, u[0], (left - core) / floor);
            }
            left = at_least((left - core - floor) / (1.0 - core - floor), 0.0);
        }
        let (cell, across) = draw(node, u[0])?;
        let [x, y] = self.hats.place(cell, across, left as f32);
        let (p, q) = self.table.cells.slope_of([f64::from(x.x), f64::from(y.x)]);
        let below = (usize::from(cell[1]) + y.beyond - 1) * self.slabs.grid.row + usize::from(cell[0]) + x.beyond - 1;
        let found = self.slabs.between::<ISO>(place, below, [x.upper, y.upper]);
        self.reflect::<ISO, PLAIN>(incident, blend, [p, q], found)
    }

    /// A draw of the floor, for two uniform numbers.
    fn sample_floor(&self, incident: &Incident, u: f64, v: f64) -> Option<BrdfSample> {
        let wo = incident.out_of_cells(by_the_cosine([u, v]));
        if wo.z <= HORIZON {
            return None;
        }
        let (f, pdf) = self.both(incident.wi, wo);
        Some(BrdfSample { wo, weight: f * wo.z / pdf, pdf, specular: false })
    }

    /// The draw of a slope in the frame of the cells.
    #[inline(always)]
    fn reflect<const ISO: bool, const PLAIN: bool>(
        &self,
        incident: &Incident,
        blend: Vec4,
        [p, q]: [f64; 2],
        found: Found,
    ) -> Option<BrdfSample> {
        let wi = incident.wi;
        let local = if ISO { DVec3::new(incident.place.sine, 0.0, wi.z) } else { wi };
        // lean = cos_beta / cos_theta_h.
        let lean = if ISO { wi.z - p * local.x } else { wi.z - p * local.x - q * local.y };
        let steepness = 1.0 + p * p + q * q;
        let inverse = 1.0 / (steepness * lean);
        let scale = 2.0 * lean * lean * inverse;
        let (x, y) = (-p * scale - local.x, -q * scale - local.y);
        let wo =
            if ISO { incident.out_of_cells(DVec3::new(x, y, scale - wi.z)) } else { DVec3::new(x, y, scale - wi.z) };
        if !(lean > 0.0 && wo.z > HORIZON) {
            return None;
        }
        let reflectance = self.table.material.reflectance_of_square(at_most(0.5 * lean * scale, 1.0));
        let cosines = self.cosines(incident, wo.z);
        let density = incident.balance * reflectance * f64::from(found.density) * lean * wo.z;
        let draws = f64::from(found.draws);
        if PLAIN {
            let pdf = 0.25 * draws * steepness * steepness * steepness * inverse;
            return Some(BrdfSample { wo, weight: density / (cosines * draws), pdf, specular: false });
        }
        // dw / (dp dq) = 4 cos_beta cos^3 theta_h: rest and draws stay per slope, floor and cosine come to it.
        let per_slope = 4.0 * lean / (steepness * steepness);
        let reflected = density / cosines + f64::from(blend.z) * wo.z * per_slope;
        let draws = draws + f64::from(blend.y) * wo.z * (1.0 / PI) * per_slope;
        Some(BrdfSample { wo, weight: reflected / draws, pdf: draws / per_slope, specular: false })
    }
}

/// The direction drawn by the cosine for two uniform numbers (Malley: a point of the disc, lifted).
#[inline]
pub(super) fn by_the_cosine([u, v]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    let r = u.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - u).sqrt())
}

/// The second of two with probability `share`, and what is left of `u`.
#[inline(always)]
fn choose(share: f64, u: f64) -> (usize, f64) {
    let from = 1.0 - share;
    let second = not_below(u, from);
    let one = f64::from_bits(second & 1f64.to_bits());
    let width = from + one * (share - from);
    ((second & 1) as usize, at_most(at_least((u - one * from) / width, 0.0), 1.0 - f64::EPSILON))
}
