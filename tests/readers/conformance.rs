//! The x3pio sample set: every kind of data an X3P file can hold, as binary and as XML text.

use crate::{largest_difference, missing, read_shared, read_shared_with, shared};
use asperity::Error;
use asperity::error::Fault;
use asperity::heightmap::read::{ReadOptions, read};

/// Heights [m] at (0, 0), (3, 7) and the last point of a layer, as x3pio reads them (before the Offset of axis Z).
struct Surface {
    name: &'static str,
    grid: (usize, usize),
    missing: usize,
    layer: usize,
    heights: [f64; 3],
    offset: f64,
}

const fn surface(
    name: &'static str,
    grid: (usize, usize),
    missing: usize,
    layer: usize,
    heights: [f64; 3],
    offset: f64,
) -> Surface {
    Surface { name, grid, missing, layer, heights, offset }
}

const PLACED: [f64; 3] = [1e-6, -3.9448808644495003e-7, -5.96956774928859e-7];
const SURFACES: &[Surface] = &[
    surface("surface", (200, 150), 180, 0, [9.999865867949641e-7, -3.944975378786924e-7, 2.9186966551485615e-7], 0.0),
    surface(
        "surface_int32",
        (120, 90),
        60,
        0,
        [1.0000000001052567e-6, -3.944880863192066e-7, -5.969567746523724e-7],
        0.0,
    ),
    surface("surface_placed", (120, 90), 0, 0, PLACED, 1.0),
    surface("surface_absolute_placed", (120, 90), 0, 0, PLACED, 1.0),
    surface("surface_layers", (160, 120), 0, 0, [1e-6, -3.9448808644495003e-7, 3.9347386130285633e-7], 0.0),
    surface(
        "surface_layers",
        (160, 120),
        0,
        2,
        [4.854002388493556e-7, -1.1069984533603568e-6, -2.651977381328298e-7],
        0.0,
    ),
    surface(
        "surface_extensions",
        (100, 80),
        0,
        0,
        [9.999999974752427e-7, -3.9448809729947243e-7, 6.532814609272464e-7],
        0.0,
    ),
];

#[test]
fn surfaces_have_exact_heights() {
    let folders = ["iso25178-72-2017", "iso25178-72-fdam1"];
    let mut read_files = 0;
    for s in SURFACES {
        for path in folders
            .iter()
            .flat_map(|f| ["binary", "xml"].map(|kind| (*f, kind)))
            .map(|(folder, kind)| format!("x3p-conformance/{folder}/{}_{kind}.x3p", s.name))
        {
            // The set does not have every combination.
            let legal = path.contains("fdam1") && !path.contains("extensions_xml");
            let legal =
                legal || path.ends_with("2017/surface_binary.x3p") || path.contains("2017/surface_extensions_b");
            if !legal {
                continue;
            }
            let options = ReadOptions { layer: Some(s.layer), ..Default::default() };
            let Some(map) = read_shared_with(&path, &options) else { continue };
            let (rows, columns) = map.heights.dim();
            assert_eq!((columns, rows), s.grid, "{path}");
            assert_eq!(missing(&map), s.missing, "{path}");
            assert!((map.pitch_x - 1e-6).abs() < 1e-15 && (map.pitch_y - 1e-6).abs() < 1e-15, "{path}");
            let found = [map.heights[[0, 0]], map.heights[[3, 7]], map.heights[[rows - 1, columns - 1]]];
            assert_eq!(found, s.heights.map(|h| h + s.offset), "{path}");
            read_files += 1;
        }
    }
    eprintln!("{read_files} readings of the conformance set compared");
}

#[test]
fn binary_and_text_give_the_same_map() {
    for name in ["surface", "surface_int32", "surface_placed", "surface_absolute_placed", "surface_layers"] {
        let path = |kind: &str| format!("x3p-conformance/iso25178-72-fdam1/{name}_{kind}.x3p");
        let (Some(binary), Some(text)) = (read_shared(&path("binary")), read_shared(&path("xml"))) else { continue };
        assert_eq!(largest_difference(&binary, &text), 0.0, "{name}");
    }
}

#[test]
fn what_is_no_regular_surface_is_refused_by_name() {
    for (name, says) in [
        ("profile", "a profile of 256 points"),
        ("profile_layers", "a profile of 256 points"),
        ("profile_int16", "a profile of 256 points"),
        ("profile_int32", "a profile of 256 points"),
        ("point_cloud", "a point cloud of 1000 points"),
        ("point_cloud_int16", "a point cloud of 1000 points"),
        ("point_cloud_int32", "a point cloud of 1000 points"),
        ("point_cloud_float64", "a point cloud of 1000 points"),
        ("surface_irregular", "no regular grid"),
        ("surface_irregular_layers", "no regular grid"),
    ] {
        for kind in ["binary", "xml"] {
            let Some(path) = shared(&format!("x3p-conformance/iso25178-72-fdam1/{name}_{kind}.x3p")) else { continue };
            let error = read(&path, &ReadOptions::default()).unwrap_err();
            assert!(matches!(error, Error::File { fault: Fault::Unsupported { .. }, .. }), "{error}");
            assert!(error.to_string().contains(says), "{error}");
        }
    }
}

#[test]
fn a_layer_that_is_not_there_is_refused() {
    let Some(path) = shared("x3p-conformance/iso25178-72-fdam1/surface_layers_binary.x3p") else { return };
    let error = read(&path, &ReadOptions { layer: Some(3), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("layer 3 of a file with 3 layer(s)"), "{error}");
}
