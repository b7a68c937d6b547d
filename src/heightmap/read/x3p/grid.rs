//! The pitch of an axis: stated if the axis is incremental, measured and tested if every coordinate is stored.

use super::main_xml::Axis;
use super::{NAME, corrupt};
use crate::error::Fault;
use std::ops::Range;

/// Which neighbour the axis steps to.
#[derive(Clone, Copy, PartialEq)]
pub enum Along {
    Row,
    Column,
}

/// A stored coordinate may stray from the regular grid by this share of the pitch (int16 coordinates are coarse).
const TOLERANCE: f64 = 0.01;

/// Sampling distance \[m\] of the layer `points`, rows of `columns` points; `None` if the file states none.
pub fn pitch(
    axis: &Axis,
    stored: &[f64],
    points: Range<usize>,
    columns: usize,
    along: Along,
) -> Result<Option<f64>, Fault> {
    if !axis.absolute {
        return Ok(axis.increment);
    }
    let stored = stored.get(points).ok_or_else(|| corrupt("coordinates are missing".to_owned()))?;
    let index = |i: usize| (if along == Along::Row { i % columns } else { i / columns }) as f64;
    // Least squares through the points that have a coordinate.
    let known = || stored.iter().enumerate().filter(|(_, c)| c.is_finite()).map(|(i, &c)| (index(i), c));
    let (mut n, mut mean_i, mut mean_c) = (0.0, 0.0, 0.0);
    for (i, c) in known() {
        n += 1.0;
        mean_i += i;
        mean_c += c;
    }
    (mean_i, mean_c) = (mean_i / n, mean_c / n);
    let (mut sxx, mut sxy) = (0.0, 0.0);
    for (i, c) in known() {
        sxx += (i - mean_i) * (i - mean_i);
        sxy += (i - mean_i) * (c - mean_c);
    }
    let step = sxy / sxx;
    let regular = step.is_finite()
        && step != 0.0
        && known().all(|(i, c)| (c - mean_c - step * (i - mean_i)).abs() <= TOLERANCE * step.abs());
    if !regular {
        let axis = if along == Along::Row { "x" } else { "y" };
        return Err(Fault::Unsupported {
            format: NAME,
            what: format!("a surface whose {axis} coordinates form no regular grid"),
            advice: "resample it to a regular grid and export it again".to_owned(),
        });
    }
    Ok(Some(step.abs() * axis.increment.unwrap_or(1.0)))
}
