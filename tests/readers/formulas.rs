//! Each handmade file holds the heights that its format's formula gives, and nothing is guessed.

use crate::handmade::{RAW, Sample, al3d, gwy, metropro, samples};
use asperity::heightmap::RawMap;
use asperity::heightmap::read::{RECOGNITION_BYTES, ReadOptions, is_recognised, read_bytes};

fn read_sample(sample: &Sample) -> RawMap {
    read_bytes(&sample.file, &sample.options).unwrap_or_else(|e| panic!("{}: {e}", sample.name))
}

#[test]
fn every_format_follows_its_formula() {
    for sample in samples() {
        let map = read_sample(&sample);
        assert_eq!(map.heights.dim(), (3, 4), "{}", sample.name);
        for ((r, c), &height) in map.heights.indexed_iter() {
            let raw = if RAW[r][c] == i32::MAX { sample.instead } else { Some(f64::from(RAW[r][c])) };
            match raw {
                // Six digits, which is what f32 fields can promise.
                Some(raw) => {
                    let expected = raw * sample.unit + sample.offset;
                    let error = (height - expected).abs();
                    assert!(error <= 1e-6 * expected.abs() + 1e-18, "{}: {r} {c}: {height}", sample.name);
                }
                None => assert!(height.is_nan(), "{}: {r} {c}: {height}", sample.name),
            }
        }
        for (found, expected) in [map.pitch_x, map.pitch_y].into_iter().zip(sample.pitch) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{}: pitch {found}", sample.name);
        }
    }
}

/// From its first bytes, so that a folder can be searched; what may hold anything is not picked up unasked.
#[test]
fn height_maps_are_recognised_by_their_beginning() {
    for sample in samples() {
        let start = &sample.file[..sample.file.len().min(RECOGNITION_BYTES)];
        let anything = ["npz", "text", "csv", "xyz", "png", "tiff", "tiff of integers", "exr"];
        assert_eq!(is_recognised(start), !anything.contains(&sample.name), "{}", sample.name);
    }
    assert!(!is_recognised(b"") && !is_recognised(b"{\"json\": 1}") && !is_recognised(&[0; 5000]));
}

/// Four columns of f32 need no padding, three do.
#[test]
fn padded_rows_of_al3d_are_not_sheared() {
    let read = |columns| read_bytes(&al3d(columns), &ReadOptions::default()).unwrap().heights;
    let (whole, narrow) = (read(4), read(3));
    assert_eq!(narrow.dim(), (3, 3));
    assert!(narrow.indexed_iter().all(|(place, h)| *h == whole[place] || h.is_nan() && whole[place].is_nan()));
}

/// A mask over one filled-in value is an importer's, one over different heights is a drawing.
#[test]
fn gwyddion_masks_hide_only_what_was_filled_in() {
    let missing = |filled| {
        let map = read_bytes(&gwy(filled), &ReadOptions::default()).unwrap();
        map.heights.iter().filter(|h| h.is_nan()).count()
    };
    assert_eq!(missing([7.0, 7.0]), 2);
    assert_eq!(missing([7.0, 3.0]), 0);
}

#[test]
fn a_channel_of_gwyddion_can_be_chosen() {
    let read = |layer| read_bytes(&gwy([7.0, 3.0]), &ReadOptions { layer: Some(layer), ..ReadOptions::default() });
    assert_eq!(read(2).unwrap().heights[[0, 0]], 10.0 * 1e-9);
    let volts = read(0).unwrap_err().to_string();
    assert!(volts.contains("--unit um"), "{volts}");
    let absent = read(1).unwrap_err().to_string();
    assert!(absent.contains("channel 1 of a file with 2 channel(s)"), "{absent}");
}

#[test]
fn pictures_ask_for_what_they_cannot_know() {
    for sample in samples().into_iter().filter(|s| ["png", "tiff", "tiff of integers", "exr"].contains(&s.name)) {
        let ask = |options: ReadOptions| read_bytes(&sample.file, &options).unwrap_err().to_string();
        let height = if sample.options.unit.is_some() { "--unit um" } else { "--height-range 0um,2.5um" };
        assert!(ask(ReadOptions::default()).contains(height), "{}", sample.name);
        assert!(ask(ReadOptions { pitch: None, ..sample.options }).contains("--pitch 0.5um"), "{}", sample.name);
    }
}

#[test]
fn an_8_bit_picture_is_refused() {
    let mut file = Vec::new();
    let encoder = ::png::Encoder::new(&mut file, 2, 2);
    encoder.write_header().unwrap().write_image_data(&[0; 4]).unwrap();
    let message = read_bytes(&file, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("8 bits") && message.contains("16-bit"), "{message}");
}

#[test]
fn an_uncalibrated_metropro_file_asks_for_the_pitch() {
    let mut file = metropro(0);
    file[184..188].fill(0);
    let message = read_bytes(&file, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("--pitch 0.5um"), "{message}");
    let options = ReadOptions { pitch: Some([1e-6, 4e-6]), ..ReadOptions::default() };
    let map = read_bytes(&file, &options).unwrap();
    assert_eq!((map.pitch_x, map.pitch_y), (1e-6, 4e-6));
}
