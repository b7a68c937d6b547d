//! Areal parameters of ISO 25178-2:2012 from a levelled map.

mod gradient;
mod heights;
mod lanes;
mod texture;

pub use gradient::Gradient;
pub use heights::{Heights, sq};
pub use texture::{DECAY, Texture};
