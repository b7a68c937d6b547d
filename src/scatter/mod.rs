//! Floor 4: how the facets scatter: detectors, tallies, the facet sum and the naive rays.

pub mod axis;
pub mod bounce;
pub mod cells;
pub mod choice;
pub mod decision;
pub mod facet_sum;
pub mod facing;
pub mod hats;
pub mod kirchhoff;
pub mod rays;
pub mod rings;
pub mod slope_histogram;
pub mod tally;

pub use cells::HalfVectorCells;
pub use choice::{Method, Options, Scatter, Symmetry, scatter};
pub use decision::Decision;
pub use tally::Tally;
