//! Nodes, cells and slopes of a run of draws.

use super::super::grid::piece as piece_f64;
use super::super::hats::LEAST_SQUARE;
use super::super::slots::{Range, STEPS, Slot, place};
use super::super::table_brdf::TableBrdf;
use super::sources::SourceLanes;
use super::{Lanes, RUN};
use crate::scatter::axis::{at_least, at_most};
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Slopes drawn by a run.
pub(super) struct Places {
    /// Along both axes, in core cells.
    pub x: [Lanes<f32>; 2],
    /// The cell at or below, and the shares of the next column and row.
    pub from: Lanes<u32>,
    pub shares: [Lanes<f32>; 2],
    /// Of a table with a core or a floor: 1 where one of them is drawn instead; probability of the floor and its `f_r`.
    pub other: Lanes<u32>,
    pub floor: Lanes<f32>,
    pub diffuse: Lanes<f32>,
}

impl Default for Places {
    #[inline(always)]
    fn default() -> Self {
        let narrow = [0.0; RUN];
        let both = [narrow; 2];
        Places { x: both, from: [0; RUN], shares: both, other: [0; RUN], floor: narrow, diffuse: narrow }
    }
}

/// What alias columns give.
struct Drawn {
    /// As in a slot.
    cells: Lanes<u32>,
    /// What is left of both numbers.
    across: Lanes<f32>,
    along: Lanes<f32>,
}

impl Places {
    /// Draws for the numbers `u`.
    #[simd]
    pub fn draw<S: Simd>(&mut self, simd: S, brdf: &TableBrdf, sources: &SourceLanes, u: &Lanes<[f64; 2]>) {
        let mut drawn = Drawn { cells: [0; RUN], across: [0.0; RUN], along: [0.0; RUN] };
        self.cells(simd, brdf, sources, u, &mut drawn);
        self.under_tents(simd, brdf, 0, &drawn.cells, &drawn.across);
        self.under_tents(simd, brdf, 1, &drawn.cells, &drawn.along);
    }

    /// Node and cell of every draw.
    #[simd]
    fn cells<S: Simd>(
        &mut self,
        _: S,
        brdf: &TableBrdf,
        sources: &SourceLanes,
        u: &Lanes<[f64; 2]>,
        drawn: &mut Drawn,
    ) {
        let (mut chosen, mut second_node) = ([0.0f64; RUN], [0.0f32; RUN]);
        let mut node = [0u32; RUN];
        for j in 0..RUN {
            let [first, second] = u[j];
            let share = f64::from(sources.upper[j]);
            let from = 1.0 - share;
            let take = second >= from;
            let (before, width) = if take { (from, share) } else { (0.0, from) };
            drawn.along[j] = (second - before) as f32 / width as f32;
            node[j] = sources.theta[j] + u32::from(take);
            chosen[j] = first;
            second_node[j] = if take { 1.0 } else { 0.0 };
        }
        if !brdf.glossy {
            let last = brdf.facts.len() - 1;
            let mut facts = [[[0.0f32; 4]; 2]; RUN];
            for j in 0..RUN {
                let theta = sources.theta[j] as usize;
                facts[j] = [brdf.facts[theta], brdf.facts[(theta + 1).min(last)]];
            }
            for j in 0..RUN {
                let [a, b] = facts[j];
                let mix = |k: usize, t: f32| a[k] + t * (b[k] - a[k]);
                let others = mix(0, second_node[j]) + mix(1, second_node[j]);
                let left = drawn.along[j] - others;
                self.other[j] = u32::from(left < 0.0);
                let left = left / (1.0 - others);
                drawn.along[j] = if left > 0.0 { left } else { 0.0 };
                self.floor[j] = mix(1, sources.upper[j]);
                self.diffuse[j] = mix(2, sources.upper[j]);
            }
        }
        let last = brdf.slots.nodes.len() - 1;
        let mut range = [Range::default(); RUN];
        for j in 0..RUN {
            range[j] = brdf.slots.nodes[(node[j] as usize).min(last)];
        }
        let (mut slot, mut rest) = ([0u32; RUN], [0u32; RUN]);
        for j in 0..RUN {
            let count = f64::from(range[j].count as i32);
            // The whole part, and the rest in steps of 2^-32: whatever of the number is finer is lost on a cell.
            let (column, beyond) = piece_f64(place(chosen[j], count) + 0.5);
            slot[j] = range[j].first + (column as u32 - 1);
            rest[j] = piece_f64(at_most(at_least((beyond + 0.5) * STEPS, 0.0), STEPS - 1.0)).0 as u32;
        }
        let mut slots = [Slot::default(); RUN];
        for j in 0..RUN {
            slots[j] = brdf.slots.slots[slot[j] as usize];
        }
        for j in 0..RUN {
            let [threshold, alias, own, beyond] = slots[j].words;
            let keep = rest[j] < threshold;
            let (before, width) = if keep { (0, threshold) } else { (threshold, beyond) };
            drawn.across[j] = (rest[j] - before) as f32 / width as f32;
            drawn.cells[j] = if keep { own } else { alias };
        }
    }

    /// Places under the tents of one axis.
    #[simd]
    fn under_tents<S: Simd>(&mut self, _: S, brdf: &TableBrdf, axis: usize, cells: &Lanes<u32>, u: &Lanes<f32>) {
        let (tents, edges) = (&brdf.hats.tents[axis][..], &brdf.hats.edges[axis][..]);
        let stride = if axis == 0 { 1 } else { brdf.slabs.grid.row as u32 };
        let mut number = [0u32; RUN];
        for j in 0..RUN {
            number[j] = cells[j] >> (16 * axis) & 0xffff;
        }
        let mut edge = [[0.0f32; 4]; RUN];
        for j in 0..RUN {
            edge[j] = edges[number[j] as usize];
        }
        let (mut piece, mut share, mut one) = ([0u32; RUN], [0.0f32; RUN], [0.0f32; RUN]);
        for j in 0..RUN {
            let [left, low, high, same] = edge[j];
            let beyond = u[j] >= left;
            one[j] = if beyond { 1.0 } else { 0.0 };
            share[j] = (one[j] - u[j]).abs();
            let foot = low + one[j] * (high - same);
            piece[j] = if beyond { 2 } else { 0 } + u32::from(share[j] >= foot);
            self.from[j] += stride * (number[j] - u32::from(!beyond));
        }
        let mut pieces = [[0.0f32; 4]; RUN];
        for j in 0..RUN {
            pieces[j] = tents[number[j] as usize].pieces[(piece[j] & 3) as usize];
        }
        for j in 0..RUN {
            let [place, slope, square, rise] = pieces[j];
            let square = square + share[j] * rise;
            let square = if square > LEAST_SQUARE { square } else { LEAST_SQUARE };
            let height = (if square < 1.0 { square } else { 1.0 }).sqrt();
            self.x[axis][j] = place + slope * height;
            self.shares[axis][j] = (one[j] - height).abs();
        }
    }
}
