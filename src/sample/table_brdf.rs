//! A table that can be drawn from.

use super::alias::AliasTable;
use crate::error::Result;
use crate::math::{direction, half_vector, slope_of_half_vector};
use crate::optics::{Brdf, BrdfSample};
use crate::scatter::cells::Stencil;
use crate::scatter::facing::facing;
use crate::scatter::hats::Hats;
use crate::table::{Incident, NodeWeights, Table};
use glam::DVec3;

/// Share of its density that a cell keeps as sampling weight when all of its quadrature points lie below the
/// horizon of the node: between two nodes, or in a corner, it may still reflect.
const SLIVER: f64 = 1e-3;

/// A [`Table`] with one alias table per incident node.
///
/// `pdf(wi, wo) = sum over nodes n of w_n (1 - c_n) sum over cells k of p_n(k) hat_k / H_k / (4 cos_beta cos^3 theta_h)`: node by
/// its interpolation weight, then core with probability `c_n` or cell `k` by alias, then a slope under the hat by which
/// the cell enters the interpolation, `H_k` its integral. So draws follow the interpolated table, and where it is 0
/// none falls. Draws whose mirror direction lies below the horizon carry nothing; the pdf integrates to 1 minus their
/// share and the core's.
pub struct TableBrdf {
    table: Table,
    /// Alias table per node, `None` where only the core reflects.
    nodes: Vec<Option<AliasTable>>,
    /// Probability of the core per node.
    core: Vec<f64>,
    hats: Hats,
}

impl TableBrdf {
    /// Builds the alias tables: weight of a cell = energy the table sends through its hat.
    ///
    /// # Errors
    /// `Error::Parameter` if a density is not a finite, non-negative number.
    pub fn new(table: Table) -> Result<Self> {
        let cells = table.cells.clone();
        let phis = table.phi_i.len();
        let mut nodes = Vec::with_capacity(table.nodes.len());
        let mut core = Vec::with_capacity(table.nodes.len());
        let points: Vec<_> = (0..cells.len()).map(|k| cells.points(k)).collect();
        let stencils: Vec<_> = points.iter().map(|p| p.map(|x| cells.stencil(x.p, x.q))).collect();
        for node in 0..table.nodes.len() {
            let wi = direction(table.theta_i[node / phis], table.phi_i[node % phis]);
            let density = &table.density[table.node_range(node)];
            let mut weights = vec![0.0; cells.len()];
            let mut held = vec![0.0; cells.len()];
            for (point, stencil) in points.iter().flatten().zip(stencils.iter().flatten()) {
                let seen = facing(point.p, point.q, wi).filter(|f| f.wo.z > 0.0);
                let share = seen.map_or(0.0, |f| f.weight * table.material.reflectance(f.cos_beta));
                for &(c, w) in stencil {
                    let t = density[c] * w * point.area;
                    held[c] += t;
                    weights[c] += t * share;
                }
            }
            for (weight, held) in weights.iter_mut().zip(held) {
                *weight = weight.max(SLIVER * held * table.material.reflectance(1.0));
            }
            let mirror = table.nodes[node].core_share * table.material.reflectance(wi.z);
            let rest: f64 = weights.iter().sum();
            core.push(if mirror > 0.0 { mirror / (mirror + rest) } else { 0.0 });
            nodes.push(if rest > 0.0 { Some(AliasTable::new(&weights)?) } else { None });
        }
        Ok(TableBrdf { table, nodes, core, hats: Hats::new(&cells) })
    }

    /// The table behind the sampler.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The alias table of a node, `None` where only the core reflects.
    pub fn alias(&self, node: usize) -> Option<&AliasTable> {
        self.nodes[node].as_ref()
    }

    fn pdf_from(&self, incident: &Incident, wo: DVec3) -> f64 {
        let wh = half_vector(incident.wi, wo);
        let (p, q) = slope_of_half_vector(incident.in_cells(wh));
        let density = self.draw_density(incident, &self.table.cells.stencil(p, q));
        density / (4.0 * wh.dot(incident.wi) * wh.z * wh.z * wh.z)
    }

    /// Density of the draws in the slope plane.
    #[inline]
    fn draw_density(&self, incident: &Incident, stencil: &Stencil) -> f64 {
        let cells = &self.table.cells;
        let under_hats = stencil.map(|(k, w)| (k, w / self.hats.integral(cells.column_and_row(k))));
        let mut density = 0.0;
        for (n, w) in incident.nodes {
            if w > 0.0
                && let Some(alias) = &self.nodes[n]
            {
                let node: f64 = under_hats.iter().map(|&(k, share)| share * alias.probability(k)).sum();
                density += w * (1.0 - self.core[n]) * node;
            }
        }
        density
    }
}

impl Brdf for TableBrdf {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.table.eval(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let incident = self.table.incident(wi);
        // The second number picks the node and the core, and what is left of it the place inside the cell.
        let (node, left) = pick(&incident.nodes, u[1]);
        let core = self.core[node];
        if left < core {
            let probability: f64 = incident.nodes.iter().map(|&(n, w)| w * self.core[n]).sum();
            return Some(BrdfSample {
                wo: DVec3::new(-wi.x, -wi.y, wi.z),
                weight: self.table.core(wi) / probability,
                pdf: f64::INFINITY,
                specular: true,
            });
        }
        let along = (left - core) / (1.0 - core);
        let (cell, across) = self.nodes[node].as_ref()?.draw(u[0]);
        let cells = &self.table.cells;
        let place = self.hats.place(cells.column_and_row(cell), across, along);
        let (p, q) = cells.slope_at(place);
        let slope = incident.out_of_cells(DVec3::new(p, q, 0.0));
        let f = facing(slope.x, slope.y, wi)?;
        if f.wo.z <= 0.0 {
            return None;
        }
        // The slope is known, so f_r cos_theta_r / pdf needs no half vector: what is left is
        // R T cb / (ch ci) over the density of the draw in the slope plane.
        let stencil = cells.stencil_at(place);
        let density = self.table.density_at(&incident, &stencil);
        let reflected = self.table.material.reflectance(f.cos_beta) * density * f.weight * incident.balance;
        let per_slope = self.draw_density(&incident, &stencil);
        let ch2 = 1.0 / (1.0 + p * p + q * q);
        let pdf = per_slope / (4.0 * f.cos_beta * ch2 * ch2.sqrt());
        (pdf > 0.0).then(|| BrdfSample { wo: f.wo, weight: reflected / per_slope, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.pdf_from(&self.table.incident(wi), wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.table.albedo(direction(theta_i, 0.0))
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.table.core(wi)
    }
}

/// A node by its weight, and what is left of `u`.
fn pick(nodes: &NodeWeights, mut u: f64) -> (usize, f64) {
    for &(node, weight) in nodes {
        if u < weight {
            return (node, u / weight);
        }
        u -= weight;
    }
    // Rounding of the weights' sum can leave a hair beyond the last one.
    (nodes[0].0, 0.5)
}
