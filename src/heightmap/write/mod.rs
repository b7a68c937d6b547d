//! Writers, one file each. All of them write heights in metres and keep missing points missing.

pub mod npy;
pub mod x3p;
