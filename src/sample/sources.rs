//! What a table needs to know of a source, in numbers small enough to stay near.

use super::grid::piece;
use crate::scatter::axis::at_least;
use crate::table::{BALANCE_STEPS, Incident, Nodes, Table};
use glam::DVec3;

/// Steps of the cosine of the masking.
pub(super) const COSINES: usize = 128;

/// Masking of a [`Table`], and its balance if that does not depend on the azimuth.
///
/// Both are straight pieces, each as the value in its middle and the rise over one step. Pieces count from 1, see
/// [`piece`]; room behind the last spares a check.
#[derive(Debug, Clone)]
pub(super) struct Sources {
    pub masking: Box<[[f64; 2]; 2 * COSINES]>,
    /// Pieces of the intervals one after the other, then those from the last node to the horizon.
    pub balance: Vec<[f64; 2]>,
    pub last: Last,
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
    /// Those of a table.
    pub fn new(table: &Table) -> Sources {
        let pieces = |values: &[f64]| -> Vec<[f64; 2]> {
            let inside = values.windows(2).map(|v| [0.5 * (v[0] + v[1]), v[1] - v[0]]);
            let end = values[values.len() - 1];
            [[values[0], 0.0]].into_iter().chain(inside).chain([[end, 0.0]]).collect()
        };
        let masking = pieces(table.masking.steps());
        let (factors, azimuths, behind) = table.balance.steps();
        let last = table.theta_i()[table.theta_i().len() - 1];
        Sources {
            masking: Box::new(std::array::from_fn(|k| masking[k.min(COSINES + 1)])),
            last: Last {
                tangent: if table.theta_i().len() > 1 { last.tan() } else { -1.0 },
                per_cosine: 1.0 / last.cos(),
                before: (factors.len() / azimuths - 1 - behind) as f64,
                behind: behind as f64,
            },
            balance: pieces(factors),
        }
    }

    /// As [`Table::incident`] of an isotropic one.
    #[inline(always)]
    pub fn incident(&self, nodes: &Nodes, wi: DVec3) -> Incident {
        let place = nodes.polar(wi);
        Incident {
            wi,
            place,
            turn: place.azimuth,
            balance: self.balance(place.theta, place.u, place.tangent, wi.z),
            masked: self.masked(wi.z),
        }
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
