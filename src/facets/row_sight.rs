//! Whether facets of a row see a source, side by side.

use super::blocks::SIDE;
use super::sight::Ascent;
use super::visibility::{HeightField, quadrant};
use crate::heightmap::Edges;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Cells of a row that are asked together.
pub const RUN: usize = 64;

/// Whether a facet sees the source, as a word for the lanes.
pub type Seen = u32;
pub const UNKNOWN: Seen = 0;
pub const YES: Seen = 1;
pub const NO: Seen = 2;

/// Samples over which a way to the source is looked along.
const FARTHEST: f64 = 160.0;

/// Heights this close, as a share of the map's range, are left to f64.
const CLOSE: f64 = 1e-6;

/// The way from the centroids of one kind of facet to one source.
///
/// All facets of a kind have the same place in their cell, so their ways cross the edges of the mesh at the same offsets and in
/// the same proportion: for a run of facets each crossing is two stretches of neighbouring heights.
pub struct RowSight {
    upper: bool,
    quadrant: usize,
    ascent: Ascent,
    climb: f64,
    /// Place in the cell, and samples along the columns and the rows per length over the mean plane.
    at: [f64; 2],
    rate: [f64; 2],
    farthest: f64,
}

/// Crossings of one kind of edges that follow each other.
struct Crossings {
    /// Number of the first of them, and how many there are.
    first: i32,
    n: usize,
    /// Where the edge begins: the whole part of the other place; how far along it, and how much higher the way is there.
    whole: [i32; MOST],
    share: [f32; MOST],
    rise: [f32; MOST],
}

/// Most crossings of one kind of edges, all of them within `FARTHEST`.
const MOST: usize = FARTHEST as usize + 16;

/// Edges along the columns, along the rows and along the diagonals: rows and columns from the first to the second vertex.
const STEPS: [[i32; 2]; 3] = [[1, 0], [0, 1], [1, 1]];

impl RowSight {
    /// The way to `wi` from the facets above (`upper`) or below the diagonals.
    pub fn new(field: &HeightField, wi: DVec3, upper: bool) -> Self {
        let map = field.map();
        let flat = wi.x.hypot(wi.y);
        let climb = wi.z / flat;
        let rate = [wi.x / (flat * map.pitch_x), -wi.y / (flat * map.pitch_y)];
        let at = if upper { [2.0 / 3.0, 1.0 / 3.0] } else { [1.0 / 3.0, 2.0 / 3.0] };
        let [lowest, highest] = field.height_range();
        let farthest = (FARTHEST / (rate[0].abs() + rate[1].abs())).min((highest - lowest) / climb);
        RowSight { upper, quadrant: quadrant(wi), ascent: Ascent::new(wi), climb, at, rate, farthest }
    }

    /// Crossings of one kind of edges between two distances.
    fn cross(&self, level: Level, kind: usize, [near, far]: [f64; 2], crossings: &mut Crossings) {
        let [[u, v], [dx, dy]] = [self.at, self.rate];
        // What grows by one from edge to edge, and what then tells the place along the edge.
        let (o, rate, along, drift) = [(u, dx, v, dy), (v, dy, u, dx), (u - v, dx - dy, u, dx)][kind];
        let (a, b) = (o + rate * near, o + rate * far);
        let (first, last) = (a.min(b).ceil() as i32, a.max(b).floor() as i32);
        crossings.first = first;
        crossings.n = (last + 1 - first).clamp(0, MOST as i32) as usize;
        let (times, along) = ([o, 1.0 / rate], [along, drift]);
        dispatch!(level, simd => cross(simd, times, along, self.climb, crossings));
    }

    /// Which of the facets of the cells `column..column + RUN` see the source, `top` and `bottom` being the vertices on either side of
    /// them. Facets near the border of a mirrored map, or so close to a shadow's edge that f32 cannot tell, stay unknown.
    pub fn seen(
        &self,
        level: Level,
        field: &HeightField,
        [column, row]: [usize; 2],
        [top, bottom]: [&[f32]; 2],
    ) -> [Seen; RUN] {
        let map = field.map();
        let [width, height] = [map.width(), map.height()];
        let lanes = RUN.min(field.cells()[0] - column);
        let (mut z, mut lowest) = ([0.0; RUN], [0.0; RUN / SIDE]);
        dispatch!(level, simd => centroids(simd, top, bottom, self.upper, &mut z, &mut lowest));
        let (mut from, mut to) = (f64::INFINITY, 0.0f64);
        for (block, z) in (column..column + lanes).step_by(SIDE).zip(lowest) {
            let outlook = &field.outlooks([block, row])[self.quadrant];
            if let Some([a, b]) = field.doubtful(outlook, f64::from(z), &self.ascent) {
                (from, to) = (from.min(a), to.max(b));
            }
        }
        if to == 0.0 {
            return [YES; RUN];
        }
        let mut seen = [UNKNOWN; RUN];
        if to > self.farthest {
            return seen;
        }
        // Whether the ways stay on the map, with a vertex to spare.
        let ends = |axis: usize| {
            let end = self.at[axis] + self.rate[axis] * to;
            [end.min(0.0).floor() as i64 - 1, end.max(1.0).ceil() as i64 + 1]
        };
        let ([left, right], [up, down]) = (ends(0), ends(1));
        let on_map = row as i64 + up >= 0
            && row as i64 + down < height as i64
            && column as i64 + left >= 0
            && column as i64 + right + lanes as i64 <= width as i64;
        // A mirrored map has its diagonals the other way round there.
        if !on_map && map.edges == Edges::Mirrored {
            return seen;
        }
        let (mut beyond, mut stretches) = (Vec::new(), Vec::with_capacity(MOST));
        let mut crossings = Crossings { first: 0, n: 0, whole: [0; MOST], share: [0.0; MOST], rise: [0.0; MOST] };
        for (kind, [down, across]) in STEPS.into_iter().enumerate() {
            self.cross(level, kind, [from, to], &mut crossings);
            let Crossings { first, n, whole, share, rise } = &crossings;
            let places = (*first..).zip(&whole[..*n]).map(|(number, &whole)| place(kind, number, whole));
            let places = places.map(|[r, c]| [row as i64 + i64::from(r), column as i64 + i64::from(c)]);
            for ([row, column], (&share, &rise)) in places.zip(share.iter().zip(rise)) {
                let starts = if on_map {
                    let first = (row * width as i64 + column) as usize;
                    [first, first + down as usize * width + across as usize]
                } else {
                    let starts = [beyond.len(), beyond.len() + lanes];
                    extend_beyond(field, row, column, lanes, &mut beyond);
                    extend_beyond(field, row + i64::from(down), column + i64::from(across), lanes, &mut beyond);
                    if map.edges == Edges::Open {
                        forget_halves(beyond[starts[0]..].split_at_mut(lanes));
                    }
                    starts
                };
                stretches.push(Stretch { starts, share, rise });
            }
        }
        let range = field.height_range();
        let close = (CLOSE * (range[1] - range[0])) as f32;
        let heights = if on_map { &field.heights[..] } else { &beyond[..] };
        dispatch!(level, simd => look(simd, heights, &stretches, &z, close, lanes, &mut seen));
        seen
    }
}

/// Row and column of an edge's first vertex from the corner of the facet's cell.
#[inline(always)]
fn place(kind: usize, number: i32, whole: i32) -> [i32; 2] {
    match kind {
        0 => [whole, number],
        1 => [number, whole],
        _ => [whole - number, whole],
    }
}

/// 1.5 * 2^52, to whose last places whole numbers of either sign can be added as bits.
const WHOLE: f64 = (3u64 << 51) as f64;

#[simd]
fn cross<S: Simd>(_: S, [o, per_rate]: [f64; 2], [start, drift]: [f64; 2], climb: f64, crossings: &mut Crossings) {
    let (n, first) = (crossings.n, f64::from(crossings.first));
    let (wholes, shares, rises) = (&mut crossings.whole[..n], &mut crossings.share[..n], &mut crossings.rise[..n]);
    for k in 0..n {
        let t = (first + f64::from(k as u32) - o) * per_rate;
        let along = start + drift * t;
        let whole = along.floor();
        wholes[k] = (whole + WHOLE).to_bits() as i32;
        shares[k] = (along - whole) as f32;
        rises[k] = (climb * t) as f32;
    }
}

/// What is only half on the map is no edge of it.
fn forget_halves((a, b): (&mut [f32], &mut [f32])) {
    for (a, b) in a.iter_mut().zip(b) {
        if *a == NOTHING || *b == NOTHING {
            (*a, *b) = (NOTHING, NOTHING);
        }
    }
}

/// Lower than any height: where an open map has ended.
const NOTHING: f32 = -1e30;

/// Adds heights of a row from a column on, whether they lie on the map or not.
fn extend_beyond(field: &HeightField, row: i64, column: i64, lanes: usize, heights: &mut Vec<f32>) {
    let map = field.map();
    let [width, height] = [map.width(), map.height()].map(|n| n as i64);
    let line = |row: i64| &field.heights[(row * width) as usize..((row + 1) * width) as usize];
    let end = column + lanes as i64;
    if map.edges == Edges::Periodic {
        let line = line(row.rem_euclid(height));
        let mut from = column;
        while from < end {
            let start = from.rem_euclid(width);
            let n = (end - from).min(width - start);
            heights.extend_from_slice(&line[start as usize..(start + n) as usize]);
            from += n;
        }
        return;
    }
    let full = heights.len() + lanes;
    if (0..height).contains(&row) {
        let [from, to] = [column, end].map(|c| c.clamp(0, width));
        heights.resize(heights.len() + (from - column).clamp(0, lanes as i64) as usize, NOTHING);
        heights.extend_from_slice(&line(row)[from as usize..to as usize]);
    }
    heights.resize(full, NOTHING);
}

/// Heights of the centroids of a run, and the lowest of each block; what is missing is no height.
#[simd]
fn centroids<S: Simd>(
    _: S,
    top: &[f32],
    bottom: &[f32],
    upper: bool,
    z: &mut [f32; RUN],
    lowest: &mut [f32; RUN / SIDE],
) {
    let (top, bottom) = (&top[..RUN + 1], &bottom[..RUN + 1]);
    let third = if upper { &top[1..] } else { &bottom[..RUN] };
    for k in 0..RUN {
        z[k] = (top[k] + bottom[k + 1] + third[k]) * (1.0 / 3.0);
    }
    for (block, lowest) in lowest.iter_mut().enumerate() {
        *lowest = f32::INFINITY;
        for z in &z[block * SIDE..(block + 1) * SIDE] {
            *lowest = if z < lowest { *z } else { *lowest };
        }
    }
}

/// A crossing on the heights of the map: indices of the vertices of lane 0.
struct Stretch {
    starts: [usize; 2],
    share: f32,
    rise: f32,
}

#[simd]
fn look<S: Simd>(
    _: S,
    heights: &[f32],
    stretches: &[Stretch],
    z: &[f32; RUN],
    close: f32,
    n: usize,
    seen: &mut [Seen; RUN],
) {
    // Height over the edges, and whether any of them is missing.
    let mut over = [f32::INFINITY; RUN];
    let mut gap = [0.0f32; RUN];
    let (over, gap, z, seen) = (&mut over[..n], &mut gap[..n], &z[..n], &mut seen[..n]);
    for stretch in stretches {
        let [a, b] = stretch.starts.map(|start| &heights[start..start + n]);
        let (share, rise) = (stretch.share, stretch.rise);
        for k in 0..n {
            let f = z[k] + rise - (a[k] + share * (b[k] - a[k]));
            over[k] = if f < over[k] { f } else { over[k] };
            gap[k] = if f.is_nan() { 1.0 } else { gap[k] };
        }
    }
    for k in 0..n {
        let state = if over[k] > close { YES } else { UNKNOWN };
        let state = if over[k] < -close { NO } else { state };
        seen[k] = if gap[k] > 0.0 { UNKNOWN } else { state };
    }
}
