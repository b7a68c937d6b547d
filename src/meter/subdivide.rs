//! The meter integral by adaptive subdivision of both stops, as the light meter of Westlund, Meyer and Hunt did it.
//!
//! `Phi = int_S cos_theta_i [ int_R f_r(wi, wo) cos_theta_r dwo ] dwi`
//!
//! The source is subdivided until its sum is stable; for every point of it the receptor is. A plain subdivision never
//! finds a lobe that slips between its first points; here the receptor's cells shrink towards the mirror direction of the
//! source point from the start, so a lobe of a thousandth of a degree is met. Slower than half vectors
//! ([`super::gloss`]), but it draws nothing, learns nothing and knows nothing of the surface's own sampler: the check
//! of the other. Source: J. Res. NIST 107, 247 (2002), section 4.2.3.

use super::Options;
use super::instrument::Instrument;
use super::measure::Reading;
use super::path::Path;
use super::stop::{Shape, Stop};
use crate::error::Result;
use crate::math::quadrature::gauss_legendre;
use crate::math::{Estimate, reflect};
use crate::optics::Brdf;
use glam::DVec3;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// Nodes per axis of the two Gauss rules whose difference is a cell's error.
const RULES: [usize; 2] = [3, 5];

/// Halvings towards the mirror direction before anything is looked at: 3.6 deg become 0.001 deg.
const GRADING: u32 = 12;

/// Cells at which to give up: of the receptor for one point of the source, and of the source.
const MOST_CELLS: [usize; 2] = [800, 32];

/// Share of the tolerance that the receptors' integrals may take.
const INNER: f64 = 0.25;

impl Instrument {
    /// The same readings as [`Instrument::measure`] by adaptive subdivision. The error is the sum of the differences between
    /// two rules over all cells: a bound in practice, usually far too wide.
    ///
    /// # Errors
    /// As [`Instrument::measure`].
    pub fn subdivide(&self, brdf: &dyn Brdf, options: &Options) -> Result<Vec<Reading>> {
        let rules = RULES.map(gauss_legendre);
        self.readings_by(options, |paths, scale| {
            let tolerance = options.tolerance / (scale * paths.len() as f64);
            let mut sum = Estimate::exact(0.0);
            for path in paths {
                let core = path.core(|wi| brdf.specular_core(wi));
                let rest = flux(path, brdf, &rules, tolerance);
                sum = Estimate {
                    value: sum.value + scale * (core + rest.value),
                    // Not independent: the errors of the paths add.
                    standard_error: sum.standard_error + scale * rest.standard_error,
                };
            }
            sum
        })
    }
}

type Rules = [Vec<(f64, f64)>; 2];

/// Flux without the specular core, to `tolerance` [sr].
fn flux(path: &Path, brdf: &dyn Brdf, rules: &Rules, tolerance: f64) -> Estimate {
    let (source, receptor) = (path.source(), path.receptor());
    let inner_tolerance = INNER * tolerance / source.projected_solid_angle();
    let mut inner_error: f64 = 0.0;
    let outer = |at: [f64; 2]| {
        let (wi, solid_angle) = spread(source, at);
        if wi.z <= 0.0 {
            return 0.0;
        }
        let through = |at: [f64; 2]| {
            let (wo, solid_angle) = spread(receptor, at);
            if wo.z <= 0.0 { 0.0 } else { brdf.eval(wi, wo) * wo.z * solid_angle }
        };
        let start = graded(place(receptor, reflect(wi, DVec3::Z)));
        let inner = cubature(through, start, rules, inner_tolerance, MOST_CELLS[0]);
        inner_error = inner_error.max(inner.standard_error);
        inner.value * wi.z * solid_angle
    };
    let found = cubature(outer, vec![Square::WHOLE], rules, (1.0 - INNER) * tolerance, MOST_CELLS[1]);
    Estimate { standard_error: found.standard_error + inner_error * source.projected_solid_angle(), ..found }
}

/// Direction at `at` in the unit square and `dw / (ds dt)`: the sides of a rectangle, radius and turn of a disc.
fn spread(stop: &Stop, [s, t]: [f64; 2]) -> (DVec3, f64) {
    let [a, b] = stop.shape().half_tangents();
    let (point, area) = match stop.shape() {
        Shape::Rectangle(_) => ([(2.0 * s - 1.0) * a, (2.0 * t - 1.0) * b], 4.0 * a * b),
        Shape::Disc(_) => {
            let (sin, cos) = (TAU * t).sin_cos();
            ([a * s * cos, a * s * sin], TAU * a * a * s)
        }
    };
    let w = stop.direction(point);
    (w, area * w.dot(stop.axes()[0]).powi(3))
}

/// The point of the unit square nearest to the direction `w`: the inverse of [`spread`].
fn place(stop: &Stop, w: DVec3) -> [f64; 2] {
    let [axis, along, across] = stop.axes();
    let z = w.dot(axis).max(1e-3);
    let (x, y) = (w.dot(along) / z, w.dot(across) / z);
    let [a, b] = stop.shape().half_tangents();
    match stop.shape() {
        Shape::Rectangle(_) => [0.5 + 0.5 * x / a, 0.5 + 0.5 * y / b],
        Shape::Disc(_) => [x.hypot(y) / a, (y.atan2(x) / TAU).rem_euclid(1.0)],
    }
    .map(|u| u.clamp(0.0, 1.0))
}

/// A cell of the unit square.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Square {
    low: [f64; 2],
    side: f64,
}

impl Square {
    const WHOLE: Square = Square { low: [0.0; 2], side: 1.0 };

    fn quarters(self) -> [Square; 4] {
        let side = 0.5 * self.side;
        [[0.0, 0.0], [side, 0.0], [0.0, side], [side, side]]
            .map(|[x, y]| Square { low: [self.low[0] + x, self.low[1] + y], side })
    }

    fn holds(self, p: [f64; 2]) -> bool {
        (0..2).all(|k| p[k] >= self.low[k] && p[k] <= self.low[k] + self.side)
    }
}

/// Cells that shrink towards `centre`.
fn graded(centre: [f64; 2]) -> Vec<Square> {
    let (mut cells, mut innermost) = (Vec::new(), Square::WHOLE);
    for _ in 0..GRADING {
        let quarters = innermost.quarters();
        let next = quarters.iter().position(|q| q.holds(centre)).unwrap_or(0);
        cells.extend(quarters.iter().enumerate().filter(|(k, _)| *k != next).map(|(_, q)| *q));
        innermost = quarters[next];
    }
    cells.push(innermost);
    cells
}

/// A cell with its integral and the difference of the two rules; the heap hands out the worst.
struct Cell {
    square: Square,
    value: f64,
    error: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error.total_cmp(&other.error)
    }
}

/// Integral of `f` over the cells `start`, the worst of them quartered until the sum of their errors is below `tolerance` or
/// there are `most` of them.
fn cubature(
    mut f: impl FnMut([f64; 2]) -> f64,
    start: Vec<Square>,
    rules: &Rules,
    tolerance: f64,
    most: usize,
) -> Estimate {
    let mut look = |square: Square| {
        let mut by_rule = [0.0; 2];
        for (sum, rule) in by_rule.iter_mut().zip(rules) {
            for &(x, wx) in rule {
                for &(y, wy) in rule {
                    let at = [x, y].map(|c| 0.5 * square.side * (1.0 + c));
                    *sum += wx * wy * f([square.low[0] + at[0], square.low[1] + at[1]]);
                }
            }
        }
        let [rough, value] = by_rule.map(|sum| 0.25 * square.side * square.side * sum);
        Cell { square, value, error: (value - rough).abs() }
    };
    let mut heap: BinaryHeap<Cell> = start.into_iter().map(&mut look).collect();
    let mut error: f64 = heap.iter().map(|c| c.error).sum();
    // A NaN from the surface ends the loop as well.
    while error > tolerance && heap.len() < most {
        let Some(worst) = heap.pop() else { break };
        for quarter in worst.square.quarters().map(&mut look) {
            error += quarter.error;
            heap.push(quarter);
        }
        error -= worst.error;
    }
    let standard_error = heap.iter().map(|c| c.error).sum();
    Estimate { value: heap.iter().map(|c| c.value).sum(), standard_error }
}
