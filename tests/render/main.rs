//! The renderer against closed forms, and the files it reads and writes.

mod closed_forms;
mod estimators;
mod materials;
mod scene_files;
mod tiles;
