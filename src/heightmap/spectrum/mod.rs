//! How the roughness is spread over wavelengths and directions: power spectrum and autocorrelation.

mod autocorrelation;
mod power;
mod real_transform;

pub use autocorrelation::Autocorrelation;
pub use power::{RadialBin, Spectrum};
