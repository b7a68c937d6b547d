//! The march of a ray over blocks and cells.

use super::blocks::SHIFT;
use super::slopes;
use super::visibility::{Fate, HeightField, Hit, Ray, plane};
use crate::heightmap::Edges;

/// A ray that crosses this many tiles is as good as horizontal.
const MAX_TILES: u32 = 256;

/// Squares of `2^FAR` blocks are where a ray from above begins.
const FAR: usize = 1;

impl HeightField<'_> {
    /// Follows `ray` to its first facet other than `own` (cell, upper), which it is leaving.
    ///
    /// Blocks are passed over when the ray stays above their highest vertex, or climbs faster than their slopes and
    /// was above the surface before. In other blocks every triangle on the way is asked whether the ray, above the surface when it
    /// came, is below it at the end: each border between triangles is judged once, so nothing slips through, and the
    /// own facet is left by its identity, not by a distance.
    #[inline]
    pub fn trace(&self, ray: Ray, own: Option<([usize; 2], bool)>) -> Fate {
        let d = ray.direction;
        if let Some((cell, _)) = own {
            let sine = f64::from(self.clear_sines(cell)[usize::from(d.x > 0.0) + 2 * usize::from(d.y > 0.0)]);
            if d.z > 0.0 && d.z * d.z >= sine * sine * d.length_squared() {
                return Fate::Escaped([1.0, 1.0]);
            }
        }
        March::new(self, ray, own).run(own.map(|o| o.1))
    }
}

/// A ray under way: `position = o + t d` in samples and metres.
struct March<'f> {
    field: &'f HeightField<'f>,
    o: [f64; 2],
    d: [f64; 2],
    inverse: [f64; 2],
    oz: f64,
    dz: f64,
    /// Cell the ray is in.
    cell: [i64; 2],
    t: f64,
    /// Beyond this the ray is above everything or below everything.
    t_end: f64,
    /// Lower bound of the ray's height above the surface; negative if it may be below, after a gap.
    above: f64,
    flip: [f64; 2],
}

impl<'f> March<'f> {
    #[inline]
    fn new(field: &'f HeightField<'f>, ray: Ray, own: Option<([usize; 2], bool)>) -> Self {
        let map = field.map();
        let [nx, ny] = field.cells.map(|n| n as i64);
        let d = [ray.direction.x / map.pitch_x, -ray.direction.y / map.pitch_y];
        let (oz, dz) = (ray.z, ray.direction.z);
        let t_end = if dz > 0.0 {
            (field.highest - oz) / dz
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

    fn run(mut self, mut own: Option<bool>) -> Fate {
        if self.t_end < 0.0 {
            return self.gone();
        }
        let top = self.field.pyramid.len();
        let mut level = if own.is_some() { 0 } else { top.min(FAR) };
        let mut tiles = 0;
        loop {
            let shift = SHIFT + level as u32;
            let (edge, to) = self.ways_out(shift);
            let out = to[0].min(to[1]).min(self.t_end).max(self.t);
            let low = self.oz + self.dz * if self.dz < 0.0 { out } else { self.t };
            let [c, r] = self.cell.map(|c| c as usize);
            if level > 0 {
                let (width, maxima) = &self.field.pyramid[level - 1];
                let highest = f64::from(maxima[(r >> shift) * width + (c >> shift)]);
                if low < highest {
                    level -= 1;
                    continue;
                }
                self.above = (self.oz + self.dz * out - highest).max(0.0);
                level = (level + 1).min(top);
            } else {
                let block = self.field.block(c, r);
                let highest = f64::from(block.top);
                let map = self.field.map();
                let gain = self.dz - block.climb(self.d[0] * map.pitch_x, -self.d[1] * map.pitch_y);
                let after = self.above + gain * (out - self.t);
                if low >= highest {
                    self.above = (self.oz + self.dz * out - highest).max(after).max(0.0);
                    level = 1.min(top);
                } else if self.above >= 0.0 && (gain >= 0.0 || after >= 0.0) {
                    self.above = after;
                } else {
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
            }
            if out >= self.t_end {
                return self.gone();
            }
            // The crossed edge fixes one index exactly, the other follows the ray but may not leave the block it is in.
            let k = usize::from(to[0] > to[1]);
            let j = 1 - k;
            let first = self.cell[j] >> shift << shift;
            let last = (first + (1 << shift)).min(self.field.cells[j] as i64) - 1;
            // Positions are not negative, so truncation is the floor, and cheaper.
            self.cell[j] = ((self.o[j] + self.d[j] * out) as i64).clamp(first, last);
            self.cell[k] = if self.d[k] > 0.0 { edge[k] } else { edge[k] - 1 };
            self.t = out;
            if self.is_outside() && !self.enter_next_tile(&mut tiles) {
                return self.fate_beyond(tiles);
            }
        }
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

    /// Cell by cell through the block the ray is in, leaving the ray at the block's border or at the end of its way.
    fn cross_block(&mut self, highest: f64, own: Option<bool>) -> Option<Hit> {
        let first = self.cell.map(|c| c >> SHIFT << SHIFT);
        let last = [0, 1].map(|k| (first[k] + (1 << SHIFT)).min(self.field.cells[k] as i64) - 1);
        if self.dz < 0.0 && own.is_none() {
            // Nothing can be met above the highest vertex.
            let entry = (highest - self.oz) / self.dz;
            if entry > self.t {
                self.t = entry.min(self.t_end);
                self.above = 0.0;
                for k in 0..2 {
                    self.cell[k] = ((self.o[k] + self.d[k] * self.t) as i64).clamp(first[k], last[k]);
                }
            }
        }
        let mut own = own;
        loop {
            let (edge, to) = self.ways_out(0);
            let out = to[0].min(to[1]).min(self.t_end).max(self.t);
            let low = self.oz + self.dz * if self.dz < 0.0 { out } else { self.t };
            let corners = self.field.corners(self.cell[0] as usize, self.cell[1] as usize);
            // A comparison with a missing vertex fails and sends the ray to the closer look.
            if own.is_none() && corners.iter().all(|&h| low >= f64::from(h)) {
                self.above = 0.0;
            } else if let Some((upper, at)) = self.cross_cell(corners, out, own) {
                return Some(self.hit(corners, upper, at));
            }
            own = None;
            self.t = out;
            if out >= self.t_end {
                return None;
            }
            let k = usize::from(to[0] > to[1]);
            self.cell[k] = if self.d[k] > 0.0 { edge[k] } else { edge[k] - 1 };
            if self.cell[k] < first[k] || self.cell[k] > last[k] {
                self.above = if self.above >= 0.0 { self.height_over_border(corners, k) } else { self.above };
                return None;
            }
        }
    }

    /// Height above the border of the cell just left along axis `k`; a gap gives no bound.
    #[inline]
    fn height_over_border(&self, [a, b, c, d]: [f32; 4], k: usize) -> f64 {
        let j = 1 - k;
        let along = (self.o[j] + self.d[j] * self.t - self.cell[j] as f64).clamp(0.0, 1.0);
        let ends = match (k, self.d[k] > 0.0) {
            (0, true) => [b, d],
            (0, false) => [a, c],
            (_, true) => [c, d],
            (_, false) => [a, b],
        };
        let [from, to] = ends.map(f64::from);
        let height = self.oz + self.dz * self.t - (from + along * (to - from));
        // The ray was above; what rounding says against it must not count.
        if height.is_nan() { f64::NEG_INFINITY } else { height.max(0.0) }
    }

    /// First triangle of the cell met between `self.t` and `out`, and where.
    fn cross_cell(&mut self, corners: [f32; 4], out: f64, own: Option<bool>) -> Option<(bool, f64)> {
        let (u, v) = (self.o[0] - self.cell[0] as f64, self.o[1] - self.cell[1] as f64);
        let (w, dw) = (u - v, self.d[0] - self.d[1]);
        // The triangle before the diagonal, and the time there.
        let before = dw < 0.0;
        let diagonal = if dw != 0.0 {
            (-w / dw).clamp(self.t, out)
        } else if (w > 0.0) == before {
            out
        } else {
            self.t
        };
        let diagonal = match own {
            // On its own facet the ray starts, whatever rounding says about the diagonal.
            Some(upper) if upper != before => self.t,
            _ => diagonal,
        };
        for (upper, from, to) in [(before, self.t, diagonal), (!before, diagonal, out)] {
            if to <= from && !(to == out && from == self.t) {
                continue;
            }
            if own == Some(upper) {
                self.above = 0.0;
                continue;
            }
            let [g0, gu, gv] = plane(corners, upper);
            let height = self.oz - g0 - gu * u - gv * v;
            let rate = self.dz - gu * self.d[0] - gv * self.d[1];
            let end = height + rate * to;
            if end.is_nan() {
                // A hole: the ray may go below the surface.
                self.above = f64::NEG_INFINITY;
                continue;
            }
            let came_above = self.above >= 0.0 || height + rate * from >= 0.0;
            if end >= 0.0 {
                self.above = end;
            } else if came_above && rate < 0.0 {
                return Some((upper, (-height / rate).clamp(from, to)));
            } else if !came_above {
                self.above = f64::NEG_INFINITY;
            }
        }
        None
    }

    fn hit(&self, corners: [f32; 4], upper: bool, at: f64) -> Hit {
        let map = self.field.map();
        let slopes = slopes::of_corners(corners.map(f64::from), map.pitch_x, map.pitch_y);
        let place = |k: usize| {
            let c = self.cell[k] as f64;
            (self.o[k] + self.d[k] * at).clamp(c, c + 1.0)
        };
        Hit {
            cell: self.cell.map(|c| c as usize),
            upper,
            column: place(0),
            row: place(1),
            z: self.oz + self.dz * at,
            slope: slopes[usize::from(upper)],
            flip: self.flip,
        }
    }

    #[inline]
    fn is_outside(&self) -> bool {
        (0..2).any(|k| self.cell[k] < 0 || self.cell[k] >= self.field.cells[k] as i64)
    }

    /// Whether there is more map where the ray left it; if so the ray is moved into the tile.
    #[cold]
    fn enter_next_tile(&mut self, tiles: &mut u32) -> bool {
        *tiles += 1;
        let edges = self.field.map().edges;
        if edges == Edges::Open || *tiles > MAX_TILES {
            return false;
        }
        for k in 0..2 {
            let n = self.field.cells[k] as i64;
            let c = self.cell[k];
            if (0..n).contains(&c) {
                continue;
            }
            if edges == Edges::Periodic {
                let by = if c < 0 { n } else { -n };
                self.cell[k] += by;
                self.o[k] += by as f64;
            } else {
                // Reflects the ray's path instead of the map: x -> -x or x -> 2 n - x.
                self.cell[k] = if c < 0 { 0 } else { n - 1 };
                self.o[k] = if c < 0 { -self.o[k] } else { 2.0 * n as f64 - self.o[k] };
                self.d[k] = -self.d[k];
                self.inverse[k] = -self.inverse[k];
                self.flip[k] = -self.flip[k];
            }
        }
        true
    }

    fn fate_beyond(&self, tiles: u32) -> Fate {
        if tiles > MAX_TILES { Fate::Lost } else { Fate::Escaped(self.flip) }
    }

    /// The fate of a ray above or below everything.
    fn gone(&self) -> Fate {
        if self.dz >= 0.0 { Fate::Escaped(self.flip) } else { Fate::Lost }
    }
}
