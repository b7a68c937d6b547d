//! Which contests there are, and the surface they are held on.

use super::race::Contest;
use super::{meters, pictures, sampling, scattering, tables};
use crate::error::Result;
use crate::heightmap::{Edges, HeightMap, level, synth};
use crate::optics::Material;
use crate::sample::TableBrdf;
use crate::scatter::{self, Method, Options};
use crate::table::{Provenance, Table};

/// The surface, and from where it is lit.
pub struct Subject<'a> {
    pub name: &'a str,
    pub map: &'a HeightMap,
    pub material: Material,
    /// Incident polar angle of the contest between scattering methods \[rad\].
    pub theta_i: f64,
    pub bounces: u32,
    pub wave: scatter::Wave,
    pub seed: u64,
}

/// The map that the time budgets are stated for, in a smaller piece: Gaussian, Sq 0.8 um, autocorrelation length 10 um, pitch
/// 0.5 um (Sdq 0.16), repeated at its edges.
///
/// # Errors
/// None for a `side` that memory holds.
pub fn default_map(side: usize) -> Result<HeightMap> {
    let grid = synth::Grid { width: side, height: side, pitch: [0.5e-6; 2] };
    let surface = synth::Gaussian { sq: 0.8e-6, acl: 10e-6, seed: 1, exact: true };
    Ok(level::keep_tilt(&synth::gaussian(grid, surface)?, Edges::Periodic))
}

/// The table of the subject as `asperity brdf` makes it.
pub(super) fn table(subject: &Subject, tolerance: f64, method: Method) -> Result<TableBrdf> {
    let options = Options {
        method,
        material: subject.material,
        bounces: subject.bounces,
        wave: subject.wave,
        seed: subject.seed,
        tolerance,
        ..Options::default()
    };
    let scattered = scatter::scatter(subject.map, &options, &|_| ())?;
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default()))
}

/// Builds a contest: its references are computed here, which takes time.
pub type Builder = for<'a> fn(&'a Subject<'a>, &'a TableBrdf) -> Result<Contest<'a>>;

/// Name and builder of every contest.
pub fn contests() -> [(&'static str, Builder); 5] {
    [
        ("scattering", scattering::contest),
        ("tables", tables::contest),
        ("sampling", sampling::contest),
        ("meters", meters::contest),
        ("pictures", pictures::contest),
    ]
}

impl Subject<'_> {
    /// The table that the contests draw from, at the default tolerance.
    ///
    /// # Errors
    /// `Error::Parameter` for a map without facets.
    pub fn table(&self) -> Result<TableBrdf> {
        table(self, Options::default().tolerance, Method::Geometric)
    }
}
