//! The march of a ray over blocks and cells.

use super::blocks::SHIFT;
use super::ends::Hits;
use super::slopes;
use super::visibility::{Fate, HeightField, Hit, Ray, plane, quadrant};
use crate::heightmap::Edges;
use glam::DVec3;

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
    pub fn trace(&self, ray: Ray, own: Option<Own>) -> Fate {
        match self.end_of_doubt(&ray, own) {
            Some(end) => self.march(ray, own, end),
            None => Fate::Escaped([1.0, 1.0]),
        }
    }

    /// How far along a ray something can be met; `None` if nothing can.
    #[inline]
    pub(super) fn end_of_doubt(&self, ray: &Ray, own: Option<Own>) -> Option<f64> {
        match own {
            Some((cell, _)) if ray.direction.z > 0.0 => self.reach(cell, ray.z, ray.direction),
            _ => Some(f64::INFINITY),
        }
    }

    /// How many times `d`, which points upwards, something can stand in the way of a beam from height `z` in a cell; `None` if
    /// nothing can, judged by what is known of the blocks around.
    #[inline]
    pub fn reach(&self, cell: [usize; 2], z: f64, d: DVec3) -> Option<f64> {
        let quadrant = quadrant(d);
        let (flat, sine) = (d.x * d.x + d.y * d.y, f64::from(self.clear_sines(cell)[quadrant]));
        if d.z * d.z >= sine * sine * (flat + d.z * d.z) {
            return None;
        }
        let [_, to] = self.doubtful(&self.outlooks(cell)[quadrant], z, d)?;
        Some(lesser(to / flat.sqrt(), (self.highest - z) / d.z))
    }

    /// The march itself, from the start of the ray up to `end`.
    pub(super) fn march(&self, ray: Ray, own: Option<Own>, end: f64) -> Fate {
        March::new(self, ray, own, end).run(own.map(|o| o.1))
    }

    /// The march of a ray that at `t` is known not to have met the surface yet, nor to have crossed a border other than of a periodic
    /// map.
    pub(super) fn march_on(&self, ray: Ray, t: f64, end: f64) -> Fate {
        let mut march = March::new(self, ray, None, end);
        for k in 0..2 {
            let n = self.cells[k] as i64;
            let mut cell = (march.o[k] + march.d[k] * t).floor() as i64;
            if self.map().edges == Edges::Periodic {
                march.o[k] -= (cell.div_euclid(n) * n) as f64;
                cell = cell.rem_euclid(n);
            }
            march.cell[k] = cell.clamp(0, n - 1);
        }
        (march.t, march.above) = (t, 0.0);
        march.run(None)
    }

    /// Where a ray from the cell `from` meets the facet number `k` that strides have found.
    #[inline]
    pub(super) fn meet(&self, ray: &Ray, from: [usize; 2], hits: &Hits, k: usize) -> Hit {
        let mut march = March::new(self, *ray, None, f64::INFINITY);
        let cell = hits.cell.each_ref().map(|x| x[k]);
        for axis in 0..2 {
            march.o[axis] += (i64::from(hits.start[axis][k]) - from[axis] as i64) as f64;
            march.cell[axis] = i64::from(cell[axis]);
        }
        let (corners, upper) = (self.corners(cell[0] as usize, cell[1] as usize), hits.upper[k] == 1);
        let (height, rate) = march.over_plane(corners, upper);
        march.hit(corners, upper, -height / rate)
    }
}

/// The cell and the triangle of it (lower or upper) that a ray is leaving.
pub type Own = ([usize; 2], bool);

/// The lesser and the greater of two numbers, neither of them NaN.
#[inline]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
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
    /// Beyond this nothing can be met.
    t_end: f64,
    /// Lower bound of the ray's height above the surface; negative if it may be below, after a gap.
    above: f64,
    flip: [f64; 2],
}

impl<'f> March<'f> {
    #[inline]
    fn new(field: &'f HeightField<'f>, ray: Ray, own: Option<Own>, end: f64) -> Self {
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

    fn run(mut self, mut own: Option<bool>) -> Fate {
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

    /// Cell by cell through the block the ray is in, leaving the ray at the block's border or at the end of its way.
    fn cross_block(&mut self, highest: f64, own: Option<bool>) -> Option<Hit> {
        let first = self.cell.map(|c| c >> SHIFT << SHIFT);
        let last = [0, 1].map(|k| (first[k] + (1 << SHIFT)).min(self.field.cells[k] as i64) - 1);
        if self.dz < 0.0 && own.is_none() {
            // Nothing can be met above the highest vertex.
            let entry = (highest - self.oz) / self.dz;
            if entry > self.t {
                self.t = lesser(entry, self.t_end);
                self.above = 0.0;
                for k in 0..2 {
                    self.cell[k] = ((self.o[k] + self.d[k] * self.t) as i64).clamp(first[k], last[k]);
                }
            }
        }
        let ahead = self.d.map(|d| i64::from(d > 0.0));
        let way = |march: &Self, k: usize| {
            if march.d[k] == 0.0 {
                return f64::INFINITY;
            }
            ((march.cell[k] + ahead[k]) as f64 - march.o[k]) * march.inverse[k]
        };
        let mut to = [way(self, 0), way(self, 1)];
        let mut own = own;
        loop {
            let out = greater(lesser(lesser(to[0], to[1]), self.t_end), self.t);
            let low = self.oz + self.dz * if self.dz < 0.0 { out } else { self.t };
            let corners = self.field.corners(self.cell[0] as usize, self.cell[1] as usize);
            let [a, b, c, d] = corners.map(|h| low >= f64::from(h));
            // A comparison with a missing vertex fails and sends the ray to the closer look.
            if own.is_none() && (a & b & c & d) {
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
            let left = self.cell;
            self.cell[k] += 2 * ahead[k] - 1;
            if self.cell[k] < first[k] || self.cell[k] > last[k] {
                if self.above >= 0.0 {
                    let height = self.height_over(corners, left, out, k);
                    // The ray was above; what rounding says against it must not count. A gap gives no bound.
                    self.above = if height.is_nan() { f64::NEG_INFINITY } else { greater(height, 0.0) };
                }
                return None;
            }
            to[k] = way(self, k);
        }
    }

    /// Height at `t` above the edge by which the ray leaves `cell` along axis `k`; NaN over a gap.
    #[inline]
    fn height_over(&self, [a, b, c, d]: [f32; 4], cell: [i64; 2], t: f64, k: usize) -> f64 {
        let j = 1 - k;
        let along = greater(lesser(self.o[j] + self.d[j] * t - cell[j] as f64, 1.0), 0.0);
        let ends = match (k, self.d[k] > 0.0) {
            (0, true) => [b, d],
            (0, false) => [a, c],
            (_, true) => [c, d],
            (_, false) => [a, b],
        };
        let [from, to] = ends.map(f64::from);
        self.oz + self.dz * t - (from + along * (to - from))
    }

    /// First triangle of the cell met between `self.t` and `out`, and where.
    fn cross_cell(&mut self, corners: [f32; 4], out: f64, own: Option<bool>) -> Option<(bool, f64)> {
        let (u, v) = (self.o[0] - self.cell[0] as f64, self.o[1] - self.cell[1] as f64);
        let (w, dw) = (u - v, self.d[0] - self.d[1]);
        // The triangle before the diagonal, and the time there.
        let before = dw < 0.0;
        let diagonal = if dw != 0.0 {
            greater(lesser(-w / dw, out), self.t)
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
            let (height, rate) = self.over_plane(corners, upper);
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
                return Some((upper, greater(lesser(-height / rate, to), from)));
            } else if !came_above {
                self.above = f64::NEG_INFINITY;
            }
        }
        None
    }

    /// Height of the start of the ray over the plane of a triangle of its cell, and its gain.
    #[inline]
    fn over_plane(&self, corners: [f32; 4], upper: bool) -> (f64, f64) {
        let (u, v) = (self.o[0] - self.cell[0] as f64, self.o[1] - self.cell[1] as f64);
        let [g0, gu, gv] = plane(corners, upper);
        (self.oz - g0 - gu * u - gv * v, self.dz - gu * self.d[0] - gv * self.d[1])
    }

    #[inline]
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
