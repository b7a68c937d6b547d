//! Rays from above come down to the highest vertices around at once.

use super::ground::Ground;
use super::lanes::{ABOVE, LANES, Lanes};
use super::starts::{WIDTH, live};
use super::stride::REACH;
use fearless_simd::{Bytes, Level, Select, Simd, SimdBase, SimdMask, dispatch, f32x16, i32x16, u32x16};
use fearless_simd_macros::simd;

/// Steps after which a ray has come down far enough, or never will.
const MOST_STEPS: usize = 32;

impl Lanes {
    /// Lets the 16 rays from lane `from` on that start above the surface fall until they are as low as the highest vertex of the
    /// blocks around.
    ///
    /// `s += min((z - top) / -climb, REACH / |d|)`: what no vertex of a block and its neighbours reaches cannot be met within the
    /// side of a block.
    pub fn descend(&mut self, level: Level, ground: &Ground, from: usize) {
        let mut tops = [0.0; WIDTH];
        for _ in 0..MOST_STEPS {
            let n = (self.n - from).min(WIDTH);
            for k in 0..n {
                let [column, row] = self.cell.each_ref().map(|x| x[from + k] >> super::blocks::SHIFT);
                tops[k] = ground.tops[(row * ground.blocks + column) as usize];
            }
            if !dispatch!(level, simd => step(simd, self, ground, from, &tops)) {
                return;
            }
        }
    }
}

/// One step; whether any of the rays may go on.
#[simd]
fn step<S: Simd>(simd: S, lanes: &mut Lanes, ground: &Ground, from: usize, tops: &[f32; WIDTH]) -> bool {
    let to = from + WIDTH;
    let real = |x: &[f32; LANES + WIDTH]| f32x16::from_slice(simd, &x[from..to]);
    let [dx, dy] = lanes.d.each_ref().map(real);
    let (climb, s) = (real(&lanes.climb), real(&lanes.s));
    let first = u32x16::from_slice(simd, &lanes.first[from..to]);
    let spare = real(&lanes.z) + climb * s - f32x16::from_slice(simd, tops) - ground.margin;
    let falls = first.simd_eq(ABOVE) & climb.simd_lt(0.0) & spare.simd_gt(0.0);
    let (by_height, by_reach) = (-spare / climb, real(&lanes.way[0]).min(real(&lanes.way[1])) * REACH);
    let far = by_reach.simd_lt(by_height);
    let s_next = (s + far.select(by_reach, by_height)).min(real(&lanes.end));
    let (x, y) = (real(&lanes.origin[0]) + dx * s_next, real(&lanes.origin[1]) + dy * s_next);
    let bases = lanes.base.each_ref().map(|x| i32x16::from_slice(simd, &x[from..to]));
    let places = ground.places(simd, bases, [x, y]);
    let moves = falls & places.are_known;
    moves.select(s_next, s).store_slice(&mut lanes.s[from..to]);
    for (place, column) in [places.u, places.v].into_iter().zip(&mut lanes.place) {
        moves.select(place, real(column)).store_slice(&mut column[from..to]);
    }
    for (cell, column) in [places.column, places.row].into_iter().zip(&mut lanes.cell) {
        let before = u32x16::from_slice(simd, &column[from..to]);
        moves.select(cell.bitcast::<u32x16<S>>(), before).store_slice(&mut column[from..to]);
    }
    if ground.wraps {
        for (axis, by) in places.shift.into_iter().enumerate() {
            moves.select(bases[axis] + by, bases[axis]).store_slice(&mut lanes.base[axis][from..to]);
        }
    }
    (moves & far).to_bitmask() & live(lanes.n, from) != 0
}
