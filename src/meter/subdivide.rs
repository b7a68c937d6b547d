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
use std::f64::consts::{PI, TAU};

/// Nodes per axis of the two Gauss rules whose difference is a cell's error.
const RULES: [usize; 2] = [3, 5];

/// Shells about the mirror direction before anything is looked at, each a third of the one outside it: 3.6 deg become
/// 0.0005 deg.
const SHELLS: i32 = 8;
const RATIO: f64 = 1.0 / 3.0;

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
    let found = cubature(outer, vec![Block::WHOLE], rules, (1.0 - INNER) * tolerance, MOST_CELLS[1]);
    Estimate { standard_error: found.standard_error + inner_error * source.projected_solid_angle(), ..found }
}

/// Direction at `at` in the unit square and `dw / (ds dt)`. A rectangle is stretched; a disc is cut across, by the sine of an
/// angle, so that its rim is no edge to the rules.
fn spread(stop: &Stop, [s, t]: [f64; 2]) -> (DVec3, f64) {
    let [a, b] = stop.shape().half_tangents();
    let (point, area) = match stop.shape() {
        Shape::Rectangle(_) => ([(2.0 * s - 1.0) * a, (2.0 * t - 1.0) * b], 4.0 * a * b),
        Shape::Disc(_) => {
            let (sin, cos) = (PI * (s - 0.5)).sin_cos();
            ([a * sin, a * cos * (2.0 * t - 1.0)], TAU * (a * cos).powi(2))
        }
    };
    let w = stop.direction(point);
    (w, area * w.dot(stop.axes()[0]).powi(3))
}

/// The point of the unit square nearest to the direction `w`: the inverse of [`spread`].
fn place(stop: &Stop, w: DVec3) -> [f64; 2] {
    let [axis, along, across] = stop.axes();
    let z = w.dot(axis).max(1e-3);
    let [a, b] = stop.shape().half_tangents();
    let (x, y) = (w.dot(along) / z / a, w.dot(across) / z / b);
    match stop.shape() {
        Shape::Rectangle(_) => [0.5 + 0.5 * x, 0.5 + 0.5 * y],
        Shape::Disc(_) => {
            let angle = x.clamp(-1.0, 1.0).asin();
            [0.5 + angle / PI, 0.5 + 0.5 * y / angle.cos().max(1e-9)]
        }
    }
    .map(|u| u.clamp(0.0, 1.0))
}

/// A rectangular cell of the unit square.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Block {
    low: [f64; 2],
    high: [f64; 2],
}

impl Block {
    const WHOLE: Block = Block { low: [0.0; 2], high: [1.0; 2] };

    fn quarters(self) -> [Block; 4] {
        let Block { low: [x0, y0], high: [x2, y2] } = self;
        let (x1, y1) = (0.5 * (x0 + x2), 0.5 * (y0 + y2));
        [[x0, y0, x1, y1], [x1, y0, x2, y1], [x0, y1, x1, y2], [x1, y1, x2, y2]]
            .map(|[a, b, c, d]| Block { low: [a, b], high: [c, d] })
    }
}

/// The square cut at `centre`, every part in shells that shrink towards it.
fn graded(centre: [f64; 2]) -> Vec<Block> {
    let mut blocks = Vec::new();
    for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        // From the centre to a share of the way to the corner, along one axis.
        let at = |axis: usize, share: f64| centre[axis] + share * (corner[axis] - centre[axis]);
        let mut block = |x: [f64; 2], y: [f64; 2]| {
            let (x, y) = (x.map(|s| at(0, s)), y.map(|s| at(1, s)));
            let low = [x[0].min(x[1]), y[0].min(y[1])];
            let high = [x[0].max(x[1]), y[0].max(y[1])];
            if high[0] > low[0] && high[1] > low[1] {
                blocks.push(Block { low, high });
            }
        };
        for shell in 0..SHELLS {
            let (outer, inner) = (RATIO.powi(shell), RATIO.powi(shell + 1));
            block([inner, outer], [0.0, inner]);
            block([0.0, inner], [inner, outer]);
            block([inner, outer], [inner, outer]);
        }
        let last = RATIO.powi(SHELLS);
        block([0.0, last], [0.0, last]);
    }
    blocks
}

/// A cell with its integral and the difference of the two rules; the heap hands out the worst.
struct Cell {
    block: Block,
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
    start: Vec<Block>,
    rules: &Rules,
    tolerance: f64,
    most: usize,
) -> Estimate {
    let mut look = |block: Block| {
        let size = [0, 1].map(|k| block.high[k] - block.low[k]);
        let mut by_rule = [0.0; 2];
        for (sum, rule) in by_rule.iter_mut().zip(rules) {
            for &(x, wx) in rule {
                for &(y, wy) in rule {
                    let at = |k: usize, c: f64| block.low[k] + 0.5 * size[k] * (1.0 + c);
                    *sum += wx * wy * f([at(0, x), at(1, y)]);
                }
            }
        }
        let [rough, value] = by_rule.map(|sum| 0.25 * size[0] * size[1] * sum);
        Cell { block, value, error: (value - rough).abs() }
    };
    let mut heap: BinaryHeap<Cell> = start.into_iter().map(&mut look).collect();
    let mut error: f64 = heap.iter().map(|c| c.error).sum();
    // A NaN from the surface ends the loop as well.
    while error > tolerance && heap.len() < most {
        let Some(worst) = heap.pop() else { break };
        for quarter in worst.block.quarters().map(&mut look) {
            error += quarter.error;
            heap.push(quarter);
        }
        error -= worst.error;
    }
    let standard_error = heap.iter().map(|c| c.error).sum();
    Estimate { value: heap.iter().map(|c| c.value).sum(), standard_error }
}
