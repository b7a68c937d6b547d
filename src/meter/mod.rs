//! Floor 7: the virtual light meter.

pub mod appearance;
pub mod clarity;
pub mod correspondence;
mod description;
pub mod facets;
pub mod geometry;
pub mod gloss;
mod grid;
pub mod hemisphere;
pub mod instrument;
pub mod measure;
pub mod multi_angle;
mod overlap;
pub mod path;
mod plan;
pub mod ray_wave;
pub mod scan;
mod slope_cells;
pub mod standards;
pub mod stop;
mod subdivide;
pub mod surface;
pub mod validity;

pub use appearance::{Appearance, appearance};
pub use clarity::ImageClarity;
pub use facets::{Azimuths, FacetGloss, facet_gloss};
pub use geometry::Geometry;
pub use gloss::{Options, gloss};
pub use hemisphere::{Hemispherical, hemispherical};
pub use instrument::{Instrument, Receptor, Specimen, Standard};
pub use measure::Reading;
pub use multi_angle::{Colour, colours};
pub use scan::{Scan, ScanPoint, scan};
pub use stop::Shape;
pub use surface::surface_gloss;
pub use validity::{Holds, Warning, check_rays, check_waves, rayleigh_parameter};
