//! Floor 0: directions, solid angles, random streams, statistics, quadrature, least squares, units.

pub mod fft;
pub mod frame;
pub mod least_squares;
pub mod quadrature;
pub mod quantity;
pub mod random;
pub mod solid_angle;
pub mod statistics;

pub use frame::{direction, half_vector, reflect, slope_of_half_vector};
pub use statistics::Estimate;
