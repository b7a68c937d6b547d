//! Floor 6: from numbers back to the parameters of a model: tables, measured lists, instrument readings, scans.

mod family;
mod levenberg;
mod search;
pub mod target;

pub use family::{Family, Free, Scale};
pub use levenberg::{LeastSquares, Minimum};
pub use search::{Search, multi_start};
