//! The alias columns of all nodes as draws want them.

use super::alias::AliasTable;
use super::grid::piece;
use crate::scatter::HalfVectorCells;
use crate::scatter::axis::{at_least, at_most};
use crate::table::not_below;

/// Steps of a threshold.
pub(super) const STEPS: f64 = (1u64 << 32) as f64;

/// The columns of every node's [`AliasTable`], one after the other, cells by column and row of the grid.
#[derive(Debug, Clone)]
pub(super) struct Slots {
    pub slots: Vec<Slot>,
    pub nodes: Vec<Range>,
}

/// One alias column: its threshold, the alias, the own cell and what lies beyond the threshold; 16 bytes, so that it is one
/// load and never in two cache lines. Cells are column + 2^16 row.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(16))]
pub(super) struct Slot {
    pub words: [u32; 4],
}

/// The slots of one node.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(8))]
pub(super) struct Range {
    pub first: u32,
    pub count: u32,
}

/// Column and row of a cell of a [`Slot`].
#[inline(always)]
fn column_and_row(cell: u32) -> [u16; 2] {
    [cell as u16, (cell >> 16) as u16]
}

/// Place of `u` in `[0, 1)` among so many columns; rounding never takes it beyond the last.
#[inline(always)]
pub(super) fn place(u: f64, count: f64) -> f64 {
    at_most(at_least(u * count, 1e-12), count * (1.0 - f64::EPSILON * 4.0))
}

impl Slots {
    /// The columns of the nodes in order.
    pub fn new<'a>(cells: &HalfVectorCells, aliases: impl Iterator<Item = Option<&'a AliasTable>>) -> Slots {
        let place = |cell: u32| {
            let [column, row] = cells.column_and_row(cell as usize);
            (column | row << 16) as u32
        };
        let (mut slots, mut nodes) = (Vec::new(), Vec::new());
        for alias in aliases {
            let first = slots.len();
            slots.extend(alias.into_iter().flat_map(AliasTable::columns).map(|c| Slot {
                words: [c.threshold, place(c.cells[0]), place(c.cells[1]), c.threshold.wrapping_neg()],
            }));
            nodes.push(Range { first: first as u32, count: (slots.len() - first) as u32 });
        }
        Slots { slots, nodes }
    }

    /// Column and row of the cell drawn by `u` in `[0, 1)` for a node, and what is left of `u`; `None` if the node has no
    /// cell to draw. As [`AliasTable::draw`], of 53 bits.
    #[inline(always)]
    pub fn draw(&self, node: usize, u: f64) -> Option<([u16; 2], f32)> {
        let range = self.nodes[node];
        if range.count == 0 {
            return None;
        }
        let (column, beyond) = piece(place(u, f64::from(range.count)) + 0.5);
        let rest = at_least(beyond + 0.5, 0.0);
        let slot = self.slots.get((range.first as usize + column).wrapping_sub(1))?;
        let threshold = f64::from(slot.words[0]) * (1.0 / STEPS);
        let other = not_below(rest, threshold);
        let one = f64::from_bits(other & 1f64.to_bits());
        let width = threshold + one * (1.0 - 2.0 * threshold);
        let left = (rest - one * threshold) as f32 / width as f32;
        Some((column_and_row(slot.words[1 + (!other & 1) as usize]), left))
    }
}
