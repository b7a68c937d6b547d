//! How sharply the surface bends upwards, which bounds how soon it can rise to a ray that is now above it.

use super::blocks::{Blocks, SIDE};
use super::slopes;
use crate::heightmap::HeightMap;
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
    /// Highest vertex of a block and its eight neighbours \[m\].
    pub tops: Vec<f32>,
    /// Largest difference of two neighbouring vertices \[m\] in blocks that miss no point.
    pub largest_step: f32,
}

impl Bends {
    /// One pass over the heights of the map that `blocks` are of. `wraps`: the map is periodic and whole blocks long and wide, so
    /// that blocks have neighbours across the border; otherwise edges on the border do not count.
    pub fn measure(map: &HeightMap, blocks: &Blocks, wraps: bool) -> Self {
        let (nx, ny) = slopes::cells(map);
        let (width, height) = (map.width(), map.height());
        let nothing = vec![f32::NAN; nx + 2];
        // The vertices of a row with those before the first and behind the last; missing where the map ends.
        let line = |row: usize| {
            let mut line = nothing.clone();
            let row = map.heights.row(row % height);
            line[1..].iter_mut().zip(row).for_each(|(to, h)| *to = *h);
            if wraps {
                (line[0], line[nx + 1]) = (row[width - 1], row[0]);
            }
            line
        };
        let rows: Vec<Vec<f32>> = (0..blocks.height)
            .into_par_iter()
            .map(|block| {
                let level = Level::new();
                let rows = block * SIDE..((block + 1) * SIDE).min(ny);
                let mut most = vec![0.0f32; nx];
                let mut above = match rows.start {
                    0 if wraps => line(height - 1),
                    0 => nothing.clone(),
                    start => line(start - 1),
                };
                let mut here = line(rows.start);
                for row in rows {
                    let below = if row + 1 < height || wraps { line(row + 1) } else { nothing.clone() };
                    dispatch!(level, simd => add(simd, &above, &here, &below, &mut most));
                    (above, here) = (here, below);
                }
                most.chunks(SIDE).map(|some| some.iter().copied().fold(0.0, f32::max)).collect()
            })
            .collect();
        let mut bends: Vec<f32> = rows.into_iter().flatten().collect();
        let pitch = [map.pitch_x, map.pitch_y];
        let mut largest_step = 0.0f32;
        for block in &blocks.blocks {
            let step = block.largest_step(pitch);
            largest_step = if step.is_finite() { largest_step.max(step) } else { largest_step };
        }
        for (bend, block) in bends.iter_mut().zip(&blocks.blocks) {
            let whole = block.largest_step(pitch).is_finite();
            *bend = if whole { *bend + WIDER * largest_step } else { f32::INFINITY };
        }
        let tops: Vec<f32> = blocks.blocks.iter().map(|block| block.top).collect();
        let around = |values| widened(values, blocks.width, wraps);
        Bends { around: around(&bends), tops: around(&tops), largest_step }
    }
}

/// Each value replaced by the largest of itself and its eight neighbours.
fn widened(values: &[f32], width: usize, wraps: bool) -> Vec<f32> {
    let around = |k: usize, n: usize| {
        let [before, after] =
            if wraps { [(k + n - 1) % n, (k + 1) % n] } else { [k.saturating_sub(1), (k + 1).min(n - 1)] };
        [before, k, after]
    };
    let largest = |three: [f32; 3]| three.into_iter().fold(f32::NEG_INFINITY, f32::max);
    let mut rows = Vec::with_capacity(values.len());
    for row in values.chunks(width) {
        rows.extend((0..width).map(|c| largest(around(c, width).map(|c| row[c]))));
    }
    let height = values.len() / width;
    let mut wide = Vec::with_capacity(values.len());
    for row in 0..height {
        let lines = around(row, height).map(|row| &rows[row * width..(row + 1) * width]);
        wide.extend((0..width).map(|c| largest(lines.map(|line| line[c]))));
    }
    wide
}

/// Edges on the left and on the upper side of the cells of a row, and their diagonals; lines begin with the vertex before the
/// first cell. A missing vertex fails every comparison.
#[simd]
fn add<S: Simd>(_: S, above: &[f32], here: &[f32], below: &[f32], most: &mut [f32]) {
    let n = most.len();
    let (over, before, a, b) = (&above[1..n + 1], &here[..n], &here[1..n + 1], &here[2..n + 2]);
    let (c, d) = (&below[1..n + 1], &below[2..n + 2]);
    for k in 0..n {
        let left = (d[k] - c[k]) - (a[k] - before[k]);
        let upper = (d[k] - b[k]) - (a[k] - over[k]);
        let diagonal = (b[k] - a[k]) - (d[k] - c[k]);
        let bend = if left > most[k] { left } else { most[k] };
        let bend = if upper > bend { upper } else { bend };
        most[k] = if diagonal > bend { diagonal } else { bend };
    }
}
