//! Flux from a source stop through a receptor stop, by way of a surface.
//!
//! `Phi = int_S int_R f_r(wi, wo) cos_theta_i cos_theta_r dwo dwi`, radiance 1 and uniform over the source stop `S`,
//! specimen overfilled. The specular core adds `int_S R cos_theta_i [mirror(wi) in receptor] dwi`.
//!
//! The integral is taken over half vectors first (`dwo = 4 cos_beta dwh`):
//!
//! `Phi = int [ int_{P(wh)} f_r cos_theta_i cos_theta_r 4 cos_beta dwi ] dwh`
//!
//! with `P(wh)` the part of the source stop that a facet of normal `wh` mirrors into the receptor
//! ([`super::overlap`]). A lobe is then one round spot whatever the angle, where over `wo` it is a ridge eleven times
//! longer than wide at 85 deg; and no ray misses the receptor: the area of `P` fades out at the rim, which
//! low-discrepancy points need to converge fast.

use super::geometry::Geometry;
use super::overlap::overlap;
use crate::math::quadrature::gauss_legendre;
use crate::math::solid_angle::RectangularAperture;
use crate::math::{half_vector, reflect};
use crate::optics::Brdf;
use glam::DVec3;
use std::f64::consts::PI;

/// Nodes per axis for the specular core: its integrand is smooth over a few degrees.
const CORE_NODES: usize = 12;

/// Intervals per side of a stop where the extreme half vectors are looked for, and the allowance for looking at
/// points only.
const SIDE: i32 = 4;
const MARGIN: f64 = 0.02;

/// Source and receptor in place at one azimuth.
#[derive(Debug, Clone)]
pub struct Path {
    geometry: Geometry,
    source: RectangularAperture,
    receptor_edges: [DVec3; 4],
    /// Half vector of the two axes, and two unit vectors across it: in the plane of measurement and normal to it.
    frame: [DVec3; 3],
    /// Region of half vectors that connect the stops, in the tangent plane at `frame[0]`.
    bounds: [[f64; 2]; 2],
}

impl Path {
    /// Source at azimuth `phi` \[rad\] of the specimen, receptor opposite.
    pub fn new(geometry: &Geometry, phi: f64) -> Self {
        let stop = |theta: f64, phi: f64, [a, b]: [f64; 2]| RectangularAperture::new(theta, phi, a, b);
        let source = stop(geometry.theta_i, phi, geometry.source);
        let receptor = stop(geometry.theta_i + geometry.offset, phi + PI, geometry.receptor);
        let centre = half_vector(source.axes()[0], receptor.axes()[0]);
        let across = source.axes()[2];
        let frame = [centre, across.cross(centre), across];
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for i in outline(&source) {
            for o in outline(&receptor) {
                for (bound, x) in bounds.iter_mut().zip(position(&frame, half_vector(i, o))) {
                    *bound = [bound[0].min(x), bound[1].max(x)];
                }
            }
        }
        for [low, high] in &mut bounds {
            let margin = MARGIN * (*high - *low);
            (*low, *high) = (*low - margin, *high + margin);
        }
        Path { geometry: geometry.clone(), source, receptor_edges: receptor.edges(), frame, bounds }
    }

    /// Direction to the middle of the source.
    pub fn centre(&self) -> DVec3 {
        self.source.axes()[0]
    }

    /// Rectangle of the tangent plane that holds every half vector connecting the stops: low and high per axis.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        self.bounds
    }

    /// Point of the tangent plane where `wh` meets it; `None` if no ray of this path has that half vector.
    pub fn position(&self, wh: DVec3) -> Option<[f64; 2]> {
        let p = position(&self.frame, wh);
        let within = self.bounds.iter().zip(p).all(|([low, high], x)| x > *low && x < *high);
        (wh.dot(self.frame[0]) > 0.0 && within).then_some(p)
    }

    /// Half vector through a point of the tangent plane.
    pub fn half_vector(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [centre, in_plane, across] = self.frame;
        (centre + x * in_plane + y * across).normalize()
    }

    /// `dwo / (dx dy) = 4 cos_beta cos^3` for the middle of the source: densities of `wo` times this are densities in
    /// the tangent plane.
    pub fn jacobian(&self, wh: DVec3) -> f64 {
        4.0 * self.centre().dot(wh) * wh.dot(self.frame[0]).powi(3)
    }

    /// `f_r cos_theta_i cos_theta_r 4 cos_beta |P(wh)| cos^3` at one `wi` uniform in `P(wh)` for `u` in `[0, 1)^2`: its
    /// mean over `u`, integrated over the tangent plane, is the flux [sr^2].
    pub fn integrand(&self, brdf: &dyn Brdf, wh: DVec3, u: [f64; 2]) -> f64 {
        let polygon = overlap(&self.source, &self.receptor_edges, wh);
        let area = polygon.area();
        if area <= 0.0 {
            return 0.0;
        }
        let [a, b] = polygon.point(u);
        let [axis, in_plane, across] = self.source.axes();
        let wi = (axis + a * in_plane + b * across).normalize();
        let wo = reflect(wi, wh);
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        // Tangent planes to solid angles: dw = cos^3 dx dy, for wi as for wh.
        let solid_angles = area * (wi.dot(axis) * wh.dot(self.frame[0])).powi(3);
        brdf.eval(wi, wo) * wi.z * wo.z * 4.0 * wi.dot(wh) * solid_angles
    }

    /// Flux of a specular core of the given reflectance [sr]: Gauss-Legendre over exactly those source directions
    /// whose mirror image the receptor accepts.
    ///
    /// In the source's tangent plane the receptor is bounded by straight lines (great circles project to lines), so
    /// the accepted part is `x` in an interval and `|y|` below a line: no jump is left for the rule to step over.
    pub fn core(&self, reflectance: impl Fn(DVec3) -> f64) -> f64 {
        let g = &self.geometry;
        let [half_x, half_y] = self.source.half_tangents();
        // x runs along growing theta, for the mirrored source as for the receptor.
        let low = (g.offset - g.receptor[0] / 2.0).tan().max(-half_x);
        let high = (g.offset + g.receptor[0] / 2.0).tan().min(half_x);
        if high <= low {
            return 0.0;
        }
        let receptor_half_y = (g.receptor[1] / 2.0).tan();
        let rule = gauss_legendre(CORE_NODES);
        let mut flux = 0.0;
        for &(a, wa) in &rule {
            let x = 0.5 * (low + high + (high - low) * a);
            let reach = (receptor_half_y * (g.offset.cos() + x * g.offset.sin())).min(half_y);
            for &(b, wb) in &rule {
                let (wi, density) = self.source.direction([0.5 + 0.5 * x / half_x, 0.5 + 0.5 * reach * b / half_y]);
                // Share of the stop's plane area that this node stands for.
                let share = 0.125 * wa * wb * (high - low) * reach / (half_x * half_y);
                flux += share / density * reflectance(wi) * wi.z.max(0.0);
            }
        }
        flux
    }
}

fn position([centre, in_plane, across]: &[DVec3; 3], wh: DVec3) -> [f64; 2] {
    let z = wh.dot(*centre);
    [wh.dot(*in_plane) / z, wh.dot(*across) / z]
}

/// Directions round the outline of a stop.
fn outline(stop: &RectangularAperture) -> Vec<DVec3> {
    let at = |k: i32| f64::from(k) / f64::from(SIDE);
    let sides = |k: i32| [[at(k), 0.0], [at(k), 1.0], [0.0, at(k)], [1.0, at(k)]];
    (0..=SIDE).flat_map(sides).map(|u| stop.direction(u).0).collect()
}
