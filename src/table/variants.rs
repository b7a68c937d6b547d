//! Tables that the surface might as well have given: what they differ in is the error that it brings to every reading.

use super::Table;
use super::balance::{Balance, mirror_energies};
use super::build::{keep_cell_means, ratios, relative_scatter};
use super::core::Cores;
use crate::heightmap::sampling::Quantum;
use crate::scatter::slope_histogram::SlopeDensity;

/// What a table would be with the heights as they are, where they come in steps and were spread evenly within them.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Step of the heights \[m\].
    pub step: f64,
    /// Angle between the glints of facets one step apart \[rad\].
    pub glint_spacing: f64,
    /// Share of facets that are the specular core, less that of the table.
    pub core: f64,
    /// Slope density per cell, less that of the table.
    pub change: Vec<f64>,
}

impl Table {
    /// The table of one sub-area of the map: same nodes and the same energy, its own slope density.
    ///
    /// # Panics
    /// If `k` is not below [`Table::subareas`].
    pub fn of_subarea(&self, k: usize) -> Table {
        let n = self.cells.len();
        let mut table = self.bare();
        for (node, t) in table.density.chunks_mut(n).enumerate() {
            let ratios = self.ratios_of(node);
            t.iter_mut().zip(&ratios[k % ratios.len()]).for_each(|(t, r)| *t *= r);
        }
        // A sub-area has other slopes, not another amount of light. What its own slopes would change in the balance between the
        // nodes is of second order, and most of the work.
        table.scale_rest(&self.balance.own);
        table
    }

    /// The table with every mirror beam weaker by its standard error, the lobe having what the beam lost; `None` if no beam has
    /// an error.
    pub fn of_weaker_beam(&self) -> Option<Table> {
        self.nodes.iter().any(|n| n.core_share * n.core_error > 0.0).then(|| {
            let mut table = self.bare();
            let mut own = self.balance.own.clone();
            for (node, own) in table.nodes.iter_mut().zip(&mut own) {
                let lost = node.core_share * node.core_error.min(1.0);
                node.core_share -= lost;
                *own *= 1.0 + lost / (1.0 - node.core_share - lost).max(1e-9);
            }
            table.with_rest(&own)
        })
    }

    /// The table with the heights as they are; `None` if they do not come in steps.
    pub fn of_raw_steps(&self) -> Option<Table> {
        let steps = self.steps.as_ref()?;
        Some(self.bare().with_slopes(steps.core, &steps.change, &self.balance.own))
    }

    /// How the heights as they are differ, if they come in steps.
    pub fn steps(&self) -> Option<&Steps> {
        self.steps.as_ref()
    }

    /// The table with heights that come in steps spread evenly within them: `raw` and `spread` are the slope densities of the map as
    /// it is and spread.
    ///
    /// Facets of such a map have a lattice of slopes. Cells of about its spacing count one line of it here and two there, and a
    /// receptor narrower than the spacing sees a line or none, as the tilt of the instrument has it. Steps that were rounded may
    /// have been anywhere within half a step; spread, the density is that of the surface, its variance larger by
    /// `step^2 / (6 pitch^2)`. Nodes of the wave calculation, which sees heights and no slopes, stay.
    pub fn with_steps_spread(mut self, quantum: &Quantum, raw: &SlopeDensity, spread: &SlopeDensity) -> Table {
        let [raw_cells, spread_cells] = [raw, spread].map(|density| {
            let mut cells = density.density.clone();
            keep_cell_means(&self.cells, &mut cells);
            cells
        });
        let change: Vec<f64> = raw_cells.iter().zip(&spread_cells).map(|(raw, spread)| raw - spread).collect();
        let core = raw.core - spread.core;
        let own = std::mem::take(&mut self.balance.own);
        let back: Vec<f64> = change.iter().map(|c| -c).collect();
        let mut table = self.with_slopes(-core, &back, &own);
        table.subarea_ratio = ratios(&spread.subareas, &spread.density);
        let scatter = relative_scatter(&table.subarea_ratio, table.cells.len());
        for node in (0..table.nodes.len()).filter(|&n| table.nodes[n].wave < 0.5) {
            let range = table.node_range(node);
            let errors = table.relative_error[range].iter_mut().zip(&scatter);
            errors.filter(|(e, _)| **e == 0.0).for_each(|(e, s)| *e = s.unwrap_or(0.0));
        }
        let (step, glint_spacing) = (quantum.step, quantum.glint_spacing);
        table.steps = Some(Steps { step, glint_spacing, core, change });
        table
    }

    /// The table with another core and another slope density at the nodes of rays, and the energy `own` it had.
    fn with_slopes(mut self, core: f64, change: &[f64], own: &[f64]) -> Table {
        let (n, phis) = (self.cells.len(), self.phi_i.len());
        let mut own = own.to_vec();
        for (k, node) in self.nodes.iter_mut().enumerate().filter(|(_, node)| node.wave < 0.5) {
            let cos = self.theta_i[k / phis].cos();
            let more = core * self.masking.visible(cos, self.masking.times_cosine(cos), cos);
            let more = more.clamp(-node.core_share, own[k].max(0.0));
            node.core_share += more;
            own[k] -= more;
            let t = &mut self.density[k * n..(k + 1) * n];
            t.iter_mut().zip(change).for_each(|(t, change)| *t = (*t + change).max(0.0));
        }
        self.with_rest(&own)
    }

    /// A copy without what variants are made of.
    fn bare(&self) -> Table {
        let mut table = self.clone();
        table.subarea_ratio.clear();
        table.speckle_ratio.clear();
        table.steps = None;
        table
    }

    /// The table with the energy `own` of mirror facets in the lobe of every node.
    fn with_rest(mut self, own: &[f64]) -> Table {
        self.scale_rest(own);
        self.cores = Cores::of(&self);
        self.balance = Balance::of(&self);
        self
    }

    fn scale_rest(&mut self, own: &[f64]) {
        let held = mirror_energies(self);
        for (node, (held, wanted)) in held.into_iter().zip(own).enumerate() {
            if held > 0.0 {
                let range = self.node_range(node);
                self.density[range].iter_mut().for_each(|t| *t *= wanted / held);
            }
        }
    }

    /// What carries the map-to-map error of a node.
    pub(crate) fn ratios_of(&self, node: usize) -> &[Vec<f64>] {
        if self.nodes[node].wave > 0.5 && !self.speckle_ratio.is_empty() {
            &self.speckle_ratio
        } else {
            &self.subarea_ratio
        }
    }
}
