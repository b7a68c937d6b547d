//! Detectors: their geometry, what closed forms and other programs say reaches them, and where counting fails.

mod bounces;
mod closed_forms;
mod gaussian;
mod klems;
mod limits;
mod partitions;
mod parts;
mod plain_tracer;
mod profile;
mod published_maps;
#[path = "../reference/mod.rs"]
mod reference;
mod waves;

use asperity::facets::{HeightField, SlopeStatistics};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::optics::Material;
use asperity::scatter::bounce::Walk;
use asperity::scatter::{Counting, Counts, Options, Partition, Run, count};
use std::path::PathBuf;

/// A file of the shared collection, or `None` with a loud line if the collection is not there.
fn shared(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder that holds heightmaps/", path.display());
        return None;
    }
    Some(path)
}

/// A periodic Gaussian surface of unit pitch whose facets have the rms slope `slope` per axis.
fn gaussian(size: usize, acl: f64, slope: f64, seed: u64) -> HeightMap {
    surface(size, acl, slope, seed, true)
}

/// `exact`: the spectrum is the wanted one to the last wave, otherwise it scatters as that of any piece of a surface.
fn surface(size: usize, acl: f64, slope: f64, seed: u64, exact: bool) -> HeightMap {
    let grid = synth::Grid { width: size, height: size, pitch: [1.0; 2] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq: slope * acl, acl, seed, exact }).unwrap();
    let mut map = level::keep_tilt(&raw, Edges::Periodic);
    rescale(&mut map, slope);
    map
}

/// Stretches the heights to an rms slope of the facets, the mean over both axes.
fn rescale(map: &mut HeightMap, slope: f64) {
    let s = SlopeStatistics::measure(map).unwrap();
    let factor = (slope / (s.sdq / 2f64.sqrt())) as f32;
    map.heights.mapv_inplace(|h| h * factor);
}

/// Calls `look` with everything a beam needs to know of a map.
fn with_walk<T>(map: &HeightMap, material: Material, max_bounces: u32, look: impl FnOnce(&Walk) -> T) -> T {
    let field = HeightField::new(map);
    let steepest = SlopeStatistics::measure(map).unwrap().steepest;
    look(&Walk { field: &field, material, max_bounces, steepest })
}

/// Counts the whole map at one azimuth 0, or averaged.
fn counted(map: &HeightMap, options: &Options, partition: Partition, averaged: bool) -> Counts {
    let options = Options { phi_i: vec![0.0], ..options.clone() };
    let counting = Counting { partition, averaged };
    count(map, &options, &counting, &mut Run::Whole, &|_| ()).unwrap()
}
