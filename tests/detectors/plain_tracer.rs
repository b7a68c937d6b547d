//! A ray tracer of its own: f64, cell by cell, no bounds, no blocks, no lanes. Slow, short, and sharing nothing with ours but
//! where the diagonal of a cell runs.

use asperity::heightmap::{Edges, HeightMap};
use asperity::math::random::CounterRng;

/// A periodic map of mirrors.
pub struct PlainTracer {
    /// Heights in pitches, row 0 at y = 0, so that y grows with the row.
    heights: Vec<f64>,
    side: usize,
    lowest: f64,
    highest: f64,
}

/// Where a ray strikes: place, slopes, and the triangle.
struct Strike {
    at: [f64; 3],
    slope: [f64; 2],
    triangle: ([i64; 2], bool),
}

impl PlainTracer {
    /// Of a periodic square map of square cells.
    pub fn new(map: &HeightMap) -> Self {
        assert!(map.edges == Edges::Periodic && map.width() == map.height() && map.pitch_x == map.pitch_y);
        let side = map.width();
        let heights: Vec<f64> =
            (0..side * side).map(|k| f64::from(map.heights[[side - 1 - k / side, k % side]]) / map.pitch_x).collect();
        let (lowest, highest) = heights.iter().fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
        PlainTracer { heights, side, lowest, highest }
    }

    /// Shares of the rays that leave after one, two and more bounces; light from +x.
    pub fn shares(&self, theta_i: f64, rays: u64, seed: u64) -> [f64; 3] {
        let mut counts = [0u64; 3];
        for ray in 0..rays {
            let mut rng = CounterRng::new(seed, 0, ray);
            let mut from = [rng.uniform() * self.side as f64, rng.uniform() * self.side as f64, self.highest + 1e-6];
            let mut way = [-theta_i.sin(), 0.0, -theta_i.cos()];
            let (mut own, mut bounces) = (None, 0);
            while let Some(strike) = self.strike(from, way, own) {
                let [p, q] = strike.slope;
                // Twice the component along the normal (-p, -q, 1), in units of its length.
                let twice = 2.0 * (way[2] - p * way[0] - q * way[1]) / (1.0 + p * p + q * q);
                way = [way[0] + twice * p, way[1] + twice * q, way[2] - twice];
                (from, own, bounces) = (strike.at, Some(strike.triangle), bounces + 1);
            }
            assert!(way[2] > 0.0 && bounces > 0, "a ray fell through the surface");
            counts[bounces.min(3) - 1] += 1;
        }
        counts.map(|n| n as f64 / rays as f64)
    }

    fn height(&self, [i, j]: [i64; 2]) -> f64 {
        let wrap = |k: i64| k.rem_euclid(self.side as i64) as usize;
        self.heights[wrap(j) * self.side + wrap(i)]
    }

    /// First triangle from above along the way; that of the start is left out once.
    fn strike(&self, from: [f64; 3], way: [f64; 3], own: Option<([i64; 2], bool)>) -> Option<Strike> {
        let mut cell = own.map_or([from[0].floor() as i64, from[1].floor() as i64], |(cell, _)| cell);
        let mut t = 0.0;
        let mut is_first = true;
        loop {
            let edge = [0, 1].map(|k| {
                let border = if way[k] > 0.0 { cell[k] + 1 } else { cell[k] };
                if way[k] == 0.0 { f64::INFINITY } else { (border as f64 - from[k]) / way[k] }
            });
            let end = edge[0].min(edge[1]).max(t);
            let z = from[2] + way[2] * t;
            if way[2] > 0.0 && z > self.highest || z < self.lowest - 1.0 {
                return None;
            }
            let hits = [false, true].map(|left| {
                if is_first && own == Some((cell, left)) { None } else { self.meet(from, way, cell, left, [t, end]) }
            });
            let nearest = hits.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, strike)) = nearest {
                return Some(strike);
            }
            let k = usize::from(edge[1] < edge[0]);
            cell[k] += if way[k] > 0.0 { 1 } else { -1 };
            (t, is_first) = (end, false);
        }
    }

    /// A triangle of a cell, right or left of its diagonal from the top left to the bottom right of the picture.
    fn meet(
        &self,
        from: [f64; 3],
        way: [f64; 3],
        cell: [i64; 2],
        upper: bool,
        [start, end]: [f64; 2],
    ) -> Option<(f64, Strike)> {
        let corner = |i: i64, j: i64| self.height([cell[0] + i, cell[1] + j]);
        let [p, q] = match upper {
            true => [corner(1, 1) - corner(0, 1), corner(1, 1) - corner(1, 0)],
            false => [corner(1, 0) - corner(0, 0), corner(0, 1) - corner(0, 0)],
        };
        let (x, y) = (from[0] - cell[0] as f64, from[1] - cell[1] as f64);
        // Both planes hold the ends of the diagonal, (0, 1) and (1, 0).
        let above = from[2] - corner(0, 1) - p * x - q * (y - 1.0);
        let fall = p * way[0] + q * way[1] - way[2];
        let t = above / fall;
        if !(fall > 0.0 && t >= 0.0 && t >= start - 1e-9 && t <= end + 1e-9) {
            return None;
        }
        let (u, v) = (x + way[0] * t, y + way[1] * t);
        let at = [from[0] + way[0] * t, from[1] + way[1] * t, from[2] + way[2] * t];
        ((u + v >= 1.0) == upper).then_some((t, Strike { at, slope: [p, q], triangle: (cell, upper) }))
    }
}
