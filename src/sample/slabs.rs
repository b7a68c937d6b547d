//! The numbers of a table as its lookups want them.

use crate::scatter::cells::between;
use crate::table::{Place, Table};

/// Both nodes of a theta_i interval side by side, for every cell: `T` below and above, draw density below and above.
///
/// A lookup reads four cells, two and two neighbours in memory: two cache lines whatever lies between the nodes. In f32,
/// which holds a density to 6e-8 of itself; what is drawn and what the pdf says come from the same numbers.
#[derive(Debug, Clone)]
pub(super) struct Slabs {
    values: Vec<[f32; 4]>,
    cells: usize,
    row: usize,
    azimuths: usize,
    half: [f64; 2],
}

/// `T` and the density of draws in the slope plane at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub density: f64,
    pub draws: f64,
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
                values.extend((0..cells).map(|k| [a[k] as f32, b[k] as f32, c[k], d[k]]));
            }
        }
        let axes = table.cells().axes;
        let half = axes.map(|a| f64::from(a.half));
        Slabs { values, cells, row: table.cells().row_length(), azimuths, half }
    }

    /// Interpolates at grid coordinates between the nodes of `place`.
    #[inline(always)]
    pub fn at(&self, place: &Place, [u, v]: [f64; 2]) -> Found {
        let (i, s) = between(u, self.half[0]);
        let (j, t) = between(v, self.half[1]);
        let (s, t) = (s as f32, t as f32);
        let slab = place.theta * self.azimuths;
        let from = j * self.row + i;
        let mut sum = self.corners(slab + place.phi[0], from, s, t);
        if self.azimuths > 1 {
            let other = self.corners(slab + place.phi[1], from, s, t);
            let v = place.v as f32;
            sum = std::array::from_fn(|k| sum[k] + v * (other[k] - sum[k]));
        }
        let w = place.u as f32;
        Found { density: f64::from(sum[0] + w * (sum[1] - sum[0])), draws: f64::from(sum[2] + w * (sum[3] - sum[2])) }
    }

    #[inline(always)]
    fn corners(&self, slab: usize, from: usize, s: f32, t: f32) -> [f32; 4] {
        let values = &self.values[slab * self.cells..(slab + 1) * self.cells];
        let near = &values[from..from + 2];
        let far = &values[from + self.row..from + self.row + 2];
        std::array::from_fn(|k| {
            let a = near[0][k] + s * (near[1][k] - near[0][k]);
            let b = far[0][k] + s * (far[1][k] - far[0][k]);
            a + t * (b - a)
        })
    }
}
