//! Least-squares sphere of a map.

use super::RawMap;
use crate::error::{Error, Result};
use crate::math::least_squares::NormalEquations;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

/// A fitted sphere, for people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sphere {
    /// Radius \[m\]: positive for a dome, negative for a bowl.
    #[serde(rename = "radius_m")]
    pub radius: f64,
    /// Position of the centre from the middle of the map, along x and y \[m\].
    #[serde(rename = "centre_m")]
    pub centre: [f64; 2],
}

impl fmt::Display for Sphere {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.radius > 0.0 { "dome" } else { "bowl" };
        write!(f, "{kind} of radius {:.6} mm", self.radius.abs() * 1e3)
    }
}

/// A sphere through `(0, 0, a)` with slopes `p, q` there: `k t^2 + t = s`, `s = p x + q y - k r^2`, `t = h - a`.
///
/// Solved, `t = 2 s / (1 + sqrt(1 + 4 k s))`. With `m = sqrt(1 + p^2 + q^2)` the radius is `m / (2 k)`. Unlike centre and
/// radius these four stay finite when the cap becomes flat (`k = 0`), so the fit never runs away.
#[derive(Debug, Clone, Copy)]
struct Cap {
    a: f64,
    p: f64,
    q: f64,
    k: f64,
}

impl Cap {
    /// Height above `a` and `sqrt(1 + 4 k s)`; NaN beyond the edge of the sphere.
    #[inline]
    fn height(&self, x: f64, y: f64) -> (f64, f64) {
        let s = self.p * x + self.q * y - self.k * (x * x + y * y);
        let root = (1.0 + 4.0 * self.k * s).sqrt();
        (2.0 * s / (1.0 + root), root)
    }
}

/// Where the samples are, in units of half the longer side, from the middle of the map.
#[derive(Clone, Copy)]
struct Frame {
    length: f64,
    reference: f64,
    step: [f64; 2],
    middle: [f64; 2],
}

impl Frame {
    #[inline]
    fn xy(&self, r: usize, c: usize) -> (f64, f64) {
        ((c as f64 - self.middle[0]) * self.step[0], (self.middle[1] - r as f64) * self.step[1])
    }
}

/// A fitted sphere, ready to be evaluated row by row.
pub struct SphereFit {
    cap: Cap,
    frame: Frame,
}

/// Gauss-Newton stops when no parameter moves by more than this, in units of half the map's longer side.
const SMALLEST_STEP: f64 = 1e-13;

/// It also stops when a step lowers the sum of squares by less than this share.
const SMALLEST_GAIN: f64 = 1e-12;

/// `(x - x0)^2 + (y - y0)^2 + (h - z0)^2 = R^2`, minimising the squared vertical residual over the measured points.
///
/// Starts from the algebraic fit `k (r^2 + h^2) + h = a + p x + q y`, linear in its four unknowns (Kasa 1976 for circles)
/// and exact for a perfect sphere, then iterates by Gauss and Newton with halved steps where needed.
///
/// # Errors
/// `Error::Parameter` if the measured points do not determine a sphere.
pub fn fit(raw: &RawMap) -> Result<SphereFit> {
    let (rows, columns) = raw.heights.dim();
    let length = 0.5 * (raw.pitch_x * (columns - 1) as f64).max(raw.pitch_y * (rows - 1) as f64);
    let frame = Frame {
        length,
        reference: raw.heights.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0),
        step: [raw.pitch_x / length, raw.pitch_y / length],
        middle: [(columns - 1) as f64 / 2.0, (rows - 1) as f64 / 2.0],
    };
    let undetermined = || {
        Error::parameter(
            "the measured points do not determine a sphere",
            "remove a plane or a polynomial instead, with --form plane or --form poly:2",
        )
    };
    let (algebraic, _) = accumulate(raw, &frame, |x, y, h| Some(([1.0, x, y, -(x * x + y * y + h * h)], h)));
    let found = algebraic.solve().ok_or_else(undetermined)?;
    let (constant, p, q, k) = (found[0], found[1], found[2], found[3]);
    // The height `a` above the middle of the map solves k a^2 + a = constant; then the middle becomes the origin of t.
    let mut cap = if 1.0 + 4.0 * k * constant > 0.0 {
        let root = (1.0 + 4.0 * k * constant).sqrt();
        Cap { a: 2.0 * constant / (1.0 + root), p: p / root, q: q / root, k: k / root }
    } else {
        Cap { a: constant, p, q, k: 0.0 }
    };
    let (mut equations, mut cost) = linearise(raw, &frame, &cap);
    for _ in 0..50 {
        let step = equations.solve().ok_or_else(undetermined)?;
        let (mut share, before) = (1.0, cost);
        let moved = loop {
            let trial = Cap {
                a: cap.a + share * step[0],
                p: cap.p + share * step[1],
                q: cap.q + share * step[2],
                k: cap.k + share * step[3],
            };
            let (next, next_cost) = linearise(raw, &frame, &trial);
            if next_cost <= cost {
                (cap, equations, cost) = (trial, next, next_cost);
                break true;
            }
            share *= 0.5;
            if share < 1e-3 {
                break false;
            }
        };
        if !moved || cost > (1.0 - SMALLEST_GAIN) * before || step.iter().all(|s| s.abs() < SMALLEST_STEP) {
            break;
        }
    }
    Ok(SphereFit { cap, frame })
}

/// Normal equations of one Gauss-Newton step and the sum of squared residuals.
fn linearise(raw: &RawMap, frame: &Frame, cap: &Cap) -> (NormalEquations, f64) {
    accumulate(raw, frame, |x, y, h| {
        let (t, root) = cap.height(x, y);
        // Beyond the edge of the sphere a point says nothing about how to move it; near the edge its derivative is huge.
        (root > 1e-3).then(|| ([1.0, x / root, y / root, -(x * x + y * y + t * t) / root], h - cap.a - t))
    })
}

/// Sums the equations of all measured points; a point without an equation costs as much as its height squared.
fn accumulate(
    raw: &RawMap,
    frame: &Frame,
    equation: impl Fn(f64, f64, f64) -> Option<([f64; 4], f64)> + Sync,
) -> (NormalEquations, f64) {
    /// Rows a task; fixed, so that rounding does not depend on the number of threads.
    const BLOCK: usize = 64;
    let (rows, _) = raw.heights.dim();
    let parts: Vec<(NormalEquations, f64)> = (0..rows.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let (mut equations, mut cost) = (NormalEquations::new(4), 0.0);
            for r in block * BLOCK..((block + 1) * BLOCK).min(rows) {
                for (c, h) in raw.heights.row(r).iter().enumerate().filter(|p| p.1.is_finite()) {
                    let (x, y) = frame.xy(r, c);
                    let h = (h - frame.reference) / frame.length;
                    match equation(x, y, h) {
                        Some((row, residual)) => {
                            equations.add(&row, residual);
                            cost += residual * residual;
                        }
                        None => cost += 1.0 + h * h,
                    }
                }
            }
            (equations, cost)
        })
        .collect();
    let (mut equations, mut cost) = (NormalEquations::new(4), 0.0);
    for (part, c) in &parts {
        equations.merge(part);
        cost += c;
    }
    (equations, cost)
}

impl SphereFit {
    /// Heights \[m\] of row `r` of the map; NaN beyond the edge of the sphere.
    pub fn heights_of_row(&self, r: usize, out: &mut [f64]) {
        let f = &self.frame;
        for (c, out) in out.iter_mut().enumerate() {
            let (x, y) = f.xy(r, c);
            *out = f.reference + f.length * (self.cap.a + self.cap.height(x, y).0);
        }
    }

    /// Radius and centre; `None` if the cap is exactly flat.
    pub fn sphere(&self) -> Option<Sphere> {
        let Cap { p, q, k, .. } = self.cap;
        let m = (1.0 + p * p + q * q).sqrt();
        let radius = self.frame.length * m / (2.0 * k);
        // The unit normal at the middle of the map is (-p, -q, 1) / m; the centre lies R below along it.
        radius.is_finite().then(|| Sphere { radius, centre: [p, q].map(|slope| radius * slope / m) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// A cap of signed radius `radius` whose centre is `centre` away from the middle of the map.
    fn cap(radius: f64, centre: [f64; 2], noise: f64) -> RawMap {
        let heights = Array2::from_shape_fn((121, 81), |(r, c)| {
            let (x, y) = ((c as f64 - 40.0) * 2e-6 - centre[0], (60.0 - r as f64) * 3e-6 - centre[1]);
            if (r + 2 * c) % 19 == 0 {
                return f64::NAN;
            }
            // A checkerboard is orthogonal to anything smooth.
            let board = noise * if (r + c) % 2 == 0 { 1.0 } else { -1.0 };
            0.01 + (radius.powi(2) - x * x - y * y).sqrt().copysign(radius) + board
        });
        RawMap { heights, pitch_x: 2e-6, pitch_y: 3e-6, format: "test", notes: vec![] }
    }

    #[test]
    fn radius_and_centre_of_caps_from_a_half_ball_to_a_lens() {
        // Steep, flat, dome, bowl, and with the apex off the map.
        for (radius, centre) in [
            (250e-6, [10e-6, -20e-6]),
            (-300e-6, [0.0, 0.0]),
            (5e-3, [300e-6, 100e-6]),
            (-0.2, [0.0, 1e-3]),
            (3.0, [0.0, 0.0]),
        ] {
            let raw = cap(radius, centre, 0.0);
            let fit = fit(&raw).unwrap();
            let found = fit.sphere().unwrap();
            // The heights carry an offset of R + 10 mm, whose rounding limits how well the sag is known.
            let sag = 180e-6f64.powi(2) / (2.0 * radius.abs());
            let tolerance = 1e-11 + 20.0 * f64::EPSILON * (radius.abs() + 0.01) / sag;
            assert!((found.radius / radius - 1.0).abs() < tolerance, "{radius}: {found:?}");
            for (c, truth) in found.centre.iter().zip(centre) {
                assert!((c - truth).abs() < tolerance * radius.abs().max(1e-3), "{radius}: {found:?}");
            }
            let mut row = vec![0.0; 81];
            for (r, heights) in raw.heights.outer_iter().enumerate() {
                fit.heights_of_row(r, &mut row);
                for (h, f) in heights.iter().zip(&row).filter(|p| p.0.is_finite()) {
                    assert!((h - f).abs() < 8.0 * f64::EPSILON * (radius.abs() + 0.01), "{radius}: {}", h - f);
                }
            }
        }
    }

    #[test]
    fn roughness_does_not_bias_the_radius() {
        // Sag 8 um, roughness 0.1 um; the algebraic fit alone would be drawn towards a smaller radius.
        let found = fit(&cap(2e-3, [0.0, 0.0], 1e-7)).unwrap().sphere().unwrap();
        assert!((found.radius / 2e-3 - 1.0).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn a_plane_is_a_sphere_without_end_and_a_line_none() {
        let heights = Array2::from_shape_fn((50, 60), |(r, c)| 1e-8 * c as f64 - 3e-8 * r as f64);
        let mut raw = RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
        let radius = fit(&raw).unwrap().sphere().map_or(f64::INFINITY, |s| s.radius.abs());
        assert!(radius > 1e3, "{radius}");
        raw.heights.fill(f64::NAN);
        raw.heights.row_mut(7).fill(0.0);
        assert!(fit(&raw).is_err());
    }
}
