//! Height parameters of ISO 25178-2.

use super::HeightMap;

/// `Sq = sqrt(<h^2>)` [m], over the measured points about their mean.
pub fn sq(map: &HeightMap) -> f64 {
    let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for row in map.heights.outer_iter() {
        for h in row.iter().filter(|h| !h.is_nan()) {
            let h = f64::from(*h);
            n += 1.0;
            sum += h;
            squares += h * h;
        }
    }
    if n == 0.0 {
        return 0.0;
    }
    let mean = sum / n;
    (squares / n - mean * mean).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::Edges;

    #[test]
    fn sinusoid_with_a_gap() {
        // Whole periods: Sq = amplitude / sqrt 2; the gap removes whole rows.
        let mut heights = ndarray::Array2::from_shape_fn((8, 64), |(_, c)| {
            (3.0 + 2.0 * (std::f64::consts::TAU * c as f64 / 16.0).sin()) as f32
        });
        heights.row_mut(3).fill(f32::NAN);
        let map = HeightMap { heights, pitch_x: 1.0, pitch_y: 1.0, edges: Edges::Open, removed_slopes: [0.0; 2] };
        assert!((sq(&map) - 2.0 / std::f64::consts::SQRT_2).abs() < 1e-6);
    }
}
