//! Floor 5: the BRDF as formulas. One file per model; its head is the model's reference page.
//!
//! A model is written `name:key=value,key=value`, for example `beckmann:alpha=0.02,n=1.5`. To add one: a file
//! with the formula and an [`Entry`], and one line in [`MODELS`].

mod albedo;
pub mod beckmann;
pub mod floor;
pub mod ggx;
pub mod lambert;
pub mod microfacet;
pub mod phong;
mod registry;
pub mod smooth;
pub mod ward;

pub use beckmann::Beckmann;
pub use floor::WithFloor;
pub use ggx::Ggx;
pub use lambert::Lambert;
pub use phong::Phong;
pub use registry::{Arguments, Entry, Parameter, is_model, parse};
pub use smooth::Smooth;
pub use ward::Ward;

/// Every model of the library, in the order `asperity models` prints them.
pub static MODELS: &[Entry] = &[
    lambert::ENTRY,
    smooth::MIRROR,
    smooth::DIELECTRIC,
    smooth::CONDUCTOR,
    beckmann::ENTRY,
    ggx::ENTRY,
    phong::ENTRY,
    ward::ENTRY,
];
