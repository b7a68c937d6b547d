//! Small files of each format put together byte by byte from the format descriptions, not by our writers.

mod containers;
mod instruments;
mod texts;

pub use containers::*;
pub use instruments::*;
pub use texts::*;

use asperity::heightmap::read::ReadOptions;

/// 3 rows of 4 points; row 0 is the top row and the third point of the second row is missing.
pub const RAW: [[i32; 4]; 3] = [[10, -20, 30, 40], [50, 60, i32::MAX, -80], [90, 100, 110, 3]];

/// HDF5 files of 4 x 3 points as Zygo Mx lays them out, written by h5py: f64 nm, contiguous; and deflated, shuffled chunks
/// of 2 x 3 in fringes of 300 nm. The decoy `{A}` comes before the surface that the graph names.
#[cfg(feature = "datx")]
pub const DATX: [&[u8]; 2] =
    [include_bytes!("../fixtures/nanometers.datx"), include_bytes!("../fixtures/fringes_deflated.datx")];

/// The points row by row as floats.
pub fn floats(missing: f64) -> impl Iterator<Item = f64> {
    RAW.iter().flatten().map(move |&v| if v == i32::MAX { missing } else { f64::from(v) })
}

/// A valid file, what its reader needs to be told, and the formula that gives the heights [m] and pitches [m].
pub struct Sample {
    pub name: &'static str,
    pub file: Vec<u8>,
    pub options: ReadOptions,
    pub unit: f64,
    pub offset: f64,
    pub pitch: [f64; 2],
    /// What stands where the point is missing, if the format knows no missing points.
    pub instead: Option<f64>,
}

/// One file per format and variant.
pub fn samples() -> Vec<Sample> {
    let none = ReadOptions::default();
    let nanometres = ReadOptions { unit: Some(1e-9), pitch: Some([2e-6, 3e-6]), ..none };
    // Level 200 is 0 m, one level 1 nm.
    let levels = ReadOptions { height_range: Some([-200e-9, 65335e-9]), pitch: Some([2e-6, 3e-6]), ..none };
    let fringe = 0.5 * 600e-9;
    let sample = |name, file, options, unit, offset| Sample {
        name,
        file,
        options,
        unit,
        offset,
        pitch: [2e-6, 3e-6],
        instead: None,
    };
    let square = |s: Sample| Sample { pitch: [2e-6, 2e-6], ..s };
    let filled = |s: Sample| Sample { instead: Some(120.0), ..s };
    let npy = |bytes: Vec<u8>| sample("npy", bytes, nanometres, 1e-9, 0.0);
    vec![
        square(sample("MetroPro", metropro(0), none, fringe / 32768.0, 0.0)),
        square(sample("MetroPro negated", metropro(1), none, -fringe / 32768.0, 0.0)),
        sample("Wyko", wyko(), none, 600e-9 / 300.0, 0.0),
        sample("x3p", x3p(), none, 1e-9, 5e-9),
        sample("x3p as text", x3p_text(), none, 1e-9, 5e-9),
        npy(asperity::npy::encode(&[3, 4], floats(f64::NAN))),
        npy(asperity::npy::encode(&[3, 4], floats(f64::INFINITY).map(|v| v as f32))),
        sample("npz", npz(), nanometres, 1e-9, 0.0),
        sample("sur", sur(false), none, 1e-9, 5e-9),
        sample("sur compressed", sur(true), none, 1e-9, 5e-9),
        sample("sdf", sdf_binary(), none, 1e-9, 0.0),
        sample("sdf as text", sdf(), none, 1e-9, 0.0),
        sample("al3d", al3d(4), none, 1e-9, 0.0),
        sample("plu", plu(), ReadOptions { layer: Some(1), ..none }, 1e-9, 0.0),
        filled(sample("nms", nms(), none, 1e-9, 2000e-9)),
        sample("bcrf", bcrf(true), none, 1e-9, 0.0),
        sample("bcr", bcrf(false), none, 2e-9, 0.0),
        Sample { instead: Some(7.0), ..sample("gwy", gwy([7.0, 3.0]), none, 1e-9, 0.0) },
        #[cfg(feature = "datx")]
        sample("datx", DATX[0].to_vec(), none, 1e-9, 0.0),
        #[cfg(feature = "datx")]
        sample("datx in fringes", DATX[1].to_vec(), none, fringe, 0.0),
        sample("text", gwyddion_matrix(), none, 1e-9, 0.0),
        sample("csv", csv(), nanometres, 1e-9, 0.0),
        sample("xyz", triples(), ReadOptions { unit: Some(1e-9), ..none }, 1e-9, 0.0),
        square(sample("Zygo xyz", zygo_xyz(), none, 1e-9, 0.0)),
        square(sample("Zygo ASCII", zygo_ascii(), none, fringe / 32768.0, 0.0)),
        sample("png", png(), levels, 1e-9, 0.0),
        sample("tiff", tiff(true), nanometres, 1e-9, 0.0),
        filled(sample("tiff of integers", tiff(false), levels, 1e-9, 0.0)),
        sample("exr", exr(), nanometres, 1e-9, 0.0),
    ]
}
