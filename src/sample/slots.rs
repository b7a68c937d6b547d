//! The alias columns of all nodes as draws want them.

use super::alias::AliasTable;
use crate::scatter::HalfVectorCells;
use crate::scatter::axis::{at_least, nearest};
use crate::table::not_below;

/// Steps of a threshold.
const STEPS: f64 = (1u64 << 32) as f64;

/// The columns of every node's [`AliasTable`], one after the other, cells by column and row of the grid.
#[derive(Debug, Clone)]
pub(super) struct Slots {
    pub slots: Vec<Slot>,
    pub nodes: Vec<Range>,
}

/// One alias column: the own cell is the second.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub threshold: u32,
    pub cells: [[u16; 2]; 2],
}

/// The slots of one node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    pub count: f64,
    pub first: u32,
}

impl Slot {
    /// The threshold as a share of the column.
    #[inline(always)]
    pub fn threshold(&self) -> f64 {
        f64::from(self.threshold) * (1.0 / STEPS)
    }
}

impl Slots {
    /// The columns of the nodes in order.
    pub fn new<'a>(cells: &HalfVectorCells, aliases: impl Iterator<Item = Option<&'a AliasTable>>) -> Slots {
        let place = |cell: u32| cells.column_and_row(cell as usize).map(|k| k as u16);
        let (mut slots, mut nodes) = (Vec::new(), Vec::new());
        for alias in aliases {
            let first = slots.len();
            slots.extend(
                alias
                    .into_iter()
                    .flat_map(AliasTable::columns)
                    .map(|column| Slot { threshold: column.threshold, cells: column.cells.map(place) }),
            );
            nodes.push(Range { count: (slots.len() - first) as f64, first: first as u32 });
        }
        Slots { slots, nodes }
    }

    /// Column and row of the cell drawn by `u` in `[0, 1)` for a node, and what is left of `u`; `None` if the node has no
    /// cell to draw. As [`AliasTable::draw`], of 53 bits.
    #[inline(always)]
    pub fn draw(&self, node: usize, u: f64) -> Option<([u16; 2], f32)> {
        let range = self.nodes[node];
        let place = u * range.count;
        let (slot, whole) = nearest(at_least(place - 0.5, 0.0));
        let rest = at_least(place - whole, 0.0);
        let slot = self.slots.get(range.first as usize + slot)?;
        let threshold = slot.threshold();
        let other = not_below(rest, threshold);
        let one = f64::from_bits(other & 1f64.to_bits());
        let width = threshold + one * (1.0 - 2.0 * threshold);
        let left = (rest - one * threshold) as f32 / width as f32;
        Some((slot.cells[(!other & 1) as usize], left))
    }
}
