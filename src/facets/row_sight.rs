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
    /// By distance.
    crossings: Vec<Crossing>,
    upper: bool,
    quadrant: usize,
    ascent: Ascent,
    farthest: f64,
}

/// Where the ways cross an edge between two vertices.
struct Crossing {
    /// Distance over the mean plane \[m\], and how much higher the way is there.
    distance: f64,
    rise: f32,
    /// Offsets of the two vertices from the corner of the facet's cell: rows and columns.
    rows: [i64; 2],
    columns: [i64; 2],
    /// How far along the edge.
    share: f32,
}

impl RowSight {
    /// The way to `wi` from the facets above (`upper`) or below the diagonals.
    pub fn new(field: &HeightField, wi: DVec3, upper: bool) -> Self {
        let map = field.map();
        let flat = wi.x.hypot(wi.y);
        let climb = wi.z / flat;
        let (dx, dy) = (wi.x / (flat * map.pitch_x), -wi.y / (flat * map.pitch_y));
        let (u, v) = if upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
        let [lowest, highest] = field.height_range();
        let farthest = (FARTHEST / (dx.abs() + dy.abs())).min((highest - lowest) / climb);
        let mut crossings = Vec::new();
        // Along `o + rate t`: the whole numbers passed.
        let passed = |o: f64, rate: f64| {
            let end = o + rate * farthest;
            let (low, high) = (o.min(end).floor() as i64 + 1, o.max(end).ceil() as i64 - 1);
            (low..=high).map(move |k| (k, (k as f64 - o) / rate))
        };
        let mut add = |t: f64, along: f64, edge: &dyn Fn(i64) -> ([i64; 2], [i64; 2])| {
            let from = along.floor();
            let (rows, columns) = edge(from as i64);
            let (share, rise) = ((along - from) as f32, (climb * t) as f32);
            crossings.push(Crossing { distance: t, rise, rows, columns, share });
        };
        for (k, t) in passed(u, dx) {
            add(t, v + dy * t, &|row| ([row, row + 1], [k, k]));
        }
        for (k, t) in passed(v, dy) {
            add(t, u + dx * t, &|column| ([k, k], [column, column + 1]));
        }
        for (k, t) in passed(u - v, dx - dy) {
            add(t, u + dx * t, &|column| ([column - k, column - k + 1], [column, column + 1]));
        }
        crossings.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        RowSight { crossings, upper, quadrant: quadrant(wi), ascent: Ascent::new(wi), farthest }
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
        let [width, height] = [field.map().width(), field.map().height()];
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
        let mut seen = [UNKNOWN; RUN];
        if to > self.farthest {
            return seen;
        }
        let first = self.crossings.partition_point(|c| c.distance < from);
        let last = self.crossings.partition_point(|c| c.distance <= to).max(first);
        let crossings = &self.crossings[first..last];
        let map = field.map();
        let inside = |offset: i64, of: usize, lanes: usize| offset >= 0 && offset + lanes as i64 <= of as i64;
        let on_map = crossings.iter().all(|c| {
            (0..2).all(|k| {
                inside(row as i64 + c.rows[k], height, 1) && inside(column as i64 + c.columns[k], width, lanes)
            })
        });
        let mut beyond = Vec::new();
        let stretches: Vec<Stretch> = if on_map {
            let start = |c: &Crossing, k: usize| {
                ((row as i64 + c.rows[k]) * width as i64 + column as i64 + c.columns[k]) as usize
            };
            let stretch = |c: &Crossing| Stretch { starts: [start(c, 0), start(c, 1)], share: c.share, rise: c.rise };
            crossings.iter().map(stretch).collect()
        } else {
            // A mirrored map has its diagonals the other way round there.
            if map.edges == Edges::Mirrored {
                return seen;
            }
            let stretch = |c: &Crossing| {
                let starts = [0, 1].map(|k| {
                    let start = beyond.len();
                    extend_beyond(field, row as i64 + c.rows[k], column as i64 + c.columns[k], lanes, &mut beyond);
                    start
                });
                if map.edges == Edges::Open {
                    // What is only half on the map is no edge of it.
                    let (a, b) = beyond[starts[0]..].split_at_mut(lanes);
                    for (a, b) in a.iter_mut().zip(b) {
                        if *a == NOTHING || *b == NOTHING {
                            (*a, *b) = (NOTHING, NOTHING);
                        }
                    }
                }
                Stretch { starts, share: c.share, rise: c.rise }
            };
            crossings.iter().map(stretch).collect()
        };
        let range = field.height_range();
        let close = (CLOSE * (range[1] - range[0])) as f32;
        let heights = if on_map { &field.heights[..] } else { &beyond[..] };
        dispatch!(level, simd => look(simd, heights, &stretches, &z, close, lanes, &mut seen));
        seen
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
