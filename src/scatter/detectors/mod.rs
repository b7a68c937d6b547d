//! Into what the hemisphere of exit directions is cut to be counted.

mod equal_angle;
mod equal_area;
mod half_vector;
mod klems;
mod partition;
mod rings;
mod shirley_chiu;

pub use partition::Partition;
pub use rings::Rings;
pub use shirley_chiu::ShirleyChiu;

use super::cells::HalfVectorCells;
use glam::DVec3;

/// A partition of the upper hemisphere: every direction above the surface belongs to exactly one detector.
///
/// Directions are unit vectors in the frame of the map, or in that of the source (`phi_i = 0`) when the run averages over
/// azimuth.
pub trait Detectors: Sync {
    /// Number of detectors.
    fn len(&self) -> usize;

    /// Never true: a hemisphere has at least one part.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Detector that `wo` reaches when the source is at `wi`; both above the surface.
    fn index(&self, wi: DVec3, wo: DVec3) -> usize;

    /// The cells of a partition by half vector. In them a facet's slope alone names the detector of its own reflection,
    /// whatever `wi`, and exactly flat facets are kept apart as the specular core.
    #[inline]
    fn slope_cells(&self) -> Option<&HalfVectorCells> {
        None
    }

    /// `integral of cos(theta_r) dw` over the detector \[sr\]; over all detectors the sum is pi.
    fn projected_solid_angle(&self, index: usize, wi: DVec3) -> f64;

    /// The smallest box in theta and phi that holds the detector.
    fn bounds(&self, index: usize) -> Bounds;
}

/// Angles \[rad\] that hold a detector; `phi` may start below zero so that `phi[0] < phi[1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub theta: [f64; 2],
    pub phi: [f64; 2],
}
