#![forbid(unsafe_code)]
//! asperity

pub mod archive;
pub mod chart;
pub mod cli;
pub mod error;
pub mod facets;
pub mod heightmap;
pub mod math;
pub mod meter;
pub mod model;
pub mod npy;
pub mod optics;
pub mod output;
pub mod render;
pub mod report;
pub mod sample;
pub mod scatter;
pub mod table;

pub use error::{Error, Result};
