//! Readers and writers of height maps against real files, a conformance set, hostile bytes and round trips.

mod collection;
mod conformance;
mod formulas;
mod handmade;
mod hostile;
mod real;
mod round_trip;

use asperity::heightmap::RawMap;
use asperity::heightmap::read::{ReadOptions, read};
use std::path::PathBuf;

/// Where the shared collection of height maps is, if it is there.
fn shared_folder() -> PathBuf {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    folder.join("heightmaps")
}

/// A file of the shared collection, or `None` with a loud line if the collection is not there.
fn shared(name: &str) -> Option<PathBuf> {
    let path = shared_folder().join(name);
    if !path.exists() {
        eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder that holds heightmaps/", path.display());
        return None;
    }
    Some(path)
}

/// Reads a shared file that must be readable.
fn read_shared(name: &str) -> Option<RawMap> {
    read_shared_with(name, &ReadOptions::default())
}

fn read_shared_with(name: &str, options: &ReadOptions) -> Option<RawMap> {
    // A build without HDF5 refuses these by design.
    if name.ends_with("datx") && !cfg!(feature = "datx") {
        return None;
    }
    Some(read(&shared(name)?, options).unwrap_or_else(|e| panic!("{e}")))
}

fn missing(map: &RawMap) -> usize {
    map.heights.iter().filter(|h| h.is_nan()).count()
}

/// Largest difference of the heights where both are measured; panics if the gaps differ.
fn largest_difference(a: &RawMap, b: &RawMap) -> f64 {
    assert_eq!(a.heights.dim(), b.heights.dim());
    let pairs = a.heights.iter().zip(&b.heights);
    assert!(pairs.clone().all(|(a, b)| a.is_nan() == b.is_nan()), "the gaps differ");
    pairs.filter(|(a, _)| !a.is_nan()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
