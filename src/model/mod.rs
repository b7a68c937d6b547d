//! Floor 5: the BRDF as formulas. One file per model; its head is the model's reference page.
//!
//! A model is written `name:key=value,key=value`, for example `beckmann:alpha=0.02,n=1.5`. To add one: a file
//! with the formula and an [`Entry`], and one line in [`MODELS`]. A [`Definition`] is a model with its parameters before
//! it is built: what a fit varies, and what colour builds once per wavelength.

mod albedo;
pub mod beard_maxwell;
pub mod beckmann;
pub mod bounded;
mod definition;
pub mod facet_normals;
pub mod floor;
pub mod ggx;
pub mod lambert;
pub mod microfacet;
pub mod nef_bm;
pub mod parameter;
pub mod phong;
mod registry;
pub mod smooth;
pub mod ward;
pub mod zero_bistatic;

pub use beard_maxwell::BeardMaxwell;
pub use beckmann::Beckmann;
pub use bounded::Bounded;
pub use definition::{Definition, Values};
pub use floor::WithFloor;
pub use ggx::Ggx;
pub use lambert::Lambert;
pub use parameter::{Absent, Parameter, Scale, Unit, Word};
pub use phong::Phong;
pub use registry::{Entry, entry, is_model, parse};
pub use smooth::Smooth;
pub use ward::Ward;

/// Every model of the library, in the order `asperity models` prints them.
pub static MODELS: &[&Entry] = &[
    &lambert::ENTRY,
    &smooth::MIRROR,
    &smooth::DIELECTRIC,
    &smooth::CONDUCTOR,
    &beckmann::ENTRY,
    &ggx::ENTRY,
    &phong::ENTRY,
    &ward::ENTRY,
    &beard_maxwell::ENTRY,
    &nef_bm::ENTRY,
];
