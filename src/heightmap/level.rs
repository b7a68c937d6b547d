//! Removal of the least-squares plane.

use super::{Edges, HeightMap, RawMap};
use crate::error::{Error, Result};
use glam::{DMat3, DVec3};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

/// `h = offset + p x + q y`: the least-squares plane of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Slopes `(dh/dx, dh/dy)`.
    pub slopes: [f64; 2],
    /// Height of the first measured point \[m\]: all sums are relative to it, so that an offset costs no digits.
    reference: f64,
    /// Height above the reference at the centre of the map, and the rise per column and per row upward \[m\].
    centre: f64,
    steps: [f64; 2],
}

/// `h <- h - (a + b x + c y)`, the plane minimising the squared residual over the measured points.
///
/// Computed in f64 on centred coordinates, stored as f32: a map at 76 mm loses nothing but its offset. Needs no memory
/// beyond the result.
///
/// # Errors
/// `Error::Parameter` if fewer than three points are measured or they lie on a line.
pub fn level(raw: &RawMap, edges: Edges) -> Result<HeightMap> {
    let heights = raw.heights.as_standard_layout();
    let plane = fit_plane(heights.view(), [raw.pitch_x, raw.pitch_y])?;
    Ok(HeightMap {
        heights: subtract(heights.view(), &plane),
        pitch_x: raw.pitch_x,
        pitch_y: raw.pitch_y,
        edges,
        removed_slopes: plane.slopes,
    })
}

/// Levels a map again in place, for example after points were removed; adds to its `removed_slopes`.
///
/// # Errors
/// As [`level`].
pub fn level_again(map: &mut HeightMap) -> Result<()> {
    if !map.heights.is_standard_layout() {
        map.heights = map.heights.as_standard_layout().into_owned();
    }
    let plane = fit_plane(map.heights.view(), [map.pitch_x, map.pitch_y])?;
    let (rows, columns) = map.heights.dim();
    let Some(all) = map.heights.as_slice_mut() else { return Ok(()) };
    all.par_chunks_mut(columns).enumerate().for_each(|(r, row)| {
        let (y, x0) = (plane.steps[1] * upward(r, rows), centre(columns));
        for (c, h) in row.iter_mut().enumerate() {
            *h = residual(f64::from(*h), &plane, y, c as f64 - x0);
        }
    });
    map.removed_slopes = [0, 1].map(|k| map.removed_slopes[k] + plane.slopes[k]);
    Ok(())
}

/// The map as measured, with only its mean removed: for ramps and other surfaces whose tilt is meant.
pub fn keep_tilt(raw: &RawMap, edges: Edges) -> HeightMap {
    let (mut n, mut sum) = (0usize, 0.0);
    for h in raw.heights.iter().filter(|h| h.is_finite()) {
        n += 1;
        sum += h;
    }
    let mean = sum / n.max(1) as f64;
    HeightMap {
        heights: raw.heights.mapv(|h| if h.is_finite() { (h - mean) as f32 } else { f32::NAN }),
        pitch_x: raw.pitch_x,
        pitch_y: raw.pitch_y,
        edges,
        removed_slopes: [0.0, 0.0],
    }
}

/// Sums of one row over its measured points: `n, x, x^2, h, x h`.
type RowSums = [f64; 5];

/// The least-squares plane of the finite heights \[m\] of a grid with the given pitch along x and y \[m\].
///
/// One pass in f64 over heights of either precision. The sums of a row never depend on the number of threads.
///
/// # Errors
/// `Error::Parameter` if fewer than three points are measured or they lie on a line.
pub fn fit_plane<T: Copy + Into<f64> + Sync>(heights: ArrayView2<'_, T>, pitch: [f64; 2]) -> Result<Plane> {
    let (rows, columns) = heights.dim();
    let reference = heights.iter().map(|h| (*h).into()).find(|h: &f64| h.is_finite()).unwrap_or(0.0);
    let x0 = centre(columns);
    let full_xx = (0..columns).map(|c| (c as f64 - x0).powi(2)).sum::<f64>();
    let sums: Vec<RowSums> = (0..rows)
        .into_par_iter()
        .map(|r| {
            let row = heights.row(r);
            let owned;
            let row = match row.as_slice() {
                Some(slice) => slice,
                None => {
                    owned = row.to_vec();
                    &owned
                }
            };
            // One missing point spoils the plain sum, and only then is the careful loop needed.
            let [h, xh] = sums_of_full(row, reference, x0);
            if (h + xh).is_finite() { [columns as f64, 0.0, full_xx, h, xh] } else { sums_of_gappy(row, reference, x0) }
        })
        .collect();
    let mut matrix = [[0.0f64; 3]; 3];
    let mut right = [0.0f64; 3];
    for (r, [n, x, xx, h, xh]) in sums.into_iter().enumerate() {
        let y = upward(r, rows);
        matrix[0][0] += n;
        matrix[0][1] += x;
        matrix[0][2] += y * n;
        matrix[1][1] += xx;
        matrix[1][2] += y * x;
        matrix[2][2] += y * y * n;
        right[0] += h;
        right[1] += xh;
        right[2] += y * h;
    }
    let m = DMat3::from_cols(
        DVec3::new(matrix[0][0], matrix[0][1], matrix[0][2]),
        DVec3::new(matrix[0][1], matrix[1][1], matrix[1][2]),
        DVec3::new(matrix[0][2], matrix[1][2], matrix[2][2]),
    );
    let scale = matrix[0][0] * matrix[1][1] * matrix[2][2];
    let plane = m.inverse() * DVec3::from_array(right);
    if !(m.determinant() > 1e-12 * scale && plane.is_finite()) {
        return Err(Error::parameter(
            "the measured points do not span a plane",
            "measure again or mend the gaps in the instrument's software",
        ));
    }
    Ok(Plane {
        slopes: [plane.y / pitch[0], plane.z / pitch[1]],
        reference,
        centre: plane.x,
        steps: [plane.y, plane.z],
    })
}

/// The heights above the plane, missing where they were not finite.
fn subtract(heights: ArrayView2<'_, f64>, plane: &Plane) -> Array2<f32> {
    let (rows, columns) = heights.dim();
    let mut out = Array2::<f32>::zeros((rows, columns));
    if let (Some(from), Some(to)) = (heights.as_slice(), out.as_slice_mut()) {
        to.par_chunks_mut(columns).zip(from.par_chunks(columns)).enumerate().for_each(|(r, (to, from))| {
            let (y, x0) = (plane.steps[1] * upward(r, rows), centre(columns));
            for (c, (to, h)) in to.iter_mut().zip(from).enumerate() {
                *to = residual(*h, plane, y, c as f64 - x0);
            }
        });
    }
    out
}

#[inline(always)]
fn residual(h: f64, plane: &Plane, rise_y: f64, x: f64) -> f32 {
    let d = (h - plane.reference - plane.centre - plane.steps[0] * x - rise_y) as f32;
    if d.is_finite() { d } else { f32::NAN }
}

/// Index of the middle of `n` samples.
fn centre(n: usize) -> f64 {
    (n as f64 - 1.0) / 2.0
}

/// Position of row `r` along +y, in rows from the middle.
fn upward(r: usize, rows: usize) -> f64 {
    centre(rows) - r as f64
}

/// Independent partial sums, so that additions need not wait for each other.
const LANES: usize = 8;

/// `sum h` and `sum x h` of a row without gaps; not finite if there is one.
fn sums_of_full<T: Copy + Into<f64>>(row: &[T], reference: f64, x0: f64) -> [f64; 2] {
    let (mut sh, mut sxh) = ([0.0; LANES], [0.0; LANES]);
    let mut x: [f64; LANES] = std::array::from_fn(|k| k as f64 - x0);
    let chunks = row.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for k in 0..LANES {
            let h = chunk[k].into() - reference;
            sh[k] += h;
            sxh[k] += x[k] * h;
            x[k] += LANES as f64;
        }
    }
    for (k, h) in rest.iter().enumerate() {
        let h = (*h).into() - reference;
        sh[k] += h;
        sxh[k] += x[k] * h;
    }
    [sh.iter().sum(), sxh.iter().sum()]
}

/// All five sums of a row in which points are missing.
fn sums_of_gappy<T: Copy + Into<f64>>(row: &[T], reference: f64, x0: f64) -> RowSums {
    const NARROW: usize = LANES / 2;
    let mut sums = [[0.0; NARROW]; 5];
    for (k, chunk) in row.chunks(NARROW).enumerate() {
        for (lane, h) in chunk.iter().enumerate() {
            let h = (*h).into() - reference;
            let x = (k * NARROW + lane) as f64 - x0;
            let (w, h) = if h.is_finite() { (1.0, h) } else { (0.0, 0.0) };
            let terms = [w, w * x, w * x * x, h, x * h];
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum[lane] += term;
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(p: f64, q: f64) -> RawMap {
        let mut heights =
            Array2::from_shape_fn((37, 53), |(r, c)| 0.0763 + p * (c as f64 * 2e-6) - q * (r as f64 * 3e-6));
        heights[[3, 4]] = f64::NAN;
        heights[[30, 50]] = f64::INFINITY;
        RawMap { heights, pitch_x: 2e-6, pitch_y: 3e-6, format: "test", notes: vec![] }
    }

    #[test]
    fn a_ramp_with_gaps_far_from_zero_is_removed() {
        let (p, q) = (0.013, -0.007);
        let map = level(&tilted(p, q), Edges::Open).unwrap();
        assert!((map.removed_slopes[0] - p).abs() < 1e-9);
        assert!((map.removed_slopes[1] - q).abs() < 1e-9);
        assert!(map.heights.iter().all(|h| h.is_nan() || h.abs() < 1e-15));
        assert_eq!(map.heights.iter().filter(|h| h.is_nan()).count(), 2);
    }

    #[test]
    fn levelling_f32_in_place_and_a_transposed_layout_agree_with_levelling_f64() {
        let raw = tilted(0.01, 0.02);
        let map = level(&raw, Edges::Open).unwrap();
        let turned =
            RawMap { heights: raw.heights.t().as_standard_layout().into_owned().reversed_axes(), ..raw.clone() };
        assert!(!turned.heights.is_standard_layout());
        assert_eq!(level(&turned, Edges::Open).unwrap().heights.mapv(f32::to_bits), map.heights.mapv(f32::to_bits));

        let mut again = keep_tilt(&raw, Edges::Open);
        level_again(&mut again).unwrap();
        assert!((again.removed_slopes[0] - 0.01).abs() < 1e-8 && (again.removed_slopes[1] - 0.02).abs() < 1e-8);
        assert_eq!(again.missing_fraction(), map.missing_fraction());
        // Half an f32 ulp of the ramp's 3 um.
        assert!(again.heights.iter().all(|h| h.is_nan() || h.abs() < 3e-13));
    }

    #[test]
    fn the_plane_leaves_nothing_that_correlates_with_x_or_y() {
        // The normal equations themselves are the closed form: the residual is orthogonal to 1, x and y.
        let mut raw = tilted(0.0, 0.0);
        for ((r, c), h) in raw.heights.indexed_iter_mut() {
            *h = if (r * 7 + c * 3) % 11 == 0 { f64::NAN } else { ((r * r + 5 * c) % 17) as f64 };
        }
        let map = level(&raw, Edges::Open).unwrap();
        for moment in [|_: f64, _: f64| 1.0, |x: f64, _: f64| x, |_: f64, y: f64| y] {
            let sum: f64 = map
                .heights
                .indexed_iter()
                .filter(|(_, h)| !h.is_nan())
                .map(|((r, c), h)| moment(c as f64 - 26.0, 18.0 - r as f64) * f64::from(*h))
                .sum();
            assert!(sum.abs() < 0.02, "{sum}");
        }
    }

    #[test]
    fn a_single_line_of_points_is_refused() {
        let mut heights = Array2::from_elem((5, 5), f64::NAN);
        heights.row_mut(2).fill(1.0);
        let raw = RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
        assert!(level(&raw, Edges::Open).is_err());
    }
}
