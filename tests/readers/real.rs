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
    Expected {
        file: "real/al3d-1.al3d",
        grid: (200, 296),
        pitch: [4.38027e-7, 4.38027e-7],
        missing: 0,
        sq: 2.898221e-7,
        slopes: [0.0649118, 0.0618888],
    },
    Expected {
        file: "real/plu-1.plu",
        grid: (768, 576),
        pitch: [1.6600001e-6, 1.6600001e-6],
        missing: 0,
        sq: 1.828196e-8,
        slopes: [0.003948149, 0.002411433],
    },
    Expected {
        file: "real/nms-1.nms",
        grid: (512, 512),
        pitch: [3.125e-7, 3.125e-7],
        missing: 0,
        sq: 3.351491e-8,
        // The independent reader takes the pitch for a million times what it is.
        slopes: [0.01771587, 0.01846676],
    },
    Expected {
        file: "real/sur-2.sur",
        grid: (563, 484),
        pitch: [3.4840002e-6, 3.4840002e-6],
        missing: 117,
        sq: 1.710414e-8,
        slopes: [0.002285561, 0.002225793],
    },
    Expected {
        file: "real/bcrf-1.bcrf",
        grid: (960, 600),
        pitch: [1.8514625e-6, 1.8514633e-6],
        missing: 0,
        sq: 2.436725e-8,
        slopes: [0.01170957, 0.01612036],
    },
    Expected {
        file: "real/sdf-1.sdf",
        grid: (7, 4),
        pitch: [1e-6, 1e-6],
        missing: 0,
        sq: 1.028993e-8,
        slopes: [0.01457124, 0.005961629],
    },
    Expected {
        file: "converted/opd-1.mimic.datx",
        grid: (640, 480),
        pitch: [1.967330e-7, 1.967330e-7],
        missing: 116,
        sq: 6.711198e-9,
        slopes: [0.0127326, 0.0128074],
    },
    Expected {
        file: "converted/al3d-1.gwy",
        grid: (200, 296),
        pitch: [4.38027e-7, 4.38027e-7],
        missing: 0,
        sq: 2.898221e-7,
        slopes: [0.0649118, 0.0618888],
    },
    Expected {
        file: "converted/al3d-1.binary.sdf",
        grid: (200, 296),
        pitch: [4.38027e-7, 4.38027e-7],
        missing: 0,
        sq: 2.898221e-7,
        slopes: [0.0649118, 0.0618888],
    },
    Expected {
        file: "converted/al3d-1.sur",
        grid: (200, 296),
        pitch: [4.38027e-7, 4.38027e-7],
        missing: 0,
        sq: 2.898221e-7,
        slopes: [0.0649118, 0.0618888],
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
        ("real/al3d-1.al3d", 0.07635815441608429, 0.07634570449590683, 0.07633679360151291),
        ("real/plu-1.plu", -1.112265625e-4, -1.0144921874999999e-4, -1.1106640625e-4),
        ("real/nms-1.nms", 2.689124584197998e-6, 4.886203864803356e-6, 3.810475042778954e-6),
        ("real/bcrf-1.bcrf", 5.0628372192382814e-5, 5.062579727172852e-5, 5.062850570678711e-5),
        ("real/sdf-1.sdf", 1e-6, 1e-6, 9.7986e-7),
    ] {
        let Some(raw) = read_shared(file) else { continue };
        let h = &raw.heights;
        let (rows, columns) = h.dim();
        let found = [h[[0, 0]], h[[0, columns - 1]], h[[rows - 1, 0]]];
        for (found, known) in found.into_iter().zip([top_left, top_right, bottom_left]) {
            assert!((found - known).abs() < 2e-5 * known.abs(), "{file}: {found} instead of {known}");
        }
    }
}

#[test]
fn a_converted_file_has_the_heights_of_its_original() {
    // Half the Increment that the int16 file states, and the last bits.
    let half_step = 0.5 * 1.970766188859833e-12 * (1.0 + 1e-9);
    for (original, converted, bound) in [
        ("real/opd-1.opd", "converted/opd-1.int16.x3p", half_step),
        ("real/al3d-1.al3d", "converted/al3d-1.gwy", 0.0),
        // Nanometres and back.
        ("real/opd-1.opd", "converted/opd-1.mimic.datx", 4.0 * f64::EPSILON * 4e-7),
        // The file stores micrometres as f64 and the factor back to metres.
        ("real/al3d-1.al3d", "converted/al3d-1.binary.sdf", 4.0 * f64::EPSILON * 0.0764),
    ] {
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

/// The file keeps the offset of 76 mm in f32, up to 4 nm off, and the step dz = 8.1 fm in f32, which over the 2^32 steps
/// of its range comes to 2^8 steps.
#[test]
fn a_converted_file_with_another_offset_has_the_same_shape() {
    let (Some(original), Some(copy)) = (read_shared("real/al3d-1.al3d"), read_shared("converted/al3d-1.sur")) else {
        return;
    };
    let (first, second) = (original.heights[[0, 0]], copy.heights[[0, 0]]);
    assert!((first - second).abs() < 4e-9);
    let bound = 256.0 * 8.1376e-15;
    let apart = original.heights.iter().zip(&copy.heights).map(|(a, b)| ((a - first) - (b - second)).abs());
    let largest = apart.fold(0.0, f64::max);
    assert!(largest <= bound, "{largest}");
}
