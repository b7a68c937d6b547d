#![forbid(unsafe_code)]
//! asperity

pub mod archive;
pub mod error;
pub mod facets;
pub mod heightmap;
pub mod math;
pub mod npy;
pub mod meter;
pub mod model;
pub mod optics;
pub mod output;
pub mod render;
pub mod sample;
pub mod scatter;
pub mod table;

pub use error::{Error, Result};
