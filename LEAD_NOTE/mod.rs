//! Floor 9: time against accuracy of everything that can be done in more than one way.
//!
//! ```text
//! contests (scattering, tables, sampling, meters, pictures)
//!    each: references, methods with their ladders of effort ─► race ─► measured points ─► CSV, JSON, charts
//! ```
//! A method or a reference is added in one place: the list in the file of its contest.

pub mod budgets;
pub mod choices;
mod contests;
mod machine;
mod meters;
mod pictures;
mod race;
mod sampling;
pub mod scaling;
mod scattering;
mod tables;
mod write;

pub use contests::{Subject, contests, default_map};
pub use machine::Machine;
pub use race::{Aggregate, Contest, Method, Outcome, Point, Reference, race};
pub use write::{as_csv, as_json, panels, scatter_panels};
