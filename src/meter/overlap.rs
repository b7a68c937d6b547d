//! The part of the source stop whose light a facet throws into the receptor stop.
//!
//! Both stops are bounded by planes through the specimen, and a facet mirrors planes into planes. In the tangent
//! plane of the source stop the answer is therefore the source's outline cut by straight lines: a convex polygon,
//! exactly.

use super::stop::{MOST_CORNERS, Stop};
use crate::math::reflect;
use arrayvec::ArrayVec;
use glam::DVec3;

type Corners = ArrayVec<[f64; 2], { 2 * MOST_CORNERS + 8 }>;

/// Convex polygon in a tangent plane.
#[derive(Debug, Clone, Default)]
pub struct Polygon {
    corners: Corners,
}

impl Polygon {
    /// Keeps the side `a + b x + c y >= 0` (Sutherland and Hodgman 1974).
    fn cut(&mut self, [a, b, c]: [f64; 3]) {
        let side = |p: [f64; 2]| a + b * p[0] + c * p[1];
        if self.corners.iter().all(|&p| side(p) >= 0.0) {
            return;
        }
        let Some(&last) = self.corners.last() else { return };
        let mut kept = Corners::new();
        // A line crosses a convex outline twice; rounding must not overrun the room for corners all the same.
        let mut keep = |corner: [f64; 2]| {
            let _ = kept.try_push(corner);
        };
        let (mut p, mut here) = (last, side(last));
        for &q in &self.corners {
            let there = side(q);
            if (here >= 0.0) != (there >= 0.0) {
                let t = here / (here - there);
                keep([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
            if there >= 0.0 {
                keep(q);
            }
            (p, here) = (q, there);
        }
        self.corners = kept;
    }

    /// Triangles of the fan about the first corner.
    fn fan(&self) -> impl Iterator<Item = [[f64; 2]; 3]> + '_ {
        let o = self.corners.first().copied().unwrap_or_default();
        self.corners.get(1..).unwrap_or_default().windows(2).map(move |p| [o, p[0], p[1]])
    }

    /// Area in the tangent plane.
    pub fn area(&self) -> f64 {
        0.5 * self.fan().map(double_area).sum::<f64>()
    }

    /// Point at `u` in `[0, 1)^2`, uniform over the area.
    pub fn point(&self, u: [f64; 2]) -> [f64; 2] {
        let mut left = u[0] * 2.0 * self.area();
        let last = self.corners.len().saturating_sub(3);
        for (k, triangle) in self.fan().enumerate() {
            let part = double_area(triangle);
            if left < part || k == last {
                // Uniform barycentric coordinates (Turk 1990); the number that chose the triangle is used again.
                let root = (left / part).clamp(0.0, 1.0).sqrt();
                let [o, p, q] = triangle;
                let mix = |axis: usize| (1.0 - root) * o[axis] + root * ((1.0 - u[1]) * p[axis] + u[1] * q[axis]);
                return [mix(0), mix(1)];
            }
            left -= part;
        }
        self.corners.first().copied().unwrap_or_default()
    }

    /// Integral of `f` over the area by the three-point rule of every triangle of the fan: exact for quadratics.
    pub fn integrate(&self, mut f: impl FnMut([f64; 2]) -> f64) -> f64 {
        // The points of degree 2 inside the triangle (Strang and Fix 1973).
        const SHARES: [[f64; 3]; 3] = [[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]];
        let mut sum = 0.0;
        for triangle in self.fan() {
            let [o, p, q] = triangle;
            let values = SHARES.map(|[a, b, c]| {
                let mix = |axis: usize| (a * o[axis] + b * p[axis] + c * q[axis]) / 6.0;
                f([mix(0), mix(1)])
            });
            sum += double_area(triangle) / 6.0 * (values[0] + values[1] + values[2]);
        }
        sum
    }

    /// The triangles of the fan, for finer rules.
    pub fn triangles(&self) -> Vec<[[f64; 2]; 3]> {
        self.fan().collect()
    }
}

/// Twice the area of a triangle.
pub fn double_area([o, p, q]: [[f64; 2]; 3]) -> f64 {
    ((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])).abs()
}

/// The polygon in the tangent plane of `source` that a facet of normal `wh` mirrors into the receptor of the given edges.
pub fn overlap(source: &Stop, receptor: &[DVec3], wh: DVec3) -> Polygon {
    let [axis, along, across] = source.axes();
    let half = source.half();
    let mut polygon = Polygon { corners: source.corners().iter().copied().collect() };
    for &edge in receptor {
        // n . reflect(wi) = reflect(n) . wi.
        let n = reflect(edge, wh);
        let line = [n.dot(axis), n.dot(along), n.dot(across)];
        let reach = line[1].abs() * half[0] + line[2].abs() * half[1];
        // Most lines miss the stop: all of it is on one side.
        if line[0] < -reach {
            return Polygon::default();
        }
        if line[0] < reach {
            polygon.cut(line);
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::meter::stop::Shape;
    use std::f64::consts::PI;

    #[test]
    fn agrees_with_counting_directions() {
        let rectangle = |a: f64, b: f64| Shape::Rectangle([a, b]);
        for (source, receptor) in [
            (rectangle(0.1, 0.2), rectangle(0.2, 0.15)),
            (Shape::Disc(0.15), rectangle(0.2, 0.15)),
            (rectangle(0.1, 0.2), Shape::Disc(0.2)),
        ] {
            let source = Stop::new(source, 1.0, 0.0, 0.3);
            let receptor = Stop::new(receptor, 1.05, PI, -0.2);
            for (tilt, azimuth) in [(0.0, 0.0), (0.04, 0.3), (0.05, 2.0), (0.03, 4.0)] {
                let wh = direction(tilt, azimuth);
                let polygon = overlap(&source, receptor.edges(), wh);
                let [a, b] = source.half();
                let (n, mut inside) = (400, 0);
                for i in 0..n * n {
                    let u = [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
                    let wi = source.direction([(2.0 * u[0] - 1.0) * a, (2.0 * u[1] - 1.0) * b]);
                    inside += i32::from(source.contains(wi) && receptor.contains(reflect(wi, wh)));
                    if polygon.area() > 0.0 {
                        let wo = reflect(source.direction(polygon.point(u)), wh);
                        // A hair of tolerance on the outline.
                        assert!(receptor.edges().iter().all(|e| e.dot(wo) > -1e-12));
                    }
                }
                let expected = f64::from(inside) / f64::from(n * n) * 4.0 * a * b;
                assert!((polygon.area() - expected).abs() < 2e-2 * a * b, "{tilt}: {} {expected}", polygon.area());
                let moment = polygon.integrate(|[x, y]| 1.0 + x * y);
                assert!((moment - polygon.area()).abs() < polygon.area() * a * b + 1e-15);
            }
        }
    }
}
