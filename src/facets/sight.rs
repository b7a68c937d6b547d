//! Whether a beam is free, without asking where it would hit.

use super::blocks::{Outlook, RINGS, SIDE};
use super::visibility::{HeightField, Ray, quadrant};

/// Samples a beam may travel to become free; what goes further is left to the march, which strides ahead.
const FARTHEST: f64 = 96.0;

impl HeightField<'_> {
    /// Whether a beam that leaves the surface in `cell` is sure to escape: it stays above the surface at every edge of the
    /// mesh within the distance at which something could stand in its way. `false` says nothing.
    ///
    /// The three families of edges (along the rows, along the columns, diagonal) are asked one after the other at
    /// evenly spaced points, which is far cheaper than cell by cell.
    pub fn is_free(&self, ray: Ray, cell: [usize; 2]) -> bool {
        let d = ray.direction;
        let flat = (d.x * d.x + d.y * d.y).sqrt();
        if d.z <= 0.0 {
            return false;
        }
        let Some([from, to]) = self.doubtful(&self.outlooks(cell)[quadrant(d)], ray.z, d.z / flat) else { return true };
        let map = self.map();
        // Per metre of way over the mean plane.
        let (dx, dy, dz) = (d.x / (flat * map.pitch_x), -d.y / (flat * map.pitch_y), d.z / flat);
        let width = map.width();
        let last = [width - 1, map.height() - 1].map(|n| n as f64);
        let ends = [ray.column + dx * to, ray.row + dy * to];
        let inside = [[ray.column, ray.row], ends].iter().all(|x| (0..2).all(|k| x[k] > 0.0 && x[k] < last[k]))
            && (ends[0] - ray.column).abs() + (ends[1] - ray.row).abs() < FARTHEST;
        if !inside {
            return false;
        }
        let heights = &self.heights[..];
        let above = |z: f64, first: usize, second: usize, share: f64| {
            let (a, b) = (f64::from(heights[first]), f64::from(heights[second]));
            // A missing vertex fails.
            z >= a + share * (b - a)
        };
        // Whole values of the coordinate that starts at `o` and grows by `rate`, from `from` to `to`.
        let crossings = |o: f64, rate: f64| {
            let (a, b) = (o + rate * from, o + rate * to);
            let low = if a < b { a } else { b };
            let high = if a < b { b } else { a };
            (low as i64 + i64::from(low > 0.0), high as i64 - i64::from(high < 0.0))
        };
        let (first, last) = crossings(ray.column, dx);
        let per = 1.0 / dx;
        for k in first..=last {
            let t = (k as f64 - ray.column) * per;
            let y = ray.row + dy * t;
            let row = y as usize;
            let place = row * width + k as usize;
            if !above(ray.z + dz * t, place, place + width, y - row as f64) {
                return false;
            }
        }
        let (first, last) = crossings(ray.row, dy);
        let per = 1.0 / dy;
        for k in first..=last {
            let t = (k as f64 - ray.row) * per;
            let x = ray.column + dx * t;
            let column = x as usize;
            let place = k as usize * width + column;
            if !above(ray.z + dz * t, place, place + 1, x - column as f64) {
                return false;
            }
        }
        let (across, rate) = (ray.column - ray.row, dx - dy);
        let (first, last) = crossings(across, rate);
        let per = 1.0 / rate;
        for k in first..=last {
            let t = (k as f64 - across) * per;
            let x = ray.column + dx * t;
            let column = x as usize;
            let row = column as i64 - k;
            let place = (row * width as i64 + column as i64) as usize;
            if !above(ray.z + dz * t, place, place + width + 1, x - column as f64) {
                return false;
            }
        }
        true
    }

    /// The stretch over the mean plane \[m\] where something could stand in the way of a beam that climbs from height `z`;
    /// `None` if nothing can.
    #[inline]
    pub(super) fn doubtful(&self, outlook: &Outlook, z: f64, climb: f64) -> Option<[f64; 2]> {
        let map = self.map();
        let side = SIDE as f64 * map.pitch_x.min(map.pitch_y);
        let (mut from, mut to) = (f64::INFINITY, 0.0);
        if climb < f64::from(outlook.climb) {
            (from, to) = (0.0, side);
        }
        let mut inner = side;
        for (ring, top) in outlook.tops.into_iter().map(f64::from).chain([self.highest]).enumerate() {
            if z + climb * inner < top {
                from = if from < inner { from } else { inner };
                let (there, outer) = ((top - z) / climb, 2.0 * inner);
                to = if there < outer || ring == RINGS { there } else { outer };
            }
            inner *= 2.0;
        }
        (to > 0.0).then_some([from, to])
    }
}
