//! Height maps from a formula: the calibration artefacts of the whole chain.

mod brushed;
mod defects;
mod shapes;
mod spectral;

pub use brushed::{Brushed, brushed};
pub use defects::{Defects, add_defects};
pub use shapes::{cap, ramp, sawtooth, sinusoid};
pub use spectral::{Decay, Gaussian, Rough, gaussian, rough};

use super::RawMap;
use crate::error::{Error, Result};
use ndarray::Array2;

/// Grid and sampling of a synthetic map.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Samples along x.
    pub width: usize,
    /// Samples along y.
    pub height: usize,
    /// Sampling distance along x and y \[m\].
    pub pitch: [f64; 2],
}

/// A length \[m\] for a message: micrometres with six digits.
fn micrometres(length: f64) -> String {
    let rounded = format!("{:.5e}", length * 1e6);
    format!("{} um", rounded.parse().unwrap_or(length * 1e6))
}

fn check_grid(grid: Grid) -> Result<()> {
    if grid.width < 2 || grid.height < 2 || grid.width.saturating_mul(grid.height) > 1 << 30 {
        return Err(Error::parameter(
            format!("a map of {} x {} points cannot be made", grid.width, grid.height),
            "choose --size between 2 and 32768",
        ));
    }
    if !grid.pitch.iter().all(|p| p.is_finite() && *p > 0.0) {
        return Err(Error::parameter(
            format!("pitch {:?} m is not positive", grid.pitch),
            "give --pitch with a unit, for example 0.5um",
        ));
    }
    Ok(())
}

fn map_of(grid: Grid, heights: Array2<f64>) -> RawMap {
    RawMap { heights, pitch_x: grid.pitch[0], pitch_y: grid.pitch[1], format: "synthetic", notes: Vec::new() }
}
