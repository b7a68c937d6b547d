//! Writers, one file each. All of them write heights in metres and keep missing points missing.

pub mod npy;
pub mod png;
pub mod sdf;
pub mod x3p;
