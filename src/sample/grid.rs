//! The half-vector cells as lookups want them: every constant worked out, no division, no branch.

use crate::scatter::HalfVectorCells;
use crate::scatter::axis::{at_least, at_most};

/// 2^52: added to a small number it rounds it, and leaves the whole number in the last bits.
const TWO_52: f64 = 4_503_599_627_370_496.0;

/// [`HalfVectorCells::coordinates`] and the cells around them.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    to_x: [[f64; 3]; 2],
    /// Per axis: end of the core, cells per octave and their inverse, cells on each side of the central one.
    core: [f64; 2],
    per_octave: [f64; 2],
    octaves_per_cell: [f64; 2],
    /// Half a cell more than there are on each side of the central one.
    pub(super) half: [f64; 2],
    /// The step from a cell to its neighbour along the second axis.
    pub row: usize,
}

/// Of a place of 0 or more, given as `x + 1/2`: the number of its piece counted from 1, and how far it lies beyond the
/// middle of that. A whole `x` is either end of a piece, that of piece 0 included.
#[inline(always)]
pub(super) fn piece(x_and_half: f64) -> (usize, f64) {
    let shifted = x_and_half + TWO_52;
    (shifted.to_bits() as u32 as usize, x_and_half - (shifted - TWO_52))
}

impl Grid {
    pub fn new(cells: &HalfVectorCells) -> Grid {
        let each = |f: fn(&crate::scatter::axis::Axis) -> f64| [f(&cells.axes[0]), f(&cells.axes[1])];
        Grid {
            to_x: cells.to_places(),
            core: each(|axis| f64::from(axis.core) + 0.5),
            per_octave: each(|axis| f64::from(axis.per_octave)),
            octaves_per_cell: each(|axis| 1.0 / f64::from(axis.per_octave)),
            half: each(|axis| f64::from(axis.half) + 0.5),
            row: cells.row_length(),
        }
    }

    /// The cell at or below a slope along both axes, and the shares of the next column and row.
    #[inline(always)]
    pub fn at(&self, p: f64, q: f64) -> (usize, [f32; 2]) {
        self.around(self.place([p, q]))
    }

    /// A slope in core cells along both axes.
    #[inline(always)]
    pub fn place(&self, [p, q]: [f64; 2]) -> [f64; 2] {
        self.to_x.map(|row| row[0] * p + row[1] * q + row[2])
    }

    /// As [`Grid::at`] for a place in core cells.
    #[inline(always)]
    pub fn around(&self, x: [f64; 2]) -> (usize, [f32; 2]) {
        // Most lookups lie in the core, where cells are even; those that do not come in a row.
        let u = if x[0].abs() < self.core[0] && x[1].abs() < self.core[1] {
            x
        } else {
            [0, 1].map(|k| self.coordinate(k, x[k]))
        };
        let [(column, s), (row, t)] = [0, 1].map(|k| {
            // Never piece 0; at the very end the last piece, with all weight on the border.
            piece(at_most(at_least(u[k] + self.half[k], 0.5 + 1e-12), 2.0 * self.half[k] - 0.5))
        });
        ((row * self.row + column).wrapping_sub(self.row + 1), [(s + 0.5) as f32, (t + 0.5) as f32])
    }

    /// As [`crate::scatter::axis::Axis::coordinate`].
    #[inline(always)]
    pub(super) fn coordinate(&self, k: usize, x: f64) -> f64 {
        let distance = x.abs();
        let tail = at_least(distance - self.core[k], 0.0);
        // The bits of a number, read as a whole one, are its logarithm to base 2 in straight pieces.
        let octaves = (1.0 + tail * self.octaves_per_cell[k]).to_bits() as i64 - 1f64.to_bits() as i64;
        let beyond = octaves as f64 * (1.0 / (1u64 << 52) as f64);
        (at_most(distance, self.core[k]) + self.per_octave[k] * beyond).copysign(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    /// The corners and weights are those of the honest stencil, in the core, in the tails and beyond the last cell.
    #[test]
    fn lookups_are_the_stencil_of_the_cells() {
        let cells = HalfVectorCells::new([0.03, -0.01], [0.1, 0.02], 0.5, 0.04);
        let grid = Grid::new(&cells);
        let mut rng = CounterRng::new(4, 0, 0);
        let weight =
            |found: &[(usize, f64); 4], k: usize| -> f64 { found.iter().filter(|s| s.0 == k).map(|s| s.1).sum() };
        for k in 0..20_000 {
            let reach = [0.05, 1.0, 30.0, 1e9][k % 4];
            let (p, q) = (reach * (rng.uniform() - 0.5), reach * (rng.uniform() - 0.5));
            let (from, shares) = grid.at(p, q);
            let [s, t] = shares.map(f64::from);
            let (row, above) = (cells.row_length(), from + cells.row_length());
            let own =
                [(from, (1.0 - s) * (1.0 - t)), (from + 1, s * (1.0 - t)), (above, (1.0 - s) * t), (above + 1, s * t)];
            let honest = cells.stencil(p, q);
            assert!(above + 1 < cells.len() && grid.row == row);
            for (cell, _) in own.into_iter().chain(honest) {
                assert!((weight(&own, cell) - weight(&honest, cell)).abs() < 2e-7, "{p} {q}: {own:?} {honest:?}");
            }
        }
        for slope in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.0, -0.0] {
            assert!(grid.at(slope, slope).0 + cells.row_length() + 1 < cells.len());
        }
    }

    #[test]
    fn places_are_pieces_and_what_lies_beyond_their_middle() {
        for (x, number, beyond) in [(0.25, 1, -0.25), (0.75, 1, 0.25), (1.25, 2, -0.25), (12.5, 13, 0.0)] {
            assert_eq!(piece(x + 0.5), (number, beyond));
        }
    }
}
