//! Detectors of equal projected solid angle.

use super::Rings;
use super::equal_angle::MOST;
use crate::error::{Error, Result};
use std::f64::consts::PI;

impl Rings {
    /// `count` detectors of `pi / count` each, nearly square: rings of the disc of direction cosines whose borders hold
    /// `k` detectors at `sin(theta) = sqrt(k / count)`, each ring about as wide as its sectors are long
    /// (Beckers and Beckers, Computational Geometry 45, 275, 2012).
    ///
    /// # Errors
    /// `Error::Parameter` if `count` is 0 or too large.
    pub fn equal_area(count: usize) -> Result<Self> {
        if count == 0 || count > MOST {
            return Err(Error::parameter(
                format!("{count} detectors of equal projected solid angle"),
                format!("give equal-area:N with N from 1 to {MOST}"),
            ));
        }
        // Detectors inside each ring border, from the horizon inwards.
        let mut inside = vec![count];
        loop {
            let k = inside[inside.len() - 1] as f64;
            let next = (k.sqrt() - PI.sqrt()).max(0.0).powi(2).round() as usize;
            inside.push(next);
            if next == 0 {
                break;
            }
        }
        inside.reverse();
        let sine2 = |k: usize| k as f64 / count as f64;
        let edges = inside[..inside.len() - 1].iter().map(|&k| sine2(k).sqrt().asin()).collect();
        Ok(Rings::new(edges, inside.windows(2).map(|w| w[1] - w[0]).collect()))
    }
}
