//! The part of the source stop whose light a facet throws into the receptor stop.
//!
//! Both stops are bounded by planes through the specimen, and a facet mirrors planes into planes. In the tangent plane of the source
//! stop the answer is therefore a rectangle cut by four straight lines: a convex polygon, exactly.

use crate::math::reflect;
use crate::math::solid_angle::RectangularAperture;
use glam::DVec3;

/// Convex polygon of up to eight corners: a rectangle after four cuts.
#[derive(Debug, Clone, Copy)]
pub struct Polygon {
    corners: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    fn rectangle(half: [f64; 2]) -> Self {
        let [x, y] = half;
        let mut corners = [[0.0; 2]; 8];
        corners[..4].copy_from_slice(&[[-x, -y], [x, -y], [x, y], [-x, y]]);
        Polygon { corners, count: 4 }
    }

    /// Keeps the side `a + b x + c y >= 0` (Sutherland and Hodgman 1974).
    fn cut(self, [a, b, c]: [f64; 3]) -> Self {
        let side = |p: [f64; 2]| a + b * p[0] + c * p[1];
        let sides = self.corners.map(side);
        if sides[..self.count].iter().all(|&s| s >= 0.0) {
            return self;
        }
        let mut cut = Polygon { corners: [[0.0; 2]; 8], count: 0 };
        for k in 0..self.count {
            let next = if k + 1 == self.count { 0 } else { k + 1 };
            let (here, there) = (sides[k], sides[next]);
            if here >= 0.0 {
                cut.push(self.corners[k]);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let t = here / (here - there);
                let (p, q) = (self.corners[k], self.corners[next]);
                cut.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        cut
    }

    /// A line crosses a convex outline twice, so eight corners suffice; rounding must not overrun them all the same.
    fn push(&mut self, corner: [f64; 2]) {
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Twice the area of triangle `k` of the fan about the first corner.
    fn fan(&self, k: usize) -> f64 {
        let [o, p, q] = [self.corners[0], self.corners[k + 1], self.corners[k + 2]];
        ((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])).abs()
    }

    /// Area in the tangent plane.
    pub fn area(&self) -> f64 {
        0.5 * (2..self.count).map(|k| self.fan(k - 2)).sum::<f64>()
    }

    /// Point at `u` in `[0, 1)^2`, uniform over the area.
    pub fn point(&self, u: [f64; 2]) -> [f64; 2] {
        let mut left = u[0] * 2.0 * self.area();
        for k in 0..self.count.saturating_sub(2) {
            let part = self.fan(k);
            if left < part || k + 3 == self.count {
                // Uniform barycentric coordinates (Turk 1990); the number that chose the triangle is used again.
                let root = (left / part).clamp(0.0, 1.0).sqrt();
                let [o, p, q] = [self.corners[0], self.corners[k + 1], self.corners[k + 2]];
                let mix = |axis: usize| (1.0 - root) * o[axis] + root * ((1.0 - u[1]) * p[axis] + u[1] * q[axis]);
                return [mix(0), mix(1)];
            }
            left -= part;
        }
        self.corners[0]
    }
}

/// The polygon in the tangent plane of `source` that a facet of normal `wh` mirrors into `receptor`.
pub fn overlap(source: &RectangularAperture, receptor: &[DVec3; 4], wh: DVec3) -> Polygon {
    let [axis, in_plane, across] = source.axes();
    let half = source.half_tangents();
    let mut polygon = Polygon::rectangle(half);
    for &edge in receptor {
        // n . reflect(wi) = reflect(n) . wi.
        let n = reflect(edge, wh);
        let line = [n.dot(axis), n.dot(in_plane), n.dot(across)];
        let reach = line[1].abs() * half[0] + line[2].abs() * half[1];
        // Most lines miss the rectangle: all of it is on one side.
        if line[0] < -reach {
            return Polygon { count: 0, ..polygon };
        }
        if line[0] < reach {
            polygon = polygon.cut(line);
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use std::f64::consts::PI;

    #[test]
    fn agrees_with_counting_directions() {
        let source = RectangularAperture::new(1.0, 0.0, 0.1, 0.2);
        let receptor = RectangularAperture::new(1.05, PI, 0.2, 0.15);
        for (tilt, azimuth) in [(0.0, 0.0), (0.04, 0.3), (0.05, 2.0), (0.03, 4.0)] {
            let wh = direction(tilt, azimuth);
            let polygon = overlap(&source, &receptor.edges(), wh);
            let (n, mut inside) = (400, 0);
            for i in 0..n * n {
                let u = [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
                inside += i32::from(receptor.contains(reflect(source.direction(u).0, wh)));
                if polygon.area() > 0.0 {
                    let [x, y] = polygon.point(u);
                    let [axis, in_plane, across] = source.axes();
                    let wo = reflect((axis + x * in_plane + y * across).normalize(), wh);
                    // A hair of tolerance on the outline.
                    assert!(receptor.edges().iter().all(|e| e.dot(wo) > -1e-12));
                }
            }
            let [a, b] = source.half_tangents();
            let expected = f64::from(inside) / f64::from(n * n) * 4.0 * a * b;
            assert!((polygon.area() - expected).abs() < 1e-2 * 4.0 * a * b, "{tilt}: {} {expected}", polygon.area());
        }
    }
}
