//! Floor 9: what a prediction says, for people and for programs.

pub mod csv;
pub mod prediction;

pub use prediction::{Prediction, Settings, predict};
