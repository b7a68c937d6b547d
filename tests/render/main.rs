//! The renderer against closed forms, and the files it writes.

mod closed_forms;
mod materials;
mod tiles;
