//! Floor 3: the facets of a height map: slopes, their distribution, and who hides whom.

pub mod distribution;
pub mod slopes;
pub mod visibility;

pub use distribution::SlopeStatistics;
pub use visibility::{HeightField, Hit, Ray};
