//! The azimuths of a table with a grain, for lanes.

use crate::table::{Table, turn};

/// Azimuths of the nodes, and the balance of energy at even steps round.
#[derive(Debug, Clone)]
pub(super) struct Azimuths {
    /// Turns of the nodes, see [`turn`], rising.
    pub turns: Vec<f64>,
    /// What lies before the first node, between two, and behind the last: to be found by how many nodes have been passed.
    pub gaps: Vec<Gap>,
    /// `[step][azimuth]`: a factor and its rise to the next azimuth.
    pub balance: Vec<[f32; 2]>,
    /// Azimuths of it.
    pub steps: usize,
}

/// Between two neighbouring azimuths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// Turn of the first and one over the distance to the second; 0 for a single one.
    pub from: f64,
    pub per_gap: f64,
    pub nodes: [u32; 2],
}

impl Azimuths {
    pub fn new(table: &Table) -> Azimuths {
        let turns: Vec<f64> = table.phi_i().iter().map(|phi| turn(phi.cos(), phi.sin())).collect();
        let n = turns.len();
        let gaps = (0..=n)
            .map(|passed| {
                let (first, second) = ((passed + n - 1) % n, passed % n);
                let gap = (turns[second] - turns[first]).rem_euclid(4.0);
                let per_gap = if gap > 0.0 { 1.0 / gap } else { 0.0 };
                Gap { from: turns[first], per_gap, nodes: [first as u32, second as u32] }
            })
            .collect();
        let (factors, steps, _) = table.balance.steps();
        let balance = factors
            .chunks(steps)
            .flat_map(|row| (0..steps).map(|k| [row[k] as f32, (row[(k + 1) % steps] - row[k]) as f32]))
            .collect();
        Azimuths { turns, gaps, balance, steps }
    }
}
