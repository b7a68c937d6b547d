//! As many incident angles as the surface needs.

use super::balance::Balance;
use super::nodes::Nodes;
use super::{Node, Table};

impl Table {
    /// The table without the incident angles that its other angles give back by interpolation: the density to within
    /// `tolerance` of the energy (mean absolute difference), core and floor and losses to within as much of the incident energy.
    ///
    /// While nothing hides, the density of a smooth surface is the same at every angle and two nodes serve up to
    /// where it begins to; a rough one keeps them all. First and last angle always stay.
    pub fn thinned(&self, tolerance: f64) -> Table {
        let count = self.theta_i.len();
        let mut kept = vec![0];
        let mut next = 1;
        // Each kept angle reaches as far as everything between can be given back.
        while next < count {
            let from = kept[kept.len() - 1];
            let mut to = next;
            while to + 1 < count && (from + 1..=to).all(|t| self.given_back(t, from, to + 1, tolerance)) {
                to += 1;
            }
            kept.push(to);
            next = to + 1;
        }
        if kept.len() == count {
            return self.clone();
        }
        let phis = self.phi_i.len();
        let nodes = kept.iter().flat_map(|&t| (0..phis).map(move |p| t * phis + p));
        let mut table = Table {
            theta_i: kept.iter().map(|&t| self.theta_i[t]).collect(),
            density: Vec::new(),
            relative_error: Vec::new(),
            nodes: Vec::new(),
            ..self.clone()
        };
        for node in nodes {
            table.density.extend_from_slice(&self.density[self.node_range(node)]);
            table.relative_error.extend_from_slice(&self.relative_error[self.node_range(node)]);
            table.nodes.push(self.nodes[node]);
        }
        table.finder = Nodes::new(&table.theta_i, &table.phi_i);
        table.balance = Balance::of(&table);
        table
    }

    /// Whether angle `t` is what lies between the angles `a` and `b`.
    fn given_back(&self, t: usize, a: usize, b: usize, tolerance: f64) -> bool {
        let tangent = |t: usize| self.theta_i[t].tan();
        let u = (tangent(t) - tangent(a)) / (tangent(b) - tangent(a));
        let phis = self.phi_i.len();
        (0..phis).all(|p| {
            let [t, a, b] = [t, a, b].map(|t| t * phis + p);
            let [own, low, high] = [t, a, b].map(|n| &self.density[self.node_range(n)]);
            let (mut difference, mut sum) = (0.0, 0.0);
            for k in (0..own.len()).filter(|&k| own[k] != 0.0 || low[k] != 0.0 || high[k] != 0.0) {
                let area = self.cells.area(k);
                difference += area * (own[k] - low[k] - u * (high[k] - low[k])).abs();
                sum += area * own[k];
            }
            let fact = |f: fn(&Node) -> f64| {
                let [t, a, b] = [t, a, b].map(|n| f(&self.nodes[n]));
                (t - a - u * (b - a)).abs() <= tolerance
            };
            difference <= tolerance * sum
                && fact(|n| n.core_share)
                && fact(|n| n.diffuse)
                && fact(|n| n.lost)
                && fact(|n| n.multiple)
                && fact(|n| n.shadowed)
        })
    }
}
