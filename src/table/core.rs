//! The specular core between the nodes.

use super::Table;
use super::balance::STEPS;
use super::nodes::Place;
use glam::DVec3;

/// `core(wi) = G(theta_i, theta_i) c_a^(1 - w) c_b^w`, `w` straight in `cos^2 theta_i` between the nodes a and b, `c = core / G` at
/// a node; exact at four steps of tan(theta_i) to an interval and straight between them, as the balance of the rest is, so that
/// both together keep the energy.
///
/// What roughness leaves of a mirror beam is `|<exp(-j v_z h)>|^2 = exp(-(4 pi Sq cos_theta_i / lambda)^2)` for normally
/// distributed heights (Beckmann and Spizzichino 1963, section 5.3), which the form meets exactly; heights of any distribution
/// have the same form where the beam is strong. The share of exactly flat facets is the same at every angle, and the form meets
/// that too. Straight where one of the nodes has no core.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Cores {
    /// `ln c` per node; minus infinity without a core.
    ln_share: Vec<f64>,
    /// `cos^2 theta_i` per polar angle.
    squares: Vec<f64>,
    azimuths: usize,
    /// The core at every step: `[interval][step][azimuth]`, the last node at the end.
    steps: Vec<f64>,
    last_tangent: f64,
}

impl Cores {
    /// Of the nodes of a table.
    pub fn of(table: &Table) -> Cores {
        let azimuths = table.phi_i.len();
        let visible = |cos: f64| table.masking.visible(cos, table.masking.times_cosine(cos), cos);
        let ln_share = (0..table.nodes.len())
            .map(|n| (table.nodes[n].core_share / visible(table.theta_i[n / azimuths].cos())).ln())
            .collect();
        let squares = table.theta_i.iter().map(|t| t.cos().powi(2)).collect();
        let tangents: Vec<f64> = table.theta_i.iter().map(|t| t.tan()).collect();
        let last_tangent = tangents[tangents.len() - 1];
        let mut cores = Cores { ln_share, squares, azimuths, steps: Vec::new(), last_tangent };
        for (t, ends) in tangents.windows(2).enumerate() {
            for step in 0..STEPS {
                let u = step as f64 / STEPS as f64;
                let cos = cosine(ends[0] + u * (ends[1] - ends[0]));
                let at = |p| cores.between([t, t + 1].map(|t| t * azimuths + p), u, cos * cos) * visible(cos);
                let row: Vec<f64> = (0..azimuths).map(at).collect();
                cores.steps.extend(row);
            }
        }
        let last = &table.nodes[table.nodes.len() - azimuths..];
        cores.steps.extend(last.iter().map(|node| node.core_share));
        cores
    }

    /// `c` at `cos2 = cos^2 theta_i` between the nodes `a` and `b`, of which tan(theta_i) gives the second the share `u`.
    pub fn between(&self, [a, b]: [usize; 2], u: f64, cos2: f64) -> f64 {
        let [x, y] = [a, b].map(|n| self.ln_share[n]);
        let [from, to] = [a, b].map(|n| self.squares[n / self.azimuths]);
        if x.is_finite() && y.is_finite() && from > to {
            let w = ((from - cos2) / (from - to)).clamp(0.0, 1.0);
            (x + w * (y - x)).exp()
        } else {
            (1.0 - u) * x.exp() + u * y.exp()
        }
    }

    /// `core` for `wi` at its place between the nodes.
    pub fn share(&self, table: &Table, place: &Place, wi: DVec3) -> f64 {
        let rows = self.steps.len() / self.azimuths;
        let x = (place.theta as f64 + place.u) * STEPS as f64;
        let step = (x as usize).min(rows.saturating_sub(2));
        let next = (step + 1).min(rows - 1);
        let at = |p: usize| {
            let [low, high] = [step, next].map(|k| self.steps[k * self.azimuths + p]);
            low + (x - step as f64) * (high - low)
        };
        let near = at(place.phi[0]);
        let core = if place.v > 0.0 { near + place.v * (at(place.phi[1]) - near) } else { near };
        if place.tangent <= self.last_tangent {
            return core;
        }
        // Beyond the last node the nearest serves, as far as hills let it.
        let visible = |cos: f64| table.masking.visible(cos, table.masking.times_cosine(cos), cos);
        core * visible(wi.z) / visible(cosine(self.last_tangent))
    }
}

/// Cosine of a tangent.
pub fn cosine(tangent: f64) -> f64 {
    1.0 / (1.0 + tangent * tangent).sqrt()
}
