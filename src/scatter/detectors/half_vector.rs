//! The cells of the slope plane seen as detectors.

use super::{Bounds, Detectors};
use crate::math::frame;
use crate::scatter::cells::HalfVectorCells;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Steps along each side of a cell when its box in theta and phi is sought.
const STEPS: usize = 8;
/// Chords through a cell that the horizon cuts.
const ROWS: usize = 32;
/// Where they lie in their rows: two rows share the two places of Gauss and Legendre, for what is lit grows with the square of
/// the distance from a corner.
const PAIR: [f64; 2] = [0.422_649_730_810_374_2, 0.577_350_269_189_625_8];
/// Places and weights on `[0, 1]` that are exact to the ninth power (Gauss and Legendre).
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

impl Detectors for HalfVectorCells {
    fn len(&self) -> usize {
        HalfVectorCells::len(self)
    }

    #[inline]
    fn index(&self, wi: DVec3, wo: DVec3) -> usize {
        self.locate_pair(wi, wo)
    }

    #[inline]
    fn slope_cells(&self) -> Option<&HalfVectorCells> {
        Some(self)
    }

    /// `integral over the cell of 4 cos(beta) cos(theta_r) cos^3(theta_h) dp dq` above the horizon: by the points of
    /// [`HalfVectorCells::points`]; along chords where the horizon cuts the cell.
    fn projected_solid_angle(&self, index: usize, wi: DVec3) -> f64 {
        let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(a, b)| self.slope_in(index, a, b));
        // What is above the horizon is convex: a cell is if its corners are.
        if corners.iter().all(|&(p, q)| jacobian(p, q, wi) > 0.0) {
            return self.points(index).iter().map(|x| x.area * jacobian(x.p, x.q, wi)).sum();
        }
        let [along, up] = [2, 1].map(|k: usize| [corners[k].0 - corners[0].0, corners[k].1 - corners[0].1]);
        // Rows only where the disc of `chord` reaches.
        let square = up[0] * up[0] + up[1] * up[1];
        let middle = -((wi.x / wi.z + corners[0].0) * up[0] + (wi.y / wi.z + corners[0].1) * up[1]) / square;
        let reach = 1.0 / (wi.z * square.sqrt());
        let (low, high) = ((middle - reach).max(0.0), (middle + reach).min(1.0));
        if !(low < high) {
            return 0.0;
        }
        let step = (high - low) / ROWS as f64;
        let chords: f64 = (0..ROWS)
            .map(|k| {
                let (p, q) = self.slope_in(index, 0.0, low + (k as f64 + PAIR[k % 2]) * step);
                let Some([from, to]) = chord([p, q], along, wi) else { return 0.0 };
                let at = |x: f64| from + x * (to - from);
                let point = |(x, weight): (f64, f64)| weight * jacobian(p + at(x) * along[0], q + at(x) * along[1], wi);
                (to - from) * GAUSS.into_iter().map(point).sum::<f64>()
            })
            .sum();
        chords * self.area(index) * step
    }

    /// Polar angle and azimuth of the half vector.
    fn bounds(&self, index: usize) -> Bounds {
        let middle = frame::phi(normal_at(self, index, 0.5, 0.5));
        let mut theta = [PI, 0.0f64];
        let mut phi = [middle, middle];
        let step = |k: usize| k as f64 / STEPS as f64;
        for k in 0..=STEPS {
            for [a, b] in [[step(k), 0.0], [step(k), 1.0], [0.0, step(k)], [1.0, step(k)]] {
                let n = normal_at(self, index, a, b);
                let t = frame::theta(n);
                theta = [theta[0].min(t), theta[1].max(t)];
                let p = middle + (frame::phi(n) - middle + PI).rem_euclid(TAU) - PI;
                phi = [phi[0].min(p), phi[1].max(p)];
            }
        }
        let holds_the_pole = self.locate(0.0, 0.0) == index;
        if holds_the_pole {
            return Bounds { theta: [0.0, theta[1]], phi: [0.0, TAU] };
        }
        Bounds { theta, phi }
    }
}

/// `dOmega_p / dp dq = 4 cos(beta) cos(theta_r) cos^3(theta_h) = 4 s (2 s / m2 - wi.z) / m2^2` of the mirror direction of a
/// facet of slope `(p, q)`, `s = wi.z - p wi.x - q wi.y`, `m2 = 1 + p^2 + q^2`; 0 if it lies below the horizon.
fn jacobian(p: f64, q: f64, wi: DVec3) -> f64 {
    let (s, m2) = (wi.z - p * wi.x - q * wi.y, 1.0 + p * p + q * q);
    let cos_r = 2.0 * s / m2 - wi.z;
    if cos_r > 0.0 { 4.0 * s * cos_r / (m2 * m2) } else { 0.0 }
}

/// Part of the way from `start` by `along`, between 0 and 1, whose mirror directions are above the horizon. They are those
/// of the disc `|(p, q) + tan(theta_i) (cos phi_i, sin phi_i)| < 1 / cos(theta_i)`.
fn chord(start: [f64; 2], along: [f64; 2], wi: DVec3) -> Option<[f64; 2]> {
    let ([p, q], [u, v]) = (start, along);
    // a x^2 + 2 b x + c < 0.
    let a = wi.z * (u * u + v * v);
    let b = wi.z * (p * u + q * v) + wi.x * u + wi.y * v;
    let c = wi.z * (p * p + q * q - 1.0) + 2.0 * (wi.x * p + wi.y * q);
    let root = (b * b - a * c).max(0.0).sqrt();
    let (from, to) = (((-b - root) / a).max(0.0), ((-b + root) / a).min(1.0));
    // Without a root both ends are the same; in a plane that is seen edge-on they are not numbers.
    (from < to).then_some([from, to])
}

fn normal_at(cells: &HalfVectorCells, index: usize, a: f64, b: f64) -> DVec3 {
    let (p, q) = cells.slope_in(index, a, b);
    frame::normal_of_slope(p, q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{direction, half_vector};
    use crate::scatter::facing::facing;

    #[test]
    fn the_jacobian_is_the_product_of_its_cosines() {
        for (p, q, theta) in [(0.1, -0.2, 0.4), (-0.9, 0.3, 1.2), (-2.0, 0.5, 1.5)] {
            let wi = direction(theta, 0.7);
            let f = facing(p, q, wi).unwrap();
            let product = 4.0 * f.cos_beta * f.wo.z.max(0.0) * half_vector(wi, f.wo).z.powi(3);
            assert!((jacobian(p, q, wi) - product).abs() < 1e-13 * product.max(1e-3));
        }
    }

    /// Against many midpoints, in cells wholly and partly above the horizon and below it.
    #[test]
    fn cells_at_the_horizon_are_as_large_as_their_points_say() {
        const N: usize = 300;
        let cells = HalfVectorCells::new([0.02, -0.01], [0.3, 0.2], 0.4, 0.01);
        let (mut cut, mut below) = (0, 0);
        for theta in [0.3, 1.0, 1.45] {
            let wi = direction(theta, 2.0);
            for index in (0..Detectors::len(&cells)).step_by(29) {
                let middle = |k: usize| (k as f64 + 0.5) / N as f64;
                let points = (0..N * N).map(|k| cells.slope_in(index, middle(k % N), middle(k / N)));
                let values: Vec<f64> = points.map(|(p, q)| jacobian(p, q, wi)).collect();
                let lit = values.iter().filter(|v| **v > 0.0).count();
                (cut, below) = (cut + usize::from(lit > 0 && lit < N * N), below + usize::from(lit == 0));
                let want = values.iter().sum::<f64>() * cells.area(index) / (N * N) as f64;
                let got = cells.projected_solid_angle(index, wi);
                let full = cells.area(index) * values.iter().fold(0.0f64, |a, b| a.max(*b));
                // A whole cell has four points, by which its energy is weighed too.
                let share = if lit == N * N { 0.01 } else { 1e-3 };
                assert!((got - want).abs() <= share * want + 2e-4 * full, "cell {index}: {got} {want}, {lit} lit");
            }
        }
        assert!(cut > 10 && below > 10, "{cut} {below}");
    }
}
