//! Least-squares polynomial of a map, in Legendre's basis.

use super::RawMap;
use crate::error::{Error, Result};
use crate::math::least_squares::NormalEquations;
use rayon::prelude::*;
use serde::Serialize;

/// Highest total degree that can be fitted.
pub const HIGHEST_DEGREE: u8 = 12;

/// Rows whose sums one task adds up; fixed, so that rounding does not depend on the number of threads.
const BLOCK: usize = 64;

/// One term `coefficient * P_i(u) P_j(v)`.
///
/// `u`, `v` run from -1 to 1 over the columns (towards +x) and rows (towards +y) that hold measured points; `P` are
/// Legendre's polynomials. The constant is relative to the first measured point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Term {
    /// Degree along x.
    pub i: u8,
    /// Degree along y.
    pub j: u8,
    /// Coefficient \[m\].
    #[serde(rename = "coefficient_m")]
    pub coefficient: f64,
}

/// Legendre's polynomials of degree 0 to `degree` on the samples of one axis.
struct Axis {
    /// `values[k]`: `P_k` at every sample.
    values: Vec<Vec<f64>>,
}

impl Axis {
    /// The coordinate is -1 at `first`, 1 at `last` and `sign` tells which way it grows.
    fn new(samples: usize, [first, last]: [usize; 2], sign: f64, degree: usize) -> Self {
        let (middle, half) = ((first + last) as f64 / 2.0, ((last - first) as f64 / 2.0).max(0.5));
        let u: Vec<f64> = (0..samples).map(|k| sign * (k as f64 - middle) / half).collect();
        let mut values = vec![vec![1.0; samples], u.clone()];
        for k in 2..=degree {
            // Bonnet: k P_k = (2k - 1) u P_(k-1) - (k - 1) P_(k-2).
            let (n, next) = (k as f64, (0..samples));
            values.push(
                next.map(|s| ((2.0 * n - 1.0) * u[s] * values[k - 1][s] - (n - 1.0) * values[k - 2][s]) / n).collect(),
            );
        }
        values.truncate(degree + 1);
        Axis { values }
    }
}

/// A fitted polynomial, ready to be evaluated row by row.
pub struct Polynomial {
    /// `(i, j)` of every term.
    exponents: Vec<(usize, usize)>,
    coefficients: Vec<f64>,
    reference: f64,
    x: Axis,
    y: Axis,
}

/// `h ~ sum_(i+j <= degree) c_ij P_i(u) P_j(v)`, minimising the squared residual over the measured points.
///
/// Legendre's basis on the rectangle of measured points keeps the normal equations well conditioned: on a full map they
/// are nearly diagonal. Missing points only drop out of the sums. Cost: `degree + 1` products per point.
///
/// # Errors
/// `Error::Parameter` if the degree is above [`HIGHEST_DEGREE`] or the measured points do not determine all terms.
pub fn fit(raw: &RawMap, degree: u8) -> Result<Polynomial> {
    if degree > HIGHEST_DEGREE {
        return Err(Error::parameter(
            format!("a polynomial of degree {degree} is not offered"),
            format!("choose a degree from 0 to {HIGHEST_DEGREE}; for shorter waves use --l-filter"),
        ));
    }
    let degree = usize::from(degree);
    let undetermined = || {
        Error::parameter(
            format!("the measured points do not determine a polynomial of degree {degree}"),
            "choose a lower degree, or crop to where the map is measured with --region",
        )
    };
    let (rows, columns) = raw.heights.dim();
    let (across, down) = extent(raw).ok_or_else(undetermined)?;
    let x = Axis::new(columns, across, 1.0, degree);
    let y = Axis::new(rows, down, -1.0, degree);
    let exponents: Vec<(usize, usize)> = (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| (i, j))).collect();
    let reference = raw.heights.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    let full = products(&x, (0..columns).map(|c| (c, 1.0)));

    let parts: Vec<NormalEquations> = (0..rows.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut equations = NormalEquations::new(exponents.len());
            let mut heights = vec![0.0; columns];
            for r in block * BLOCK..((block + 1) * BLOCK).min(rows) {
                let mut gaps = Vec::new();
                for (c, (to, h)) in heights.iter_mut().zip(raw.heights.row(r)).enumerate() {
                    *to = if h.is_finite() { h - reference } else { 0.0 };
                    if !h.is_finite() {
                        gaps.push(c);
                    }
                }
                if gaps.len() < columns {
                    add_row(&mut equations, &exponents, &x, &y, r, &heights, &gaps, &full);
                }
            }
            equations
        })
        .collect();
    let mut equations = NormalEquations::new(exponents.len());
    parts.iter().for_each(|p| equations.merge(p));
    let coefficients = equations.solve().ok_or_else(undetermined)?;
    Ok(Polynomial { exponents, coefficients, reference, x, y })
}

/// Adds one row: its sums along x are separated from the polynomials along y, which are constant in it.
#[expect(clippy::too_many_arguments, reason = "the row, the basis and where they go")]
fn add_row(
    equations: &mut NormalEquations,
    exponents: &[(usize, usize)],
    x: &Axis,
    y: &Axis,
    r: usize,
    heights: &[f64],
    gaps: &[usize],
    full: &[f64],
) {
    let n = x.values.len();
    let moments: Vec<f64> = x.values.iter().map(|p| dot(p, heights)).collect();
    let gram = if gaps.is_empty() {
        full.to_vec()
    } else if 2 * gaps.len() < heights.len() {
        let mut gram = products(x, gaps.iter().map(|c| (*c, -1.0)));
        gram.iter_mut().zip(full).for_each(|(g, f)| *g += f);
        gram
    } else {
        let mut next = gaps.iter().peekable();
        products(x, (0..heights.len()).map(|c| (c, if next.next_if(|g| **g == c).is_some() { 0.0 } else { 1.0 })))
    };
    for (s, (i, a)) in exponents.iter().enumerate() {
        let ya = y.values[*a][r];
        equations.add_right(s, moments[*i] * ya);
        for (t, (j, b)) in exponents[..=s].iter().enumerate() {
            equations.add_entry(s, t, gram[i * n + j] * ya * y.values[*b][r]);
        }
    }
}

/// `sum_c w_c P_i(u_c) P_j(u_c)` for all `i, j`.
fn products(axis: &Axis, weighted: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
    let n = axis.values.len();
    let mut gram = vec![0.0; n * n];
    for (c, w) in weighted.filter(|p| p.1 != 0.0) {
        for i in 0..n {
            let pi = w * axis.values[i][c];
            for j in 0..=i {
                gram[i * n + j] += pi * axis.values[j][c];
            }
        }
    }
    for i in 0..n {
        for j in i + 1..n {
            gram[i * n + j] = gram[j * n + i];
        }
    }
    gram
}

/// First and last column and row with a measured point.
fn extent(raw: &RawMap) -> Option<([usize; 2], [usize; 2])> {
    let (mut across, mut down): (Option<[usize; 2]>, Option<[usize; 2]>) = (None, None);
    for (r, row) in raw.heights.outer_iter().enumerate() {
        let Some(first) = row.iter().position(|h| h.is_finite()) else { continue };
        let last = row.iter().rposition(|h| h.is_finite()).unwrap_or(first);
        across = Some(across.map_or([first, last], |[a, b]| [a.min(first), b.max(last)]));
        down = Some(down.map_or([r, r], |[a, _]| [a, r]));
    }
    across.zip(down)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in ca.zip(cb) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

impl Polynomial {
    /// Heights \[m\] of row `r` of the map.
    pub fn heights_of_row(&self, r: usize, out: &mut [f64]) {
        let mut along_x = vec![0.0; self.x.values.len()];
        for ((i, j), c) in self.exponents.iter().zip(&self.coefficients) {
            along_x[*i] += c * self.y.values[*j][r];
        }
        out.fill(self.reference);
        for (c, values) in along_x.iter().zip(&self.x.values) {
            for (out, value) in out.iter_mut().zip(values) {
                *out += c * value;
            }
        }
    }

    /// All terms, by degree along x, then y.
    pub fn terms(&self) -> Vec<Term> {
        self.exponents
            .iter()
            .zip(&self.coefficients)
            .map(|(&(i, j), &coefficient)| Term { i: i as u8, j: j as u8, coefficient })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// A sum of monomials, an offset of 76 mm and a map with ragged gaps.
    fn raw(degree: i32, measured: impl Fn(usize, usize) -> bool) -> RawMap {
        let heights = Array2::from_shape_fn((90, 131), |(r, c)| {
            let (x, y) = (c as f64 / 130.0, (89 - r) as f64 / 89.0);
            let mut sum = 0.0;
            for i in 0..=degree {
                for j in 0..=degree - i {
                    sum += f64::from((i * 3 + j * 5) % 7 - 3) * x.powi(i) * y.powi(j);
                }
            }
            if measured(r, c) { 0.076 + 1e-6 * sum } else { f64::NAN }
        });
        RawMap { heights, pitch_x: 1e-6, pitch_y: 2e-6, format: "test", notes: vec![] }
    }

    fn largest_residual(raw: &RawMap, degree: u8) -> f64 {
        let found = fit(raw, degree).unwrap();
        let mut row = vec![0.0; raw.heights.ncols()];
        let mut worst = 0.0f64;
        for (r, heights) in raw.heights.outer_iter().enumerate() {
            found.heights_of_row(r, &mut row);
            for (h, f) in heights.iter().zip(&row).filter(|p| p.0.is_finite()) {
                worst = worst.max((h - f).abs());
            }
        }
        worst
    }

    #[test]
    fn a_polynomial_is_removed_to_rounding_whatever_is_missing() {
        // 1.4e-17 m is one ulp of the offset.
        for degree in [0, 1, 2, 4, 8, 12] {
            let whole = raw(degree, |_, _| true);
            assert!(largest_residual(&whole, degree as u8) < 2e-16, "degree {degree}");
            let ragged = raw(degree, |r, c| (r * 7 + c * 11) % 13 != 0 && !(20..40).contains(&r));
            assert!(largest_residual(&ragged, degree as u8) < 2e-16, "ragged, degree {degree}");
            let round = raw(degree, |r, c| ((r as f64 - 30.0) / 25.0).hypot((c as f64 - 80.0) / 45.0) < 1.0);
            assert!(largest_residual(&round, degree as u8) < 1e-14, "round, degree {degree}");
        }
        assert!(largest_residual(&raw(4, |_, _| true), 3) > 1e-9);
    }

    #[test]
    fn coefficients_of_a_product_of_legendre_polynomials() {
        // P_2(u) P_1(v), u and v from -1 to 1 across the map, v growing upward.
        let heights = Array2::from_shape_fn((41, 61), |(r, c)| {
            let (u, v) = (c as f64 / 30.0 - 1.0, 1.0 - r as f64 / 20.0);
            (1.5 * u * u - 0.5) * v
        });
        let raw = RawMap { heights, pitch_x: 1.0, pitch_y: 1.0, format: "test", notes: vec![] };
        let offset = raw.heights[[0, 0]];
        for term in fit(&raw, 3).unwrap().terms() {
            let expected = match (term.i, term.j) {
                (2, 1) => 1.0,
                (0, 0) => -offset,
                _ => 0.0,
            };
            assert!((term.coefficient - expected).abs() < 1e-13, "{term:?}");
        }
    }

    #[test]
    fn too_few_points_or_too_high_a_degree_is_refused() {
        let line = raw(1, |r, _| r == 40);
        assert!(fit(&line, 1).is_err() && fit(&line, 0).is_ok());
        let two_columns = raw(1, |_, c| c == 3 || c == 90);
        assert!(fit(&two_columns, 1).is_ok() && fit(&two_columns, 2).is_err());
        assert!(fit(&line, 13).is_err());
        assert!(fit(&raw(1, |_, _| false), 1).is_err());
    }
}
