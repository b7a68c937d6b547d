//! Where an incident direction lies between the nodes of a table.

use crate::scatter::axis::{at_least, at_most, nearest};
use glam::DVec3;

/// Nodes that surround an incident direction and their weights, which sum to 1.
pub type NodeWeights = [(usize, f64); 4];

/// Steps of the cosine in which intervals are looked for.
pub(crate) const BUCKETS: usize = 512;

/// Incident angles prepared for finding.
///
/// Linear in tan(theta_i), as the lit area of a facet is, and beyond the first and last angle the nearest; linear in the
/// turn, which runs with phi from 0 to 4 without needing an arc tangent:
/// `turn = y / (|x| + |y|)` in the first quadrant, and so on round.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Nodes {
    pub(crate) gaps: Vec<Gap>,
    /// The first interval that a step of the cosine, rounded to the nearest, reaches into; twice as many as there are, so that
    /// a mask spares a check.
    pub(crate) first: Vec<u16>,
    angles: usize,
    turns: Vec<f64>,
}

/// One interval of theta_i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// Tangents of its nodes; the second is infinite for a single angle.
    pub tangents: [f64; 2],
    pub per_gap: f64,
    /// Square of the tangent at which the next interval begins; infinite for the last.
    pub end2: f64,
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
    /// Tangent and sine of theta_i, cosine and sine of phi_i; along x for light from above.
    pub tangent: f64,
    pub sine: f64,
    pub azimuth: [f64; 2],
}

/// All ones if `a >= b`, from the sign of the difference: of a comparison on random numbers LLVM makes a branch, which is
/// missed every other time.
#[inline(always)]
pub(crate) fn not_below(a: f64, b: f64) -> u64 {
    !(((a - b).to_bits() as i64) >> 63) as u64
}

impl Nodes {
    /// Nodes at rising angles \[rad\].
    pub fn new(theta_i: &[f64], phi_i: &[f64]) -> Nodes {
        let tangents: Vec<f64> = theta_i.iter().map(|t| t.tan()).collect();
        let gap = |t: &[f64]| Gap { tangents: [t[0], t[1]], per_gap: 1.0 / (t[1] - t[0]), end2: t[1] * t[1] };
        let mut gaps: Vec<Gap> = if tangents.len() > 1 {
            tangents.windows(2).map(gap).collect()
        } else {
            tangents.iter().map(|&t| Gap { tangents: [t, f64::INFINITY], per_gap: 0.0, end2: 0.0 }).collect()
        };
        if let Some(last) = gaps.last_mut() {
            last.end2 = f64::INFINITY;
        }
        let first = (0..2 * BUCKETS)
            .map(|k| {
                // Tangent at the end of the step, rounded down.
                let cos = (k as f64 / BUCKETS as f64).min(1.0);
                let tangent = (1.0 - cos * cos).sqrt() / cos.max(1e-9) * (1.0 - 1e-9);
                gaps.iter().skip(1).filter(|gap| gap.tangents[0] <= tangent).count() as u16
            })
            .collect();
        let turns = phi_i.iter().map(|p| turn(p.cos(), p.sin())).collect();
        Nodes { gaps, first, angles: theta_i.len(), turns }
    }

    /// Intervals of theta_i; 1 for a single angle as well.
    pub fn intervals(&self) -> usize {
        self.gaps.len()
    }

    /// Interval of the cosine `z` and squared sine `r2`: neither root nor division, and the loop seldom turns.
    #[inline(always)]
    pub fn interval(&self, z: f64, r2: f64) -> usize {
        let (step, _) = nearest(z * BUCKETS as f64 + 0.5);
        let mut theta = usize::from(self.first[step & (2 * BUCKETS - 1)]);
        while r2 >= self.gaps[theta].end2 * (z * z) {
            theta += 1;
        }
        theta
    }

    /// Share of an interval's second node at a tangent.
    #[inline(always)]
    pub fn share(&self, theta: usize, tangent: f64) -> f64 {
        let gap = &self.gaps[theta];
        at_most(at_least((tangent - gap.tangents[0]) * gap.per_gap, 0.0), 1.0)
    }

    /// The second node of the interval with the probability of its share, and what is left of `u`. Decided by the tangent that
    /// `u` asks for, before the share is known.
    #[inline(always)]
    pub fn choose(&self, place: &Place, z: f64, u: f64) -> (usize, f64) {
        let [low, high] = self.gaps[place.theta].tangents;
        let asked = z * (low + (1.0 - u) * (high - low));
        let second = not_below(place.sine * place.sine, asked * asked);
        let one = f64::from_bits(second & 1f64.to_bits());
        let from = 1.0 - place.u;
        let width = from + one * (place.u - from);
        let left = (u - one * from) / width;
        ((second & 1) as usize, at_most(at_least(left, 0.0), 1.0 - f64::EPSILON))
    }

    /// Finds `wi`, which must lie above the horizon, in theta_i alone.
    #[inline(always)]
    pub fn polar(&self, wi: DVec3) -> Place {
        // Too little to matter, but for light from above.
        let x = wi.x + 1e-150;
        let r2 = x * x + wi.y * wi.y;
        let theta = self.interval(wi.z, r2);
        let sine = r2.sqrt();
        let inverse = 1.0 / (sine * wi.z);
        let tangent = r2 * inverse;
        let per_sine = inverse * wi.z;
        let azimuth = [x * per_sine, wi.y * per_sine];
        let u = self.share(theta, tangent);
        Place { theta, u, phi: [0, 0], v: 0.0, turn: 0.0, tangent, sine, azimuth }
    }

    /// Finds `wi`, which must lie above the horizon.
    #[inline(always)]
    pub fn place(&self, wi: DVec3) -> Place {
        let mut place = self.polar(wi);
        let n = self.turns.len();
        if n > 1 {
            let turn = turn(wi.x, wi.y);
            let above = self.turns.iter().map(|&t| usize::from(t <= turn)).sum::<usize>();
            let (p0, p1) = (if above == 0 { n - 1 } else { above - 1 }, if above == n { 0 } else { above });
            let round = |x: f64| x + if x < 0.0 { 4.0 } else { 0.0 };
            let gap = round(self.turns[p1] - self.turns[p0]);
            let v = if gap > 0.0 { round(turn - self.turns[p0]) / gap } else { 0.0 };
            place = Place { phi: [p0, p1], v, turn, ..place };
        }
        place
    }

    /// The same as a list of node numbers, `theta * azimuths + phi`, and weights.
    pub fn weights(&self, place: &Place) -> NodeWeights {
        let n = self.turns.len();
        let next = (place.theta + 1).min(self.angles - 1);
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
    let t = y / (x.abs() + y.abs() + f64::MIN_POSITIVE);
    // Sums of masked terms: branches would be missed every other time.
    let back = if x < 0.0 { 2.0 - 2.0 * t } else { 0.0 };
    let below = if y < 0.0 { 4.0 } else { 0.0 };
    let turn = t + back + if x < 0.0 { 0.0 } else { below };
    if turn < 4.0 { turn } else { 0.0 }
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
            nodes.weights(&nodes.place(wi))
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
        assert_eq!(single.weights(&single.place(direction(1.0, 2.0)))[0], (0, 1.0));
    }
}
