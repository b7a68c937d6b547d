//! How many incident angles a table needs.

use super::balance::{Balance, mesh};
use super::nodes::{Nodes, turn};
use super::{Node, Table};
use crate::math::direction;
use crate::optics::Material;
use rayon::prelude::*;

/// Two nodes and their shares.
type Pair = [(usize, f64); 2];

impl Table {
    /// `error(t) = [ rest_t sum_k |b T'_k - T_k| W_k / sum_k T_k W_k + |core' - core| + |F' - F| ] / albedo_t <= tolerance`, the worst
    /// over azimuths, primes for what interpolation between the kept neighbours says and `W_k` the energy of hat k: the
    /// polar angles to keep so that it holds at all others, as indices.
    ///
    /// The first and the last angle stay. Then the worst one is added until none is left. What waves gave
    /// is never made of what rays gave, nor the other way round. The noise of rays counts as error, so a noisy table stays as it is.
    pub fn needed_theta_i(&self, tolerance: f64) -> Vec<usize> {
        let weights = self.hat_weights();
        let (angles, phis) = (self.theta_i.len(), self.phi_i.len());
        let between = |low: usize, high: usize, t: usize| -> Pair {
            let tan = |k: usize| self.theta_i[k].tan();
            let u = (tan(t) - tan(low)) / (tan(high) - tan(low));
            [(low, 1.0 - u), (high, u)]
        };
        let error = |kept: &[usize], t: usize| {
            let above = kept.partition_point(|&k| k < t);
            let pair = between(kept[above - 1], kept[above], t);
            let of_azimuth = |p: usize| self.misfit(&weights, t * phis + p, pair.map(|(k, w)| (k * phis + p, w)));
            (0..phis).map(of_azimuth).fold(0.0, f64::max)
        };
        let mut kept = vec![0];
        kept.extend((angles > 1).then_some(angles - 1));
        insert_worst(kept, angles, tolerance, error)
    }

    /// The same for the source azimuths of an anisotropic table, the worst over polar angles.
    pub fn needed_phi_i(&self, tolerance: f64) -> Vec<usize> {
        let weights = self.hat_weights();
        let (angles, phis) = (self.theta_i.len(), self.phi_i.len());
        let turns: Vec<f64> = self.phi_i.iter().map(|p| turn(p.cos(), p.sin())).collect();
        let between = |low: usize, high: usize, p: usize| -> Pair {
            let gap = (turns[high] - turns[low]).rem_euclid(4.0);
            let v = if gap > 0.0 { (turns[p] - turns[low]).rem_euclid(4.0) / gap } else { 0.0 };
            [(low, 1.0 - v), (high, v)]
        };
        let error = |kept: &[usize], p: usize| {
            let above = kept.partition_point(|&k| k < p);
            let pair = between(kept[(above + kept.len() - 1) % kept.len()], kept[above % kept.len()], p);
            let of_angle = |t: usize| self.misfit(&weights, t * phis + p, pair.map(|(k, w)| (t * phis + k, w)));
            (0..angles).map(of_angle).fold(0.0, f64::max)
        };
        insert_worst(vec![0], phis, tolerance, error)
    }

    /// The table of some of its incident angles, indices rising.
    ///
    /// # Panics
    /// If an index is out of range or none is given.
    pub fn at_nodes(&self, theta_i: &[usize], phi_i: &[usize]) -> Table {
        let phis = self.phi_i.len();
        let nodes: Vec<usize> = theta_i.iter().flat_map(|t| phi_i.iter().map(move |p| t * phis + p)).collect();
        let rows = |values: &[f64]| nodes.iter().flat_map(|&n| values[self.node_range(n)].to_vec()).collect();
        let mut table = Table {
            theta_i: theta_i.iter().map(|&t| self.theta_i[t]).collect(),
            phi_i: phi_i.iter().map(|&p| self.phi_i[p]).collect(),
            density: rows(&self.density),
            relative_error: rows(&self.relative_error),
            nodes: nodes.iter().map(|&n| self.nodes[n]).collect(),
            ..self.clone()
        };
        table.finder = Nodes::new(&table.theta_i, &table.phi_i);
        table.balance = Balance::of(&table);
        table
    }

    /// Energy of every hat of every node, for mirror facets.
    fn hat_weights(&self) -> Vec<Vec<f64>> {
        let mesh = mesh(self);
        let phis = self.phi_i.len();
        (0..self.nodes.len())
            .into_par_iter()
            .map(|n| {
                let wi = direction(self.theta_i[n / phis], self.phi_i[n % phis]);
                mesh.hat_energies(self.cells.len(), wi, &Material::Mirror)
            })
            .collect()
    }

    /// What is wrong, relative to its albedo, with a node made of two others.
    fn misfit(&self, weights: &[Vec<f64>], node: usize, pair: Pair) -> f64 {
        let facts = &self.nodes[node];
        if pair.iter().any(|&(n, w)| w > 0.0 && self.nodes[n].wave != facts.wave) {
            return f64::INFINITY;
        }
        let [(a, wa), (b, wb)] = pair;
        let (low, high) = (&self.density[self.node_range(a)], &self.density[self.node_range(b)]);
        let own = &self.density[self.node_range(node)];
        let weights = &weights[node];
        let held: f64 = (0..own.len()).map(|k| (wa * low[k] + wb * high[k]) * weights[k]).sum();
        let wanted = wa * self.balance.own[a] + wb * self.balance.own[b];
        let scale = if held > 0.0 { wanted / held } else { 0.0 };
        let difference: f64 =
            (0..own.len()).map(|k| (scale * (wa * low[k] + wb * high[k]) - own[k]).abs() * weights[k]).sum();
        let blend = |field: fn(&Node) -> f64| wa * field(&self.nodes[a]) + wb * field(&self.nodes[b]) - field(facts);
        let cos = self.theta_i[node / self.phi_i.len()].cos();
        let rest = facts.rest(&self.material, cos);
        let of_rest = if self.balance.own[node] > 0.0 { rest * difference / self.balance.own[node] } else { 0.0 };
        let of_core = blend(|n| n.core_share).abs() * self.material.reflectance(cos);
        let error = of_rest + of_core + blend(|n| n.diffuse).abs();
        if facts.albedo > 0.0 { error / facts.albedo } else { error }
    }
}

/// Adds the index with the largest error until it is below the tolerance.
fn insert_worst(
    mut kept: Vec<usize>,
    count: usize,
    tolerance: f64,
    error: impl Fn(&[usize], usize) -> f64 + Sync,
) -> Vec<usize> {
    loop {
        let left: Vec<usize> = (0..count).filter(|k| !kept.contains(k)).collect();
        let errors: Vec<(f64, usize)> = left.into_par_iter().map(|k| (error(&kept, k), k)).collect();
        match errors.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((worst, k)) if worst > tolerance => {
                kept.push(k);
                kept.sort_unstable();
            }
            _ => return kept,
        }
    }
}
