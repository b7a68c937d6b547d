//! Removal of the least-squares plane.

use super::{Edges, HeightMap, RawMap};
use crate::error::{Error, Result};
use glam::{DMat3, DVec3};

/// `h <- h - (a + b x + c y)`, the plane minimising the squared residual over the measured points.
///
/// Computed in f64 on centred coordinates, stored as f32: a map at 76 mm loses nothing but its offset.
///
/// # Errors
/// `Error::Parameter` if fewer than three points are measured or they lie on a line.
pub fn level(raw: &RawMap, edges: Edges) -> Result<HeightMap> {
    let (rows, columns) = raw.heights.dim();
    // Index coordinates centred on the map keep the normal equations well conditioned.
    let x_of = |c: usize| c as f64 - (columns as f64 - 1.0) / 2.0;
    let y_of = |r: usize| (rows as f64 - 1.0) / 2.0 - r as f64;
    let reference = raw.heights.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    let mut matrix = [[0.0f64; 3]; 3];
    let mut right = [0.0f64; 3];
    for (r, row) in raw.heights.outer_iter().enumerate() {
        let y = y_of(r);
        let (mut n, mut sx, mut sxx, mut sh, mut sxh) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (c, &h) in row.iter().enumerate() {
            if h.is_finite() {
                let (x, h) = (x_of(c), h - reference);
                n += 1.0;
                sx += x;
                sxx += x * x;
                sh += h;
                sxh += x * h;
            }
        }
        matrix[0][0] += n;
        matrix[0][1] += sx;
        matrix[0][2] += y * n;
        matrix[1][1] += sxx;
        matrix[1][2] += y * sx;
        matrix[2][2] += y * y * n;
        right[0] += sh;
        right[1] += sxh;
        right[2] += y * sh;
    }
    let m = DMat3::from_cols(
        DVec3::new(matrix[0][0], matrix[0][1], matrix[0][2]),
        DVec3::new(matrix[0][1], matrix[1][1], matrix[1][2]),
        DVec3::new(matrix[0][2], matrix[1][2], matrix[2][2]),
    );
    let scale = matrix[0][0] * matrix[1][1] * matrix[2][2];
    // A NaN spans nothing either.
    let spans = m.determinant() > 1e-12 * scale;
    if !spans {
        return Err(Error::parameter(
            "the measured points do not span a plane",
            "measure again or mend the gaps in the instrument's software",
        ));
    }
    let plane = m.inverse() * DVec3::from_array(right);
    let heights = ndarray::Array2::from_shape_fn((rows, columns), |(r, c)| {
        let h = raw.heights[[r, c]];
        if h.is_finite() { (h - reference - plane.x - plane.y * x_of(c) - plane.z * y_of(r)) as f32 } else { f32::NAN }
    });
    Ok(HeightMap {
        heights,
        pitch_x: raw.pitch_x,
        pitch_y: raw.pitch_y,
        edges,
        removed_slopes: [plane.y / raw.pitch_x, plane.z / raw.pitch_y],
    })
}

/// The map as measured, with only its mean removed: for ramps and other surfaces whose tilt is meant.
pub fn keep_tilt(raw: &RawMap, edges: Edges) -> HeightMap {
    let measured: Vec<f64> = raw.heights.iter().copied().filter(|h| h.is_finite()).collect();
    let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
    HeightMap {
        heights: raw.heights.mapv(|h| if h.is_finite() { (h - mean) as f32 } else { f32::NAN }),
        pitch_x: raw.pitch_x,
        pitch_y: raw.pitch_y,
        edges,
        removed_slopes: [0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn a_ramp_with_gaps_far_from_zero_is_removed() {
        let (p, q) = (0.013, -0.007);
        let mut heights =
            Array2::from_shape_fn((37, 53), |(r, c)| 0.0763 + p * (c as f64 * 2e-6) - q * (r as f64 * 3e-6));
        heights[[3, 4]] = f64::NAN;
        heights[[30, 50]] = f64::INFINITY;
        let raw = RawMap { heights, pitch_x: 2e-6, pitch_y: 3e-6, format: "test", notes: vec![] };
        let map = level(&raw, Edges::Open).unwrap();
        assert!((map.removed_slopes[0] - p).abs() < 1e-9);
        assert!((map.removed_slopes[1] - q).abs() < 1e-9);
        assert!(map.heights.iter().all(|h| h.is_nan() || h.abs() < 1e-15));
        assert_eq!(map.heights.iter().filter(|h| h.is_nan()).count(), 2);
    }

    #[test]
    fn a_single_line_of_points_is_refused() {
        let mut heights = Array2::from_elem((5, 5), f64::NAN);
        heights.row_mut(2).fill(1.0);
        let raw = RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
        assert!(level(&raw, Edges::Open).is_err());
    }
}
