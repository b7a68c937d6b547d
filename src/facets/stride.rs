//! The strides of rays side by side.

use super::bends::Bends;
use fearless_simd::{
    Bytes, Level, Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x16, i32x16, mask32x16, u32x16,
};
use fearless_simd_macros::simd;

/// Rays under way at a time, and rays of one vector.
pub const LANES: usize = 128;
const WIDTH: usize = 16;

/// Farther than this from its start \[samples\] the place of a ray in f32 is not trusted.
const FARTHEST: f32 = 256.0;

/// A ray that has not ended after so many strides is left to f64.
const MOST_STRIDES: u32 = 100;

/// Length of a stride \[samples\] over which the bends around a block hold.
const REACH: f32 = super::blocks::SIDE as f32 * (1.0 - 1e-5);

/// How far a ray goes beyond an edge that it crosses: more than places are rounded by.
const BEYOND: [f32; 2] = [2e-5, 2e-7];

/// Share of the largest step between neighbours that places are wrong by, at the most, in height; likewise of the largest
/// height, and of the way that a ray goes beyond an edge.
const MARGIN: [f32; 3] = [4e-4, 1e-6, 4e-5];

/// The surface that rays stride over.
pub struct Ground<'a> {
    heights: &'a [f32],
    bends: &'a [f32],
    /// Vertices in a row, and blocks.
    width: u32,
    blocks: u32,
    /// Cells that rays may be in, and whether those on one border have neighbours on the other.
    cells: [u32; 2],
    wraps: bool,
    per_pitch: [f32; 2],
    per_range: f32,
    margin: f32,
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

    /// Column and row of a cell of the heights.
    fn cell(&self, index: u32) -> [usize; 2] {
        [(index % self.width) as usize, (index / self.width) as usize]
    }
}

/// A ray in f32, at its start.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// Number by which its end is reported.
    pub id: u32,
    pub cell: [u32; 2],
    /// 1 or 2 if it leaves the lower or the upper facet of the cell, 0 if it comes from above.
    pub own: u32,
    /// Place in the cell \[samples\], height \[m\].
    pub at: [f32; 2],
    pub z: f32,
    /// Direction \[m\] in the surface frame, and how many times it is of interest.
    pub direction: [f32; 3],
    pub end: f32,
}

/// A facet that a ray meets, in f32.
#[derive(Debug, Clone, Copy)]
pub struct Struck {
    pub cell: [usize; 2],
    pub upper: bool,
    /// Place in the cell \[samples\], height \[m\].
    pub at: [f32; 2],
    pub z: f32,
    /// Rise of the facet per sample along the columns and the rows \[m\].
    pub rise: [f32; 2],
    /// The cell that the ray started in, counted from the tile of a periodic map in which it meets the facet.
    pub start: [i32; 2],
}

/// How the way of a ray ended.
#[derive(Debug, Clone, Copy)]
pub enum End {
    /// Above everything ahead.
    Free,
    /// It meets this facet, which no earlier one hides.
    Hit(Struck),
    /// F32 cannot tell; so many times its direction it is above the surface.
    Unsure(f64),
}

/// [`End`] as a number for the lanes; 0 is under way.
const UNDER_WAY: u32 = 0;
const FREE: u32 = 1;
const UNSURE: u32 = 2;
const HIT: u32 = 4;

/// Rays side by side: at `s` each is at `origin + s d` in samples from the corner of its first cell and `z + s climb` in
/// height, and known to have been above the surface up to there.
pub struct Lanes {
    n: usize,
    under_way: usize,
    strides: u32,
    id: [u32; LANES],
    base: [[i32; LANES]; 2],
    origin: [[f32; LANES]; 2],
    d: [[f32; LANES]; 2],
    z: [f32; LANES],
    climb: [f32; LANES],
    end: [f32; LANES],
    /// The direction times `unit` is `d` and `climb`: none of them above 1 sample, or the range of the heights.
    unit: [f32; LANES],
    s: [f32; LANES],
    state: [u32; LANES],
    /// 1 or 2 on the first stride from a lower or an upper facet.
    own: [u32; LANES],
    /// Place in the cell, the cell and its block.
    place: [[f32; LANES]; 2],
    cell: [u32; LANES],
    block: [u32; LANES],
    /// Where the map wraps: how far before the cell's first vertex the second one is stored, modulo 2^32.
    right: [u32; LANES],
    corners: [[f32; LANES]; 4],
    bend: [f32; LANES],
    /// Of a facet that was met: its rise, and the height where.
    rise: [[f32; LANES]; 2],
    height: [f32; LANES],
    /// Lanes that ended on the last stride, a bit each.
    ended: [u64; LANES / WIDTH],
}

impl Default for Lanes {
    fn default() -> Self {
        let (f, u) = ([0.0; LANES], [0; LANES]);
        Lanes {
            n: 0,
            under_way: 0,
            strides: 0,
            id: u,
            base: [[0; LANES]; 2],
            origin: [f; 2],
            d: [f; 2],
            z: f,
            climb: f,
            end: f,
            unit: f,
            s: f,
            state: u,
            own: u,
            place: [f; 2],
            cell: u,
            block: u,
            right: u,
            corners: [f; 4],
            bend: f,
            rise: [f; 2],
            height: f,
            ended: [0; LANES / WIDTH],
        }
    }
}

impl Lanes {
    /// Takes all rays away.
    pub fn clear(&mut self) {
        (self.n, self.under_way, self.strides) = (0, 0, 0);
    }

    /// Whether there is no lane for another ray.
    pub fn is_full(&self) -> bool {
        self.n == LANES
    }

    /// Whether all rays have ended.
    pub fn all_ended(&self) -> bool {
        self.under_way == 0
    }

    /// Adds a ray; `false` if it starts across a border.
    #[inline]
    pub fn push(&mut self, ground: &Ground, start: &Start) -> bool {
        let cell = start.cell;
        if cell[0] >= ground.cells[0] || cell[1] >= ground.cells[1] {
            return false;
        }
        let k = self.n % LANES;
        self.n += 1;
        self.under_way += 1;
        self.id[k] = start.id;
        let [x, y, z] = start.direction;
        let d = [x * ground.per_pitch[0], -y * ground.per_pitch[1]];
        let longest = if d[0].abs() > d[1].abs() { d[0].abs() } else { d[1].abs() };
        let per_unit = longest + z.abs() * ground.per_range;
        let unit = 1.0 / per_unit;
        for axis in 0..2 {
            self.base[axis][k] = cell[axis] as i32;
            self.origin[axis][k] = start.at[axis];
            self.place[axis][k] = start.at[axis];
            self.d[axis][k] = d[axis] * unit;
        }
        self.z[k] = start.z;
        self.climb[k] = z * unit;
        self.unit[k] = unit;
        self.end[k] = start.end * per_unit;
        self.s[k] = 0.0;
        self.state[k] = UNDER_WAY;
        self.own[k] = start.own;
        self.cell[k] = cell[1] * ground.width + cell[0];
        self.right[k] = if ground.wraps && cell[0] + 1 == ground.width { ground.width - 1 } else { u32::MAX };
        self.block[k] = Bends::index(ground.blocks, cell[0], cell[1]);
        true
    }

    /// One stride of every ray; `ended` hears of each that ended.
    pub fn stride(&mut self, level: Level, ground: &Ground, mut ended: impl FnMut(u32, End)) {
        self.fetch(ground);
        dispatch!(level, simd => advance(simd, self, ground));
        self.strides += 1;
        if self.strides == MOST_STRIDES {
            for k in 0..self.n {
                if self.state[k] == UNDER_WAY {
                    self.state[k] = UNSURE;
                    self.ended[k / WIDTH] |= 1 << (k % WIDTH);
                }
            }
        }
        for group in 0..self.n.div_ceil(WIDTH) {
            let mut bits = self.ended[group];
            self.under_way -= bits.count_ones() as usize;
            while bits != 0 {
                let k = group * WIDTH + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let end = match self.state[k] {
                    FREE => End::Free,
                    UNSURE => End::Unsure(f64::from(self.s[k]) * f64::from(self.unit[k])),
                    hit => End::Hit(Struck {
                        cell: ground.cell(self.cell[k]),
                        upper: hit > HIT,
                        at: [self.place[0][k], self.place[1][k]],
                        z: self.height[k],
                        rise: [self.rise[0][k], self.rise[1][k]],
                        start: [self.base[0][k], self.base[1][k]],
                    }),
                };
                ended(self.id[k], end);
            }
        }
        // Lanes that have ended cost as much as the others.
        if 4 * self.under_way < 3 * self.n {
            dispatch!(level, simd => pack(simd, self));
        }
    }

    /// Corners and bends of the cells the rays are in; a loop of plain loads, which is what gathering is made of anyway.
    fn fetch(&mut self, ground: &Ground) {
        let (heights, width) = (ground.heights, ground.width as usize);
        let [a, b, c, d] = &mut self.corners;
        let n = self.n;
        let rights = &self.right[..n];
        let (cells, blocks, bends) = (&self.cell[..n], &self.block[..n], &mut self.bend[..n]);
        let (a, b, c, d) = (&mut a[..n], &mut b[..n], &mut c[..n], &mut d[..n]);
        for k in 0..n {
            bends[k] = ground.bends[blocks[k] as usize];
        }
        if !ground.wraps {
            for k in 0..n {
                let cell = cells[k] as usize;
                let (top, bottom) = (&heights[cell..cell + 2], &heights[cell + width..cell + width + 2]);
                (a[k], b[k], c[k], d[k]) = (top[0], top[1], bottom[0], bottom[1]);
            }
            return;
        }
        for k in 0..n {
            let (top, right) = (cells[k] as usize, rights[k]);
            // What lies below the last row is the first.
            let bottom = if top + width < heights.len() { top + width } else { top + width - heights.len() };
            let beside = |cell: usize| heights[(cell as u32).wrapping_sub(right) as usize];
            (a[k], b[k], c[k], d[k]) = (heights[top], beside(top), heights[bottom], beside(bottom));
        }
    }
}

/// The stride itself. Across an edge the slope along a ray rises by `J |d|` at most, `d` across the edges of that kind, which lie
/// `1 / |d|` apart, so by `s` the surface has risen over the facet's plane by no more than the sum over the three kinds of
/// `J / 2 (|d| s + 1/2 - rho)^2`, with the first edge at `s = rho / |d|`. Where `c + r s` outdoes this, the ray is above.
#[simd]
fn advance<S: Simd>(simd: S, lanes: &mut Lanes, ground: &Ground) {
    let first = lanes.strides == 0;
    let zero = f32x16::splat(simd, 0.0);
    let [columns, rows] = ground.cells.map(|n| i32x16::splat(simd, n as i32));
    let none = i32x16::splat(simd, 0);
    let tiny = f32x16::splat(simd, 1e-20);
    for from in (0..lanes.n).step_by(WIDTH) {
        let to = from + WIDTH;
        let real = |x: &[f32; LANES]| f32x16::from_slice(simd, &x[from..to]);
        let word = |x: &[u32; LANES]| u32x16::from_slice(simd, &x[from..to]);
        let whole = |x: &[i32; LANES]| i32x16::from_slice(simd, &x[from..to]);
        let [a, b, c, d] = lanes.corners.each_ref().map(real);
        let [u, v] = lanes.place.each_ref().map(real);
        let [dx, dy] = lanes.d.each_ref().map(real);
        let (climb, s, end, bend) = (real(&lanes.climb), real(&lanes.s), real(&lanes.end), real(&lanes.bend));
        let (own, state) = (word(&lanes.own), word(&lanes.state));

        // Height above the facet's plane and its gain.
        let starts = if first { own.simd_gt(0) } else { mask32x16::splat(simd, false) };
        let upper = (starts & own.simd_eq(2)) | (!starts & u.simd_gt(v));
        let gu = upper.select(b - a, d - c);
        let gv = upper.select(d - b, c - a);
        let over = real(&lanes.z) + climb * s - (a + (gu * u + gv * v));
        let over = starts.select(zero, over);
        let gain = climb - (gu * dx + gv * dy);
        let margin = climb.abs() * MARGIN[2] + ground.margin;

        // Edges ahead: across the columns, the rows, the diagonals.
        let (w, dw) = (u - v, dx - dy);
        let (ax, ay, aw) = (dx.abs(), dy.abs(), dw.abs());
        let rx = dx.simd_gt(zero).select(-(u - 1.0), u);
        let ry = dy.simd_gt(zero).select(-(v - 1.0), v);
        let rw = dw.simd_gt(zero).select(upper.select(-(w - 1.0), -w), upper.select(w, w + 1.0));
        let edge = (rx / ax.max(tiny)).min(ry / ay.max(tiny)).min(rw / aw.max(tiny)).max(zero);
        let (ex, ey, ew) = (-(rx - 0.5), -(ry - 0.5), -(rw - 0.5));
        let c0 = over - margin - bend * (ex * ex + ey * ey + ew * ew) * 0.5;
        let c1 = gain - bend * (ax * ex + ay * ey + aw * ew);
        let c2 = bend * (ax * ax + ay * ay + aw * aw);
        let root = (c1 * c1 + c2 * c0 * 2.0).max(zero).sqrt();
        let rises = c1.simd_gt(zero);
        let far = rises.select(c1 + root, c0 * 2.0) / rises.select(c2, root - c1).max(tiny);
        let far = (far * (1.0 - 1e-5)).min(f32x16::splat(simd, REACH) / ax.max(ay).max(tiny));
        let across = edge + s * BEYOND[1] + BEYOND[0];
        let at_edge = c0 + edge * (c1 - c2 * edge * 0.5);

        // A long stride, one across the next edge, or the end of the way.
        let known = bend.simd_lt(f32::MAX);
        let known = if first { known & (starts | over.simd_ge(margin)) } else { known };
        let strides = known & at_edge.simd_ge(zero) & far.simd_gt(across);
        let exit = over + gain * edge;
        let goes = strides | (known & exit.simd_ge(margin));
        let hits = known & exit.simd_le(-margin) & over.simd_ge(margin);
        let s_next = (s + strides.select(far, across)).min(end);
        let (x, y) = (real(&lanes.origin[0]) + dx * s_next, real(&lanes.origin[1]) + dy * s_next);
        let (fx, fy) = (x.floor(), y.floor());
        let mut column = whole(&lanes.base[0]) + fx.to_int::<i32x16<S>>();
        let mut row = whole(&lanes.base[1]) + fy.to_int::<i32x16<S>>();
        let mut shift = [none; 2];
        if ground.wraps {
            for (cell, n, axis) in [(&mut column, columns, 0), (&mut row, rows, 1)] {
                let by = cell.simd_lt(0).select(n, cell.simd_ge(n).select(-n, none));
                *cell += by;
                shift[axis] = by;
            }
        }
        let inside = column.simd_ge(0) & column.simd_lt(columns) & row.simd_ge(0) & row.simd_lt(rows);
        let near = x.abs().simd_lt(FARTHEST) & y.abs().simd_lt(FARTHEST);
        let goes = goes & inside & near;
        let is_free = goes & s_next.simd_ge(end);

        let under_way = state.simd_eq(UNDER_WAY);
        let moves = under_way & goes & !is_free;
        let number = |x: u32| u32x16::splat(simd, x);
        let met = upper.select(number(HIT + 1), number(HIT));
        let ending = is_free.select(number(FREE), hits.select(met, number(UNSURE)));
        let next = under_way.select(moves.select(number(UNDER_WAY), ending), state);
        lanes.ended[from / WIDTH] = (under_way & !moves).to_bitmask() & live(lanes.n, from);
        next.store_slice(&mut lanes.state[from..to]);
        moves.select(s_next, s).store_slice(&mut lanes.s[from..to]);
        // Where the facet's plane is met.
        let on = -over / gain;
        moves.select(x - fx, u + dx * on).store_slice(&mut lanes.place[0][from..to]);
        moves.select(y - fy, v + dy * on).store_slice(&mut lanes.place[1][from..to]);
        gu.store_slice(&mut lanes.rise[0][from..to]);
        gv.store_slice(&mut lanes.rise[1][from..to]);
        (real(&lanes.z) + climb * (s + on)).store_slice(&mut lanes.height[from..to]);
        if ground.wraps {
            for (axis, by) in shift.into_iter().enumerate() {
                let base = whole(&lanes.base[axis]);
                moves.select(base + by, base).store_slice(&mut lanes.base[axis][from..to]);
            }
            let right = column.simd_eq(columns - 1).select(number(ground.width - 1), number(u32::MAX));
            moves.select(right, word(&lanes.right)).store_slice(&mut lanes.right[from..to]);
        }
        let (column, row) = (column.bitcast::<u32x16<S>>(), row.bitcast::<u32x16<S>>());
        let cell = row * ground.width + column;
        moves.select(cell, word(&lanes.cell)).store_slice(&mut lanes.cell[from..to]);
        let block = (row >> super::blocks::SHIFT) * ground.blocks + (column >> super::blocks::SHIFT);
        moves.select(block, word(&lanes.block)).store_slice(&mut lanes.block[from..to]);
    }
}

/// Bits of the lanes of the vector from `from` that hold rays.
#[inline(always)]
fn live(n: usize, from: usize) -> u64 {
    if n - from < WIDTH { (1 << (n - from)) - 1 } else { (1 << WIDTH) - 1 }
}

/// Moves the rays under way together.
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
        let Lanes { id, base, origin, d, z, climb, end, unit, s, state, place, cell, block, right, .. } = lanes;
        let [bx, by] = base;
        let [ox, oy] = origin;
        let [dx, dy] = d;
        let [u, v] = place;
        for x in [ox, oy, dx, dy, z, climb, end, unit, s, u, v] {
            let packed = simd.compress_f32x16(f32x16::from_slice(simd, &x[from..from + WIDTH]), mask);
            packed.store_slice(&mut x[kept..kept + WIDTH]);
        }
        for x in [id, state, cell, block, right] {
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
