//! How many incident angles a table needs.

use super::Table;
use super::balance::{Balance, STEPS, mesh};
use super::core::{Cores, cosine};
use super::nodes::{Nodes, turn};
use crate::math::direction;
use crate::optics::Material;
use rayon::prelude::*;

/// Weight of what is wrong with the core.
const CORE: f64 = 5.0;

/// Two nodes and their shares.
type Pair = [(usize, f64); 2];

impl Table {
    /// `error(t) = [ rest_t sum_k |b T'_k - T_k| W_k / sum_k T_k W_k + 5 |core' - core| + |F' - F| ] / albedo_t <= tolerance`, the worst
    /// over azimuths, primes for what interpolation between the kept neighbours says and `W_k` the energy of hat k: the
    /// polar angles to keep so that it holds at all others, as indices.
    ///
    /// Of the rest a receptor sees a part, and in it what is too much beside what is too little; what the core lacks is all missing in
    /// the mirror direction. Hence the 5: at a tolerance of half a per cent a glossmeter is off by a tenth of a unit. What the steps
    /// of `b` make wrong in the energy of the rest counts like the core, beside which a narrow lobe lies.
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
        table.cores = Cores::of(&table);
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
        let theta = node / self.phi_i.len();
        let cos = self.theta_i[theta].cos();
        let (core, wrong) = self.core_between([a, b], wb);
        let straight = |wb: f64| (1.0 - wb) * self.nodes[a].core_share + wb * self.nodes[b].core_share;
        let wanted = wa * self.balance.own[a] + wb * self.balance.own[b] + straight(wb) - core;
        let scale = if held > 0.0 { wanted.max(0.0) / held } else { 0.0 };
        let difference: f64 =
            (0..own.len()).map(|k| (scale * (wa * low[k] + wb * high[k]) - own[k]).abs() * weights[k]).sum();
        let rest = facts.rest(&self.material, cos);
        let of_rest = if self.balance.own[node] > 0.0 { rest * difference / self.balance.own[node] } else { 0.0 };
        let reflectance = self.material.reflectance(cos);
        let of_core = CORE * ((core - facts.core_share).abs() + wrong) * reflectance;
        let diffuse = wa * self.nodes[a].diffuse + wb * self.nodes[b].diffuse - facts.diffuse;
        let error = of_rest + of_core + diffuse.abs();
        if facts.albedo > 0.0 { error / facts.albedo } else { error }
    }

    /// Core that interpolation between two nodes gives where tan(theta_i) gives the second the share `u`, and what the steps of
    /// `b` then make wrong in the energy of the rest.
    fn core_between(&self, [a, b]: [usize; 2], u: f64) -> (f64, f64) {
        let phis = self.phi_i.len();
        let [from, to] = [a, b].map(|n| self.theta_i[n / phis].tan());
        let mix = |u: f64, field: &dyn Fn(usize) -> f64| (1.0 - u) * field(a) + u * field(b);
        let straight = |u: f64| mix(u, &|n| self.nodes[n].core_share);
        if to <= from {
            return (straight(u), 0.0);
        }
        let own = |u: f64| mix(u, &|n| self.balance.own[n]).max(1e-9);
        let steps = STEPS as f64;
        let step = (u * steps).floor().min(steps - 1.0);
        // Cores and factors of the rest at the steps around, and what is between them.
        let [low, high] = [step, step + 1.0].map(|k| {
            let u = k / steps;
            let cos = cosine(from + u * (to - from));
            let visible = self.masking.visible(cos, self.masking.times_cosine(cos), cos);
            let core = self.cores.between([a, b], u, cos * cos) * visible;
            [core, (1.0 + (straight(u) - core) / own(u)).max(0.0)]
        });
        let [core, factor] = [0, 1].map(|k| low[k] + (u * steps - step) * (high[k] - low[k]));
        (core, (factor * own(u) - (own(u) + straight(u) - core).max(0.0)).abs())
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
