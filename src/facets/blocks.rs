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
pub(super) const WIDER: f32 = 1e-6;

/// Rings of blocks that are looked through for what stands in the way; ring `k` lies from `2^k` to `2^(k+1)` blocks away.
pub const RINGS: usize = 5;

/// Largest slopes towards one quadrant: along x, along y, and their sum; infinite where a facet is missing, for there the
/// surface may jump.
#[derive(Debug, Clone, Copy)]
pub struct Climb {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) sum: f32,
}

impl Climb {
    /// Bound of the climb along a horizontal vector of the quadrant, times the vector's length: a direction is a sum of the
    /// nearer axis and the diagonal, each with its largest slope. NaN or infinite if unknown.
    #[inline]
    pub fn along(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x.abs(), y.abs());
        let (axis, diagonal) = if x > y { (x - y, y) } else { (y - x, x) };
        axis * f64::from(if x > y { self.x } else { self.y }) + diagonal * f64::from(self.sum)
    }

    /// Bound of the climb towards any direction of the quadrant.
    fn steepest(&self) -> f32 {
        let octant = |axis: f32| {
            let rest = self.sum - axis;
            if (0.0..=axis).contains(&rest) {
                axis.hypot(rest)
            } else {
                axis.max(self.sum * std::f32::consts::FRAC_1_SQRT_2)
            }
        };
        octant(self.x).max(octant(self.y)).max(0.0)
    }

    fn max(self, other: Climb) -> Climb {
        Climb { x: self.x.max(other.x), y: self.y.max(other.y), sum: self.sum.max(other.sum) }
    }
}

/// What may stand in the way of beams from a block towards one quadrant.
#[derive(Debug, Clone, Copy)]
pub struct Outlook {
    /// Largest slopes of the surface within the next `SIDE`, and within twice as many cells.
    pub climb: Climb,
    pub farther: Climb,
    /// Highest vertices up to the far side of each ring \[m\].
    pub tops: [f32; RINGS],
}

impl Outlook {
    /// Sine of the elevation above which a beam from anywhere in the block escapes.
    fn clear_sine(&self, bottom: f32, highest: f32, side: f32) -> f32 {
        let mut climb = self.climb.steepest();
        for (ring, top) in self.tops.into_iter().enumerate() {
            let over = (top - bottom) / ((1 << ring) as f32 * side);
            climb = climb.max(if ring == 0 { over.min(self.farther.steepest()) } else { over });
        }
        climb = climb.max((highest - bottom) / ((1 << RINGS) as f32 * side));
        // An unknown climb becomes a sine above 1, which no direction exceeds.
        if climb.is_finite() { climb / (1.0 + climb * climb).sqrt() + 4.0 * WIDER } else { 2.0 }
    }
}

/// Slopes whose largest values bound a block: p, -p, q, -q, p + q, -p - q, p - q, q - p.
const KINDS: usize = 8;

/// The bounds of one block.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// Highest vertex \[m\].
    pub top: f32,
    most: [f32; KINDS],
}

impl Block {
    /// Largest slopes of its facets towards a quadrant.
    #[inline]
    pub fn climb(&self, quadrant: usize) -> Climb {
        let sum = [5, 6, 7, 4][quadrant];
        Climb { x: self.most[1 - (quadrant & 1)], y: self.most[3 - (quadrant >> 1)], sum: self.most[sum] }
    }

    /// Largest difference of neighbouring vertices along x or y \[m\]; infinite if a facet is missing.
    pub fn largest_step(&self, pitch: [f64; 2]) -> f32 {
        let [px, py] = pitch.map(|p| p as f32);
        (self.most[0].max(self.most[1]) * px).max(self.most[2].max(self.most[3]) * py)
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

/// Running bounds of one row of blocks, per vertex column and per cell column.
struct Columns {
    top: Vec<f32>,
    bottom: Vec<f32>,
    missing: Vec<f32>,
    most: [Vec<f32>; KINDS],
}

impl Columns {
    fn measure(map: &HeightMap, nx: usize, rows: std::ops::Range<usize>) -> Self {
        let level = Level::new();
        let mut columns = Columns {
            top: vec![f32::NEG_INFINITY; nx + 1],
            bottom: vec![f32::INFINITY; nx + 1],
            missing: vec![0.0; nx + 1],
            most: std::array::from_fn(|_| vec![f32::NEG_INFINITY; nx]),
        };
        let pitch = [1.0 / map.pitch_x as f32, 1.0 / map.pitch_y as f32];
        let mut above = Vec::new();
        let mut vertices = Vec::new();
        for row in rows.start..=rows.end {
            slopes::vertices(map, row, &mut vertices);
            dispatch!(level, simd => add_heights(simd, &vertices, &mut columns));
            if row > rows.start {
                dispatch!(level, simd => add_slopes(simd, &above, &vertices, pitch, &mut columns.most));
            }
            std::mem::swap(&mut above, &mut vertices);
        }
        columns
    }

    /// Bounds over the cells of `range`, and the lowest vertex.
    fn block(&self, range: std::ops::Range<usize>) -> (Block, f32) {
        let vertices = range.start..range.end + 1;
        let most = |v: &[f32]| v.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let bottom = self.bottom[vertices.clone()].iter().copied().fold(f32::INFINITY, f32::min);
        let whole = most(&self.missing[vertices.clone()]) == 0.0;
        let bounds = std::array::from_fn(|k| {
            let slope = most(&self.most[k][range.clone()]);
            if whole { slope + WIDER * slope.abs() } else { f32::INFINITY }
        });
        (Block { top: most(&self.top[vertices]), most: bounds }, bottom)
    }
}

#[simd]
fn add_heights<S: Simd>(_: S, row: &[f32], columns: &mut Columns) {
    let n = row.len();
    let (top, bottom, missing) = (&mut columns.top[..n], &mut columns.bottom[..n], &mut columns.missing[..n]);
    for k in 0..n {
        let h = row[k];
        // Comparisons that a NaN fails keep the bound.
        top[k] = if h > top[k] { h } else { top[k] };
        bottom[k] = if h < bottom[k] { h } else { bottom[k] };
        missing[k] = if h.is_nan() { 1.0 } else { missing[k] };
    }
}

/// Adds the slopes of both facets of each cell of a row.
#[simd]
fn add_slopes<S: Simd>(_: S, top: &[f32], bottom: &[f32], per_pitch: [f32; 2], most: &mut [Vec<f32>; KINDS]) {
    let n = most[0].len();
    let (a, b, c, d) = (&top[..n], &top[1..n + 1], &bottom[..n], &bottom[1..n + 1]);
    let [m0, m1, m2, m3, m4, m5, m6, m7] = most.each_mut().map(|m| &mut m[..n]);
    let larger = |x: f32, y: f32| if x > y { x } else { y };
    for k in 0..n {
        let [px, py] = per_pitch;
        let (p, q) = ((d[k] - c[k]) * px, (a[k] - c[k]) * py);
        let (r, s) = ((b[k] - a[k]) * px, (b[k] - d[k]) * py);
        m0[k] = larger(larger(p, r), m0[k]);
        m1[k] = larger(larger(-p, -r), m1[k]);
        m2[k] = larger(larger(q, s), m2[k]);
        m3[k] = larger(larger(-q, -s), m3[k]);
        m4[k] = larger(larger(p + q, r + s), m4[k]);
        m5[k] = larger(larger(-p - q, -r - s), m5[k]);
        m6[k] = larger(larger(p - q, r - s), m6[k]);
        m7[k] = larger(larger(q - p, s - r), m7[k]);
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

    /// What each block sees towards each quadrant: the steepest slopes nearby and the highest vertices of squares that
    /// double in size.
    ///
    /// Quadrant `k`: towards +x if `k & 1`, towards +y (against the row) if `k & 2`.
    pub fn outlooks(&self, map: &HeightMap, highest: f32) -> Vec<[Outlook; 4]> {
        let (nx, ny) = slopes::cells(map);
        let repeated = map.edges != Edges::Open;
        // A border amid a block makes a step of one block shorter than `SIDE` cells, once every tile.
        let ragged = repeated && (nx % SIDE != 0 || ny % SIDE != 0);
        let small = ragged && nx.min(ny) < (SIDE << RINGS);
        let none = Climb { x: 0.0, y: 0.0, sum: 0.0 };
        let mut outlooks = vec![[Outlook { climb: none, farther: none, tops: [highest; RINGS] }; 4]; self.blocks.len()];
        for quadrant in 0..4 {
            let step = [if quadrant & 1 == 1 { 1 } else { -1 }, if quadrant & 2 == 2 { -1 } else { 1 }];
            let mut climbs: Vec<Climb> = self.blocks.iter().map(|b| b.climb(quadrant)).collect();
            if map.edges == Edges::Mirrored {
                // A mirrored tile turns its slopes round.
                let all = |b: &Block| (0..4).map(|k| b.climb(k)).fold(b.climb(0), Climb::max);
                climbs = self.blocks.iter().map(all).collect();
            }
            if small {
                let steepest = climbs.iter().copied().fold(none, Climb::max);
                outlooks.iter_mut().for_each(|o| (o[quadrant].climb, o[quadrant].farther) = (steepest, steepest));
                continue;
            }
            let mut tops: Vec<f32> = self.blocks.iter().map(|b| b.top).collect();
            for _ in 0..if ragged { 3 } else { 1 } {
                climbs = self.widened(&climbs, step, 1, map.edges, Climb::max);
                tops = self.widened(&tops, step, 1, map.edges, f32::max);
            }
            let farther = self.widened(&climbs, step, 1, map.edges, Climb::max);
            for ((o, climb), farther) in outlooks.iter_mut().zip(climbs).zip(farther) {
                (o[quadrant].climb, o[quadrant].farther) = (climb, farther);
            }
            for ring in 0..RINGS {
                tops = self.widened(&tops, step, 1 << ring, map.edges, f32::max);
                outlooks.iter_mut().zip(&tops).for_each(|(o, &top)| o[quadrant].tops[ring] = top);
            }
        }
        outlooks
    }

    /// Sines of the elevations above which beams from anywhere in a block escape, for each quadrant.
    pub fn clear_sines(&self, outlooks: &[[Outlook; 4]], pitch: f64, highest: f32) -> Vec<[f32; 4]> {
        let side = SIDE as f32 * pitch as f32;
        let sines = |(o, bottom): (&[Outlook; 4], &f32)| o.each_ref().map(|o| o.clear_sine(*bottom, highest, side));
        outlooks.iter().zip(&self.bottoms).map(sines).collect()
    }

    /// Each value replaced by the `max` of itself and its three neighbours `by` blocks along the quadrant's axes.
    fn widened<T: Copy>(
        &self,
        values: &[T],
        step: [isize; 2],
        by: isize,
        edges: Edges,
        max: impl Fn(T, T) -> T,
    ) -> Vec<T> {
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
        let along: Vec<usize> = (0..self.width).map(|c| place(c, step[0], self.width).unwrap_or(c)).collect();
        let mut wide = Vec::with_capacity(values.len());
        let mut line = Vec::with_capacity(self.width);
        for row in 0..self.height {
            let here = &values[row * self.width..(row + 1) * self.width];
            let other = place(row, step[1], self.height).unwrap_or(row);
            let there = &values[other * self.width..(other + 1) * self.width];
            line.clear();
            line.extend(here.iter().zip(there).map(|(&x, &y)| max(x, y)));
            wide.extend(line.iter().zip(&along).map(|(&x, &to)| max(x, line[to])));
        }
        wide
    }
}
