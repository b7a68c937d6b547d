#![forbid(unsafe_code)]
//! asperity

pub mod chart;
pub mod error;
pub mod heightmap;
pub mod math;
pub mod meter;
pub mod model;
pub mod optics;
pub mod output;

pub use error::{Error, Result};
