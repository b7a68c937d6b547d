//! Floor 7: pictures of materials, path-traced.
//!
//! ```text
//! description (.toml)
//!   shape, disc, mesh ─┐
//!   material, paint ───┼► scene ─► wave ─► film ─► picture (.exr, .png)
//!   light, environment ┘           camera, stream   caption
//! tiles: one picture that compares materials side by side
//! ```
//! Lengths in metres, radiance in W/(m2 sr) per linear RGB channel, z up.

pub mod camera;
pub mod caption;
pub mod description;
pub mod disc;
pub mod environment;
mod exposure;
pub mod exr_file;
pub mod film;
pub mod integrator;
pub mod letters;
mod light;
pub mod material;
pub mod mesh;
mod mesh_file;
pub mod metallic_paint;
pub mod paint;
pub mod picture;
mod rays;
mod reach;
pub mod revolution;
pub mod scene;
mod screens;
pub mod shape;
mod shares;
pub mod sheet;
mod solids;
pub mod spectral;
mod spot;
pub mod stage;
mod stream;
pub mod tiles;
mod triangle;
pub mod warning;
mod wave;

pub use camera::Camera;
pub use description::Description;
pub use disc::Disc;
pub use environment::Environment;
pub use exposure::{Rendering, Report, render_with_report};
pub use film::{Film, Pixel};
pub use integrator::{Estimator, RenderOptions, render};
pub use material::{Coat, Cover, Material, Reflector};
pub use mesh::Mesh;
pub use metallic_paint::MetallicPaint;
pub use paint::{Paint, Pattern};
pub use picture::{Picture, exr_bytes, save_exr};
pub use revolution::revolution;
pub use scene::Scene;
pub use shape::{Quad, Ray, Shape, Sphere};
pub use sheet::Sheet;
pub use spectral::Spectral;
pub use tiles::{Tile, TilesOptions, TilesPicture, render_tiles};
pub use warning::RenderWarning;
