//! `x y z` triples to a matrix: the coordinates must lie on a regular grid, in any order, with gaps.
//!
//! x grows with the column; y points up, so the largest y is row 0. All three are in the unit of the heights, unless
//! the user gives the pitch: then the coordinates only say which point is where.

use super::NAME;
use crate::error::Fault;
use crate::heightmap::RawMap;
use crate::heightmap::read::ReadOptions;
use ndarray::Array2;

/// A coordinate may be off its grid line by this share of the pitch.
const TOLERANCE: f64 = 0.05;
/// A grid may have this many times more places than there are points.
const MAX_GAPS: usize = 64;

pub fn to_map(values: &[f64], unit: f64, options: &ReadOptions) -> Result<RawMap, Fault> {
    let axis = |offset: usize| Lines::through(values.iter().skip(offset).step_by(3).copied());
    let irregular = || Fault::Unsupported {
        format: NAME,
        what: "three columns whose first two form no regular grid".to_owned(),
        advice: "resample the points to a regular grid".to_owned(),
    };
    let (x, y) = axis(0).zip(axis(1)).ok_or_else(irregular)?;
    let places = x.count.checked_mul(y.count).filter(|&n| n <= MAX_GAPS * (values.len() / 3));
    places.ok_or_else(irregular)?;
    let mut heights = Array2::from_elem((y.count, x.count), f64::NAN);
    for point in values.chunks_exact(3) {
        let (column, line) = (x.index(point[0]), y.index(point[1]));
        let place = heights.get_mut((y.count - 1 - line, column)).ok_or_else(irregular)?;
        *place = if point[2].is_finite() { point[2] * unit } else { f64::NAN };
    }
    let [pitch_x, pitch_y] = options.pitch.unwrap_or([x.step * unit, y.step * unit]);
    Ok(RawMap { heights, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// Equidistant grid lines along one axis.
struct Lines {
    first: f64,
    step: f64,
    count: usize,
}

impl Lines {
    /// The lines on which all coordinates lie; at least two.
    fn through(coordinates: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = coordinates.collect();
        if !sorted.iter().all(|c| c.is_finite()) {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let (&first, &last) = (sorted.first()?, sorted.last()?);
        // Every line occupied is the usual case and gives the best step; else the closest two are neighbours.
        let all_occupied = (last - first) / (sorted.len() - 1) as f64;
        let closest = sorted.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
        [all_occupied, closest].into_iter().find_map(|step| {
            let lines = Lines { first, step, count: ((last - first) / step).round() as usize + 1 };
            let fits = |c: &f64| ((c - first) / step - lines.index(*c) as f64).abs() <= TOLERANCE;
            (step.is_finite() && step > 0.0 && sorted.iter().all(fits)).then_some(lines)
        })
    }

    fn index(&self, coordinate: f64) -> usize {
        ((coordinate - self.first) / self.step).round() as usize
    }
}
