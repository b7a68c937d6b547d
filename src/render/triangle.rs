//! Where a ray meets a triangle, without gaps along shared edges.

use super::shape::Ray;
use crate::math::frame::DVec3;

/// A ray turned so that it runs along +z: the three edge functions of a triangle are then plane cross products, which two
/// triangles with a common edge compute from the same numbers, so no ray slips between them.
///
/// Source: Woop, Benthin, Wald, J. Computer Graphics Techniques 2(1), 2013.
#[derive(Clone, Copy)]
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: [f64; 3],
}

/// Distance \[m\] and the weights of the second and third corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    pub t: f64,
    pub weights: [f64; 2],
}

impl ShearedRay {
    #[inline]
    pub(super) fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let size = d.map(f64::abs);
        let z = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let inverse = 1.0 / d[z];
        ShearedRay { origin: ray.origin, axes: [x, y, z], shear: [d[x] * inverse, d[y] * inverse, inverse] }
    }

    /// The triangle is met from either side, at `0 < t < t_max`.
    #[inline]
    pub(super) fn meet(&self, corners: [DVec3; 3], t_max: f64) -> Option<Meeting> {
        let [x, y, z] = self.axes;
        let turned = corners.map(|corner| {
            let p = (corner - self.origin).to_array();
            [p[x] - self.shear[0] * p[z], p[y] - self.shear[1] * p[z], p[z]]
        });
        let [a, b, c] = turned;
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let t = self.shear[2] * (u * a[2] + v * b[2] + w * c[2]) * inverse;
        (t > 0.0 && t < t_max).then_some(Meeting { t, weights: [v * inverse, w * inverse] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    #[test]
    fn a_triangle_is_met_from_both_sides_with_its_weights() {
        let corners = [DVec3::new(0.0, 0.0, 2.0), DVec3::new(4.0, 0.0, 2.0), DVec3::new(0.0, 2.0, 4.0)];
        // The point with weights (0.25, 0.25, 0.5) of the corners is (1, 1, 3).
        for (origin, direction, t) in
            [([1.0, 1.0, 0.0], [0.0, 0.0, 1.0], 3.0), ([1.0, 1.0, 8.0], [0.0, 0.0, -1.0], 5.0)]
        {
            let meeting = ShearedRay::new(&ray(origin, direction)).meet(corners, f64::INFINITY).unwrap();
            assert!((meeting.t - t).abs() < 1e-14);
            assert!((meeting.weights[0] - 0.25).abs() < 1e-15 && (meeting.weights[1] - 0.5).abs() < 1e-15);
            assert_eq!(ShearedRay::new(&ray(origin, direction)).meet(corners, t), None);
        }
        assert_eq!(ShearedRay::new(&ray([1.0, 1.0, 8.0], [0.0, 0.0, 1.0])).meet(corners, f64::INFINITY), None);
        assert_eq!(ShearedRay::new(&ray([3.0, 1.5, 0.0], [0.0, 0.0, 1.0])).meet(corners, f64::INFINITY), None);
    }

    /// Rays aimed at points of a common edge of two skew triangles, rounded as they come, meet one or the other.
    #[test]
    fn no_ray_slips_through_a_shared_edge() {
        let (p, q) = (DVec3::new(0.1, -0.3, 0.7), DVec3::new(1.3, 0.9, 0.2));
        let near = [p, q, DVec3::new(-0.4, 1.1, 0.3)];
        let far = [q, p, DVec3::new(1.0, -0.8, 0.9)];
        let eye = DVec3::new(0.3, 0.2, 5.0);
        for k in 1..20_000 {
            let target = p.lerp(q, f64::from(k) / 20_000.0);
            let sheared = ShearedRay::new(&Ray { origin: eye, direction: (target - eye).normalize() });
            let met = [near, far].iter().any(|t| sheared.meet(*t, f64::INFINITY).is_some());
            assert!(met, "a ray at {target} slips through");
        }
    }
}
