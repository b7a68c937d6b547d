//! Autocorrelation of the heights.

use super::real_transform::{HalfSpectrum, fast_length};
use crate::heightmap::parameters::Heights;
use crate::heightmap::{Edges, HeightMap};

/// Maps of more points are correlated to a quarter of each side instead of half of it, for the sake of memory.
const LARGE: usize = 1 << 22;

/// Lags with a smaller share of the pairs that an unbroken map has are left out: too few to mean anything.
const FEWEST_PAIRS: f32 = 0.02;

/// `f_ACF(tx, ty) = <h(x, y) h(x - tx, y - ty)> / Sq^2`, the mean over all pairs of measured points that far apart.
///
/// ISO 25178-2:2012, 3.2.8, with every lag normalised by its own number of pairs, so that neither the border nor missing
/// points pull the function down. Lags reach half the map along each axis (a quarter above 4 million points); a periodic
/// map wraps round.
#[derive(Debug, Clone)]
pub struct Autocorrelation {
    /// Largest lag along x and y [points].
    pub reach: [usize; 2],
    /// Sampling distance along x and y \[m\].
    pub pitch: [f64; 2],
    /// Row `reach_y + j` holds the lags `j` rows down and 0 .. reach_x columns to the right; NaN without pairs.
    values: Vec<f32>,
}

impl Autocorrelation {
    /// By Fourier transform, padded with zeros unless the map is periodic. A flat map has the value 1 everywhere.
    pub fn measure(map: &HeightMap) -> Self {
        Self::about(map, &Heights::measure(map))
    }

    /// As [`Autocorrelation::measure`] for heights already known.
    pub(crate) fn about(map: &HeightMap, heights: &Heights) -> Self {
        let (height, width) = map.heights.dim();
        let part = if height * width > LARGE { 4 } else { 2 };
        let reach = [width / part, height / part].map(|n| n.max(1));
        let pitch = [map.pitch_x, map.pitch_y];
        let wide = 2 * reach[1] + 1;
        if heights.sq == 0.0 {
            return Autocorrelation { reach, pitch, values: vec![1.0; wide * (reach[0] + 1)] };
        }
        let periodic = map.edges == Edges::Periodic;
        let padded = |n: usize, reach: usize| if periodic { n } else { fast_length(n + reach) };
        let (rows, columns) = (padded(height, reach[1]), padded(width, reach[0]));
        let lag_rows: Vec<usize> = (0..wide).map(|i| (i + rows - reach[1] % rows) % rows).collect();
        let correlate = |value: &(dyn Fn(f32) -> f64 + Sync)| {
            let mut half = HalfSpectrum::of_rows(rows, columns, height, |r, row| {
                row.iter_mut().zip(map.heights.row(r)).for_each(|(v, &h)| *v = value(h));
            });
            half.square((width * height) as f64);
            half.rows_back(&lag_rows, reach[0] + 1).concat()
        };
        let scale = 1.0 / heights.sq;
        let mut values = correlate(&|h| if h.is_nan() { 0.0 } else { (f64::from(h) - heights.mean) * scale });
        if heights.points == (width * height) as u64 {
            // Without gaps the share of pairs is known.
            let share = |n: usize, lag: usize| if periodic { 1.0 } else { (n - lag.min(n)) as f32 / n as f32 };
            for (i, value) in values.iter_mut().enumerate() {
                let (down, right) = ((i / (reach[0] + 1)).abs_diff(reach[1]), i % (reach[0] + 1));
                *value /= share(height, down) * share(width, right);
            }
        } else {
            let pairs = correlate(&|h| if h.is_nan() { 0.0 } else { 1.0 });
            for (value, pairs) in values.iter_mut().zip(pairs) {
                *value = if pairs > FEWEST_PAIRS { *value / pairs } else { f32::NAN };
            }
        }
        // The value at no lag is 1 but for f32.
        values[reach[1] * (reach[0] + 1)] = 1.0;
        Autocorrelation { reach, pitch, values }
    }

    /// Value at a lag of whole points, to the right and down; `None` beyond the reach or without pairs.
    pub fn at(&self, right: isize, down: isize) -> Option<f64> {
        let (right, down) = if right < 0 { (-right, -down) } else { (right, down) };
        let reach = self.reach.map(|n| n as isize);
        if right > reach[0] || down.abs() > reach[1] {
            return None;
        }
        let value = self.values[(down + reach[1]) as usize * (self.reach[0] + 1) + right as usize];
        (!value.is_nan()).then(|| f64::from(value))
    }

    /// Value at a lag `(x, y)` \[m\] by cubic convolution (Keys 1981, a = -1/2); `None` beyond the reach.
    pub fn at_lag(&self, x: f64, y: f64) -> Option<f64> {
        let (right, down) = (x / self.pitch[0], -y / self.pitch[1]);
        let weights = |t: f64| {
            let (t2, t3) = (t * t, t * t * t);
            [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)]
        };
        let (wx, wy) = (weights(right - right.floor()), weights(down - down.floor()));
        let (c, r) = (right.floor() as isize, down.floor() as isize);
        let mut sum = 0.0;
        for (j, wy) in wy.into_iter().enumerate() {
            for (i, wx) in wx.into_iter().enumerate() {
                if wx != 0.0 && wy != 0.0 {
                    sum += wx * wy * self.at(c + i as isize - 1, r + j as isize - 1)?;
                }
            }
        }
        Some(sum)
    }

    /// `(lag [m], value)` along x.
    pub fn along_x(&self) -> Vec<(f64, f64)> {
        let points = (0..=self.reach[0]).map_while(|k| Some((k as f64 * self.pitch[0], self.at(k as isize, 0)?)));
        points.collect()
    }

    /// `(lag [m], value)` along y.
    pub fn along_y(&self) -> Vec<(f64, f64)> {
        let points = (0..=self.reach[1]).map_while(|k| Some((k as f64 * self.pitch[1], self.at(0, k as isize)?)));
        points.collect()
    }

    /// `(lag [m], mean over all directions)`, in rings as wide as the larger pitch, up to the shorter reach.
    pub fn radial(&self) -> Vec<(f64, f64)> {
        let ring = self.pitch[0].max(self.pitch[1]);
        let farthest = (self.reach[0] as f64 * self.pitch[0]).min(self.reach[1] as f64 * self.pitch[1]);
        let rings = (farthest / ring) as usize + 1;
        let mut sums = vec![[0.0; 3]; rings];
        for (i, &value) in self.values.iter().enumerate() {
            let (down, right) = ((i / (self.reach[0] + 1)).abs_diff(self.reach[1]), i % (self.reach[0] + 1));
            let lag = (right as f64 * self.pitch[0]).hypot(down as f64 * self.pitch[1]);
            let k = (lag / ring).round() as usize;
            if k < rings && !value.is_nan() {
                // The left half of the plane mirrors the right one; the column between is stored whole.
                let weight = if right == 0 { 1.0 } else { 2.0 };
                sums[k][0] += weight;
                sums[k][1] += weight * lag;
                sums[k][2] += weight * f64::from(value);
            }
        }
        sums.into_iter().filter(|s| s[0] > 0.0).map(|s| (s[1] / s[0], s[2] / s[0])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn map(edges: Edges, gaps: bool) -> HeightMap {
        let mut heights = Array2::from_shape_fn((15, 22), |(r, c)| 1e-7 * (((r * r * 5 + c * 7) % 13) as f32 - 3.0));
        if gaps {
            heights[[3, 4]] = f32::NAN;
            (0..24).for_each(|k| heights[[6 + k / 8, 10 + k % 8]] = f32::NAN);
        }
        HeightMap { heights, pitch_x: 1e-6, pitch_y: 3e-6, edges, removed_slopes: [0.0; 2] }
    }

    /// Against the sum over pairs itself, with and without gaps, wrapped and not.
    #[test]
    fn agrees_with_the_sum_over_pairs() {
        for (edges, gaps) in
            [(Edges::Open, false), (Edges::Open, true), (Edges::Periodic, false), (Edges::Periodic, true)]
        {
            let m = map(edges, gaps);
            let heights = Heights::measure(&m);
            let acf = Autocorrelation::measure(&m);
            assert_eq!(acf.reach, [11, 7]);
            let (rows, columns) = m.heights.dim();
            for (right, down) in [(0isize, 0isize), (3, 0), (0, 5), (11, 7), (4, -6), (-4, 6), (-1, -7)] {
                let (mut sum, mut pairs) = (0.0, 0.0);
                for r in 0..rows as isize {
                    for c in 0..columns as isize {
                        let (r2, c2) = (r + down, c + right);
                        let inside = (0..rows as isize).contains(&r2) && (0..columns as isize).contains(&c2);
                        if edges == Edges::Open && !inside {
                            continue;
                        }
                        let other = [r2.rem_euclid(rows as isize) as usize, c2.rem_euclid(columns as isize) as usize];
                        let product = (f64::from(m.heights[[r as usize, c as usize]]) - heights.mean)
                            * (f64::from(m.heights[other]) - heights.mean);
                        if !product.is_nan() {
                            sum += product;
                            pairs += 1.0;
                        }
                    }
                }
                let expected = sum / pairs / heights.sq.powi(2);
                let found = acf.at(right, down).unwrap();
                assert!((found - expected).abs() < 3e-6, "{edges:?} {gaps} {right} {down}: {found} {expected}");
            }
            assert!(acf.at(12, 0).is_none() && acf.at(0, -8).is_none());
        }
    }

    #[test]
    fn between_points_and_mirrored() {
        let acf = Autocorrelation::measure(&map(Edges::Open, true));
        // y points up, rows go down.
        assert_eq!(acf.at_lag(2e-6, 9e-6), acf.at(2, -3));
        assert_eq!(acf.at_lag(-2e-6, -9e-6), acf.at(2, -3));
        let between = acf.at_lag(2.5e-6, 0.0).unwrap();
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| acf.at(k, 0).unwrap());
        assert!((between - (9.0 * (b + c) - a - d) / 16.0).abs() < 1e-12);
        assert!(acf.at_lag(11e-6, 0.0).is_some() && acf.at_lag(11.5e-6, 0.0).is_none());
    }
}
