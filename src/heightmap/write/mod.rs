//! Writers, one file each.
