//! Flags that say how to read and prepare a height map.

use super::quantity;
use crate::error::{Error, Result};
use crate::heightmap::read::{ReadOptions, read};
use crate::heightmap::{Edges, HeightMap, level};
use clap::{Args, ValueEnum};
use std::path::Path;

#[derive(Args, Clone, Debug)]
pub struct MapOptions {
    /// Sampling distance for files that carry none: 0.5um, or X,Y
    #[arg(long, value_parser = quantity::pitch, value_name = "LENGTH")]
    pitch: Option<[f64; 2]>,
    /// Unit of the heights for files that carry none: m, mm, um, nm
    #[arg(long, value_parser = quantity::length_unit)]
    unit: Option<f64>,
    /// Layer of a file with several, from 0
    #[arg(long)]
    layer: Option<usize>,
    /// Heights of black and white in a picture of integers: LOW,HIGH
    #[arg(long, value_parser = quantity::height_range, value_name = "LOW,HIGH", allow_hyphen_values = true)]
    height_range: Option<[f64; 2]>,
    /// What lies beyond the border; periodic only for maps made so
    #[arg(long, value_enum, default_value_t = EdgesFlag::Open)]
    edges: EdgesFlag,
    /// Keep the tilt instead of removing the least-squares plane
    #[arg(long)]
    keep_tilt: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum EdgesFlag {
    Open,
    Mirrored,
    Periodic,
}

impl MapOptions {
    /// Reads and levels one map.
    pub fn load(&self, path: &Path) -> Result<HeightMap> {
        let MapOptions { pitch, unit, layer, height_range, .. } = *self;
        let raw = read(path, &ReadOptions { pitch, unit, layer, height_range })?;
        let edges = match self.edges {
            EdgesFlag::Open => Edges::Open,
            EdgesFlag::Mirrored => Edges::Mirrored,
            EdgesFlag::Periodic => Edges::Periodic,
        };
        if self.keep_tilt {
            return Ok(level::keep_tilt(&raw, edges));
        }
        level::level(&raw, edges).map_err(|e| match e {
            Error::Parameter { what, advice } => Error::content(path, what, advice),
            other => other,
        })
    }
}
