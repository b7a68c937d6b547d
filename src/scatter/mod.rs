//! Floor 4: how the facets scatter: detectors, tallies, the facet sum and the naive rays.

pub mod accumulator;
pub mod axis;
pub mod beam;
pub mod bounce;
pub mod cells;
pub mod choice;
pub mod count;
pub mod detectors;
pub mod facet_sum;
pub mod facing;
pub mod first_bounces;
pub mod hats;
pub mod lanes;
pub mod rays;
pub mod rings;
pub mod run;
pub mod selection;
pub mod slope_histogram;
pub mod spread;
pub mod tally;
pub mod warning;

pub use accumulator::Accumulator;
pub use cells::HalfVectorCells;
pub use choice::{Decision, Method, Options, Scatter, Symmetry, scatter, scatter_run};
pub use count::{Counting, Counts, count};
pub use detectors::{Detectors, Partition};
pub use run::{Run, Sums};
pub use selection::{Footprint, Part, Selection};
pub use tally::Tally;
pub use warning::Warning;
