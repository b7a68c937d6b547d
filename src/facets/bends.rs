//! How sharply the surface bends upwards, which bounds how soon it can rise to a ray that is now above it.

use super::blocks::{Blocks, SHIFT, SIDE};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rayon::prelude::*;

/// Bounds are widened by this share of the largest step between neighbours against the rounding of f32.
const WIDER: f32 = 4e-7;

/// `J = max(0, largest rise of the slope, in heights per sample, across an edge of the mesh)` around each block.
///
/// A ray that is `c` above the surface and gains `r` on the facet below it stays above for `s` samples if
/// `c + r s - J (number of edges crossed, each from where it is crossed) > 0`: two derivatives for a surface that has none.
pub struct Bends {
    /// `J` of a block and its eight neighbours \[m\]; infinite if one of them misses a point.
    pub around: Vec<f32>,
    /// Largest difference of two neighbouring vertices \[m\] in blocks that miss no point.
    pub largest_step: f32,
}

impl Bends {
    /// One pass over the heights of the map that `blocks` are of. Cells across the border of a repeated map have no part in it.
    pub fn measure(heights: &[f32], width: usize, blocks: &Blocks, pitch: [f64; 2]) -> Self {
        let height = heights.len() / width;
        let rows: Vec<Vec<f32>> = (0..blocks.height)
            .into_par_iter()
            .map(|block| {
                let level = Level::new();
                let mut most = vec![0.0f32; width - 1];
                let line = |row: usize| &heights[row * width..(row + 1) * width];
                for row in block * SIDE..((block + 1) * SIDE).min(height - 1) {
                    let (here, below) = (line(row), line(row + 1));
                    dispatch!(level, simd => add_upright_and_diagonal(simd, here, below, &mut most));
                    if row > 0 {
                        dispatch!(level, simd => add_level(simd, line(row - 1), here, below, &mut most));
                    }
                }
                let mut bends: Vec<f32> =
                    most.chunks(SIDE).map(|some| some.iter().copied().fold(0.0, f32::max)).collect();
                // The last block of a periodic map may hold nothing but the cells across the border.
                bends.resize(blocks.width, 0.0);
                bends
            })
            .collect();
        let mut bends: Vec<f32> = rows.into_iter().flatten().collect();
        let mut largest_step = 0.0f32;
        for block in &blocks.blocks {
            let step = block.largest_step(pitch);
            largest_step = if step.is_finite() { largest_step.max(step) } else { largest_step };
        }
        for (bend, block) in bends.iter_mut().zip(&blocks.blocks) {
            let whole = block.largest_step(pitch).is_finite();
            *bend = if whole { *bend + WIDER * largest_step } else { f32::INFINITY };
        }
        Bends { around: widened(&bends, blocks.width), largest_step }
    }

    /// Index of the block around a cell.
    #[inline(always)]
    pub fn index(width: u32, column: u32, row: u32) -> u32 {
        (row >> SHIFT) * width + (column >> SHIFT)
    }
}

/// Each value replaced by the largest of itself and its eight neighbours.
fn widened(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let around = |k: usize, n: usize| k.saturating_sub(1)..(k + 2).min(n);
    let mut rows = Vec::with_capacity(values.len());
    for row in values.chunks(width) {
        rows.extend((0..width).map(|c| row[around(c, width)].iter().copied().fold(0.0, f32::max)));
    }
    let column = |r: usize, c: usize| around(r, height).map(|r| rows[r * width + c]).fold(0.0, f32::max);
    (0..height).flat_map(|r| (0..width).map(move |c| (r, c))).map(|(r, c)| column(r, c)).collect()
}

/// Edges on the left of the cells of a row, from the second cell on, and their diagonals.
#[simd]
fn add_upright_and_diagonal<S: Simd>(_: S, here: &[f32], below: &[f32], most: &mut [f32]) {
    let n = most.len();
    let (a, b, c, d) = (&here[..n], &here[1..n + 1], &below[..n], &below[1..n + 1]);
    for k in 0..n {
        let bend = (b[k] - a[k]) - (d[k] - c[k]);
        most[k] = if bend > most[k] { bend } else { most[k] };
    }
    let (before, a, c, d, most) = (&here[..n - 1], &here[1..n], &below[1..n], &below[2..n + 1], &mut most[1..n]);
    for k in 0..n - 1 {
        let bend = (d[k] - c[k]) - (a[k] - before[k]);
        most[k] = if bend > most[k] { bend } else { most[k] };
    }
}

/// Edges on the upper side of the cells of a row.
#[simd]
fn add_level<S: Simd>(_: S, above: &[f32], here: &[f32], below: &[f32], most: &mut [f32]) {
    let n = most.len();
    let (before, a, b, d) = (&above[..n], &here[..n], &here[1..n + 1], &below[1..n + 1]);
    for k in 0..n {
        let bend = (d[k] - b[k]) - (a[k] - before[k]);
        most[k] = if bend > most[k] { bend } else { most[k] };
    }
}
