//! One axis of the half-vector cells: equal cells in the middle, ever wider ones in the tails.

/// `u(x) = sign(x) (min(|x|, c) + n L(1 + max(|x| - c, 0) / n))`, `L(y) = e + y / 2^e - 1` for `2^e <= y < 2^(e+1)`.
///
/// `x` counts core cells from the centre and `u` is the grid coordinate: cell `j` spans `j - 1/2 .. j + 1/2` in u. `L` is the
/// logarithm to base 2 with straight lines between the powers of two; an IEEE number holds it in its exponent and mantissa,
/// so neither `u` nor its inverse needs more than a few additions. `c` is half a whole number and `n` a power of two:
/// every cell then lies within one straight piece, and after every `n` tail cells the width doubles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Equal cells on each side of the central one; the first `per_octave` tail cells are as wide.
    pub core: u32,
    /// Tail cells after which the width doubles, a power of two.
    pub per_octave: u32,
    /// Cells on each side of the central one; the outermost on either side is the border, which holds nothing.
    pub half: u32,
}

impl Axis {
    /// The axis whose cells, border excluded, reach `x` core cells from the centre.
    pub fn reaching(x: f64, core: u32, per_octave: u32) -> Axis {
        let axis = Axis { core, per_octave, half: 0 };
        // A border cell and one that holds something are the least; the cap keeps any input within memory.
        let half = (axis.coordinate(x) + 0.5).ceil().clamp(2.0, 4000.0);
        Axis { half: half as u32, ..axis }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        2 * self.half as usize + 1
    }

    /// Never true.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Grid coordinate of `x`; a NaN counts as the end of the core.
    #[inline]
    pub fn coordinate(&self, x: f64) -> f64 {
        let c = f64::from(self.core) + 0.5;
        let n = f64::from(self.per_octave);
        let distance = x.abs();
        let tail = at_least(distance - c, 0.0);
        (at_most(distance, c) + n * piecewise_log2(1.0 + tail / n)).copysign(x)
    }

    /// The `x` of a grid coordinate.
    #[inline]
    pub fn place(&self, u: f64) -> f64 {
        let c = f64::from(self.core) + 0.5;
        let n = f64::from(self.per_octave);
        let distance = u.abs();
        let tail = at_least(distance - c, 0.0);
        (at_most(distance, c) + n * (piecewise_exp2(tail / n) - 1.0)).copysign(u)
    }

    /// Cell of a grid coordinate, counted from 0; beyond the border's inner edge the last cell before it.
    #[inline]
    pub fn cell(&self, u: f64) -> usize {
        let half = f64::from(self.half);
        nearest(at_most(at_least(u, 0.75 - half), half - 0.75) + half).0
    }

    /// The same axis for lanes.
    pub fn lanes(&self) -> AxisLanes {
        AxisLanes {
            core: self.core as f32 + 0.5,
            per_octave: self.per_octave as f32,
            octaves_per_cell: 1.0 / self.per_octave as f32,
            half: self.half as f32,
        }
    }

    /// Width of cell `k` in core cells.
    pub fn width(&self, k: usize) -> f64 {
        let u = k as f64 - f64::from(self.half);
        self.place(u + 0.5) - self.place(u - 0.5)
    }
}

/// An [`Axis`] in f32, made of operations that work on lanes side by side.
#[derive(Debug, Clone, Copy)]
pub struct AxisLanes {
    core: f32,
    per_octave: f32,
    octaves_per_cell: f32,
    half: f32,
}

/// 2^23, to whose last places whole numbers can be added as bits.
const TWO_23: u32 = 0x4b00_0000;

impl AxisLanes {
    /// As [`Axis::coordinate`] for `x >= 0`.
    #[inline(always)]
    pub fn coordinate(&self, x: f32) -> f32 {
        let tail = if x > self.core { x - self.core } else { 0.0 };
        let bits = (1.0 + tail * self.octaves_per_cell).to_bits();
        let exponent = f32::from_bits(bits >> 23 | TWO_23) - (f32::from_bits(TWO_23) + 127.0);
        let log2 = exponent + (f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0);
        (if x < self.core { x } else { self.core }) + self.per_octave * log2
    }

    /// Cell of `x`, as [`Axis::cell`] of [`Axis::coordinate`]; a NaN falls into some cell.
    #[inline(always)]
    pub fn cell(&self, x: f32) -> u32 {
        let u = self.coordinate(x.abs());
        let inside = self.half - 0.75;
        let u = if u < inside { u } else { inside };
        (u.copysign(x) + self.half + f32::from_bits(TWO_23)).to_bits() & 0x007f_ffff
    }
}

/// The whole part of `x >= 0` below 2^22.
#[inline(always)]
pub fn whole(x: f32) -> u32 {
    let shifted = if x > 0.5 { x - 0.5 } else { 0.0 };
    (shifted + f32::from_bits(TWO_23)).to_bits() & 0x007f_ffff
}

/// Bits of 1.0, of the mantissa, and of 2^52, to whose last places small whole numbers can be added as bits.
const ONE: u64 = 0x3ff0_0000_0000_0000;
const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
const TWO_52: u64 = 0x4330_0000_0000_0000;

/// `max(x, low)` in one instruction; `low` for a NaN.
#[inline]
pub fn at_least(x: f64, low: f64) -> f64 {
    if x > low { x } else { low }
}

/// `min(x, high)` in one instruction; `high` for a NaN.
#[inline]
pub fn at_most(x: f64, high: f64) -> f64 {
    if x < high { x } else { high }
}

/// The whole number nearest to `x` in `[0, 2^31)`, as index and as number: adding 2^52 rounds, and leaves the whole
/// number in the last bits. No conversion instruction, so loops over many slopes run in lanes.
#[inline]
pub fn nearest(x: f64) -> (usize, f64) {
    let shifted = x + f64::from_bits(TWO_52);
    (shifted.to_bits() as u32 as usize, shifted - f64::from_bits(TWO_52))
}

/// `e + y / 2^e - 1` for `y >= 1`.
#[inline]
fn piecewise_log2(y: f64) -> f64 {
    let bits = y.to_bits();
    let exponent = f64::from_bits(bits >> 52 | TWO_52) - (f64::from_bits(TWO_52) + 1023.0);
    exponent + (f64::from_bits(bits & MANTISSA | ONE) - 1.0)
}

/// The inverse: `2^e (1 + z - e)` with `e` the whole part of `z >= 0`; at a whole number either neighbour serves.
#[inline]
fn piecewise_exp2(z: f64) -> f64 {
    let (e, whole) = nearest(at_least(at_most(z, 1000.0) - 0.5, 0.0));
    f64::from_bits((e as u64 + 1023) << 52) * (1.0 + (z - whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinate_and_place_are_inverse_and_rise() {
        let axis = Axis::reaching(3000.0, 7, 4);
        let mut before = f64::NEG_INFINITY;
        for k in -4000..=4000 {
            let u = f64::from(k) * f64::from(axis.half) / 4000.0;
            let x = axis.place(u);
            assert!(x > before);
            assert!((axis.coordinate(x) - u).abs() < 1e-12 * u.abs().max(1.0), "{u} {x}");
            before = x;
        }
        assert!(axis.place(f64::from(axis.half) - 0.5) >= 3000.0);
    }

    #[test]
    fn widths_are_equal_then_double_every_octave() {
        let axis = Axis::reaching(200.0, 3, 4);
        let widths: Vec<f64> = (0..20).map(|k| axis.width(axis.half as usize + k)).collect();
        let mut expected = vec![1.0; 8];
        expected.extend([2.0; 4]);
        expected.extend([4.0; 4]);
        expected.extend([8.0; 4]);
        for (w, e) in widths.iter().zip(expected) {
            assert!((w - e).abs() < 1e-12, "{widths:?}");
        }
    }

    /// Same cells as in f64, but for what lies within rounding of a border.
    #[test]
    fn lanes_are_the_axis_in_f32() {
        let axis = Axis::reaching(3000.0, 7, 4);
        let lanes = axis.lanes();
        for k in -200_000..=200_000 {
            let x = f64::from(k).powi(3) * 1e-12;
            let u = axis.coordinate(x);
            let cell = lanes.cell(x as f32) as usize;
            assert!(cell.abs_diff(axis.cell(u)) <= usize::from(((u + 0.5).round() - u - 0.5).abs() < 1e-4), "{x}");
        }
        for x in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e30, -1e30] {
            let cell = lanes.cell(x) as usize;
            assert!(cell >= 1 && cell + 1 < axis.len(), "{x}: {cell}");
        }
        assert_eq!([0.0, 0.49, 0.99, 1.01, 1.3, 7.6].map(whole), [0, 0, 0, 1, 1, 7]);
    }

    #[test]
    fn no_slope_falls_outside() {
        let axis = Axis::reaching(50.0, 2, 8);
        for x in [0.0, -0.0, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 49.9, -1e-300] {
            let cell = axis.cell(axis.coordinate(x));
            assert!(cell >= 1 && cell + 1 < axis.len(), "{x}: {cell}");
        }
        assert_eq!(axis.cell(axis.coordinate(0.0)), axis.half as usize);
    }
}
