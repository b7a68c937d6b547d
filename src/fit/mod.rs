//! Floor 6: from numbers back to the parameters of a model: tables, measured lists, instrument readings, scans.

mod brdf;
mod family;
mod levenberg;
mod observations;
pub mod protocol;
mod search;
pub mod target;
mod warning;

pub use crate::model::Scale;
pub use brdf::{Fitted, FittedParameter, Options, Residual, Weights, errors_from_repeats, fit};
pub use family::{Family, Free};
pub use levenberg::{LeastSquares, Minimum};
pub use observations::{Design, Observation, Observations};
pub use search::{Search, multi_start};
pub use warning::Warning;
