//! Floor 9: what a prediction says, for people and for programs.

pub mod csv;
mod detectors_csv;
pub mod html;
pub mod prediction;

pub use detectors_csv::detectors_csv;
pub use prediction::{Prediction, Settings, predict, predict_run};
