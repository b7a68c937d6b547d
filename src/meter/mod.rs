//! Floor 7: the virtual light meter.

mod flux;
pub mod geometry;
pub mod gloss;
mod grid;
mod overlap;
mod plan;
pub mod surface;
pub mod validity;

pub use geometry::Geometry;
pub use gloss::{Options, gloss};
pub use surface::surface_gloss;
pub use validity::{Warning, check_rays, rayleigh_parameter};
