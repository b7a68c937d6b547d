//! Floor 6: drawing directions.

pub mod alias;
mod slabs;
pub mod table_brdf;

pub use alias::AliasTable;
pub use table_brdf::TableBrdf;
