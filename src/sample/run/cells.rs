//! Nodes, cells and slopes of a run of draws.

use super::super::draw::by_the_cosine;
use super::super::grid::piece as piece_f64;
use super::super::hats::LEAST_SQUARE;
use super::super::slots::{Range, STEPS, Slot, place};
use super::super::table_brdf::TableBrdf;
use super::Lanes;
use super::sources::SourceLanes;
use crate::scatter::axis::{at_least, at_most};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use glam::Vec4;

/// Slopes drawn by a run.
pub(super) struct Places<const N: usize> {
    /// Along both axes, in core cells.
    pub x: [Lanes<f32, N>; 2],
    /// The cell at or below, and the shares of the next column and row.
    pub from: Lanes<u32, N>,
    pub shares: [Lanes<f32, N>; 2],
    /// Of a table with a core or a floor: 1 where the core is drawn instead, and what the nodes say of both.
    pub core: Lanes<u32, N>,
    pub blend: Lanes<Vec4, N>,
}

impl<const N: usize> Default for Places<N> {
    #[inline(always)]
    fn default() -> Self {
        let narrow = [0.0; N];
        let both = [narrow; 2];
        Places { x: both, from: [0; N], shares: both, core: [0; N], blend: [Vec4::ZERO; N] }
    }
}

/// What alias columns give.
struct Drawn<const N: usize> {
    /// As in a slot.
    cells: Lanes<u32, N>,
    /// What is left of both numbers.
    across: Lanes<f32, N>,
    along: Lanes<f32, N>,
    /// Where the floor is drawn instead, what is left of the second number; below 0 elsewhere.
    floor: Lanes<f64, N>,
}

impl<const N: usize> Places<N> {
    /// Draws for the numbers `u`.
    #[simd]
    pub fn draw<S: Simd>(&mut self, simd: S, brdf: &TableBrdf, sources: &SourceLanes<N>, u: &Lanes<[f64; 2], N>) {
        let narrow = [0.0; N];
        let mut drawn = Drawn { cells: [0; N], across: narrow, along: narrow, floor: [-1.0; N] };
        self.cells(simd, brdf, sources, u, &mut drawn);
        self.under_tents(simd, brdf, 0, &drawn.cells, &drawn.across);
        self.under_tents(simd, brdf, 1, &drawn.cells, &drawn.along);
        if !brdf.glossy {
            for j in 0..N {
                if drawn.floor[j] >= 0.0 {
                    self.on_the_floor(brdf, sources, j, [u[j][0], drawn.floor[j]]);
                }
            }
        }
    }

    /// A draw by the cosine, as the slope that mirrors it: from there on it is a draw like the others.
    #[inline(never)]
    fn on_the_floor(&mut self, brdf: &TableBrdf, s: &SourceLanes<N>, j: usize, u: [f64; 2]) {
        let wo = by_the_cosine(u);
        let per_z = -1.0 / (s.z[j] + wo.z);
        let slope = [per_z * (s.x[j] + wo.x), per_z * (s.y[j] + wo.y)];
        // The place as it is kept is the one that is looked up.
        let x = brdf.slabs.grid.place(slope).map(|x| x as f32);
        let (from, shares) = brdf.slabs.grid.around(x.map(f64::from));
        self.from[j] = from as u32;
        for axis in 0..2 {
            (self.x[axis][j], self.shares[axis][j]) = (x[axis], shares[axis]);
        }
    }

    /// Node and cell of every draw.
    #[simd]
    fn cells<S: Simd>(
        &mut self,
        simd: S,
        brdf: &TableBrdf,
        sources: &SourceLanes<N>,
        u: &Lanes<[f64; 2], N>,
        drawn: &mut Drawn<N>,
    ) {
        let mut left = [0.0f64; N];
        let mut node = [0u32; N];
        for j in 0..N {
            let (take, rest) = choose(sources.second[j], u[j][1]);
            node[j] = sources.theta[j] + take;
            left[j] = rest;
        }
        let phis = brdf.table.phi_i().len();
        if phis > 1 {
            for j in 0..N {
                let (take, rest) = choose(sources.second_azimuth[j], left[j]);
                let phi = if take == 0 { sources.phi[0][j] } else { sources.phi[1][j] };
                node[j] = node[j] * phis as u32 + phi;
                left[j] = rest;
            }
        }
        if !brdf.glossy {
            let last = brdf.facts.len() - 1;
            sources.blend(simd, brdf, &mut self.blend);
            let mut facts = [[0.0f32; 2]; N];
            for j in 0..N {
                let here = brdf.facts[(node[j] as usize).min(last)];
                facts[j] = [here.x, here.y];
            }
            for j in 0..N {
                let [core, floor] = facts[j].map(f64::from);
                let beyond = left[j] - core;
                self.core[j] = u32::from(beyond < 0.0);
                let on_floor = beyond >= 0.0 && beyond < floor;
                drawn.floor[j] = if on_floor { beyond / floor } else { -1.0 };
                let rest = (beyond - floor) / (1.0 - core - floor);
                left[j] = if rest > 0.0 { rest } else { 0.0 };
            }
        }
        for j in 0..N {
            drawn.along[j] = left[j] as f32;
        }
        let last = brdf.slots.nodes.len() - 1;
        let mut range = [Range::default(); N];
        for j in 0..N {
            range[j] = brdf.slots.nodes[(node[j] as usize).min(last)];
        }
        let (mut slot, mut rest) = ([0u32; N], [0u32; N]);
        for j in 0..N {
            let count = f64::from(range[j].count as i32);
            // The whole part, and the rest in steps of 2^-32: whatever of the number is finer is lost on a cell.
            let (column, beyond) = piece_f64(place(u[j][0], count) + 0.5);
            slot[j] = range[j].first + (column as u32 - 1);
            rest[j] = piece_f64(at_most(at_least((beyond + 0.5) * STEPS, 0.0), STEPS - 1.0)).0 as u32;
        }
        let mut slots = [Slot::default(); N];
        for j in 0..N {
            slots[j] = brdf.slots.slots[slot[j] as usize];
        }
        for j in 0..N {
            let [threshold, alias, own, beyond] = slots[j].words;
            let keep = rest[j] < threshold;
            let (before, width) = if keep { (0, threshold) } else { (threshold, beyond) };
            drawn.across[j] = (rest[j] - before) as f32 / width as f32;
            drawn.cells[j] = if keep { own } else { alias };
        }
    }

    /// Places under the tents of one axis.
    #[simd]
    fn under_tents<S: Simd>(&mut self, _: S, brdf: &TableBrdf, axis: usize, cells: &Lanes<u32, N>, u: &Lanes<f32, N>) {
        let (tents, edges) = (&brdf.hats.tents[axis][..], &brdf.hats.edges[axis][..]);
        let stride = if axis == 0 { 1 } else { brdf.slabs.grid.row as u32 };
        let mut number = [0u32; N];
        for j in 0..N {
            number[j] = cells[j] >> (16 * axis) & 0xffff;
        }
        let mut edge = [[0.0f32; 4]; N];
        for j in 0..N {
            edge[j] = edges[number[j] as usize];
        }
        let (mut piece, mut share, mut one) = ([0u32; N], [0.0f32; N], [0.0f32; N]);
        for j in 0..N {
            let [left, low, high, same] = edge[j];
            let beyond = u[j] >= left;
            one[j] = if beyond { 1.0 } else { 0.0 };
            share[j] = (one[j] - u[j]).abs();
            let foot = low + one[j] * (high - same);
            piece[j] = if beyond { 2 } else { 0 } + u32::from(share[j] >= foot);
            self.from[j] += stride * (number[j] - u32::from(!beyond));
        }
        let mut pieces = [[0.0f32; 4]; N];
        for j in 0..N {
            pieces[j] = tents[number[j] as usize].pieces[(piece[j] & 3) as usize];
        }
        for j in 0..N {
            let [place, slope, square, rise] = pieces[j];
            let square = square + share[j] * rise;
            let square = if square > LEAST_SQUARE { square } else { LEAST_SQUARE };
            let height = (if square < 1.0 { square } else { 1.0 }).sqrt();
            self.x[axis][j] = place + slope * height;
            self.shares[axis][j] = (one[j] - height).abs();
        }
    }
}

/// 1 with probability `share`, and what is left of `u`.
#[inline(always)]
fn choose(share: f64, u: f64) -> (u32, f64) {
    let from = 1.0 - share;
    let take = u >= from;
    let (before, width) = if take { (from, share) } else { (0.0, from) };
    (u32::from(take), (u - before) / width)
}
