//! First hit of a ray on the height field: who hides whom.

use super::bends::Bends;
use super::blocks::{Block, Blocks, Outlook, SIDE};
use super::ground::Ground;
use super::slopes;
use crate::heightmap::{Edges, HeightMap};
use glam::DVec3;
use std::borrow::Cow;

/// A ray over the map: position in samples (column, row, both continuous) and height \[m\], direction in metres
/// in the surface frame (z up, y against the row). The direction need not be unit.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub column: f64,
    pub row: f64,
    pub z: f64,
    pub direction: DVec3,
}

/// Where a ray met the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Cell and triangle; see [`slopes::Facet`].
    pub cell: [usize; 2],
    pub upper: bool,
    /// Point of impact: column and row in samples, height \[m\].
    pub column: f64,
    pub row: f64,
    pub z: f64,
    /// Slopes of the facet `(dh/dx, dh/dy)` in the map's frame.
    pub slope: (f64, f64),
    /// Signs by which mirrored tiles crossed on the way have flipped the ray along x and y.
    pub flip: [f64; 2],
}

/// What became of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fate {
    Hit(Hit),
    /// Left upwards or over an open border, with the flips of the mirrored tiles crossed.
    Escaped([f64; 2]),
    /// Went down through a gap, or wandered over more than 256 tiles of a repeated map.
    Lost,
}

/// The two-triangle surface over a map with bounds of its blocks: their highest vertices in a pyramid, their slopes,
/// and how far up a beam must go to be free.
///
/// About half the heights in memory. [`HeightField::trace`] gives the exact first hit.
pub struct HeightField<'a> {
    map: &'a HeightMap,
    pub(super) heights: Cow<'a, [f32]>,
    pub(super) cells: [usize; 2],
    pub(super) blocks: Blocks,
    /// Highest vertices of squares of 1, 2, 4, ... blocks: width and values.
    pub(super) pyramid: Vec<(usize, Vec<f32>)>,
    outlooks: Vec<[Outlook; 4]>,
    sines: Vec<[f32; 4]>,
    bends: Bends,
    /// Whether packets of rays may go on across the border, into the block next to it in the periodic map.
    wraps: bool,
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// What heights in f32 may be wrong by, and the side of a block \[m\].
    pub(super) margin: f32,
    pub(super) side: f32,
}

impl<'a> HeightField<'a> {
    /// One pass over the heights, then work on blocks only.
    pub fn new(map: &'a HeightMap) -> Self {
        let (nx, ny) = slopes::cells(map);
        let blocks = Blocks::new(map);
        let highest = blocks.blocks.iter().map(|b| b.top).fold(f32::NEG_INFINITY, f32::max);
        // Even a flat map has an above and a below, or no ray would cross it.
        let depth = if blocks.lowest() == highest { 1e-9 * map.pitch_x.min(map.pitch_y) } else { 0.0 };
        let lowest = f64::from(blocks.lowest()) - depth;
        let outlooks = blocks.outlooks(map, highest);
        let heights = match map.heights.as_slice() {
            Some(heights) => Cow::Borrowed(heights),
            None => Cow::Owned(map.heights.iter().copied().collect()),
        };
        let (top, depth) = (f64::from(highest), f64::from(highest) - lowest);
        let side = SIDE as f64 * map.pitch_x.min(map.pitch_y);
        let wraps = map.edges == Edges::Periodic && nx % SIDE == 0 && ny % SIDE == 0;
        let bends = Bends::measure(map, &blocks, wraps);
        HeightField {
            map,
            heights,
            bends,
            wraps,
            cells: [nx, ny],
            pyramid: pyramid(&blocks),
            sines: blocks.clear_sines(&outlooks, map.pitch_x.min(map.pitch_y), highest),
            blocks,
            outlooks,
            lowest,
            highest: top,
            margin: (1e-6 * (depth + top.abs().max(lowest.abs()))) as f32,
            side: side as f32,
        }
    }

    /// Lowest and highest measured height \[m\].
    pub fn height_range(&self) -> [f64; 2] {
        [self.lowest, self.highest]
    }

    /// Number of cells along x and y.
    pub fn cells(&self) -> [usize; 2] {
        self.cells
    }

    /// The map under the field.
    pub fn map(&self) -> &HeightMap {
        self.map
    }

    /// Height of the surface at a point inside the grid \[m\]; `None` over a gap.
    pub fn height_at(&self, column: f64, row: f64) -> Option<f64> {
        let c = (column.max(0.0) as usize).min(self.cells[0] - 1);
        let r = (row.max(0.0) as usize).min(self.cells[1] - 1);
        let (u, v) = (column - c as f64, row - r as f64);
        let [g0, gu, gv] = plane(self.corners(c, r), u > v);
        let z = g0 + gu * u + gv * v;
        z.is_finite().then_some(z)
    }

    /// What may stand in the way of beams that leave the surface in a cell, for each quadrant: towards +x if `k & 1`,
    /// towards +y if `k & 2`. Bounds, not horizons: what they do not let through may escape, too.
    #[inline]
    pub fn outlooks(&self, [column, row]: [usize; 2]) -> &[Outlook; 4] {
        &self.outlooks[self.blocks.index(column, row)]
    }

    /// Sine of the elevation from which a beam that leaves the surface in a cell escapes towards each quadrant, whatever its
    /// place in the cell's block; above 1 if unknown.
    #[inline]
    pub fn clear_sines(&self, [column, row]: [usize; 2]) -> &[f32; 4] {
        &self.sines[self.blocks.index(column, row)]
    }

    /// The same of all blocks in one list, by `4 block + quadrant`.
    pub fn clear_sine_table(&self) -> &[f32] {
        self.sines.as_flattened()
    }

    /// The outlooks of all blocks in one list, by `4 block + quadrant`.
    pub(super) fn outlook_table(&self) -> &[Outlook] {
        self.outlooks.as_flattened()
    }

    /// Heights of the corners of a cell as [`slopes::of_corners`] takes them.
    #[inline]
    pub fn corners(&self, column: usize, row: usize) -> [f32; 4] {
        let width = self.map.width();
        let next = if column + 1 == width { 0 } else { column + 1 };
        let top = row * width;
        let bottom = if row + 1 == self.map.height() { 0 } else { top + width };
        let h = &self.heights;
        [h[top + column], h[top + next], h[bottom + column], h[bottom + next]]
    }

    /// What packets of rays stride over.
    pub(super) fn ground(&self) -> Ground<'_> {
        let pitch = [self.map.pitch_x, self.map.pitch_y];
        let (width, blocks) = (self.map.width(), self.blocks.width);
        Ground::new(&self.heights, width, &self.bends, blocks, self.wraps, pitch, self.height_range())
    }

    #[inline]
    pub(super) fn block(&self, column: usize, row: usize) -> &Block {
        &self.blocks.blocks[self.blocks.index(column, row)]
    }
}

/// The quadrant a direction points to, as [`HeightField::outlooks`] counts them.
#[inline]
pub fn quadrant(d: DVec3) -> usize {
    usize::from(d.x > 0.0) + 2 * usize::from(d.y > 0.0)
}

/// `h = g0 + gu u + gv v` over one triangle of a cell, u along the columns, v along the rows.
#[inline]
pub(super) fn plane([a, b, c, d]: [f32; 4], upper: bool) -> [f64; 3] {
    let [a, b, c, d] = [a, b, c, d].map(f64::from);
    if upper { [a, b - a, d - b] } else { [a, d - c, c - a] }
}

/// Maximum mipmap over the blocks (Tevs, Ihrke and Seidel 2008).
fn pyramid(blocks: &Blocks) -> Vec<(usize, Vec<f32>)> {
    let mut levels = vec![(blocks.width, blocks.blocks.iter().map(|b| b.top).collect::<Vec<f32>>())];
    loop {
        let (width, below) = &levels[levels.len() - 1];
        if below.len() == 1 {
            return levels;
        }
        let (half, rows) = (width.div_ceil(2), (below.len() / width).div_ceil(2));
        let mut maxima = vec![f32::NEG_INFINITY; half * rows];
        for (k, &m) in below.iter().enumerate() {
            let target = &mut maxima[k / width / 2 * half + k % width / 2];
            *target = target.max(m);
        }
        levels.push((half, maxima));
    }
}
