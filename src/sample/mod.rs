//! Floor 6: drawing directions.

pub mod alias;
pub mod audit;
mod azimuths;
mod draw;
mod grid;
mod hats;
mod lookup;
pub mod reciprocal;
pub mod rivals;
mod run;
mod slabs;
mod slots;
mod sources;
pub mod table_brdf;

pub use alias::AliasTable;
pub use audit::{Audit, audit};
pub use reciprocal::Reciprocal;
pub use table_brdf::TableBrdf;
