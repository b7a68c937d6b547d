//! Surfaces made of height maps: the same maps as the epoxy series that comes with the program, synthesised in memory.

use crate::error::Result;
use crate::heightmap::prepare::{Preparation, prepare};
use crate::heightmap::{parameters, synth};
use crate::optics::Material;
use crate::sample::TableBrdf;
use crate::scatter::{self, Options};
use crate::table::{Provenance, Table};

/// A map of `synth --sq SQ --acl 20um --size 1024 --pitch 0.6um --exact`.
#[derive(Debug, Clone, Copy)]
pub struct Map {
    /// Root-mean-square height \[m\].
    pub sq: f64,
    /// Of the random phases.
    pub seed: u64,
}

/// Autocorrelation length \[m\].
const ACL: f64 = 20e-6;
const GRID: synth::Grid = synth::Grid { width: 1024, height: 1024, pitch: [0.6e-6; 2] };
/// At which materials are looked up and rays are judged \[m\].
pub const WAVELENGTH: f64 = 550e-9;

/// The table of a map, by the method that the program chooses.
///
/// # Errors
/// `Error::Parameter` if the map cannot be made or scattered.
pub fn table(map: Map, material: Material, progress: &(dyn Fn(f64) + Sync)) -> Result<TableBrdf> {
    let surface = synth::Gaussian { sq: map.sq, acl: ACL, seed: map.seed, exact: true };
    let heights = prepare(synth::gaussian(GRID, surface)?, &Preparation::default())?.map;
    let sq = parameters::sq(&heights);
    let options = Options { material, ..Options::default() };
    let scattered = scatter::scatter(&heights, &options, progress)?;
    let provenance = Provenance {
        source: format!("synthetic, Sq {:.0} nm", sq * 1e9),
        sq,
        sdq: parameters::Gradient::measure(&heights).sdq,
        missing_fraction: 0.0,
        wavelength: WAVELENGTH,
        method: options.method,
        seed: options.seed,
        program: concat!("asperity ", env!("CARGO_PKG_VERSION")).to_owned(),
    };
    TableBrdf::new(Table::from_scatter(&scattered, provenance))
}
