//! Floor 5: the BRDF as formulas. One file per model; its head is the model's reference page.
//!
//! A model is written `name:key=value,key=value`, for example `beckmann:alpha=0.02,n=1.5`. To add one: a file
//! with the formula and an [`Entry`], and one line in [`MODELS`]. A [`Definition`] is a model with its parameters before
//! it is built: what a fit varies. Colour builds a text once per wavelength: [`parse`]; the texts `material:NAME` and
//! `layered:COAT,over=BASE` are understood too ([`library`], [`layered`]).

mod albedo;
pub mod beard_maxwell;
pub mod beckmann;
pub mod blinn_dusty;
pub mod bounded;
pub mod cook_torrance;
mod definition;
pub mod facet_normals;
pub mod floor;
pub mod ggx;
pub mod he_torrance;
pub mod lafortune;
pub mod lambert;
pub mod layered;
pub mod library;
pub mod metallic;
pub mod microfacet;
pub mod minnaert;
pub mod nef_bm;
pub mod oren_nayar;
pub mod parameter;
pub mod phong;
mod poisson_series;
pub mod poulin_fournier;
mod registry;
pub mod smooth;
pub mod ward;
pub mod zero_bistatic;

pub use albedo::CosineTable;
pub use beard_maxwell::BeardMaxwell;
pub use beckmann::Beckmann;
pub use bounded::Bounded;
pub use definition::{Definition, Values};
pub use floor::WithFloor;
pub use ggx::Ggx;
pub use he_torrance::HeTorrance;
pub use lafortune::Lafortune;
pub use lambert::Lambert;
pub use layered::Layered;
pub use parameter::{Absent, Parameter, Scale, Unit, Word};
pub use phong::Phong;
pub use registry::{Entry, entry, is_model, parse, parse_with};
pub use smooth::Smooth;
pub use ward::Ward;

/// Every model of the library, in the order `asperity models` prints them.
pub static MODELS: &[&Entry] = &[
    &lambert::ENTRY,
    &minnaert::ENTRY,
    &oren_nayar::ENTRY,
    &phong::ENTRY,
    &lafortune::ENTRY,
    &ward::ENTRY,
    &cook_torrance::ENTRY,
    &beckmann::ENTRY,
    &ggx::ENTRY,
    &he_torrance::ENTRY,
    &poulin_fournier::ENTRY,
    &blinn_dusty::ENTRY,
    &beard_maxwell::ENTRY,
    &nef_bm::ENTRY,
    &metallic::ENTRY,
    &smooth::MIRROR,
    &smooth::DIELECTRIC,
    &smooth::CONDUCTOR,
];
