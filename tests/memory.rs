//! What reading, levelling and measuring a map takes, in sizes of its f32 heights: at most three.

use asperity::heightmap::parameters::{Gradient, Heights};
use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Preparation, level, prepare};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const SIDE: usize = 2048;

/// The file (1) and its heights in f64 (2), then those and the levelled ones in f32 (1); nothing else grows with the map.
#[test]
fn a_map_takes_three_times_its_heights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.npy");
    let height = |k: usize| 1e-7 * ((k * 7919 % 1009) as f32) + 1e-9 * (k % SIDE) as f32;
    std::fs::write(&path, asperity::npy::encode(&[SIDE, SIDE], (0..SIDE * SIDE).map(height))).unwrap();
    let options = ReadOptions { pitch: Some([1e-6, 2e-6]), unit: Some(1.0), ..ReadOptions::default() };

    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let mut prepared = prepare(read(&path, &options).unwrap(), &Preparation::default()).unwrap();
    let numbers = (Heights::measure(&prepared.map), Gradient::measure(&prepared.map));
    let (peak, after) = (MEMORY.peak_usage() - before, MEMORY.current_usage() - before);

    let heights = (SIDE * SIDE * 4) as f64;
    eprintln!("peak {:.3}, afterwards {:.3} times the heights", peak as f64 / heights, after as f64 / heights);
    assert!(numbers.0.sq > 0.0 && numbers.1.sdq > 0.0);
    assert!(peak as f64 <= 3.02 * heights && after as f64 <= 1.01 * heights);

    // Heights already in f32: the plane is taken off in place and the numbers need sums of rows only.
    MEMORY.reset_peak_usage();
    level::level_again(&mut prepared.map).unwrap();
    let again = (Heights::measure(&prepared.map), Gradient::measure(&prepared.map));
    let peak = (MEMORY.peak_usage() - before) as f64 / heights;
    eprintln!("in place: peak {peak:.3} times the heights");
    assert!((again.0.sq / numbers.0.sq - 1.0).abs() < 1e-6 && (again.1.sdq / numbers.1.sdq - 1.0).abs() < 1e-6);
    assert!(peak <= 1.01, "{peak}");
}
