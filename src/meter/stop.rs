//! A stop of an instrument in place: which directions pass.
//!
//! A stop lies in the focal plane of a lens: it selects directions, not places on the specimen. Everything is done in
//! the plane that touches the unit sphere at the stop's axis (gnomonic), where great circles are straight lines.

use crate::error::{Error, Result};
use crate::math::direction;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Corners of the regular polygon that stands for a disc. Of the same area, it leaves the circle by at most 0.33 % of
/// the radius.
const DISC_CORNERS: usize = 32;

/// Most corners of any stop.
pub const MOST_CORNERS: usize = DISC_CORNERS;

/// Outline of a stop, full plane angles \[rad\] subtended at the specimen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Angle in the plane of measurement, angle across it.
    Rectangle([f64; 2]),
    /// Diameter.
    Disc(f64),
}

impl Shape {
    /// Tangents of half the angles in the plane of measurement and across it.
    pub fn half_tangents(self) -> [f64; 2] {
        match self {
            Shape::Rectangle(sides) => sides,
            Shape::Disc(diameter) => [diameter; 2],
        }
        .map(|angle| (angle / 2.0).tan())
    }

    /// Whether all angles lie between 0 and 90 deg, both excluded.
    ///
    /// # Errors
    /// `Error::Parameter` naming the stop (`whose`) and the angle.
    pub fn check(self, whose: &str) -> Result<()> {
        let angles = match self {
            Shape::Rectangle(sides) => sides.to_vec(),
            Shape::Disc(diameter) => vec![diameter],
        };
        match angles.into_iter().find(|&a| !(a > 0.0 && a < FRAC_PI_2)) {
            None => Ok(()),
            Some(angle) => Err(Error::parameter(
                format!("{whose} is {} deg wide, which is not between 0 and 90", in_degrees(angle)),
                "give full angles in degrees, such as 1.8 by 3.6",
            )),
        }
    }
}

/// Degrees for people, without the dust of the way through radians.
pub fn in_degrees(angle: f64) -> f64 {
    (angle.to_degrees() * 1e9).round() / 1e9
}

/// A convex stop in place.
#[derive(Debug, Clone)]
pub struct Stop {
    shape: Shape,
    /// Axis; unit vectors along growing theta and across it.
    axes: [DVec3; 3],
    /// Counter-clockwise, in the tangent plane at the axis.
    corners: Vec<[f64; 2]>,
    /// Largest coordinates of any corner.
    half: [f64; 2],
    /// Inward normals of the planes through the origin that bound the stop.
    edges: Vec<DVec3>,
}

impl Stop {
    /// A stop about `(theta, phi)`, turned by `turn` about its axis; all in radians. `theta` may be negative: it is then
    /// on the other side of the normal, its first side still along growing theta.
    pub fn new(shape: Shape, theta: f64, phi: f64, turn: f64) -> Self {
        let axis = direction(theta, phi);
        let along = direction(theta + FRAC_PI_2, phi);
        let across = axis.cross(along);
        let (s, c) = turn.sin_cos();
        Self::in_frame(shape, [axis, c * along + s * across, c * across - s * along])
    }

    fn in_frame(shape: Shape, axes: [DVec3; 3]) -> Self {
        let [a, b] = shape.half_tangents();
        let corners = match shape {
            Shape::Rectangle(_) => vec![[-a, -b], [a, -b], [a, b], [-a, b]],
            Shape::Disc(_) => {
                let step = TAU / DISC_CORNERS as f64;
                // The polygon has the area of the circle.
                let r = a * (PI / (0.5 * DISC_CORNERS as f64 * step.sin())).sqrt();
                (0..DISC_CORNERS).map(|k| (k as f64 * step).sin_cos()).map(|(s, c)| [r * c, r * s]).collect()
            }
        };
        let half = [0, 1].map(|k| corners.iter().map(|c| c[k]).fold(0.0, f64::max));
        let mut stop = Stop { shape, axes, corners, half, edges: Vec::new() };
        let w: Vec<DVec3> = stop.corner_directions().collect();
        stop.edges = (0..w.len()).map(|k| w[k].cross(w[(k + 1) % w.len()]).normalize()).collect();
        stop
    }

    /// The same stop seen from a frame in which directions are `turn * w`.
    pub fn seen_from(&self, turn: &DMat3) -> Self {
        Self::in_frame(self.shape, self.axes.map(|axis| *turn * axis))
    }

    /// Axis, unit vector along the first side, unit vector along the second.
    pub fn axes(&self) -> [DVec3; 3] {
        self.axes
    }

    /// Outline.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Corners in the tangent plane, counter-clockwise.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// Largest coordinates of any corner in the tangent plane.
    pub fn half(&self) -> [f64; 2] {
        self.half
    }

    /// Inward normals of the bounding planes: `w` passes if no `n . w` is negative.
    pub fn edges(&self) -> &[DVec3] {
        &self.edges
    }

    /// Direction through a point of the tangent plane.
    pub fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [axis, along, across] = self.axes;
        (axis + x * along + y * across).normalize()
    }

    /// Directions to the corners.
    pub fn corner_directions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.corners.iter().map(|&c| self.direction(c))
    }

    /// Whether `w` passes.
    pub fn contains(&self, w: DVec3) -> bool {
        w.dot(self.axes[0]) > 0.0 && self.edges.iter().all(|n| n.dot(w) >= 0.0)
    }

    /// Solid angle \[sr\]: the sum over the triangles of its fan of `2 atan2(a . (b x c), 1 + a.b + b.c + c.a)` (van Oosterom
    /// and Strackee 1983).
    pub fn solid_angle(&self) -> f64 {
        let w: Vec<DVec3> = self.corner_directions().collect();
        let triangle = |b: DVec3, c: DVec3| {
            let a = w[0];
            2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        };
        w[1..].windows(2).map(|p| triangle(p[0], p[1])).sum()
    }

    /// Projected solid angle `int cos_theta dw` \[sr\] of a stop above the horizon: `1/2 sum gamma_k n_k . z` over its sides of
    /// length gamma (Lambert 1760).
    pub fn projected_solid_angle(&self) -> f64 {
        let w: Vec<DVec3> = self.corner_directions().collect();
        let side = |k: usize| {
            let (a, b) = (w[k], w[(k + 1) % w.len()]);
            let normal = a.cross(b);
            normal.length().atan2(a.dot(b)) * normal.normalize().z
        };
        0.5 * (0..w.len()).map(side).sum::<f64>()
    }

    /// Smallest `cos_theta` of any direction that passes.
    pub fn lowest(&self) -> f64 {
        self.corner_directions().map(|w| w.z).fold(1.0, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// TV14 and TV15: receptor solid angles of the three gloss geometries.
    #[test]
    fn receptors_have_the_published_solid_angles() {
        let cases = [
            (20.0, 1.8, 3.6, 1.97351511945e-3, 1.8541163752e-3),
            (60.0, 4.4, 11.7, 1.56506661342e-2, 7.8098504152e-3),
            (85.0, 4.0, 6.0, 7.30599819155e-3, 6.3633978655e-4),
        ];
        let r = |x: f64| f64::to_radians(x);
        for (angle, a, b, omega, projected) in cases {
            let shape = Shape::Rectangle([r(a), r(b)]);
            let stop = Stop::new(shape, r(angle), PI, 0.0);
            assert!((stop.solid_angle() - omega).abs() < 1e-12, "{}", stop.solid_angle());
            assert!((stop.projected_solid_angle() - projected).abs() < 1e-12);
            // Turned a quarter about its axis it is another stop of the same solid angle.
            let turned = Stop::new(Shape::Rectangle([r(b), r(a)]), r(angle), PI, FRAC_PI_2);
            assert!((turned.projected_solid_angle() - projected).abs() < 1e-12);
            assert!(turned.corner_directions().all(|w| stop.edges().iter().all(|n| n.dot(w) > -1e-12)));
        }
    }

    /// A cone of half angle a subtends `2 pi (1 - cos a)` and projects to `pi sin^2 a cos theta`.
    #[test]
    fn a_disc_is_a_cone() {
        let half = 2.5f64.to_radians();
        let stop = Stop::new(Shape::Disc(2.0 * half), 0.5, 1.0, 0.0);
        assert!((stop.solid_angle() / (TAU * (1.0 - half.cos())) - 1.0).abs() < 1e-5);
        assert!((stop.projected_solid_angle() / (PI * half.sin().powi(2) * 0.5f64.cos()) - 1.0).abs() < 1e-5);
        for k in 0..100 {
            let turn = f64::from(k) * TAU / 100.0;
            let at = |r: f64| stop.direction([r * half.tan() * turn.cos(), r * half.tan() * turn.sin()]);
            assert!(stop.contains(at(0.996)) && !stop.contains(at(1.004)));
        }
    }

    #[test]
    fn the_first_side_lies_in_the_plane_of_measurement_on_either_side() {
        for theta in [0.6, -0.6, 0.0] {
            let stop = Stop::new(Shape::Rectangle([0.02, 0.1]), theta, PI, 0.0);
            let [axis, along, across] = stop.axes();
            assert!(along.y.abs() < 1e-12 && across.y.abs() > 0.999 && axis.cross(along).dot(across) > 0.999);
            assert!((stop.lowest() - stop.corner_directions().map(|w| w.z).fold(9.0, f64::min)).abs() < 1e-15);
        }
    }
}
