//! The strides of rays side by side.

use super::ground::{Ground, MARGIN};
use super::lanes::{ABOVE, FREE, HIT, LANES, Lanes, UNDER_WAY, UNSURE, UPPER};
use super::starts::{WIDTH, live};
use fearless_simd::{Bytes, Level, Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x16, i32x16, u32x16};
use fearless_simd_macros::simd;

/// A ray that has not ended after so many strides is left to f64.
const MOST_STRIDES: u32 = 100;

/// Length of a stride \[samples\] over which the bends around a block hold.
pub(super) const REACH: f32 = super::blocks::SIDE as f32 * (1.0 - 1e-5);

/// How far a ray goes beyond an edge that it crosses: more than places are rounded by.
const BEYOND: [f32; 2] = [2e-5, 2e-7];

impl Lanes {
    /// One stride of every ray; how many have ended by now.
    pub fn stride(&mut self, level: Level, ground: &Ground) -> usize {
        self.fetch(level, ground);
        dispatch!(level, simd => advance(simd, self, ground))
    }
}

/// The stride itself. Across an edge the slope along a ray rises by `J |d|` at most, `d` across the edges of that kind, which lie
/// `1 / |d|` apart, so by `s` the surface has risen over the facet's plane by no more than the sum over the three kinds of
/// `J / 2 (|d| s + 1/2 - rho)^2`, with the first edge at `s = rho / |d|`. Where `c + r s` outdoes this, the ray is above.
#[simd]
fn advance<S: Simd>(simd: S, lanes: &mut Lanes, ground: &Ground) -> usize {
    let zero = f32x16::splat(simd, 0.0);
    let tiny = f32x16::splat(simd, 1e-20);
    let number = |x: u32| u32x16::splat(simd, x);
    let mut under_way_still = 0;
    for from in (0..lanes.n).step_by(WIDTH) {
        let to = from + WIDTH;
        let real = |x: &[f32; LANES + WIDTH]| f32x16::from_slice(simd, &x[from..to]);
        let word = |x: &[u32; LANES + WIDTH]| u32x16::from_slice(simd, &x[from..to]);
        let whole = |x: &[i32; LANES + WIDTH]| i32x16::from_slice(simd, &x[from..to]);
        let [a, b, c, d] = lanes.corners.each_ref().map(real);
        let [u, v] = lanes.place.each_ref().map(real);
        let [dx, dy] = lanes.d.each_ref().map(real);
        let (climb, s, end, bend) = (real(&lanes.climb), real(&lanes.s), real(&lanes.end), real(&lanes.bend));
        let (first, state) = (word(&lanes.first), word(&lanes.state));

        // Height above the facet's plane and its gain.
        let starts = first.simd_gt(0) & first.simd_lt(ABOVE);
        let upper = (starts & first.simd_eq(UPPER)) | (!starts & u.simd_gt(v));
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
        let [way_x, way_y, way_w] = lanes.way.each_ref().map(real);
        let edge = (rx * way_x).min(ry * way_y).min(rw * way_w).max(zero);
        let (ex, ey, ew) = (-(rx - 0.5), -(ry - 0.5), -(rw - 0.5));
        let c0 = over - margin - bend * (ex * ex + ey * ey + ew * ew) * 0.5;
        let c1 = gain - bend * (ax * ex + ay * ey + aw * ew);
        let c2 = bend * (ax * ax + ay * ay + aw * aw);
        let root = (c1 * c1 + c2 * c0 * 2.0).max(zero).sqrt();
        let rises = c1.simd_gt(zero);
        let far = rises.select(c1 + root, c0 * 2.0) / rises.select(c2, root - c1).max(tiny);
        let far = (far * (1.0 - 1e-5)).min(way_x.min(way_y) * REACH);
        let across = edge + s * BEYOND[1] + BEYOND[0];
        let at_edge = c0 + edge * (c1 - c2 * edge * 0.5);

        // A long stride, one across the next edge, or the end of the way.
        let known = bend.simd_lt(f32::MAX) & (!first.simd_eq(ABOVE) | over.simd_ge(margin));
        let strides = known & at_edge.simd_ge(zero) & far.simd_gt(across);
        let exit = over + gain * edge;
        let goes = strides | (known & exit.simd_ge(margin));
        let hits = known & exit.simd_le(-margin) & over.simd_ge(margin);
        let s_next = (s + strides.select(far, across)).min(end);
        let (x, y) = (real(&lanes.origin[0]) + dx * s_next, real(&lanes.origin[1]) + dy * s_next);
        let places = ground.places(simd, lanes.base.each_ref().map(whole), [x, y]);
        let count = word(&lanes.strides) + 1;
        let goes = goes & places.are_known & count.simd_lt(MOST_STRIDES);
        let is_free = goes & s_next.simd_ge(end);

        let under_way = state.simd_eq(UNDER_WAY);
        let moves = under_way & goes & !is_free;
        let met = upper.select(number(HIT + 1), number(HIT));
        let ending = is_free.select(number(FREE), hits.select(met, number(UNSURE)));
        let next = under_way.select(moves.select(number(UNDER_WAY), ending), state);
        let live = live(lanes.n, from);
        lanes.ended[from / WIDTH] = (under_way & !moves).to_bitmask() & live;
        under_way_still += (moves.to_bitmask() & live).count_ones() as usize;
        next.store_slice(&mut lanes.state[from..to]);
        count.store_slice(&mut lanes.strides[from..to]);
        number(0).store_slice(&mut lanes.first[from..to]);
        moves.select(s_next, s).store_slice(&mut lanes.s[from..to]);
        // Where the facet's plane is met.
        let on = -over / gain;
        moves.select(places.u, u + dx * on).store_slice(&mut lanes.place[0][from..to]);
        moves.select(places.v, v + dy * on).store_slice(&mut lanes.place[1][from..to]);
        gu.store_slice(&mut lanes.rise[0][from..to]);
        gv.store_slice(&mut lanes.rise[1][from..to]);
        (real(&lanes.z) + climb * (s + on)).store_slice(&mut lanes.height[from..to]);
        if ground.wraps {
            for (axis, by) in places.shift.into_iter().enumerate() {
                let base = whole(&lanes.base[axis]);
                moves.select(base + by, base).store_slice(&mut lanes.base[axis][from..to]);
            }
        }
        let (column, row) = (places.column.bitcast::<u32x16<S>>(), places.row.bitcast::<u32x16<S>>());
        moves.select(column, word(&lanes.cell[0])).store_slice(&mut lanes.cell[0][from..to]);
        moves.select(row, word(&lanes.cell[1])).store_slice(&mut lanes.cell[1][from..to]);
    }
    lanes.n - under_way_still
}
