//! What a writer writes, its reader reads: an asymmetric map with unequal pitches, one bright corner and gaps.

use crate::largest_difference;
use asperity::heightmap::RawMap;
use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::write::{npy, png, sdf, x3p};
use ndarray::Array2;
use std::path::Path;

const ROWS: usize = 23;
const COLUMNS: usize = 37;

/// Tilted waves at an offset, top left corner 1 um higher, no mirror symmetry.
fn asymmetric(offset: f64, gaps: bool) -> RawMap {
    let mut heights = Array2::from_shape_fn((ROWS, COLUMNS), |(r, c)| {
        let (x, y) = (c as f64, r as f64);
        offset + 1e-7 * (0.3 * x + 0.05 * y * y).sin() + 2e-9 * x - 3e-9 * y
    });
    heights[[0, 0]] += 1e-6;
    if gaps {
        heights[[5, 7]] = f64::NAN;
        heights[[ROWS - 1, COLUMNS - 1]] = f64::NAN;
    }
    RawMap { heights, pitch_x: 0.4e-6, pitch_y: 0.9e-6, format: "test", notes: vec![] }
}

fn through(map: &RawMap, options: &ReadOptions, write: impl Fn(&Path, &RawMap)) -> RawMap {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map");
    write(&path, map);
    read(&path, options).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn x3p_keeps_pitch_orientation_gaps_and_heights() {
    for offset in [0.0, 0.0763] {
        for gaps in [false, true] {
            let map = asymmetric(offset, gaps);
            // Range 1.3 um at most: half of 1/65532 of it, half a unit in the last place of f32, nothing.
            for (samples, bound) in [
                (x3p::Samples::Int16, 0.5 * 1.3e-6 / 65532.0),
                (x3p::Samples::Float32, 0.65e-6 * 2f64.powi(-24)),
                (x3p::Samples::Float64, 0.0),
            ] {
                let back = through(&map, &ReadOptions::default(), |p, m| x3p::write(p, m, samples).unwrap());
                assert_eq!((back.pitch_x, back.pitch_y), (0.4e-6, 0.9e-6));
                // Adding the offset again rounds in the last place of f64.
                let bound = if bound == 0.0 { 0.0 } else { bound + 2.0 * f64::EPSILON * offset };
                let difference = largest_difference(&map, &back);
                assert!(difference <= bound, "{samples:?} at {offset}: {difference} > {bound}");
            }
        }
    }
}

#[test]
fn x3p_of_a_flat_map_is_flat() {
    let heights = Array2::from_elem((4, 5), 0.25e-3);
    let map = RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
    for samples in [x3p::Samples::Int16, x3p::Samples::Float32, x3p::Samples::Float64] {
        let back = through(&map, &ReadOptions::default(), |p, m| x3p::write(p, m, samples).unwrap());
        assert!(largest_difference(&map, &back) <= 1e-15, "{samples:?}");
        assert!(back.heights.iter().all(|h| *h == back.heights[[0, 0]]), "{samples:?}");
    }
}

#[test]
fn npy_keeps_orientation_gaps_and_heights() {
    let map = asymmetric(1e-6, true);
    let options = ReadOptions { pitch: Some([0.4e-6, 0.9e-6]), unit: Some(1.0), ..Default::default() };
    let back = through(&map, &options, |p, m| npy::write(p, m, npy::Precision::Float64).unwrap());
    assert_eq!(largest_difference(&map, &back), 0.0);
    assert_eq!((back.pitch_x, back.pitch_y), (0.4e-6, 0.9e-6));
    let back = through(&map, &options, |p, m| npy::write(p, m, npy::Precision::Float32).unwrap());
    assert!(largest_difference(&map, &back) <= 2.3e-6 * 2f64.powi(-24));
}

#[test]
fn sdf_keeps_everything_exactly() {
    for offset in [0.0, 0.0763] {
        let map = asymmetric(offset, true);
        for encoding in [sdf::Encoding::Binary, sdf::Encoding::Ascii] {
            let back = through(&map, &ReadOptions::default(), |p, m| sdf::write(p, m, encoding).unwrap());
            assert_eq!((back.pitch_x, back.pitch_y), (0.4e-6, 0.9e-6), "{encoding:?}");
            assert_eq!(largest_difference(&map, &back), 0.0, "{encoding:?}");
        }
    }
}

#[test]
fn png_keeps_pitch_orientation_gaps_and_heights() {
    for gaps in [false, true] {
        let map = asymmetric(1e-3, gaps);
        let back = through(&map, &ReadOptions::default(), |p, m| {
            let [low, high] = png::write(p, m).unwrap();
            assert!(low > 0.9e-3 && high < 1.1e-3 && high - low < 1.3e-6);
        });
        assert_eq!((back.pitch_x, back.pitch_y), (0.4e-6, 0.9e-6));
        // Half of 65535 steps over the range, and the last place of f64 at 1 mm.
        assert!(largest_difference(&map, &back) <= 0.5 * 1.3e-6 / 65535.0 + 2.0 * f64::EPSILON * 1e-3);
    }
}

#[test]
fn the_user_s_range_wins_over_the_picture_s() {
    let map = asymmetric(0.0, false);
    let options = ReadOptions { height_range: Some([0.0, 65535.0]), ..ReadOptions::default() };
    let back = through(&map, &options, |p, m| {
        png::write(p, m).unwrap();
    });
    // Black is the lowest point, white the raised corner.
    assert_eq!(back.heights[[0, 0]], 65535.0);
    assert_eq!(back.heights.iter().copied().fold(f64::INFINITY, f64::min), 0.0);
}

#[test]
fn what_a_format_cannot_hold_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let map = |heights| RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
    let long = map(Array2::zeros((2, 70_000)));
    let error = sdf::write(&folder.path().join("a.sdf"), &long, sdf::Encoding::Binary).unwrap_err();
    assert!(error.to_string().contains("70000 points"), "{error}");
    let empty = map(Array2::from_elem((3, 3), f64::NAN));
    assert!(png::write(&folder.path().join("a.png"), &empty).is_err());
    assert!(x3p::write(&folder.path().join("a.x3p"), &empty, x3p::Samples::Int16).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
