//! The numbers of a table as its lookups want them.

use super::grid::Grid;
use crate::table::{Place, Table};
use glam::Vec4;

/// Both nodes of a theta_i interval side by side, for every cell: `T` and density of draws below, then above.
///
/// A lookup reads four cells, two and two neighbours in memory: two cache lines whatever lies between the nodes. In f32,
/// which holds a density to 6e-8 of itself; what is drawn and what the pdf says come from the same numbers.
#[derive(Debug, Clone)]
pub(super) struct Slabs {
    values: Vec<Vec4>,
    cells: usize,
    azimuths: usize,
    pub grid: Grid,
}

/// `T` and the density of draws in the slope plane at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub density: f32,
    pub draws: f32,
}

impl Slabs {
    /// `draws`: density of the draws at the cell centres per node, as `Table`'s densities.
    pub fn new(table: &Table, draws: &[Vec<f32>]) -> Slabs {
        let cells = table.cells().len();
        let azimuths = table.phi_i().len();
        let angles = table.theta_i().len();
        let mut values = Vec::with_capacity(table.finder.intervals() * azimuths * cells);
        for t in 0..table.finder.intervals() {
            for p in 0..azimuths {
                let (low, high) = (t * azimuths + p, (t + 1).min(angles - 1) * azimuths + p);
                let (a, b) = (&table.density[table.node_range(low)], &table.density[table.node_range(high)]);
                let (c, d) = (&draws[low], &draws[high]);
                values.extend((0..cells).map(|k| Vec4::new(a[k] as f32, c[k], b[k] as f32, d[k])));
            }
        }
        Slabs { values, cells, azimuths, grid: Grid::new(table.cells()) }
    }

    /// Interpolates at a slope between the nodes of `place`; `ISO`: of a table of one azimuth.
    #[inline(always)]
    pub fn at<const ISO: bool>(&self, place: &Place, [p, q]: [f64; 2]) -> Found {
        let (from, shares) = self.grid.at(p, q);
        self.between::<ISO>(place, from, shares)
    }

    /// The same above the cell `from`, at the shares of the next column and row.
    #[inline(always)]
    pub fn between<const ISO: bool>(&self, place: &Place, from: usize, shares: [f32; 2]) -> Found {
        if ISO {
            return self.of_interval(place.theta, place.u as f32, from, shares);
        }
        self.of_azimuths(place.theta, place.phi, [place.u, place.v].map(|x| x as f32), from, shares)
    }

    /// The same between two azimuths, at the shares `upper` of the interval `theta` and `v` of the second azimuth.
    #[inline(always)]
    pub fn of_azimuths(
        &self,
        theta: usize,
        phi: [usize; 2],
        [upper, v]: [f32; 2],
        from: usize,
        shares: [f32; 2],
    ) -> Found {
        let [near, other] = phi.map(|p| self.corners(theta * self.azimuths + p, from, shares));
        blend(near + v * (other - near), upper)
    }

    /// The same for a table of one azimuth.
    #[inline(always)]
    pub fn of_interval(&self, theta: usize, upper: f32, from: usize, shares: [f32; 2]) -> Found {
        blend(self.corners(theta, from, shares), upper)
    }

    #[inline(always)]
    fn corners(&self, slab: usize, from: usize, [s, t]: [f32; 2]) -> Vec4 {
        let row = self.grid.row;
        let values = &self.values[slab * self.cells + from..][..row + 2];
        let (near, far) = (&values[..2], &values[row..]);
        let a = near[0] + s * (near[1] - near[0]);
        let b = far[0] + s * (far[1] - far[0]);
        a + t * (b - a)
    }
}

#[inline(always)]
fn blend(sum: Vec4, upper: f32) -> Found {
    Found { density: sum.x + upper * (sum.z - sum.x), draws: sum.y + upper * (sum.w - sum.y) }
}
