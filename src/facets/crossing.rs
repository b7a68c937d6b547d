//! The way of a ray through one block, triangle by triangle.

use super::blocks::SHIFT;
use super::march::{March, greater, lesser};
use super::slopes;
use super::visibility::{Hit, plane};

impl March<'_> {
    /// Cell by cell through the block the ray is in, leaving the ray at the block's border or at the end of its way.
    pub(super) fn cross_block(&mut self, highest: f64, own: Option<bool>) -> Option<Hit> {
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
    pub(super) fn height_over(&self, [a, b, c, d]: [f32; 4], cell: [i64; 2], t: f64, k: usize) -> f64 {
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
    pub(super) fn over_plane(&self, corners: [f32; 4], upper: bool) -> (f64, f64) {
        let (u, v) = (self.o[0] - self.cell[0] as f64, self.o[1] - self.cell[1] as f64);
        let [g0, gu, gv] = plane(corners, upper);
        (self.oz - g0 - gu * u - gv * v, self.dz - gu * self.d[0] - gv * self.d[1])
    }

    #[inline]
    pub(super) fn hit(&self, corners: [f32; 4], upper: bool, at: f64) -> Hit {
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
}
