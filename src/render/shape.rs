//! Quads and spheres: where a ray meets them.

use super::disc::Disc;
use super::mesh::Mesh;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use std::sync::Arc;

/// `origin + t direction`, `t > 0`, lengths in metres, `direction` of unit length.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    /// The point at the distance `t` \[m\].
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// A parallelogram `corner + u edge_u + v edge_v`, `u, v` in `[0, 1]`; its front looks along `edge_u x edge_v`.
#[derive(Debug, Clone, Copy)]
pub struct Quad {
    pub(super) corner: DVec3,
    pub(super) edge_u: DVec3,
    pub(super) edge_v: DVec3,
    pub(super) normal: DVec3,
    /// Unit vector along `edge_u`, and the one that completes the frame.
    pub(super) tangent: DVec3,
    pub(super) bitangent: DVec3,
    pub(super) area: f64,
    pub(super) offset: f64,
    /// Dual basis: `u = p . dual_u - shift_u` for a point of the plane.
    pub(super) dual_u: DVec3,
    pub(super) dual_v: DVec3,
    pub(super) shift_u: f64,
    pub(super) shift_v: f64,
}

impl Quad {
    /// A parallelogram from a corner and two edges \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` if a number is not finite or the edges are parallel.
    pub fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self> {
        let cross = edge_u.cross(edge_v);
        let area = cross.length();
        let sound = corner.is_finite() && area.is_finite() && area > 1e-12 * edge_u.length() * edge_v.length();
        if !sound {
            return Err(Error::parameter(
                format!("the quad with edges {edge_u} and {edge_v} at {corner} has no area"),
                "give a finite corner and two finite edges that are not parallel, in metres",
            ));
        }
        let normal = cross / area;
        let (dual_u, dual_v) = (edge_v.cross(normal) / area, normal.cross(edge_u) / area);
        Ok(Quad {
            corner,
            edge_u,
            edge_v,
            normal,
            tangent: edge_u.normalize(),
            bitangent: normal.cross(edge_u.normalize()),
            area,
            offset: normal.dot(corner),
            dual_u,
            dual_v,
            shift_u: corner.dot(dual_u),
            shift_v: corner.dot(dual_v),
        })
    }

    /// `t = (corner - origin) . n / (direction . n)` \[m\] if the ray meets the quad before `t_max`.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let (height, fall) = (self.offset - self.normal.dot(ray.origin), self.normal.dot(ray.direction));
        // Away from the plane: no division.
        if height * fall <= 0.0 {
            return None;
        }
        let t = height / fall;
        // A ray in the plane gives an infinity or a NaN: both fail this comparison.
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let [u, v] = self.uv(ray.at(t));
        ((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)).then_some(t)
    }

    /// Plane coordinates of a point on the quad, `[0, 1]` inside.
    #[inline]
    pub fn uv(&self, point: DVec3) -> [f64; 2] {
        [point.dot(self.dual_u) - self.shift_u, point.dot(self.dual_v) - self.shift_v]
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Area [m2].
    pub fn area(&self) -> f64 {
        self.area
    }
}

/// The sphere `|p - centre| = radius`; its front looks outwards.
#[derive(Debug, Clone, Copy)]
pub struct Sphere {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Sphere {
    /// A sphere from centre and radius \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` if a number is not finite or the radius is not positive.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self> {
        if !(centre.is_finite() && radius.is_finite() && radius > 0.0) {
            return Err(Error::parameter(
                format!("the sphere of radius {radius} m at {centre} has no surface"),
                "give a finite centre and a radius above 0, in metres",
            ));
        }
        Ok(Sphere { centre, radius })
    }

    /// Smaller positive root of `t^2 + 2 b t + c = 0`, `b = m . direction`, `c = m . m - r^2`, `m = origin - centre`.
    ///
    /// The discriminant is taken from the distance of the centre to the ray and the roots from `c / q`, which keeps
    /// the digits for small and distant spheres (Haines et al., Ray Tracing Gems, 2019, chapter 7).
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let m = ray.origin - self.centre;
        let b = m.dot(ray.direction);
        let across = m - b * ray.direction;
        let discriminant = self.radius * self.radius - across.length_squared();
        // Most spheres are missed: this exit comes first because it is the one a processor predicts.
        if discriminant < 0.0 {
            return None;
        }
        let c = m.length_squared() - self.radius * self.radius;
        // Outside and going away.
        if c > 0.0 && b > 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        // Outside and approaching: both roots positive, the near one is c / q. Inside: one positive root.
        let t = if c > 0.0 { c / (root - b) } else { root - b };
        (t > 0.0 && t < t_max).then_some(t)
    }

    /// As [`Self::intersect`] for a ray that starts on the sphere itself, where rounding must not find the start again.
    #[cfg(test)]
    pub(super) fn intersect_again(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let t = -2.0 * (ray.origin - self.centre).dot(ray.direction);
        (t > 1e-9 * self.radius && t < t_max).then_some(t)
    }

    /// Longitude / 2 pi about z from x and polar angle / pi from +z.
    pub(super) fn uv(&self, point: DVec3) -> [f64; 2] {
        let n = (point - self.centre) / self.radius;
        let polar = crate::math::frame::theta(n) / std::f64::consts::PI;
        [crate::math::frame::phi(n) / std::f64::consts::TAU, polar]
    }
}

/// What a scene is built of.
#[derive(Clone)]
pub enum Shape {
    Quad(Quad),
    Sphere(Sphere),
    Disc(Disc),
    Mesh(Arc<Mesh>),
}

impl From<Disc> for Shape {
    fn from(disc: Disc) -> Self {
        Shape::Disc(disc)
    }
}

impl From<Mesh> for Shape {
    fn from(mesh: Mesh) -> Self {
        Shape::Mesh(Arc::new(mesh))
    }
}

impl From<Quad> for Shape {
    fn from(quad: Quad) -> Self {
        Shape::Quad(quad)
    }
}

impl From<Sphere> for Shape {
    fn from(sphere: Sphere) -> Self {
        Shape::Sphere(sphere)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    #[test]
    fn a_skew_quad_is_hit_inside_its_edges_only() {
        let quad = Quad::new(DVec3::new(1.0, 0.0, 2.0), DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 3.0, 0.0)).unwrap();
        assert!((quad.area() - 6.0).abs() < 1e-15);
        // The point u = 0.25, v = 0.5 is (2, 1.5, 2).
        let down = ray([2.0, 1.5, 5.0], [0.0, 0.0, -1.0]);
        assert_eq!(quad.intersect(&down, f64::INFINITY), Some(3.0));
        let [u, v] = quad.uv(down.at(3.0));
        assert!((u - 0.25).abs() < 1e-15 && (v - 0.5).abs() < 1e-15);
        assert_eq!(quad.intersect(&down, 3.0), None);
        assert_eq!(quad.intersect(&ray([2.0, 1.5, 5.0], [0.0, 0.0, 1.0]), f64::INFINITY), None);
        // u = -0.01 at v = 0.5.
        assert_eq!(quad.intersect(&ray([1.48, 1.5, 5.0], [0.0, 0.0, -1.0]), f64::INFINITY), None);
        assert_eq!(quad.intersect(&ray([0.0, 1.0, 2.0], [1.0, 0.0, 0.0]), f64::INFINITY), None);
    }

    #[test]
    fn a_sphere_is_hit_from_outside_and_inside() {
        let sphere = Sphere::new(DVec3::new(0.0, 0.0, 10.0), 2.0).unwrap();
        assert_eq!(sphere.intersect(&ray([0.0; 3], [0.0, 0.0, 1.0]), f64::INFINITY), Some(8.0));
        assert_eq!(sphere.intersect(&ray([0.0, 0.0, 11.0], [0.0, 0.0, 1.0]), f64::INFINITY), Some(1.0));
        assert_eq!(sphere.intersect(&ray([0.0; 3], [0.0, 0.0, -1.0]), f64::INFINITY), None);
        assert_eq!(sphere.intersect(&ray([2.1, 0.0, 0.0], [0.0, 0.0, 1.0]), f64::INFINITY), None);
        // Chord of a ray that starts on the surface, 60 deg from the inward normal: 2 r cos 60.
        let chord = ray([0.0, 0.0, 8.0], [3f64.sqrt(), 0.0, 1.0]);
        assert!((sphere.intersect_again(&chord, f64::INFINITY).unwrap() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_tiny_distant_sphere_keeps_its_digits() {
        let sphere = Sphere::new(DVec3::new(0.0, 0.0, 1e6), 1e-3).unwrap();
        let t = sphere.intersect(&ray([0.0; 3], [0.0, 0.0, 1.0]), f64::INFINITY).unwrap();
        assert!((t - (1e6 - 1e-3)).abs() < 1e-6, "{t}");
    }

    #[test]
    fn shapes_without_a_surface_are_refused() {
        assert!(Quad::new(DVec3::ZERO, DVec3::X, 2.0 * DVec3::X).is_err());
        assert!(Quad::new(DVec3::ZERO, DVec3::X, DVec3::NAN).is_err());
        assert!(Sphere::new(DVec3::ZERO, 0.0).is_err());
        assert!(Sphere::new(DVec3::ZERO, f64::NAN).is_err());
    }
}
