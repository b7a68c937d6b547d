//! What a cell of a node is worth to those who draw from it.

use crate::math::direction;
use crate::table::{Mesh, Table, coarse_mesh, mesh};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Azimuths of the circle at which the light is looked at: of a table with a single node for all of them, and of one with several.
const OF_ONE: usize = 12;
const OF_MANY: usize = 24;

/// Energies of the hats of a table by which its cells are drawn: of a table with a grain the root mean square over the
/// azimuths that draw from a node, each with the share of the node there.
///
/// Draws of density `p` from what carries `e` have the second moment `integral of e^2 / p`; of all `p` the one that follows the root
/// mean square of `e` makes the mean of that over the azimuths least (Cauchy and Schwarz). A cell that is lit from one of M
/// azimuths alone is then drawn `1 / sqrt(M)` as often as for that azimuth alone, so no weight grows beyond bounds; the energies of a
/// single azimuth would leave out cells that lie in the dark there.
pub(super) struct Served<'a> {
    table: &'a Table,
    mesh: Mesh<'a>,
    /// For all azimuths but the own.
    coarse: Option<Mesh<'a>>,
}

impl<'a> Served<'a> {
    /// Those of a table.
    pub fn new(table: &'a Table) -> Self {
        let coarse = (!table.is_isotropic()).then(|| coarse_mesh(table));
        Served { table, mesh: mesh(table), coarse }
    }

    /// Energy of every hat of a node.
    pub fn energies(&self, node: usize) -> Vec<f64> {
        let table = self.table;
        let phis = table.phi_i().len();
        let (theta_i, azimuth) = (table.theta_i()[node / phis], node % phis);
        let of =
            |mesh: &Mesh, phi: f64| mesh.hat_energies(table.cells().len(), direction(theta_i, phi), &table.material());
        let own = of(&self.mesh, table.phi_i()[azimuth]);
        let Some(coarse) = self.coarse.as_ref().filter(|_| theta_i > 0.0) else { return own };
        let mut squares: Vec<f64> = own.iter().map(|e| e * e).collect();
        let mut shares = 1.0;
        for (phi, share) in self.others(azimuth) {
            shares += share;
            squares.iter_mut().zip(of(coarse, phi)).for_each(|(sum, e)| *sum += share * e * e);
        }
        squares.iter().map(|sum| (sum / shares).sqrt()).collect()
    }

    /// Other azimuths that draw from the nodes of one, and the share of their draws.
    fn others(&self, own: usize) -> Vec<(f64, f64)> {
        let phis = self.table.phi_i().len();
        let count = if phis == 1 { OF_ONE } else { OF_MANY };
        let share = |phi: f64| -> f64 {
            let weights = self.table.node_weights(direction(FRAC_PI_4, phi));
            weights.iter().filter(|(node, _)| node % phis == own).map(|(_, weight)| weight).sum()
        };
        (1..count)
            .map(|k| self.table.phi_i()[own] + TAU * k as f64 / count as f64)
            .map(|phi| (phi, share(phi)))
            .filter(|(_, share)| *share > 1e-9)
            .collect()
    }
}
