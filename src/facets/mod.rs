//! Floor 3: the facets of a height map: slopes, their distribution, and who hides whom.

pub mod bends;
pub mod blocks;
pub mod crossing;
pub mod descent;
pub mod distribution;
pub mod ends;
pub mod ground;
pub mod lanes;
pub mod march;
pub mod packet;
pub mod radial;
pub mod row_sight;
pub mod sight;
pub mod slopes;
pub mod starts;
pub mod stride;
pub mod tiles;
pub mod trace;
pub mod visibility;

pub use distribution::SlopeStatistics;
pub use packet::{Packet, Strides};
pub use visibility::{HeightField, Hit, Ray};
