//! What is known of a block of cells without looking at its vertices: how high, how steep, how far it sees.

use super::slopes;
use crate::heightmap::{Edges, HeightMap};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rayon::prelude::*;

/// Cells along one side of a block: `1 << SHIFT`.
pub const SHIFT: u32 = 3;
pub const SIDE: usize = 1 << SHIFT;

/// Bounds are widened by this share against the rounding of f32.
const WIDER: f32 = 1e-6;

/// Slope bounds where a facet is missing: the surface may jump.
const UNKNOWN: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

/// Rings of blocks that are looked through for what stands in the way.
const REACH: usize = 32;

/// The bounds of one block.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// Highest vertex \[m\].
    pub top: f32,
    /// Smallest and largest `dh/dx` of its facets; infinite where a facet is missing.
    pub p: [f32; 2],
    /// Smallest and largest `dh/dy`.
    pub q: [f32; 2],
}

impl Block {
    /// Steepest climb of its facets along the horizontal vector `(x, y)`, times the vector's length.
    #[inline]
    pub fn climb(&self, x: f64, y: f64) -> f64 {
        f64::from(self.p[usize::from(x > 0.0)]) * x + f64::from(self.q[usize::from(y > 0.0)]) * y
    }

    /// Steepest climb towards any direction of a quadrant, or of any quadrant.
    fn climb_in(&self, quadrant: Option<usize>) -> f32 {
        let ahead = |[low, high]: [f32; 2], up: Option<bool>| match up {
            Some(true) => high.max(0.0),
            Some(false) => (-low).max(0.0),
            None => high.max(-low).max(0.0),
        };
        ahead(self.p, quadrant.map(|k| k & 1 == 1)).hypot(ahead(self.q, quadrant.map(|k| k & 2 == 2)))
    }
}

/// Blocks of a map, row by row.
pub struct Blocks {
    pub width: usize,
    pub height: usize,
    pub blocks: Vec<Block>,
    /// Lowest vertex of each block \[m\].
    bottoms: Vec<f32>,
}

/// Running bounds of one row of blocks, per vertex or cell column.
struct Columns {
    top: Vec<f32>,
    bottom: Vec<f32>,
    p: [Vec<f32>; 2],
    q: [Vec<f32>; 2],
    missing: Vec<f32>,
}

impl Columns {
    fn measure(map: &HeightMap, nx: usize, rows: std::ops::Range<usize>) -> Self {
        let level = Level::new();
        let filled = |x: f32| vec![x; nx + 1];
        let (up, down) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut columns = Columns {
            top: filled(down),
            bottom: filled(up),
            p: [filled(up), filled(down)],
            q: [filled(up), filled(down)],
            missing: filled(0.0),
        };
        let pitch = [1.0 / map.pitch_x as f32, 1.0 / map.pitch_y as f32];
        let mut above = Vec::new();
        let mut vertices = Vec::new();
        for row in rows.start..=rows.end {
            slopes::vertices(map, row, &mut vertices);
            dispatch!(level, simd => along(simd, &vertices, pitch[0], &mut columns));
            if row > rows.start {
                dispatch!(level, simd => across(simd, &above, &vertices, pitch[1], &mut columns.q));
            }
            std::mem::swap(&mut above, &mut vertices);
        }
        columns
    }

    /// Bounds over the cells of `range`, and the lowest vertex.
    fn block(&self, range: std::ops::Range<usize>) -> (Block, f32) {
        let vertices = range.start..range.end + 1;
        let least = |v: &[f32]| v.iter().copied().fold(f32::INFINITY, f32::min);
        let most = |v: &[f32]| v.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let wide = |v: &[Vec<f32>; 2], range: std::ops::Range<usize>| {
            let [low, high] = [least(&v[0][range.clone()]), most(&v[1][range])];
            [low - WIDER * low.abs(), high + WIDER * high.abs()]
        };
        let mut block = Block {
            top: most(&self.top[vertices.clone()]),
            p: wide(&self.p, range),
            q: wide(&self.q, vertices.clone()),
        };
        if most(&self.missing[vertices.clone()]) > 0.0 {
            (block.p, block.q) = (UNKNOWN, UNKNOWN);
        }
        (block, least(&self.bottom[vertices]))
    }
}

/// Adds the vertices of one row and the slopes along it.
#[simd]
fn along<S: Simd>(_: S, row: &[f32], per_pitch: f32, columns: &mut Columns) {
    let n = row.len() - 1;
    let next = &row[1..n + 1];
    let (row, last) = (&row[..n], row[n]);
    let [low, high] = &mut columns.p;
    let (low, high) = (&mut low[..n], &mut high[..n]);
    let (top, bottom, missing) =
        (&mut columns.top[..n + 1], &mut columns.bottom[..n + 1], &mut columns.missing[..n + 1]);
    for k in 0..n {
        let (h, slope) = (row[k], (next[k] - row[k]) * per_pitch);
        // Comparisons that a NaN fails keep the bound.
        top[k] = if h > top[k] { h } else { top[k] };
        bottom[k] = if h < bottom[k] { h } else { bottom[k] };
        missing[k] = if h.is_nan() { 1.0 } else { missing[k] };
        low[k] = if slope < low[k] { slope } else { low[k] };
        high[k] = if slope > high[k] { slope } else { high[k] };
    }
    top[n] = top[n].max(last);
    bottom[n] = bottom[n].min(last);
    missing[n] = if last.is_nan() { 1.0 } else { missing[n] };
}

/// Adds the slopes from one row to the one above it.
#[simd]
fn across<S: Simd>(_: S, above: &[f32], row: &[f32], per_pitch: f32, q: &mut [Vec<f32>; 2]) {
    let n = row.len();
    let above = &above[..n];
    let [low, high] = q;
    let (low, high) = (&mut low[..n], &mut high[..n]);
    for k in 0..n {
        let slope = (above[k] - row[k]) * per_pitch;
        low[k] = if slope < low[k] { slope } else { low[k] };
        high[k] = if slope > high[k] { slope } else { high[k] };
    }
}

impl Blocks {
    /// One pass over the heights.
    pub fn new(map: &HeightMap) -> Self {
        let (nx, ny) = slopes::cells(map);
        let (width, height) = (nx.div_ceil(SIDE), ny.div_ceil(SIDE));
        let rows: Vec<Vec<(Block, f32)>> = (0..height)
            .into_par_iter()
            .map(|row| {
                let columns = Columns::measure(map, nx, row * SIDE..((row + 1) * SIDE).min(ny));
                (0..width).map(|c| columns.block(c * SIDE..((c + 1) * SIDE).min(nx))).collect()
            })
            .collect();
        let (blocks, bottoms) = rows.into_iter().flatten().unzip();
        Blocks { width, height, blocks, bottoms }
    }

    /// Index of the block that holds a cell.
    #[inline]
    pub fn index(&self, column: usize, row: usize) -> usize {
        (row >> SHIFT) * self.width + (column >> SHIFT)
    }

    /// Lowest vertex of the map \[m\].
    pub fn lowest(&self) -> f32 {
        self.bottoms.iter().copied().fold(f32::INFINITY, f32::min)
    }

    /// Sine of the elevation above which a beam from any point of each block escapes towards each quadrant,
    /// by the steepest slopes nearby and the highest vertices of squares that double in size.
    ///
    /// Quadrant `k`: towards +x if `k & 1`, towards +y (against the row) if `k & 2`.
    pub fn clear_sines(&self, map: &HeightMap, highest: f32) -> Vec<[f32; 4]> {
        let (nx, ny) = slopes::cells(map);
        let repeated = map.edges != Edges::Open;
        // A border amid a block makes a step of one block shorter than `SIDE` cells, once every tile.
        let ragged = repeated && (nx % SIDE != 0 || ny % SIDE != 0);
        let small = ragged && nx.min(ny) < REACH * SIDE;
        let side = SIDE as f32 * map.pitch_x.min(map.pitch_y) as f32;
        let mut sines = vec![[0.0f32; 4]; self.blocks.len()];
        for quadrant in 0..4 {
            let step = [if quadrant & 1 == 1 { 1 } else { -1 }, if quadrant & 2 == 2 { -1 } else { 1 }];
            // A mirrored tile turns its slopes round.
            let towards = (map.edges != Edges::Mirrored).then_some(quadrant);
            let mut climbs: Vec<f32> = self.blocks.iter().map(|b| b.climb_in(towards)).collect();
            if small {
                let steepest = climbs.iter().copied().fold(0.0, f32::max);
                climbs.fill(steepest);
            } else {
                let widen = |v: &mut Vec<f32>, by: usize| *v = self.widened(v, step, by as isize, map.edges);
                let mut tops: Vec<f32> = self.blocks.iter().map(|b| b.top).collect();
                for _ in 0..if ragged { 3 } else { 1 } {
                    widen(&mut climbs, 1);
                    widen(&mut tops, 1);
                }
                let mut steep = climbs.clone();
                widen(&mut steep, 1);
                let mut from = 1;
                while from < REACH {
                    widen(&mut tops, from);
                    for (k, climb) in climbs.iter_mut().enumerate() {
                        let over = (tops[k] - self.bottoms[k]) / (from as f32 * side);
                        *climb = climb.max(if from == 1 { over.min(steep[k]) } else { over });
                    }
                    from *= 2;
                }
                for (climb, bottom) in climbs.iter_mut().zip(&self.bottoms) {
                    *climb = climb.max((highest - bottom) / (REACH as f32 * side));
                }
            }
            for (sines, climb) in sines.iter_mut().zip(climbs) {
                // An unknown climb becomes a sine above 1, which no direction exceeds.
                let sine = if climb.is_finite() { climb / (1.0 + climb * climb).sqrt() } else { 2.0 };
                sines[quadrant] = sine + 4.0 * WIDER;
            }
        }
        sines
    }

    /// Each value replaced by the largest of itself and its three neighbours `by` blocks along the quadrant's axes.
    fn widened(&self, values: &[f32], step: [isize; 2], by: isize, edges: Edges) -> Vec<f32> {
        let place = |k: usize, step: isize, n: usize| -> Option<usize> {
            let n = n as isize;
            let to = k as isize + step * by;
            match edges {
                _ if (0..n).contains(&to) => Some(to as usize),
                Edges::Open => None,
                Edges::Periodic => Some(to.rem_euclid(n) as usize),
                Edges::Mirrored => {
                    let folded = to.rem_euclid(2 * n);
                    Some(if folded < n { folded } else { 2 * n - 1 - folded } as usize)
                }
            }
        };
        let along: Vec<Option<usize>> = (0..self.width).map(|c| place(c, step[0], self.width)).collect();
        let mut wide = vec![0.0f32; values.len()];
        for (row, out) in wide.chunks_mut(self.width).enumerate() {
            out.copy_from_slice(&values[row * self.width..(row + 1) * self.width]);
            if let Some(other) = place(row, step[1], self.height) {
                for (x, y) in out.iter_mut().zip(&values[other * self.width..(other + 1) * self.width]) {
                    *x = x.max(*y);
                }
            }
            let line = out.to_vec();
            for (x, to) in out.iter_mut().zip(&along) {
                if let Some(to) = to {
                    *x = x.max(line[*to]);
                }
            }
        }
        wide
    }
}
