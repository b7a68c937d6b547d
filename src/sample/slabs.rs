//! The numbers of a table as its lookups want them.

use crate::scatter::cells::between;
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
    row: usize,
    azimuths: usize,
    half: [f64; 2],
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
        let half = table.cells().axes.map(|a| f64::from(a.half));
        Slabs { values, cells, row: table.cells().row_length(), azimuths, half }
    }

    /// Interpolates at grid coordinates between the nodes of `place`.
    #[inline(always)]
    pub fn at(&self, place: &Place, [u, v]: [f64; 2]) -> Found {
        let (i, s) = between(u, self.half[0]);
        let (j, t) = between(v, self.half[1]);
        self.between(place, j * self.row + i, [s as f32, t as f32])
    }

    /// The same above the cell `from`, at the shares of the next column and row.
    #[inline(always)]
    pub fn between(&self, place: &Place, from: usize, shares: [f32; 2]) -> Found {
        let slab = place.theta * self.azimuths;
        let mut sum = self.corners(slab + place.phi[0], from, shares);
        if self.azimuths > 1 {
            let other = self.corners(slab + place.phi[1], from, shares);
            sum += place.v as f32 * (other - sum);
        }
        blend(sum, place.u as f32)
    }

    /// The same for a table of one azimuth.
    #[inline(always)]
    pub fn of_interval(&self, theta: usize, upper: f32, from: usize, shares: [f32; 2]) -> Found {
        blend(self.corners(theta, from, shares), upper)
    }

    /// The step from a cell to its neighbour along the second axis.
    pub fn row(&self) -> usize {
        self.row
    }

    #[inline(always)]
    fn corners(&self, slab: usize, from: usize, [s, t]: [f32; 2]) -> Vec4 {
        let values = &self.values[slab * self.cells + from..];
        let (near, far) = (&values[..2], &values[self.row..self.row + 2]);
        let a = near[0] + s * (near[1] - near[0]);
        let b = far[0] + s * (far[1] - far[0]);
        a + t * (b - a)
    }
}

#[inline(always)]
fn blend(sum: Vec4, upper: f32) -> Found {
    Found { density: sum.x + upper * (sum.z - sum.x), draws: sum.y + upper * (sum.w - sum.y) }
}
