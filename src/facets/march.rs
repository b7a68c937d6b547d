//! The march of a ray from block to block.

use super::blocks::SHIFT;
use super::trace::Own;
use super::visibility::{Fate, HeightField, Ray};

/// Squares of `2^FAR` blocks are where a ray from above begins.
const FAR: usize = 1;

/// The lesser and the greater of two numbers, neither of them NaN.
#[inline]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
#[inline]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// A ray under way: `position = o + t d` in samples and metres.
pub(super) struct March<'f> {
    pub(super) field: &'f HeightField<'f>,
    pub(super) o: [f64; 2],
    pub(super) d: [f64; 2],
    pub(super) inverse: [f64; 2],
    pub(super) oz: f64,
    pub(super) dz: f64,
    /// Cell the ray is in.
    pub(super) cell: [i64; 2],
    pub(super) t: f64,
    /// Beyond this nothing can be met.
    pub(super) t_end: f64,
    /// Lower bound of the ray's height above the surface; negative if it may be below, after a gap.
    pub(super) above: f64,
    pub(super) flip: [f64; 2],
}

impl<'f> March<'f> {
    #[inline]
    pub(super) fn new(field: &'f HeightField<'f>, ray: Ray, own: Option<Own>, end: f64) -> Self {
        let map = field.map();
        let [nx, ny] = field.cells.map(|n| n as i64);
        let d = [ray.direction.x / map.pitch_x, -ray.direction.y / map.pitch_y];
        let (oz, dz) = (ray.z, ray.direction.z);
        let t_end = if dz > 0.0 {
            lesser((field.highest - oz) / dz, end)
        } else if dz < 0.0 {
            (field.lowest - oz - 1e-9 * (field.highest - field.lowest)) / dz
        } else {
            f64::INFINITY
        };
        let cell = match own {
            Some((cell, _)) => cell.map(|c| c as i64),
            None => [(ray.column as i64).clamp(0, nx - 1), (ray.row as i64).clamp(0, ny - 1)],
        };
        March {
            field,
            o: [ray.column, ray.row],
            d,
            inverse: d.map(|d| 1.0 / d),
            oz,
            dz,
            cell,
            t: 0.0,
            t_end,
            above: if own.is_some() || oz >= field.highest { 0.0 } else { f64::NEG_INFINITY },
            flip: [1.0; 2],
        }
    }

    pub(super) fn run(mut self, mut own: Option<bool>) -> Fate {
        if self.t_end < 0.0 {
            return self.gone();
        }
        let map = self.field.map();
        let metres = [self.d[0] * map.pitch_x, -self.d[1] * map.pitch_y];
        let top = self.field.pyramid.len() - 1;
        let mut level = if own.is_some() || self.t > 0.0 { 0 } else { top.min(FAR) };
        let mut tiles = 0;
        loop {
            let shift = SHIFT + level as u32;
            let (edge, to) = self.ways_out(shift);
            let out = greater(lesser(lesser(to[0], to[1]), self.t_end), self.t);
            let z_out = self.oz + self.dz * out;
            let low = if self.dz < 0.0 { z_out } else { self.oz + self.dz * self.t };
            let [c, r] = self.cell.map(|c| c as usize);
            let (width, maxima) = &self.field.pyramid[level];
            let highest = f64::from(maxima[(r >> shift) * width + (c >> shift)]);
            let k = usize::from(to[0] > to[1]);
            let clear = low >= highest;
            if clear {
                self.above = greater(z_out - highest, 0.0);
            } else if level > 0 {
                level -= 1;
                continue;
            } else if !self.passes(c, r, [metres[0] * self.flip[0], metres[1] * self.flip[1]], out, k) {
                if let Some(hit) = self.cross_block(highest, own) {
                    return Fate::Hit(hit);
                }
                own = None;
                if self.t >= self.t_end {
                    return self.gone();
                }
                if self.is_outside() && !self.enter_next_tile(&mut tiles) {
                    return self.fate_beyond(tiles);
                }
                continue;
            }
            own = None;
            if out >= self.t_end {
                return self.gone();
            }
            // The crossed edge fixes one index exactly, the other follows the ray but may not leave the block it is in.
            let j = 1 - k;
            let first = self.cell[j] >> shift << shift;
            let last = (first + (1 << shift)).min(self.field.cells[j] as i64) - 1;
            // Positions are not negative, so truncation is the floor, and cheaper.
            self.cell[j] = ((self.o[j] + self.d[j] * out) as i64).clamp(first, last);
            let left = self.cell[k];
            self.cell[k] = if self.d[k] > 0.0 { edge[k] } else { edge[k] - 1 };
            // Larger strides begin where a larger square does.
            if clear && level < top && (left ^ self.cell[k]) >> (shift + 1) != 0 {
                level += 1;
            }
            self.t = out;
            if self.is_outside() && !self.enter_next_tile(&mut tiles) {
                return self.fate_beyond(tiles);
            }
        }
    }

    /// Whether the ray is sure to meet nothing in its block up to `out`, where it leaves along axis `k`: its height above the
    /// surface outlasts the block's slopes, or it is above all edges on the way.
    fn passes(&mut self, c: usize, r: usize, metres: [f64; 2], out: f64, k: usize) -> bool {
        if self.above < 0.0 {
            return false;
        }
        let quadrant = usize::from(metres[0] > 0.0) + 2 * usize::from(metres[1] > 0.0);
        let gain = self.dz - self.field.block(c, r).climb(quadrant).along(metres[0], metres[1]);
        let after = self.above + gain * (out - self.t);
        // An unknown climb compares as false.
        if gain >= 0.0 || after >= 0.0 {
            self.above = after;
            return true;
        }
        // A ray that comes down will hardly miss.
        if self.dz < 0.0 || !self.field.is_above_edges(self.o, self.d, [self.oz, self.dz], [self.t, out]) {
            return false;
        }
        if out < self.t_end {
            // The edge the ray leaves by belongs to the last cell before the border.
            let mut last = self.cell;
            last[k] = if self.d[k] > 0.0 {
                (self.cell[k] >> SHIFT << SHIFT) + (1 << SHIFT) - 1
            } else {
                self.cell[k] >> SHIFT << SHIFT
            };
            last[k] = last[k].min(self.field.cells[k] as i64 - 1);
            let j = 1 - k;
            last[j] = ((self.o[j] + self.d[j] * out) as i64).clamp(0, self.field.cells[j] as i64 - 1);
            let corners = self.field.corners(last[0] as usize, last[1] as usize);
            let height = self.height_over(corners, last, out, k);
            if !(height >= 0.0) {
                return false;
            }
            self.above = height;
        }
        true
    }

    /// Edges of the square of `1 << shift` cells that the ray will leave by, and when.
    #[inline]
    fn ways_out(&self, shift: u32) -> ([i64; 2], [f64; 2]) {
        let mut edge = [0; 2];
        let mut to = [f64::INFINITY; 2];
        for k in 0..2 {
            let first = self.cell[k] >> shift << shift;
            edge[k] = if self.d[k] > 0.0 { (first + (1 << shift)).min(self.field.cells[k] as i64) } else { first };
            if self.d[k] != 0.0 {
                to[k] = (edge[k] as f64 - self.o[k]) * self.inverse[k];
            }
        }
        (edge, to)
    }

    /// The fate of a ray above or below everything.
    fn gone(&self) -> Fate {
        if self.dz >= 0.0 { Fate::Escaped(self.flip) } else { Fate::Lost }
    }
}
