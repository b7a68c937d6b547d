#![forbid(unsafe_code)]
//! asperity

pub mod error;
pub mod heightmap;
pub mod math;
pub mod optics;
pub mod output;
pub mod render;

pub use error::{Error, Result};
