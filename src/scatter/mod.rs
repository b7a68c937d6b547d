//! Floor 4: how a surface scatters: facet sum, naive rays, phase integral; detectors, tallies, and the choice of method.

pub mod accumulator;
pub mod axis;
pub mod beam;
pub mod bounce;
pub mod cells;
pub mod choice;
pub mod count;
mod count_wave;
pub mod decision;
pub mod detectors;
pub mod facet_sum;
pub mod facing;
pub mod first_bounces;
pub mod hats;
pub mod kirchhoff;
pub mod lanes;
mod ratio;
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
pub use choice::{Method, Options, Scatter, Symmetry, scatter, scatter_run};
pub use count::{Counting, Counts, count};
pub use decision::Decision;
pub use detectors::{Detectors, Partition};
pub use kirchhoff::Wave;
pub use run::{Run, Sums};
pub use selection::{Footprint, Part, Selection};
pub use tally::Tally;
pub use warning::Warning;
