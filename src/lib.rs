#![forbid(unsafe_code)]
//! asperity

pub mod archive;
pub mod error;
pub mod heightmap;
pub mod math;
pub mod npy;
pub mod optics;
pub mod output;

pub use error::{Error, Result};
