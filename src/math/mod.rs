//! Floor 0: directions, solid angles, random streams, statistics, quadrature.

pub mod fft;
pub mod frame;
pub mod quadrature;
pub mod random;
pub mod solid_angle;
pub mod statistics;

pub use frame::{direction, half_vector, reflect, slope_of_half_vector};
pub use statistics::Estimate;
