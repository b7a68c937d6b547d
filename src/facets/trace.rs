//! First hit of a ray: what a height field is asked.

use super::ends::Hits;
use super::march::{March, lesser};
use super::sight::Ascent;
use super::visibility::{Fate, HeightField, Hit, Ray, quadrant};
use crate::heightmap::Edges;
use glam::DVec3;

/// The cell and the triangle of it (lower or upper) that a ray is leaving.
pub type Own = ([usize; 2], bool);

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
        let [_, to] = self.doubtful(&self.outlooks(cell)[quadrant], z, &Ascent::new(d))?;
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
