//! Whether facets of a row see a source, side by side.

use super::blocks::SIDE;
use super::visibility::{HeightField, quadrant};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Cells of a row that are asked together.
pub const RUN: usize = 64;

/// Whether a facet sees the source, as a byte for the lanes.
pub type Seen = u8;
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
    wi: DVec3,
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
        RowSight { crossings, upper, quadrant: quadrant(wi), wi, farthest }
    }

    /// Which of the facets of the cells `column..column + RUN` see the source. Facets near a border, or so close to a shadow's
    /// edge that f32 cannot tell, stay unknown.
    pub fn seen(&self, level: Level, field: &HeightField, row: usize, column: usize) -> [Seen; RUN] {
        let [width, height] = [field.map().width(), field.map().height()];
        let lanes = RUN.min(field.cells()[0] - column);
        let corners: [[f32; 4]; RUN] =
            std::array::from_fn(|k| if k < lanes { field.corners(column + k, row) } else { [f32::NAN; 4] });
        let z: [f32; RUN] = std::array::from_fn(|k| {
            let [a, b, c, d] = corners[k];
            (a + d + if self.upper { b } else { c }) * (1.0 / 3.0)
        });
        let lowest = f64::from(z.iter().copied().fold(f32::INFINITY, f32::min));
        let (mut from, mut to) = (f64::INFINITY, 0.0f64);
        for block in (column..column + lanes).step_by(SIDE) {
            let outlook = &field.outlooks([block, row])[self.quadrant];
            if let Some([a, b]) = field.doubtful(outlook, lowest, self.wi) {
                (from, to) = (from.min(a), to.max(b));
            }
        }
        let mut seen = [UNKNOWN; RUN];
        if to > self.farthest {
            return seen;
        }
        let first = self.crossings.partition_point(|c| c.distance < from);
        let last = self.crossings.partition_point(|c| c.distance <= to).max(first);
        // Lanes for which every vertex lies on the map.
        let (mut low, mut high) = (0, lanes as i64);
        let mut stretches = Vec::with_capacity(last - first);
        for c in &self.crossings[first..last] {
            let rows = c.rows.map(|r| r + row as i64);
            if rows.iter().any(|r| !(0..height as i64).contains(r)) {
                return seen;
            }
            for k in 0..2 {
                let offset = column as i64 + c.columns[k];
                low = low.max(-offset);
                high = high.min(width as i64 - offset);
            }
            stretches.push(Stretch {
                starts: [0, 1].map(|k| rows[k] * width as i64 + column as i64 + c.columns[k]),
                share: c.share,
                rise: c.rise,
            });
        }
        if low >= high {
            return seen;
        }
        let lanes = low as usize..high as usize;
        let range = field.height_range();
        let close = (CLOSE * (range[1] - range[0])) as f32;
        dispatch!(level, simd => look(simd, &field.heights, &stretches, &z, close, lanes, &mut seen));
        seen
    }
}

/// A crossing on the heights of the map: indices of the vertices of lane 0.
struct Stretch {
    starts: [i64; 2],
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
    lanes: std::ops::Range<usize>,
    seen: &mut [Seen; RUN],
) {
    let n = lanes.len();
    // Height over the edges, and whether any of them is missing.
    let mut over = [f32::INFINITY; RUN];
    let mut gap = [0.0f32; RUN];
    let (over, gap, z, seen) = (&mut over[..n], &mut gap[..n], &z[lanes.clone()], &mut seen[lanes.clone()]);
    for stretch in stretches {
        let [a, b] = stretch.starts.map(|start| {
            let start = (start + lanes.start as i64) as usize;
            &heights[start..start + n]
        });
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
