//! The surface as rays stride over it.

use super::bends::Bends;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x16, i32x16, mask32x16};

/// Farther than this from its start \[samples\] the place of a ray in f32 is not trusted.
const FARTHEST: f32 = 256.0;

/// Share of the largest step between neighbours that places are wrong by, at the most, in height; likewise of the largest
/// height, and of the way that a ray goes beyond an edge.
pub(super) const MARGIN: [f32; 3] = [4e-4, 1e-6, 4e-5];

/// The surface that rays stride over.
pub struct Ground<'a> {
    pub(super) heights: &'a [f32],
    pub(super) bends: &'a [f32],
    pub(super) tops: &'a [f32],
    /// Vertices in a row, and blocks.
    pub(super) width: u32,
    pub(super) blocks: u32,
    /// Cells that rays may be in, and whether those on one border have neighbours on the other.
    pub(super) cells: [u32; 2],
    pub(super) wraps: bool,
    pub(super) per_pitch: [f32; 2],
    pub(super) per_range: f32,
    pub(super) margin: f32,
}

impl<'a> Ground<'a> {
    /// The surface of `heights` with `width` vertices in a row, and `blocks` blocks.
    pub fn new(
        heights: &'a [f32],
        width: usize,
        bends: &'a Bends,
        blocks: usize,
        wraps: bool,
        pitch: [f64; 2],
        [low, high]: [f64; 2],
    ) -> Self {
        let (largest, range) = (low.abs().max(high.abs()) as f32, (high - low) as f32);
        Ground {
            heights,
            bends: &bends.around,
            tops: &bends.tops,
            width: width as u32,
            blocks: blocks as u32,
            // Without those across the border of a repeated map, unless it wraps.
            cells: [width as u32, (heights.len() / width) as u32].map(|n| n - u32::from(!wraps)),
            wraps,
            per_pitch: pitch.map(|p| (1.0 / p) as f32),
            per_range: 1.0 / range,
            margin: MARGIN[0] * bends.largest_step + MARGIN[1] * (largest + range),
        }
    }
}

/// Where rays are after a step.
pub(super) struct Places<S: Simd> {
    /// Cell, and place in it.
    pub column: i32x16<S>,
    pub row: i32x16<S>,
    pub u: f32x16<S>,
    pub v: f32x16<S>,
    /// What the tile of a periodic map that they are in changes about cells.
    pub shift: [i32x16<S>; 2],
    /// They are on the map, and not too far for f32.
    pub are_known: mask32x16<S>,
}

impl Ground<'_> {
    /// Places of rays at `x` and `y` \[samples\] from the cells `base`.
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, simd: S, base: [i32x16<S>; 2], [x, y]: [f32x16<S>; 2]) -> Places<S> {
        let none = i32x16::splat(simd, 0);
        let [columns, rows] = self.cells.map(|n| i32x16::splat(simd, n as i32));
        let (fx, fy) = (x.floor(), y.floor());
        let mut column = base[0] + fx.to_int::<i32x16<S>>();
        let mut row = base[1] + fy.to_int::<i32x16<S>>();
        let mut shift = [none; 2];
        if self.wraps {
            for (cell, n, axis) in [(&mut column, columns, 0), (&mut row, rows, 1)] {
                let by = cell.simd_lt(0).select(n, cell.simd_ge(n).select(-n, none));
                *cell += by;
                shift[axis] = by;
            }
        }
        let inside = column.simd_ge(0) & column.simd_lt(columns) & row.simd_ge(0) & row.simd_lt(rows);
        let near = x.abs().simd_lt(FARTHEST) & y.abs().simd_lt(FARTHEST);
        Places { column, row, u: x - fx, v: y - fy, shift, are_known: inside & near }
    }
}
