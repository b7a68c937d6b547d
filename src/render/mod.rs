//! Floor 7: pictures of materials, path-traced.
//!
//! ```text
//! shape, paint ─► scene ─► integrator ─► film ─► picture (.exr, .png)
//!                 light      camera, stream        caption
//! tiles: one picture that compares materials side by side
//! ```
//! Lengths in metres, radiance in W/(m2 sr) per linear RGB channel, z up.

pub mod camera;
pub mod caption;
pub mod film;
pub mod integrator;
mod light;
pub mod paint;
pub mod picture;
pub mod scene;
pub mod shape;
mod stage;
mod stream;
pub mod tiles;

pub use camera::Camera;
pub use film::{Film, Pixel};
pub use integrator::{RenderOptions, Strategy, render};
pub use paint::{Paint, Pattern};
pub use picture::{Picture, exr_bytes, save_exr};
pub use scene::{Material, Scene};
pub use shape::{Quad, Ray, Shape, Sphere};
pub use tiles::{Tile, TilesOptions, TilesPicture, render_tiles};
