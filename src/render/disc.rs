//! Discs and rings: where a ray meets them.

use super::shape::Ray;
use crate::error::{Error, Result};
use crate::math::frame::{DVec3, tangents};
use std::f64::consts::{PI, TAU};

/// The points of a plane whose distance from `centre` is between `inner` and `radius`; its front looks along `normal`.
#[derive(Debug, Clone, Copy)]
pub struct Disc {
    pub(super) centre: DVec3,
    pub(super) normal: DVec3,
    pub(super) tangent: DVec3,
    pub(super) radius: f64,
    inner: f64,
}

impl Disc {
    /// A disc, or a ring if `inner` is above 0; lengths in metres.
    ///
    /// # Errors
    /// `Error::Parameter` if a number is not finite, the normal is zero or no area is left.
    pub fn new(centre: DVec3, normal: DVec3, radius: f64, inner: f64) -> Result<Self> {
        let axis = normal.try_normalize().filter(|n| n.is_finite());
        let (Some(normal), true) = (axis, centre.is_finite() && radius.is_finite() && inner >= 0.0 && radius > inner)
        else {
            return Err(Error::parameter(
                format!(
                    "the disc of radius {radius} m, inner radius {inner} m, normal {normal} at {centre} has no area"
                ),
                "give a finite centre, a normal that is not zero and a radius above the inner radius, in metres",
            ));
        };
        Ok(Disc { centre, normal, tangent: tangents(normal).0, radius, inner })
    }

    /// Distance \[m\] if the ray meets the disc before `t_max`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let t = (self.centre - ray.origin).dot(self.normal) / self.normal.dot(ray.direction);
        // A ray in the plane gives an infinity or a NaN: both fail this comparison.
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let r2 = (ray.at(t) - self.centre).length_squared();
        (r2 <= self.radius * self.radius && r2 >= self.inner * self.inner).then_some(t)
    }

    /// Area [m2].
    pub fn area(&self) -> f64 {
        PI * (self.radius * self.radius - self.inner * self.inner)
    }

    /// A point uniform over the area.
    #[inline]
    pub(super) fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        let inner2 = self.inner * self.inner;
        let r = (inner2 + u * (self.radius * self.radius - inner2)).sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        self.centre + r * (cos * self.tangent + sin * self.normal.cross(self.tangent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_hit_between_its_circles() {
        let ring = Disc::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, -2.0, 0.0), 2.0, 1.0).unwrap();
        assert!((ring.area() - 3.0 * PI).abs() < 1e-14);
        let at = |x: f64| ring.intersect(&Ray { origin: DVec3::new(1.0 + x, 0.0, 3.0), direction: DVec3::Y }, 9.0);
        assert_eq!((at(1.5), at(0.5), at(2.5), at(-1.5)), (Some(2.0), None, None, Some(2.0)));
        for k in 0..100 {
            let p = ring.point([(f64::from(k) + 0.5) / 100.0, (f64::from(k) * 0.618).fract()]) - ring.centre;
            assert!(p.y.abs() < 1e-12 && (1.0..=2.0).contains(&p.length()));
        }
        assert!(Disc::new(DVec3::ZERO, DVec3::ZERO, 1.0, 0.0).is_err());
        assert!(Disc::new(DVec3::ZERO, DVec3::Z, 1.0, 1.0).is_err());
        assert!(Disc::new(DVec3::ZERO, DVec3::Z, f64::NAN, 0.0).is_err());
    }
}
