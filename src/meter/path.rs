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

use super::overlap::{double_area, overlap};
use super::stop::Stop;
use crate::math::quadrature::gauss_legendre;
use crate::math::{half_vector, reflect};
use crate::optics::Brdf;
use glam::DVec3;

/// Nodes per axis and triangle for the specular core: its integrand is smooth over a few degrees.
const CORE_NODES: usize = 8;

/// Points per side of a stop where the extreme half vectors are looked for, and the allowance for looking at points
/// only.
const SIDE: usize = 4;
const MARGIN: f64 = 0.02;

/// Source and receptor in place, in the frame of the specimen.
#[derive(Debug, Clone)]
pub struct Path {
    source: Stop,
    receptor: Stop,
    /// Half vector of the two axes, and two unit vectors across it: in the plane of both axes and normal to it.
    frame: [DVec3; 3],
    /// Region of half vectors that connect the stops, in the tangent plane at `frame[0]`.
    bounds: [[f64; 2]; 2],
}

impl Path {
    /// From `source` by way of the specimen to `receptor`.
    pub fn new(source: Stop, receptor: Stop) -> Self {
        let (i, o) = (source.axes()[0], receptor.axes()[0]);
        let centre = half_vector(i, o);
        // Back to the source there is no plane of both axes: any will do.
        let across = o.cross(i).try_normalize().unwrap_or(source.axes()[2]);
        let frame = [centre, across.cross(centre), across];
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let receptor_outline = outline(&receptor);
        for i in outline(&source) {
            for &o in &receptor_outline {
                for (bound, x) in bounds.iter_mut().zip(position(&frame, half_vector(i, o))) {
                    *bound = [bound[0].min(x), bound[1].max(x)];
                }
            }
        }
        for [low, high] in &mut bounds {
            let margin = MARGIN * (*high - *low);
            (*low, *high) = (*low - margin, *high + margin);
        }
        Path { source, receptor, frame, bounds }
    }

    /// Source stop.
    pub fn source(&self) -> &Stop {
        &self.source
    }

    /// Receptor stop.
    pub fn receptor(&self) -> &Stop {
        &self.receptor
    }

    /// Direction to the middle of the source.
    pub fn centre(&self) -> DVec3 {
        self.source.axes()[0]
    }

    /// Half vector of both axes and two unit vectors across it: the frame of [`Path::position`].
    pub fn frame(&self) -> [DVec3; 3] {
        self.frame
    }

    /// Rectangle of the tangent plane that holds every half vector connecting the stops: low and high per axis.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        self.bounds
    }

    /// Largest gradient of a facet that throws light from the source into the receptor; infinite if it may be a wall.
    pub fn steepest(&self) -> f64 {
        let [x, y] = self.bounds;
        let corners = [[x[0], y[0]], [x[0], y[1]], [x[1], y[0]], [x[1], y[1]]].map(|c| self.half_vector(c));
        if corners.iter().any(|w| w.z <= 0.0) {
            return f64::INFINITY;
        }
        // A gradient is convex over the tangent plane: its largest value is at a corner.
        corners.iter().map(|w| w.x.hypot(w.y) / w.z).fold(0.0, f64::max)
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
        let polygon = overlap(&self.source, self.receptor.edges(), wh);
        let area = polygon.area();
        if area <= 0.0 {
            return 0.0;
        }
        let wi = self.source.direction(polygon.point(u));
        let wo = reflect(wi, wh);
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        // Tangent planes to solid angles: dw = cos^3 dx dy, for wi as for wh.
        let solid_angles = area * (wi.dot(self.centre()) * wh.dot(self.frame[0])).powi(3);
        brdf.eval(wi, wo) * wi.z * wo.z * 4.0 * wi.dot(wh) * solid_angles
    }

    /// Flux by way of a mirror of normal +z and the given reflectance [sr]: Gauss-Legendre over exactly those source
    /// directions whose mirror image the receptor accepts.
    pub fn core(&self, reflectance: impl Fn(DVec3) -> f64) -> f64 {
        let rule = gauss_legendre(CORE_NODES);
        let mut flux = 0.0;
        for [o, p, q] in overlap(&self.source, self.receptor.edges(), DVec3::Z).triangles() {
            // The square folded to the triangle (Duffy 1982): r from the first corner, t along the far side.
            for &(a, wa) in &rule {
                let r = 0.5 * (1.0 + a);
                for &(b, wb) in &rule {
                    let t = 0.5 * (1.0 + b);
                    let mix = |k: usize| o[k] + r * ((1.0 - t) * (p[k] - o[k]) + t * (q[k] - o[k]));
                    let wi = self.source.direction([mix(0), mix(1)]);
                    let solid_angle = 0.25 * wa * wb * r * double_area([o, p, q]) * wi.dot(self.centre()).powi(3);
                    flux += solid_angle * reflectance(wi) * wi.z.max(0.0);
                }
            }
        }
        flux
    }

    /// Flux of one facet of unit normal `n`, per unit of plan area [sr]:
    /// `int_{P(n)} reflectance(cos_beta, wi, wo) (n . wi) / n.z dwi`, beams that would enter or leave below the horizon
    /// left out.
    pub fn facet(&self, n: DVec3, reflectance: impl Fn(f64, DVec3, DVec3) -> f64) -> f64 {
        let polygon = overlap(&self.source, self.receptor.edges(), n);
        let flux = polygon.integrate(|at| {
            let wi = self.source.direction(at);
            let wo = reflect(wi, n);
            let cos_beta = wi.dot(n);
            if wi.z <= 0.0 || wo.z <= 0.0 || cos_beta <= 0.0 {
                return 0.0;
            }
            reflectance(cos_beta, wi, wo) * cos_beta * wi.dot(self.centre()).powi(3)
        });
        flux / n.z
    }
}

fn position([centre, in_plane, across]: &[DVec3; 3], wh: DVec3) -> [f64; 2] {
    let z = wh.dot(*centre);
    [wh.dot(*in_plane) / z, wh.dot(*across) / z]
}

/// Directions round the outline of a stop.
fn outline(stop: &Stop) -> Vec<DVec3> {
    let corners = stop.corners();
    let steps = if corners.len() > 4 { 1 } else { SIDE };
    (0..corners.len() * steps)
        .map(|k| {
            let (p, q) = (corners[k / steps], corners[(k / steps + 1) % corners.len()]);
            let t = (k % steps) as f64 / steps as f64;
            stop.direction([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])])
        })
        .collect()
}
