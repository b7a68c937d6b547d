//! The surface that is measured when no map is named, and what all families take from a map.

use crate::error::Result;
use crate::facets::{HeightField, SlopeStatistics};
use crate::heightmap::{Edges, HeightMap, level, parameters, synth};
use crate::optics::Material;
use crate::scatter::HalfVectorCells;
use crate::scatter::bounce::Walk;

/// Coating of every family.
pub const GLASS: Material = Material::Dielectric { n: 1.5 };
/// Its wavelength \[m\].
pub const WAVELENGTH: f64 = 550e-9;

/// The map of the budgets: Gaussian, periodic, Sq 0.8 um, autocorrelation length 10 um, pitch 0.5 um, so that Sdq is 0.16.
///
/// # Errors
/// `Error::Parameter` if `side` makes no grid.
pub fn budget_map(side: usize) -> Result<HeightMap> {
    gaussian(side, 0.5e-6, 0.8e-6, 10e-6, 1)
}

/// A Gaussian periodic map of exact Sq \[m\] and autocorrelation length \[m\].
///
/// # Errors
/// As [`budget_map`].
pub fn gaussian(side: usize, pitch: f64, sq: f64, acl: f64, seed: u64) -> Result<HeightMap> {
    let grid = synth::Grid { width: side, height: side, pitch: [pitch; 2] };
    let surface = synth::Gaussian { sq, acl, seed, exact: true };
    Ok(level::keep_tilt(&synth::gaussian(grid, surface)?, Edges::Periodic))
}

/// A map with what scattering needs of it.
pub struct Surface<'a> {
    pub map: &'a HeightMap,
    pub name: String,
    pub field: HeightField<'a>,
    pub statistics: SlopeStatistics,
    pub cells: HalfVectorCells,
}

impl<'a> Surface<'a> {
    /// Measures `map`.
    ///
    /// # Errors
    /// `Error::Parameter` for a map without facets.
    pub fn new(map: &'a HeightMap, name: &str) -> Result<Self> {
        let statistics = SlopeStatistics::measure(map)?;
        let cells = HalfVectorCells::for_lobe(&statistics, true, 0.01);
        Ok(Surface { map, name: name.to_owned(), field: HeightField::new(map), statistics, cells })
    }

    /// How beams walk on it.
    pub fn walk(&self) -> Walk<'_> {
        Walk { field: &self.field, material: GLASS, max_bounces: 8, steepest: self.statistics.steepest }
    }

    /// Name, size and roughness in a line.
    pub fn describe(&self) -> String {
        format!(
            "{}: {} x {} points, Sq {:.4} \u{b5}m, Sdq {:.4}, n = 1.5",
            self.name,
            self.map.width(),
            self.map.height(),
            1e6 * parameters::sq(self.map),
            self.statistics.sdq
        )
    }
}
