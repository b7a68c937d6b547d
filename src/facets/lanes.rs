//! Rays under way side by side: taken in, moved together, let go.

use super::ends::Ends;
use super::ground::Ground;
use super::starts::{Starts, WIDTH, live};
use fearless_simd::{Bytes, Level, Select, Simd, SimdBase, SimdMask, dispatch, f32x16, i32x16, mask32x16, u32x16};
use fearless_simd_macros::simd;

/// Rays under way at a time.
pub const LANES: usize = 128;

/// Columns have room for a vector that is stored across their end.
type Column<T> = [T; LANES + WIDTH];

/// How a ray is: under way, above everything ahead, unsure, or at a lower or (one more) an upper facet.
pub const UNDER_WAY: u32 = 0;
pub const FREE: u32 = 1;
pub const UNSURE: u32 = 2;
pub const HIT: u32 = 4;

/// Where a ray is on its first stride: on the lower or the upper facet of its cell, or above the surface.
pub const LOWER: u32 = 1;
pub const UPPER: u32 = 2;
pub const ABOVE: u32 = 3;

/// At `s` each ray is at `origin + s d` in samples from the corner of its first cell and `z + s climb` in height, and known to
/// have been above the surface up to there.
pub struct Lanes {
    pub(super) n: usize,
    pub(super) id: Column<u32>,
    pub(super) base: [Column<i32>; 2],
    pub(super) origin: [Column<f32>; 2],
    pub(super) d: [Column<f32>; 2],
    /// How long the ways from edge to edge are: across the columns, the rows, the diagonals.
    pub(super) way: [Column<f32>; 3],
    pub(super) z: Column<f32>,
    pub(super) climb: Column<f32>,
    pub(super) end: Column<f32>,
    /// The direction times `unit` is `d` and `climb`: none of them above 1 sample, or the range of the heights.
    pub(super) unit: Column<f32>,
    pub(super) s: Column<f32>,
    pub(super) state: Column<u32>,
    /// Not 0 on the first stride.
    pub(super) first: Column<u32>,
    pub(super) strides: Column<u32>,
    /// Cell, and place in it.
    pub(super) cell: [Column<u32>; 2],
    pub(super) place: [Column<f32>; 2],
    /// Numbers of the cell's first vertex and of its block.
    vertex: Column<u32>,
    block: Column<u32>,
    pub(super) corners: [Column<f32>; 4],
    pub(super) bend: Column<f32>,
    /// Of a facet that was met: its rise, and the height where.
    pub(super) rise: [Column<f32>; 2],
    pub(super) height: Column<f32>,
    /// Lanes that ended on the last stride, a bit each.
    pub(super) ended: [u64; LANES / WIDTH],
}

impl Default for Lanes {
    fn default() -> Self {
        let (f, u, i) = ([0.0; LANES + WIDTH], [0; LANES + WIDTH], [0; LANES + WIDTH]);
        Lanes {
            n: 0,
            id: u,
            base: [i; 2],
            origin: [f; 2],
            d: [f; 2],
            way: [f; 3],
            z: f,
            climb: f,
            end: f,
            unit: f,
            s: f,
            state: u,
            first: u,
            strides: u,
            cell: [u; 2],
            place: [f; 2],
            vertex: u,
            block: u,
            corners: [f; 4],
            bend: f,
            rise: [f; 2],
            height: f,
            ended: [0; LANES / WIDTH],
        }
    }
}

impl Lanes {
    /// Takes in rays from number `next` on while there are lanes for them; the number of the first one that waits. Rays that start
    /// across a border are unsure.
    pub fn fill(&mut self, level: Level, ground: &Ground, starts: &Starts, mut next: usize, ends: &mut Ends) -> usize {
        while next < starts.n && self.n + WIDTH <= LANES {
            let from = self.n;
            let outside = dispatch!(level, simd => take(simd, self, ground, starts, next));
            if self.first[from] == ABOVE && self.n > from {
                self.descend(level, ground, from);
            }
            for k in (0..WIDTH).filter(|k| outside >> k & 1 == 1) {
                ends.unsure.push((starts.id[next + k], 0.0));
            }
            next += WIDTH;
        }
        next
    }

    /// Corners and bends of the cells the rays are in; a loop of plain loads, which is what gathering is made of anyway.
    pub fn fetch(&mut self, level: Level, ground: &Ground) {
        dispatch!(level, simd => find_vertices(simd, self, ground));
        let (heights, width) = (ground.heights, ground.width as usize);
        let [a, b, c, d] = &mut self.corners;
        let n = self.n;
        let (vertices, blocks, bends) = (&self.vertex[..n], &self.block[..n], &mut self.bend[..n]);
        let (a, b, c, d) = (&mut a[..n], &mut b[..n], &mut c[..n], &mut d[..n]);
        let columns = &self.cell[0][..n];
        for k in 0..n {
            bends[k] = ground.bends[blocks[k] as usize];
            let first = vertices[k] as usize;
            let below = first + width;
            let inside = columns[k] + 1 < ground.width && below + 1 < heights.len();
            (a[k], b[k], c[k], d[k]) = if inside {
                let (top, bottom) = (&heights[first..first + 2], &heights[below..below + 2]);
                (top[0], top[1], bottom[0], bottom[1])
            } else {
                // What lies beyond the last column and below the last row of a map that wraps are the first ones.
                let below = below % heights.len();
                let beside = |vertex: usize| vertex + 1 - if columns[k] + 1 < ground.width { 0 } else { width };
                (heights[first], heights[beside(first)], heights[below], heights[beside(below)])
            };
        }
    }

    /// Reports the rays that ended on the last stride.
    pub fn let_go(&mut self, level: Level, ends: &mut Ends) {
        dispatch!(level, simd => let_go(simd, self, ends));
    }

    /// Moves the rays under way together.
    pub fn pack(&mut self, level: Level) {
        dispatch!(level, simd => pack(simd, self));
    }
}

/// Takes in the 16 rays from `from` on; a bit for each that cannot be taken.
#[simd]
fn take<S: Simd>(simd: S, lanes: &mut Lanes, ground: &Ground, starts: &Starts, from: usize) -> u64 {
    let real = |x: &[f32]| f32x16::from_slice(simd, &x[from..from + WIDTH]);
    let word = |x: &[u32]| u32x16::from_slice(simd, &x[from..from + WIDTH]);
    let cell = starts.cell.each_ref().map(|x| word(x));
    let inside = cell[0].simd_lt(ground.cells[0]) & cell[1].simd_lt(ground.cells[1]);
    let all = live(starts.n, from);
    let taken = inside.to_bitmask() & all;
    let mask = mask32x16::from_bitmask(simd, taken);
    let to = lanes.n;
    let put = |x: f32x16<S>, column: &mut Column<f32>| {
        simd.compress_f32x16(x, mask).store_slice(&mut column[to..to + WIDTH]);
    };
    let put_word = |x: u32x16<S>, column: &mut Column<u32>| {
        simd.compress_u32x16(x, mask).store_slice(&mut column[to..to + WIDTH]);
    };
    let [x, y, up] = starts.direction.each_ref().map(|x| real(x));
    let (dx, dy) = (x * ground.per_pitch[0], -y * ground.per_pitch[1]);
    let (ax, ay) = (dx.abs(), dy.abs());
    let longest = ax.simd_gt(ay).select(ax, ay);
    let per_unit = longest + up.abs() * ground.per_range;
    let unit = f32x16::splat(simd, 1.0) / per_unit;
    for axis in 0..2 {
        let at = real(&starts.at[axis]);
        put(at, &mut lanes.origin[axis]);
        put(at, &mut lanes.place[axis]);
        put([dx, dy][axis] * unit, &mut lanes.d[axis]);
        put_word(cell[axis], &mut lanes.cell[axis]);
        let base = simd.compress_u32x16(cell[axis], mask).bitcast::<i32x16<S>>();
        base.store_slice(&mut lanes.base[axis][to..to + WIDTH]);
    }
    let across = [dx * unit, dy * unit, (dx - dy) * unit];
    for (across, way) in across.into_iter().zip(&mut lanes.way) {
        put(f32x16::splat(simd, 1.0) / across.abs().max(f32x16::splat(simd, 1e-20)), way);
    }
    put(real(&starts.z), &mut lanes.z);
    put(up * unit, &mut lanes.climb);
    put(unit, &mut lanes.unit);
    put(real(&starts.end) * per_unit, &mut lanes.end);
    let (own, none) = (word(&starts.own), u32x16::splat(simd, 0));
    put_word(own.simd_eq(none).select(u32x16::splat(simd, ABOVE), own), &mut lanes.first);
    put_word(word(&starts.id), &mut lanes.id);
    f32x16::splat(simd, 0.0).store_slice(&mut lanes.s[to..to + WIDTH]);
    u32x16::splat(simd, UNDER_WAY).store_slice(&mut lanes.state[to..to + WIDTH]);
    none.store_slice(&mut lanes.strides[to..to + WIDTH]);
    lanes.n += taken.count_ones() as usize;
    all & !taken
}

/// Where to look for the corners and bends of the cells.
#[simd]
fn find_vertices<S: Simd>(simd: S, lanes: &mut Lanes, ground: &Ground) {
    for from in (0..lanes.n).step_by(WIDTH) {
        let to = from + WIDTH;
        let [column, row] = lanes.cell.each_ref().map(|x| u32x16::from_slice(simd, &x[from..to]));
        (row * ground.width + column).store_slice(&mut lanes.vertex[from..to]);
        let shift = super::blocks::SHIFT;
        ((row >> shift) * ground.blocks + (column >> shift)).store_slice(&mut lanes.block[from..to]);
    }
}

/// Reports the rays that ended.
#[simd]
fn let_go<S: Simd>(simd: S, lanes: &mut Lanes, ends: &mut Ends) {
    ends.hits.reserve(lanes.n);
    for from in (0..lanes.n).step_by(WIDTH) {
        let ended = lanes.ended[from / WIDTH];
        if ended == 0 {
            continue;
        }
        let to = from + WIDTH;
        let state = u32x16::from_slice(simd, &lanes.state[from..to]);
        let mut unsure = state.simd_eq(UNSURE).to_bitmask() & ended;
        while unsure != 0 {
            let k = from + unsure.trailing_zeros() as usize;
            unsure &= unsure - 1;
            ends.unsure.push((lanes.id[k], f64::from(lanes.s[k]) * f64::from(lanes.unit[k])));
        }
        let hit = state.simd_ge(HIT).to_bitmask() & ended;
        if hit == 0 {
            continue;
        }
        let mask = mask32x16::from_bitmask(simd, hit);
        let hits = &mut ends.hits;
        let at = hits.n;
        let word = |x: &Column<u32>, column: &mut Vec<u32>| {
            let packed = simd.compress_u32x16(u32x16::from_slice(simd, &x[from..to]), mask);
            packed.store_slice(&mut column[at..at + WIDTH]);
        };
        let real = |x: &Column<f32>, column: &mut Vec<f32>| {
            let packed = simd.compress_f32x16(f32x16::from_slice(simd, &x[from..to]), mask);
            packed.store_slice(&mut column[at..at + WIDTH]);
        };
        word(&lanes.id, &mut hits.id);
        for axis in 0..2 {
            word(&lanes.cell[axis], &mut hits.cell[axis]);
            real(&lanes.place[axis], &mut hits.at[axis]);
            real(&lanes.rise[axis], &mut hits.rise[axis]);
            let start = simd.compress_i32x16(i32x16::from_slice(simd, &lanes.base[axis][from..to]), mask);
            start.store_slice(&mut hits.start[axis][at..at + WIDTH]);
        }
        real(&lanes.height, &mut hits.z);
        (simd.compress_u32x16(state, mask) - HIT).store_slice(&mut hits.upper[at..at + WIDTH]);
        hits.n += hit.count_ones() as usize;
    }
}

#[simd]
fn pack<S: Simd>(simd: S, lanes: &mut Lanes) {
    let n = lanes.n;
    let mut kept = 0;
    for from in (0..n).step_by(WIDTH) {
        let bits = {
            let state = u32x16::from_slice(simd, &lanes.state[from..from + WIDTH]);
            state.simd_eq(UNDER_WAY).to_bitmask() & live(n, from)
        };
        if bits == 0 {
            continue;
        }
        let mask = mask32x16::from_bitmask(simd, bits);
        let Lanes { id, base, origin, d, way, z, climb, end, unit, s, state, first, strides, cell, place, .. } = lanes;
        let [bx, by] = base;
        let [ox, oy] = origin;
        let [dx, dy] = d;
        let [wx, wy, ww] = way;
        let [u, v] = place;
        let [column, row] = cell;
        for x in [ox, oy, dx, dy, wx, wy, ww, z, climb, end, unit, s, u, v] {
            let packed = simd.compress_f32x16(f32x16::from_slice(simd, &x[from..from + WIDTH]), mask);
            packed.store_slice(&mut x[kept..kept + WIDTH]);
        }
        for x in [id, state, first, strides, column, row] {
            let packed = simd.compress_u32x16(u32x16::from_slice(simd, &x[from..from + WIDTH]), mask);
            packed.store_slice(&mut x[kept..kept + WIDTH]);
        }
        for x in [bx, by] {
            let packed = simd.compress_i32x16(i32x16::from_slice(simd, &x[from..from + WIDTH]), mask);
            packed.store_slice(&mut x[kept..kept + WIDTH]);
        }
        kept += bits.count_ones() as usize;
    }
    lanes.n = kept;
}
