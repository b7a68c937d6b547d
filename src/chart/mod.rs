//! Floor 8: charts as SVG text, drawn with plotters' shapes and no font library.

mod axis;
mod canvas;
pub mod gloss_roughness;

pub use gloss_roughness::{GlossPoint, gloss_vs_roughness};
