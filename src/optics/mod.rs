//! Floor 1: Fresnel reflectance, refractive indices and the [`Brdf`] doorway.

pub mod brdf;
pub mod colour;
pub mod fresnel;
pub mod material;

pub use brdf::{Brdf, BrdfSample};
pub use material::Material;
