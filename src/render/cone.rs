//! Directions in the cone that a sphere fills.

use super::shape::Sphere;
use crate::math::frame::{DVec3, sin_cos_turns, tangents};
use std::f64::consts::TAU;

impl Sphere {
    /// A direction uniform in the cone that the sphere fills, its distance \[m\] and density per steradian; `None` from inside.
    #[inline(always)]
    pub(super) fn sample_direction(&self, from: DVec3, u: [f64; 2]) -> Option<(DVec3, f64, f64)> {
        let (direction, distance, pdf) = self.cone(from, u);
        (pdf > 0.0).then_some((direction, distance, pdf))
    }

    /// As [`Self::sample_direction`] with density 0 from inside, and not a branch on the way
    /// (Wang, Graphics Gems III, 1992).
    #[inline(always)]
    pub(super) fn cone(&self, from: DVec3, u: [f64; 2]) -> (DVec3, f64, f64) {
        let away = self.centre - from;
        let d2 = away.length_squared();
        let (height, pdf) = self.cap(d2);
        let d = d2.sqrt();
        let axis = away * (1.0 / d);
        let (x, y) = tangents(axis);
        // cos = 1 - u h; sin^2 = u h (2 - u h) keeps its digits for a small cone.
        let drop = u[0] * height;
        let sin2 = drop * (2.0 - drop);
        let (s, c) = sin_cos_turns(u[1]);
        let direction = sin2.sqrt() * (c * x + s * y) + (1.0 - drop) * axis;
        let half_chord = (self.radius * self.radius - d2 * sin2).max(0.0).sqrt();
        (direction, d * (1.0 - drop) - half_chord, pdf)
    }

    /// `1 / (2 pi (1 - cos a))`, `sin a = r / d` [1/sr] for any direction that meets the sphere; 0 from inside.
    #[inline]
    pub(super) fn direction_pdf(&self, from: DVec3) -> f64 {
        self.cap((self.centre - from).length_squared()).1
    }

    /// `1 - cos a = sin^2 a / (1 + cos a)` of the cone about the sphere seen from the squared distance `d2`, and the density in it.
    #[inline(always)]
    fn cap(&self, d2: f64) -> (f64, f64) {
        let r2 = self.radius * self.radius;
        let sin2 = r2 / d2;
        let beyond = 1.0 + (1.0 - sin2).max(0.0).sqrt();
        // One division for height and density.
        let inverse = 1.0 / (sin2 * beyond);
        let pdf = beyond * beyond * inverse * (1.0 / TAU);
        (sin2 * sin2 * inverse, if r2 < d2 { pdf } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::shape::Ray;

    #[test]
    fn directions_to_a_sphere_meet_it_and_agree_on_distance_and_density() {
        let sphere = Sphere::new(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
        let from = DVec3::new(-0.5, 0.3, 0.1);
        for u in (0..2500).map(|k| [(f64::from(k % 50) + 0.5) / 50.0, (f64::from(k / 50) + 0.5) / 50.0]) {
            let (direction, distance, pdf) = sphere.sample_direction(from, u).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let t = sphere.intersect(&Ray { origin: from, direction }, f64::INFINITY).unwrap();
            assert!((t - distance).abs() < 1e-9);
            assert_eq!(pdf, sphere.direction_pdf(from));
        }
        // 2 pi (1 - cos 30) when r / d = 1/2.
        let half = Sphere::new(2.0 * DVec3::Z, 1.0).unwrap();
        let solid_angle = TAU * (1.0 - 0.75f64.sqrt());
        assert!((1.0 / half.direction_pdf(DVec3::ZERO) - solid_angle).abs() < 1e-14);
        assert!(half.sample_direction(2.0 * DVec3::Z, [0.5; 2]).is_none());
    }
}
