//! Whether a beam is free, without asking where it would hit.

use super::blocks::{Climb, Outlook, RINGS, SIDE};
use super::visibility::HeightField;
use glam::DVec3;

/// A direction upwards and how it climbs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ascent {
    d: DVec3,
    /// Height per length over the mean plane, and its inverse.
    climb: f64,
    per_climb: f64,
}

impl Ascent {
    pub(super) fn new(d: DVec3) -> Self {
        let climb = d.z / (d.x * d.x + d.y * d.y).sqrt();
        Ascent { d, climb, per_climb: 1.0 / climb }
    }
}

impl HeightField<'_> {
    /// The stretch over the mean plane \[m\] where something could stand in the way of a beam from height `z`; `None` if
    /// nothing can.
    #[inline]
    pub(super) fn doubtful(&self, outlook: &Outlook, z: f64, ascent: &Ascent) -> Option<[f64; 2]> {
        let Ascent { d, climb, per_climb } = *ascent;
        let map = self.map();
        let side = SIDE as f64 * if map.pitch_x < map.pitch_y { map.pitch_x } else { map.pitch_y };
        let (mut from, mut to) = (f64::INFINITY, 0.0);
        // An unknown climb is never outdone.
        let outdoes = |climb: &Climb| d.z >= climb.along(d.x, d.y);
        let outdone = outdoes(&outlook.climb);
        if !outdone {
            (from, to) = (0.0, side);
        }
        let farther = outdone && outdoes(&outlook.farther);
        let mut inner = side;
        for ring in 0..=RINGS {
            let top = if ring < RINGS { f64::from(outlook.tops[ring]) } else { self.highest };
            if z + climb * inner < top && !(ring == 0 && farther) {
                from = if from < inner { from } else { inner };
                let (there, outer) = ((top - z) * per_climb, 2.0 * inner);
                to = if there < outer || ring == RINGS { there } else { outer };
            }
            inner *= 2.0;
        }
        (to > 0.0).then_some([from, to])
    }

    /// Whether a ray `o + t d` (samples), `z[0] + t z[1]` (metres) stays above every edge of the mesh that it crosses for `t`
    /// within `times`, all of it on the map. `false` says nothing.
    ///
    /// The three families of edges (along the columns, along the rows, diagonal) are crossed at evenly spaced
    /// times, which is far cheaper to follow than the way from cell to cell.
    pub(super) fn is_above_edges(&self, o: [f64; 2], d: [f64; 2], z: [f64; 2], times: [f64; 2]) -> bool {
        let width = self.map().width();
        let last = [width - 1, self.map().height() - 1].map(|n| n as f64);
        let ends = times.map(|t| [o[0] + d[0] * t, o[1] + d[1] * t]);
        if !ends.iter().all(|x| (0..2).all(|k| x[k] >= 0.0 && x[k] < last[k])) {
            return false;
        }
        let heights = &self.heights[..];
        let is_above = |t: f64, first: usize, step: usize, share: f64| {
            // Rounding may put a crossing beyond the border; that fails, and so does a missing vertex.
            let (Some(&a), Some(&b)) = (heights.get(first), heights.get(first.wrapping_add(step))) else {
                return false;
            };
            let (a, b) = (f64::from(a), f64::from(b));
            z[0] + z[1] * t >= a + share * (b - a)
        };
        let across = (o[0] - o[1], d[0] - d[1]);
        let per = [1.0 / d[0], 1.0 / d[1], 1.0 / across.1];
        for k in passed(ends[0][0], ends[1][0]) {
            let t = (k as f64 - o[0]) * per[0];
            let y = o[1] + d[1] * t;
            let row = y as usize;
            if !is_above(t, row * width + k as usize, width, y - row as f64) {
                return false;
            }
        }
        for k in passed(ends[0][1], ends[1][1]) {
            let t = (k as f64 - o[1]) * per[1];
            let x = o[0] + d[0] * t;
            let column = x as usize;
            if !is_above(t, k as usize * width + column, 1, x - column as f64) {
                return false;
            }
        }
        for k in passed(ends[0][0] - ends[0][1], ends[1][0] - ends[1][1]) {
            let t = (k as f64 - across.0) * per[2];
            let x = o[0] + d[0] * t;
            let column = x as usize;
            let first = ((column as i64 - k) as usize).wrapping_mul(width).wrapping_add(column);
            if !is_above(t, first, width + 1, x - column as f64) {
                return false;
            }
        }
        true
    }
}

/// The whole numbers between two numbers.
#[inline]
fn passed(a: f64, b: f64) -> std::ops::RangeInclusive<i64> {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    low as i64 + i64::from(low > 0.0)..=high as i64 - i64::from(high < 0.0)
}
