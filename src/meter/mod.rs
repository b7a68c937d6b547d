//! Floor 7: the virtual light meter.

pub mod facets;
pub mod geometry;
pub mod gloss;
mod grid;
mod overlap;
pub mod path;
mod plan;
mod slope_cells;
pub mod stop;
pub mod surface;
pub mod validity;

pub use facets::{Azimuths, FacetGloss, facet_gloss};
pub use geometry::Geometry;
pub use gloss::{Options, gloss};
pub use surface::surface_gloss;
pub use validity::{Warning, check_rays, rayleigh_parameter};
