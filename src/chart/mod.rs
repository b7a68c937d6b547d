//! Floor 8: charts: SVG text drawn with plotters' shapes, and pages of pixels drawn with our own lines; no font library.

mod axis;
mod canvas;
mod colours;
mod curves;
pub mod facts;
mod fit_page;
pub mod gloss_roughness;
mod height_view;
mod inspection;
pub mod lobe;
pub mod panels;
mod plot;
mod raster;
pub mod ray_wave;
mod shapes;
mod slices;
mod units;

pub use curves::{parameter_chart, scan_chart};
pub use fit_page::fit_page;
pub use gloss_roughness::{GlossPoint, gloss_vs_roughness};
pub use height_view::height_preview;
pub use inspection::{PageNotes, inspection_page};
pub use raster::Raster;
pub use shapes::Drawing;
