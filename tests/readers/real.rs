//! Files that instruments wrote. The expected figures come from independent readers (SurfaceTopography, NumPy) and
//! agree with the table that accompanies the files.

use crate::{largest_difference, missing, read_shared};
use asperity::heightmap::{Edges, HeightMap, level::level};

/// What an independent reader found: grid, pitch [m], missing points, Sq [m], rms of the 1-pixel forward differences.
struct Expected {
    file: &'static str,
    grid: (usize, usize),
    pitch: [f64; 2],
    missing: usize,
    sq: f64,
    slopes: [f64; 2],
}

const MAPS: &[Expected] = &[
    Expected {
        file: "real/x3p-2.x3p",
        grid: (650, 650),
        pitch: [1.276565e-7, 3.145821e-7],
        missing: 0,
        sq: 7.719303e-8,
        slopes: [0.0556106, 0.0275797],
    },
    Expected {
        file: "real/sample-land.x3p",
        grid: (918, 256),
        pitch: [2.58e-6, 2.58e-6],
        missing: 25292,
        sq: 3.364028e-5,
        slopes: [0.699822, 0.557098],
    },
    Expected {
        file: "converted/di-1.x3p",
        grid: (512, 512),
        pitch: [9.765625e-10, 9.765625e-10],
        missing: 0,
        sq: 9.843662e-9,
        slopes: [0.211040, 0.736782],
    },
    Expected {
        file: "converted/opd-1.int16.x3p",
        grid: (640, 480),
        pitch: [1.967330e-7, 1.967330e-7],
        missing: 116,
        sq: 6.711198e-9,
        slopes: [0.0127326, 0.0128074],
    },
    Expected {
        file: "real/opd-1.opd",
        grid: (640, 480),
        pitch: [1.967330e-7, 1.967330e-7],
        missing: 116,
        sq: 6.711198e-9,
        slopes: [0.0127326, 0.0128074],
    },
    Expected {
        file: "real/valid_zygo_dat_file.dat",
        grid: (425, 432),
        pitch: [1.1792420e-4, 1.1792420e-4],
        missing: 47241,
        sq: 4.459141e-8,
        slopes: [6.256763e-5, 6.386985e-5],
    },
];

#[test]
fn grid_pitch_gaps_and_roughness_are_those_of_other_readers() {
    for expected in MAPS {
        let Some(raw) = read_shared(expected.file) else { continue };
        let file = expected.file;
        assert_eq!((raw.heights.ncols(), raw.heights.nrows()), expected.grid, "{file}");
        for (pitch, known) in [raw.pitch_x, raw.pitch_y].into_iter().zip(expected.pitch) {
            assert!((pitch / known - 1.0).abs() < 1e-6, "{file}: pitch {pitch}");
        }
        assert_eq!(missing(&raw), expected.missing, "{file}");
        let map = level(&raw, Edges::Open).unwrap();
        let sq = root_mean_square(map.heights.iter().map(|&h| f64::from(h)));
        assert!((sq / expected.sq - 1.0).abs() < 1e-3, "{file}: Sq {sq}");
        let found = slopes(&map);
        for (slope, known) in found.into_iter().zip(expected.slopes) {
            assert!((slope / known - 1.0).abs() < 1e-3, "{file}: slopes {found:?}");
        }
        // Printed with --nocapture: how near the figures really are.
        eprintln!("{file}: Sq {:.1e}, slopes {:.1e} off", sq / expected.sq - 1.0, found[0] / expected.slopes[0] - 1.0);
    }
}

/// Corner heights [m] that other readers give: orientation, sign and offset in one.
#[test]
fn corners_are_where_other_readers_see_them() {
    for (file, top_left, top_right, bottom_left) in [
        ("real/x3p-2.x3p", 6.579781341223288e-8, -4.133318658776711e-8, 9.597611341223287e-8),
        ("real/opd-1.opd", -2.6550621614908414e-7, -2.5646328900066876e-7, -2.8399285465906725e-7),
        ("converted/opd-1.int16.x3p", -2.6550626403591414e-7, -2.564624179952364e-7, -2.839920508874194e-7),
    ] {
        let Some(raw) = read_shared(file) else { continue };
        let h = &raw.heights;
        let (rows, columns) = h.dim();
        let found = [h[[0, 0]], h[[0, columns - 1]], h[[rows - 1, 0]]];
        for (found, known) in found.into_iter().zip([top_left, top_right, bottom_left]) {
            assert!((found - known).abs() < 1e-6 * known.abs(), "{file}: {found} instead of {known}");
        }
    }
}

#[test]
fn a_converted_file_has_the_heights_of_its_original() {
    // Half the Increment that the int16 file states, and the last bits.
    let half_step = 0.5 * 1.970766188859833e-12 * (1.0 + 1e-9);
    for (original, converted, bound) in [("real/opd-1.opd", "converted/opd-1.int16.x3p", half_step)] {
        let (Some(original), Some(copy)) = (read_shared(original), read_shared(converted)) else { continue };
        let difference = largest_difference(&original, &copy);
        assert!(difference <= bound, "{converted}: {difference}");
        assert!((original.pitch_x / copy.pitch_x - 1.0).abs() < 1e-12);
    }
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut n, mut sum) = (0.0, 0.0);
    for v in values.filter(|v| v.is_finite()) {
        n += 1.0;
        sum += v * v;
    }
    (sum / n).sqrt()
}

/// Rms of the forward differences along x and y over all neighbouring measured pairs.
fn slopes(map: &HeightMap) -> [f64; 2] {
    let h = |r: usize, c: usize| f64::from(map.heights[[r, c]]);
    let (rows, columns) = map.heights.dim();
    let x = (0..rows).flat_map(|r| (1..columns).map(move |c| (h(r, c) - h(r, c - 1)) / map.pitch_x));
    let y = (1..rows).flat_map(|r| (0..columns).map(move |c| (h(r, c) - h(r - 1, c)) / map.pitch_y));
    [root_mean_square(x), root_mean_square(y)]
}
