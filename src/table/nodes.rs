//! Where an incident direction lies between the nodes of a table.

use crate::scatter::axis::{at_least, at_most};
use glam::DVec3;

/// Nodes that surround an incident direction and their weights, which sum to 1.
pub type NodeWeights = [(usize, f64); 4];

/// Incident angles prepared for finding.
///
/// Linear in tan(theta_i), as the lit area of a facet is, and beyond the first and last angle the nearest; linear in the
/// turn, which runs with phi from 0 to 4 without needing an arc tangent:
/// `turn = y / (|x| + |y|)` in the first quadrant, and so on round.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Nodes {
    tangents: Vec<f64>,
    per_gap: Vec<f64>,
    turns: Vec<f64>,
}

/// One place between the nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Interval of theta_i: nodes `theta` and `theta + 1`, the share of the latter. With a single angle the share is 0.
    pub theta: usize,
    pub u: f64,
    /// Indices of the azimuths and the share of the second.
    pub phi: [usize; 2],
    pub v: f64,
    /// Turn of the direction, 0 to 4; 0 with a single azimuth.
    pub turn: f64,
    /// Tangent of theta_i.
    pub tangent: f64,
}

impl Nodes {
    /// Nodes at rising angles \[rad\].
    pub fn new(theta_i: &[f64], phi_i: &[f64]) -> Nodes {
        let tangents: Vec<f64> = theta_i.iter().map(|t| t.tan()).collect();
        let per_gap = tangents.windows(2).map(|t| 1.0 / (t[1] - t[0])).collect();
        let turns = phi_i.iter().map(|p| turn(p.cos(), p.sin())).collect();
        Nodes { tangents, per_gap, turns }
    }

    /// Intervals of theta_i; 1 for a single angle as well.
    pub fn intervals(&self) -> usize {
        self.per_gap.len().max(1)
    }

    /// Finds `wi`, which must lie above the horizon; `r` is the length of its horizontal part.
    #[inline(always)]
    pub fn place(&self, wi: DVec3, r: f64) -> Place {
        let tangent = r / wi.z;
        let (mut theta, mut u) = (0, 0.0);
        if !self.per_gap.is_empty() {
            // Counted over all angles: the branches of a search could not be predicted.
            let inner = &self.tangents[1..self.tangents.len() - 1];
            theta = inner.iter().map(|&t| usize::from(t <= tangent)).sum();
            u = at_most(at_least((tangent - self.tangents[theta]) * self.per_gap[theta], 0.0), 1.0);
        }
        let n = self.turns.len();
        if n == 1 {
            return Place { theta, u, phi: [0, 0], v: 0.0, turn: 0.0, tangent };
        }
        let turn = turn(wi.x, wi.y);
        let above = self.turns.iter().map(|&t| usize::from(t <= turn)).sum::<usize>();
        let (p0, p1) = (if above == 0 { n - 1 } else { above - 1 }, if above == n { 0 } else { above });
        let round = |x: f64| if x < 0.0 { x + 4.0 } else { x };
        let gap = round(self.turns[p1] - self.turns[p0]);
        let v = if gap > 0.0 { round(turn - self.turns[p0]) / gap } else { 0.0 };
        Place { theta, u, phi: [p0, p1], v, turn, tangent }
    }

    /// The same as a list of node numbers, `theta * azimuths + phi`, and weights.
    pub fn weights(&self, place: &Place) -> NodeWeights {
        let n = self.turns.len();
        let next = (place.theta + 1).min(self.tangents.len() - 1);
        let Place { theta, u, phi: [p0, p1], v, .. } = *place;
        [
            (theta * n + p0, (1.0 - u) * (1.0 - v)),
            (next * n + p0, u * (1.0 - v)),
            (theta * n + p1, (1.0 - u) * v),
            (next * n + p1, u * v),
        ]
    }
}

/// 0 to 4 for azimuths 0 to 2 pi, monotone; 0 on the axis.
#[inline]
pub fn turn(x: f64, y: f64) -> f64 {
    let sum = x.abs() + y.abs();
    if sum == 0.0 {
        return 0.0;
    }
    let t = y / sum;
    let turn = if x < 0.0 {
        2.0 - t
    } else if y < 0.0 {
        4.0 + t
    } else {
        t
    };
    if turn >= 4.0 { 0.0 } else { turn }
}

/// The horizontal unit vector at a turn.
pub fn at_turn(turn: f64) -> [f64; 2] {
    let (x, y) = match turn {
        t if t < 1.0 => (1.0 - t, t),
        t if t < 2.0 => (1.0 - t, 2.0 - t),
        t if t < 3.0 => (t - 3.0, 2.0 - t),
        t => (t - 3.0, t - 4.0),
    };
    let r = x.hypot(y);
    [x / r, y / r]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;

    #[test]
    fn turns_run_with_the_azimuth() {
        let mut before = -1.0;
        for k in 0..720 {
            let phi = f64::from(k) * std::f64::consts::TAU / 720.0;
            let t = turn(phi.cos(), phi.sin());
            assert!(t > before && t < 4.0, "{k}: {t}");
            let [x, y] = at_turn(t);
            assert!((x - phi.cos()).abs() < 1e-12 && (y - phi.sin()).abs() < 1e-12);
            before = t;
        }
    }

    #[test]
    fn nodes_have_all_weight_at_their_place_and_share_it_between() {
        let theta_i = [0.0f64, 20.0, 60.0, 75.0, 86.0, 88.0, 89.0].map(f64::to_radians);
        let phi_i = [0.0f64, 30.0, 100.0, 350.0].map(f64::to_radians);
        let nodes = Nodes::new(&theta_i, &phi_i);
        let find = |t: f64, p: f64| {
            let wi = direction(t, p);
            nodes.weights(&nodes.place(wi, wi.x.hypot(wi.y)))
        };
        for (i, &t) in theta_i.iter().enumerate().skip(1) {
            for (j, &p) in phi_i.iter().enumerate() {
                let own: f64 = find(t, p).iter().filter(|n| n.0 == i * 4 + j).map(|n| n.1).sum();
                assert!((own - 1.0).abs() < 1e-9, "{t} {p}: {own}");
            }
        }
        for k in 0..2000 {
            let w = find(1.57 * f64::from(k % 97) / 97.0, f64::from(k) * 0.01);
            assert!((w.iter().map(|n| n.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(w.iter().all(|n| n.1 >= 0.0 && n.0 < 28));
        }
        // Beyond the last angle the last node; between two linear in the tangent.
        let beyond = find(89.9f64.to_radians(), 0.0);
        assert!((beyond[1].1 - 1.0).abs() < 1e-12 && beyond[1].0 == 24);
        let tangent = |t: f64| t.to_radians().tan();
        let share = (tangent(70.0) - tangent(60.0)) / (tangent(75.0) - tangent(60.0));
        assert!((find(70f64.to_radians(), 0.0)[1].1 - share).abs() < 1e-12);
        let single = Nodes::new(&[0.3], &[0.0]);
        assert_eq!(single.weights(&single.place(direction(1.0, 2.0), 1f64.sin()))[0], (0, 1.0));
    }
}
