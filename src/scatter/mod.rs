//! Floor 4: how the facets scatter: detectors, tallies, the facet sum and the naive rays.

pub mod accumulator;
pub mod axis;
pub mod bounce;
pub mod cells;
pub mod choice;
pub mod detectors;
pub mod facet_sum;
pub mod facing;
pub mod hats;
pub mod rays;
pub mod rings;
pub mod selection;
pub mod slope_histogram;
pub mod tally;

pub use accumulator::Accumulator;
pub use cells::HalfVectorCells;
pub use choice::{Decision, Method, Options, Scatter, Symmetry, scatter};
pub use detectors::{Detectors, Partition};
pub use selection::{Footprint, Part, Selection};
pub use tally::Tally;
