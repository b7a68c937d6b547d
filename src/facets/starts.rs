//! Rays in f32 at their starts, column by column.

use super::blocks::{RINGS, SHIFT, WIDER};
use super::visibility::HeightField;
use fearless_simd::{Level, Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x16, mask32x16, u32x16};
use fearless_simd_macros::simd;

/// Values of one vector.
pub const WIDTH: usize = 16;

/// Makes room for `n` values of a column, and for a vector that is stored across its end.
#[inline(always)]
pub fn make_room<T: Copy + Default>(column: &mut Vec<T>, n: usize) {
    if column.len() < n + WIDTH {
        column.resize((n + WIDTH).next_power_of_two(), T::default());
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

/// [`Start`]s side by side: the first `n` values of each column, behind which there is room for a vector.
#[derive(Debug, Default)]
pub struct Starts {
    pub n: usize,
    pub id: Vec<u32>,
    pub cell: [Vec<u32>; 2],
    pub own: Vec<u32>,
    pub at: [Vec<f32>; 2],
    pub z: Vec<f32>,
    pub direction: [Vec<f32>; 3],
    pub end: Vec<f32>,
}

impl Starts {
    /// Makes room for so many more rays.
    #[inline]
    pub fn reserve(&mut self, more: usize) {
        let n = self.n + more;
        if self.id.len() >= n + WIDTH {
            return;
        }
        let Starts { n: _, id, cell: [column, row], own, at: [u, v], z, direction: [x, y, up], end } = self;
        [id, column, row, own].into_iter().for_each(|words| make_room(words, n));
        [u, v, z, x, y, up, end].into_iter().for_each(|reals| make_room(reals, n));
    }

    /// Adds a ray.
    #[inline]
    pub fn push(&mut self, start: &Start) {
        self.reserve(1);
        let k = self.n;
        self.n += 1;
        (self.id[k], self.own[k], self.z[k], self.end[k]) = (start.id, start.own, start.z, start.end);
        for axis in 0..2 {
            (self.cell[axis][k], self.at[axis][k]) = (start.cell[axis], start.at[axis]);
        }
        for axis in 0..3 {
            self.direction[axis][k] = start.direction[axis];
        }
    }

    /// Keeps the rays in whose way something can stand, judged by what is known of the blocks around, and finds out up to where;
    /// see [`HeightField::reach`].
    pub fn keep_doubtful(&mut self, level: Level, field: &HeightField) {
        let mut kept = 0;
        for from in (0..self.n).step_by(WIDTH) {
            let outlooks = Outlooks::gather(level, field, self, from);
            kept += dispatch!(level, simd => keep(simd, field, self, &outlooks, from, kept));
        }
        self.n = kept;
    }
}

type Lane = [f32; WIDTH];

/// What stands around 16 rays towards their quadrants: see `Outlook`.
struct Outlooks {
    climb: [Lane; 3],
    farther: [Lane; 3],
    tops: [Lane; RINGS],
}

impl Outlooks {
    #[inline]
    fn gather(level: Level, field: &HeightField, starts: &Starts, from: usize) -> Self {
        let mut places = [0; WIDTH];
        dispatch!(level, simd => find_outlooks(simd, field.blocks.width as u32, starts, from, &mut places));
        let outlooks = field.outlook_table();
        let none = [0.0; WIDTH];
        let mut gathered = Outlooks { climb: [none; 3], farther: [none; 3], tops: [none; RINGS] };
        let n = (starts.n - from).min(WIDTH);
        for k in 0..n {
            let outlook = &outlooks[places[k] as usize];
            for (to, climb) in [(&mut gathered.climb, &outlook.climb), (&mut gathered.farther, &outlook.farther)] {
                (to[0][k], to[1][k], to[2][k]) = (climb.x, climb.y, climb.sum);
            }
            for ring in 0..RINGS {
                gathered.tops[ring][k] = outlook.tops[ring];
            }
        }
        gathered
    }
}

/// Numbers of the outlooks of rays: block by block, quadrant by quadrant.
#[simd]
fn find_outlooks<S: Simd>(simd: S, blocks: u32, starts: &Starts, from: usize, places: &mut [u32; WIDTH]) {
    let [column, row] = starts.cell.each_ref().map(|x| u32x16::from_slice(simd, &x[from..from + WIDTH]));
    let [x, y] = [0, 1].map(|k| f32x16::from_slice(simd, &starts.direction[k][from..from + WIDTH]));
    quadrant_numbers(simd, blocks, [column, row], [x, y]).store_slice(places);
}

/// `4 block + quadrant` of a cell and a direction.
#[inline(always)]
pub fn quadrant_numbers<S: Simd>(
    simd: S,
    blocks: u32,
    [column, row]: [u32x16<S>; 2],
    [x, y]: [f32x16<S>; 2],
) -> u32x16<S> {
    let number = |x: u32| u32x16::splat(simd, x);
    let block = (row >> SHIFT) * blocks + (column >> SHIFT);
    (block << 2) + x.simd_gt(0.0).select(number(1), number(0)) + y.simd_gt(0.0).select(number(2), number(0))
}

/// As [`HeightField::reach`] in f32, without a branch; moves the doubtful of 16 rays to `to`.
#[simd]
fn keep<S: Simd>(
    simd: S,
    field: &HeightField,
    starts: &mut Starts,
    around: &Outlooks,
    from: usize,
    to: usize,
) -> usize {
    let real = |x: &[f32]| f32x16::from_slice(simd, &x[from..from + WIDTH]);
    let splat = |x: f32| f32x16::splat(simd, x);
    let lanes = |x: &Lane| f32x16::from_slice(simd, x);
    let [x, y, up] = starts.direction.each_ref().map(|x| real(x));
    let (ax, ay) = (x.abs(), y.abs());
    let flat = (x * x + y * y).sqrt();
    // Lower than it is by more than heights in f32 may be wrong by.
    let z = real(&starts.z) - field.margin;
    let along_x = ax.simd_gt(ay);
    let (far, near) = (along_x.select(ax, ay), along_x.select(ay, ax));
    // An unknown climb is never outdone.
    let outdoes = |climb: &[Lane; 3]| {
        let [cx, cy, sum] = climb.each_ref().map(lanes);
        let bound = (far - near) * along_x.select(cx, cy) + near * sum;
        up.simd_ge(bound + bound.abs() * WIDER)
    };
    let outdone = outdoes(&around.climb);
    let farther = outdone & outdoes(&around.farther);
    let rises = up.simd_gt(0.0);
    let (per_up, per_flat) = (splat(1.0) / up, splat(1.0) / flat);
    let lesser = |a: f32x16<S>, b: f32x16<S>| a.simd_lt(b).select(a, b);
    // The outermost ring whose top the beam is not above where it enters it decides.
    let mut open = !outdone;
    let mut end = per_flat * field.side;
    let (mut inner, mut outer) = (field.side, 2.0 * field.side);
    for ring in 0..=RINGS {
        let last = ring == RINGS;
        let top = if last { splat(field.highest as f32) } else { lanes(&around.tops[ring]) };
        let here = (up * inner).simd_lt((top - z) * flat);
        let here = if ring == 0 { here & !farther } else { here };
        let there = (top - z) * per_up;
        end = here.select(if last { there } else { lesser(there, per_flat * outer) }, end);
        open |= here;
        (inner, outer) = (outer, 2.0 * outer);
    }
    let end = rises.select(end, splat(f32::INFINITY));
    let live = mask32x16::from_bitmask(simd, live(starts.n, from));
    let doubtful = (open | !rises) & live;
    end.store_slice(&mut starts.end[from..from + WIDTH]);
    starts.pack(simd, doubtful, from, to);
    doubtful.to_bitmask().count_ones() as usize
}

impl Starts {
    /// Moves the `kept` of the 16 rays from `from` on to `to`.
    #[inline(always)]
    fn pack<S: Simd>(&mut self, simd: S, kept: mask32x16<S>, from: usize, to: usize) {
        let Starts { n: _, id, cell: [column, row], own, at: [u, v], z, direction: [x, y, up], end } = self;
        for words in [id, column, row, own] {
            let packed = simd.compress_u32x16(u32x16::from_slice(simd, &words[from..from + WIDTH]), kept);
            packed.store_slice(&mut words[to..to + WIDTH]);
        }
        for reals in [u, v, z, x, y, up, end] {
            let packed = simd.compress_f32x16(f32x16::from_slice(simd, &reals[from..from + WIDTH]), kept);
            packed.store_slice(&mut reals[to..to + WIDTH]);
        }
    }
}

/// Bits of the lanes of the vector from `from` on that hold one of `n` values.
#[inline(always)]
pub fn live(n: usize, from: usize) -> u64 {
    if n - from < WIDTH { (1 << (n - from)) - 1 } else { (1 << WIDTH) - 1 }
}
