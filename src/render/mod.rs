//! Floor 7: pictures of materials, path-traced.
//!
//! ```text
//! shape, paint ─► scene ─► integrator ─► film ─► picture (.exr, .png)
//!                 light      camera, stream        caption
//! tiles: one picture that compares materials side by side
//! ```
//! Lengths in metres, radiance in W/(m2 sr) per linear RGB channel, z up.

pub mod camera;
pub mod film;
pub mod integrator;
mod light;
pub mod paint;
pub mod scene;
pub mod shape;
mod stream;

pub use camera::Camera;
pub use film::{Film, Pixel};
pub use integrator::{RenderOptions, Strategy, render};
pub use paint::{Paint, Pattern};
pub use scene::{Material, Scene};
pub use shape::{Quad, Ray, Shape, Sphere};
