//! What an isotropic table needs to know of a source, in numbers small enough to stay near.

use super::grid::piece;
use crate::scatter::axis::{at_least, at_most};
use crate::table::{BALANCE_STEPS, Incident, Place, Table};
use glam::DVec3;

/// Steps of the cosine in which intervals of theta_i are looked for.
pub(super) const BUCKETS: usize = 512;
/// Steps of the cosine of the masking.
pub(super) const COSINES: usize = 128;

/// Intervals of theta_i, masking and balance of a [`Table`] that does not depend on the azimuth.
///
/// The last two are straight pieces, each as the value in its middle and the rise over one step. Pieces count from 1, see
/// [`piece`]; room behind the last spares a check.
#[derive(Debug, Clone)]
pub(super) struct Sources {
    /// The first interval that a step of the cosine reaches into.
    pub first: Box<[u16; 2 * BUCKETS]>,
    pub gaps: Vec<Gap>,
    pub masking: Box<[[f64; 2]; 2 * COSINES]>,
    /// Pieces of the intervals one after the other, then those from the last node to the horizon.
    pub balance: Vec<[f64; 2]>,
    pub last: Last,
}

/// One interval of theta_i.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// Tangent of its first node and one over the distance to the next.
    pub from: f64,
    pub per_gap: f64,
    /// Square of the tangent of its second node; infinite for the last interval.
    pub end2: f64,
}

/// The last node, beyond which the balance runs with the cosine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Last {
    pub tangent: f64,
    pub per_cosine: f64,
    /// Pieces before it and behind it.
    pub before: f64,
    pub behind: f64,
}

impl Sources {
    /// Those of an isotropic table.
    pub fn new(table: &Table) -> Sources {
        let tangents: Vec<f64> = table.theta_i().iter().map(|t| t.tan()).collect();
        let mut gaps: Vec<Gap> =
            tangents.windows(2).map(|t| Gap { from: t[0], per_gap: 1.0 / (t[1] - t[0]), end2: t[1] * t[1] }).collect();
        if gaps.is_empty() {
            gaps.push(Gap { from: tangents[0], per_gap: 0.0, end2: 0.0 });
        }
        let end = gaps.len() - 1;
        gaps[end].end2 = f64::INFINITY;
        let first = |k: usize| {
            // Tangent at the end of the step, rounded down.
            let cos = (k as f64 / BUCKETS as f64).min(1.0);
            let tangent = (1.0 - cos * cos).sqrt() / cos.max(1e-9) * (1.0 - 1e-9);
            gaps.iter().skip(1).filter(|gap| gap.from <= tangent).count() as u16
        };
        let pieces = |values: &[f64]| -> Vec<[f64; 2]> {
            let inside = values.windows(2).map(|v| [0.5 * (v[0] + v[1]), v[1] - v[0]]);
            let end = values[values.len() - 1];
            [[values[0], 0.0]].into_iter().chain(inside).chain([[end, 0.0]]).collect()
        };
        let masking = pieces(table.masking.steps());
        let (factors, azimuths, behind) = table.balance.steps();
        let last = table.theta_i()[table.theta_i().len() - 1];
        Sources {
            first: Box::new(std::array::from_fn(first)),
            masking: Box::new(std::array::from_fn(|k| masking[k.min(COSINES + 1)])),
            last: Last {
                tangent: if tangents.len() > 1 { last.tan() } else { -1.0 },
                per_cosine: 1.0 / last.cos(),
                before: (factors.len() / azimuths - 1 - behind) as f64,
                behind: behind as f64,
            },
            gaps,
            balance: pieces(factors),
        }
    }

    /// As [`Table::incident`].
    #[inline(always)]
    pub fn incident(&self, wi: DVec3) -> Incident {
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
        Incident {
            wi,
            place: Place { theta, u, phi: [0, 0], v: 0.0, turn: 0.0, tangent, sine, azimuth },
            turn: azimuth,
            balance: self.balance(theta, u, tangent, wi.z),
            masked: self.masked(wi.z),
        }
    }

    /// Interval of the cosine `z` and squared sine `r2`: neither root nor division, and the loop seldom turns.
    #[inline(always)]
    pub fn interval(&self, z: f64, r2: f64) -> usize {
        let (step, _) = piece(z * BUCKETS as f64 + 0.5);
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
        at_most(at_least((tangent - gap.from) * gap.per_gap, 0.0), 1.0)
    }

    /// `b(wi)`.
    #[inline(always)]
    pub fn balance(&self, theta: usize, upper: f64, tangent: f64, cos_theta_i: f64) -> f64 {
        if tangent > self.last.tangent {
            return self.balance_beyond(cos_theta_i);
        }
        let (step, x) = piece(BALANCE_STEPS as f64 * upper + 0.5);
        let [middle, rise] = self.balance[BALANCE_STEPS * theta + step];
        middle + x * rise
    }

    #[inline(never)]
    pub fn balance_beyond(&self, cos_theta_i: f64) -> f64 {
        let last = &self.last;
        let beyond = at_least(1.0 - cos_theta_i * last.per_cosine, 0.0);
        let (step, x) = piece(last.before + beyond * last.behind + 0.5);
        let [middle, rise] = self.balance[step];
        middle + x * rise
    }

    /// `L(cos_theta)` of the masking.
    #[inline(always)]
    pub fn masked(&self, cos_theta: f64) -> f64 {
        let (step, x) = piece(cos_theta * COSINES as f64 + 0.5);
        let [middle, rise] = self.masking[step & (2 * COSINES - 1)];
        middle + x * rise
    }
}
