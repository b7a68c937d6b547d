//! Directions towards emitting quads and spheres, with their densities per steradian.

use super::shape::{Quad, Shape, Sphere};
use crate::math::frame::{DVec3, tangents};

/// A direction drawn towards an emitter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Toward {
    pub direction: DVec3,
    /// Distance to the point that was drawn \[m\].
    pub distance: f64,
    /// Density of `direction` per steradian.
    pub pdf: f64,
}

impl Quad {
    /// The point at plane coordinates `uv`, drawn uniformly over the area; `None` from behind or within the plane.
    #[inline]
    pub(super) fn sample_direction(&self, from: DVec3, uv: [f64; 2]) -> Option<Toward> {
        let away = self.corner + uv[0] * self.edge_u + uv[1] * self.edge_v - from;
        let distance = away.length();
        let direction = away / distance;
        let pdf = self.direction_pdf(direction, distance);
        (pdf > 0.0 && pdf.is_finite()).then_some(Toward { direction, distance, pdf })
    }

    /// `d^2 / (A cos)` [1/sr] at a point of the quad seen along `direction` at the distance `d`; 0 from behind.
    #[inline]
    pub(super) fn direction_pdf(&self, direction: DVec3, distance: f64) -> f64 {
        let cos = -direction.dot(self.normal);
        if cos > 0.0 { distance * distance / (self.area * cos) } else { 0.0 }
    }
}

impl Sphere {
    /// A direction uniform in the cone that the sphere fills (Wang, Graphics Gems III, 1992); `None` from inside.
    #[inline]
    pub(super) fn sample_direction(&self, from: DVec3, u: [f64; 2]) -> Option<Toward> {
        let height = self.cap_height(from)?;
        let away = self.centre - from;
        let d2 = away.length_squared();
        let d = d2.sqrt();
        let axis = away / d;
        let (x, y) = tangents(axis);
        // cos = 1 - u h; sin^2 = u h (2 - u h) keeps its digits for a small cone.
        let drop = u[0] * height;
        let sin2 = drop * (2.0 - drop);
        let (s, c) = (std::f64::consts::TAU * u[1]).sin_cos();
        let direction = sin2.sqrt() * (c * x + s * y) + (1.0 - drop) * axis;
        let half_chord = (self.radius * self.radius - d2 * sin2).max(0.0).sqrt();
        let distance = d * (1.0 - drop) - half_chord;
        Some(Toward { direction, distance, pdf: 1.0 / (std::f64::consts::TAU * height) })
    }

    /// `1 / (2 pi (1 - cos a))`, `sin a = r / d` [1/sr] for any direction that meets the sphere; 0 from inside.
    #[inline]
    pub(super) fn direction_pdf(&self, from: DVec3) -> f64 {
        self.cap_height(from).map_or(0.0, |height| 1.0 / (std::f64::consts::TAU * height))
    }

    /// `1 - cos a = sin^2 a / (1 + cos a)` of the cone about the sphere.
    #[inline]
    fn cap_height(&self, from: DVec3) -> Option<f64> {
        let sin2 = self.radius * self.radius / (self.centre - from).length_squared();
        (sin2 < 1.0).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }
}

/// Power per solid angle that ranks emitters for selection: area that can be seen times radiance [W/sr].
pub(super) fn intensity(shape: &Shape, mean_radiance: DVec3) -> f64 {
    let area = match shape {
        Shape::Quad(quad) => quad.area,
        Shape::Sphere(sphere) => std::f64::consts::PI * sphere.radius * sphere.radius,
    };
    area * mean_radiance.element_sum() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::shape::Ray;

    fn grid(n: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..n * n).map(move |k| [((k % n) as f64 + 0.5) / n as f64, ((k / n) as f64 + 0.5) / n as f64])
    }

    /// The mean of 1 / pdf is the solid angle: of a square seen from its axis, 4 asin(sin^2) (gnomonic rectangle).
    #[test]
    fn the_mean_inverse_density_is_the_solid_angle_of_a_quad() {
        let quad = Quad::new(DVec3::new(-1.0, -1.0, 2.0), 2.0 * DVec3::Y, 2.0 * DVec3::X).unwrap();
        let n = 400;
        let sum: f64 = grid(n).map(|u| 1.0 / quad.sample_direction(DVec3::ZERO, u).unwrap().pdf).sum();
        let full_angle = 2.0 * 0.5f64.atan();
        let expected = crate::math::solid_angle::rectangle(full_angle, full_angle);
        assert!((sum / (n * n) as f64 - expected).abs() < 1e-5 * expected);
        assert!(quad.sample_direction(DVec3::new(0.0, 0.0, 3.0), [0.5; 2]).is_none());
    }

    #[test]
    fn directions_to_a_sphere_meet_it_and_agree_on_distance_and_density() {
        let sphere = Sphere::new(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
        let from = DVec3::new(-0.5, 0.3, 0.1);
        for u in grid(50) {
            let toward = sphere.sample_direction(from, u).unwrap();
            assert!((toward.direction.length() - 1.0).abs() < 1e-12);
            let t = sphere.intersect(&Ray { origin: from, direction: toward.direction }, f64::INFINITY).unwrap();
            assert!((t - toward.distance).abs() < 1e-9);
            assert_eq!(toward.pdf, sphere.direction_pdf(from));
        }
        // 2 pi (1 - cos 30) when r / d = 1/2.
        let half = Sphere::new(2.0 * DVec3::Z, 1.0).unwrap();
        let solid_angle = std::f64::consts::TAU * (1.0 - 0.75f64.sqrt());
        assert!((1.0 / half.direction_pdf(DVec3::ZERO) - solid_angle).abs() < 1e-14);
        assert!(half.sample_direction(2.0 * DVec3::Z, [0.5; 2]).is_none());
    }
}
