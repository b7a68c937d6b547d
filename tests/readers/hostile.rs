//! Damaged, lying and mislabelled files: a typed fault with a sentence, never a panic or a huge allocation.

use crate::handmade::{self, samples};
use crate::{largest_difference, shared};
use asperity::Error;
use asperity::error::Fault;
use asperity::heightmap::read::{ReadOptions, read, read_bytes};

fn everything_known() -> ReadOptions {
    ReadOptions { pitch: Some([1e-6, 1e-6]), unit: Some(1e-6), height_range: Some([0.0, 1e-6]), layer: None }
}

/// Shortened by any number of bytes, a file is refused or has lost only what the heights do not need.
#[test]
fn every_truncation_is_a_fault_or_harmless() {
    for sample in samples() {
        let whole = read_bytes(&sample.file, &sample.options).unwrap();
        let is_table = ["text", "csv", "xyz"].contains(&sample.name);
        // The last number may lose digits unnoticed where the count of numbers is all there is to check.
        let ends_in_digits = ["Zygo xyz", "Zygo ASCII", "sdf as text"].contains(&sample.name);
        let mut harmless = 0;
        for length in 0..sample.file.len() {
            match read_bytes(&sample.file[..length], &sample.options) {
                Err(fault) => assert!(fault.to_string().len() > 10, "{fault}"),
                // A table has no end mark: a row or digit less is still a table.
                Ok(_) if is_table => {}
                Ok(mut cut) => {
                    if ends_in_digits {
                        cut.heights[[2, 3]] = whole.heights[[2, 3]];
                    }
                    assert_eq!(largest_difference(&whole, &cut), 0.0, "{} cut at {length}", sample.name);
                    harmless += 1;
                }
            }
        }
        eprintln!("{}: {harmless} of {} cuts are harmless", sample.name, sample.file.len());
        assert!(harmless < sample.file.len() / 2, "{}", sample.name);
    }
}

#[test]
fn the_name_of_a_file_does_not_matter_but_its_content_does() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content, says) in [
        ("text.x3p", b"this is a letter, not a surface\n".as_slice(), "no known height-map format"),
        ("empty.dat", b"", "the file is empty"),
        ("one.opd", b"\x01", "no known height-map format"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let error = read(&path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, Error::Content { .. }), "{error}");
        assert!(error.to_string().contains(says) && error.to_string().contains(name), "{error}");
    }
    let path = folder.path().join("really-a.txt");
    std::fs::write(&path, handmade::metropro(0)).unwrap();
    assert_eq!(read(&path, &ReadOptions::default()).unwrap().format, "MetroPro");
}

#[test]
fn maps_without_a_facet_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.npy");
    for (shape, value, says) in [
        ([1, 1], 0.0, "1 x 1 points"),
        ([1, 9], 0.0, "9 x 1 points"),
        ([4, 4], f64::NAN, "every point of the map is missing"),
        ([4, 4], f64::INFINITY, "every point of the map is missing"),
        ([0, 7], 0.0, "7 x 0 points"),
    ] {
        let file = asperity::npy::encode(&shape, std::iter::repeat_n(value, shape[0] * shape[1]));
        std::fs::write(&path, file).unwrap();
        let error = read(&path, &everything_known()).unwrap_err();
        assert!(matches!(error, Error::Content { .. }) && error.to_string().contains(says), "{error}");
    }
}

#[test]
fn npy_asks_for_what_it_cannot_know() {
    let file = asperity::npy::encode(&[2, 2], [0.0f64; 4]);
    let unit = ReadOptions { unit: Some(1e-6), ..Default::default() };
    for (options, advice) in [(ReadOptions::default(), "--unit um"), (unit, "--pitch 0.5um")] {
        let fault = read_bytes(&file, &options).unwrap_err();
        assert!(matches!(fault, Fault::MetadataMissing { .. }) && fault.to_string().contains(advice), "{fault}");
    }
}

#[test]
fn announced_sizes_are_not_believed() {
    let size = |n: &str| {
        let xml = handmade::x3p_xml("<DataLink><PointDataLink>d</PointDataLink></DataLink>")
            .replace("<SizeX>4</SizeX>", &format!("<SizeX>{n}</SizeX>"));
        handmade::zip_stored(&[("main.xml", xml.as_bytes()), ("d", &[0; 24])])
    };
    // Overflow, more than there is, less than there is, nothing.
    for n in ["18446744073709551615", "6148914691236517205", "4000000000", "5", "3", "0", "-4", "1e3"] {
        let fault = read_bytes(&size(n), &ReadOptions::default()).unwrap_err();
        assert!(matches!(fault, Fault::Corrupt { .. }), "{n}: {fault}");
    }
    assert!(read_bytes(&size("4"), &ReadOptions::default()).is_ok());
}

#[test]
fn a_zip_bomb_is_cut_off() {
    // 300 MiB of zeros pack into 300 kB; the announced size matches, the expansion is not plausible.
    let xml = handmade::x3p_xml("<DataLink><PointDataLink>d</PointDataLink></DataLink>")
        .replace("<SizeX>4</SizeX>", "<SizeX>52428800</SizeX>");
    let bomb = asperity::archive::pack(&[("main.xml", xml.as_bytes()), ("d", &vec![0; 52_428_800 * 6])]).unwrap();
    assert!(bomb.len() < 1 << 20);
    let fault = read_bytes(&bomb, &ReadOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("unpacks to more than"), "{fault}");
    // The same for a document of points that nobody announced.
    let xml = handmade::x3p_xml(&format!("<DataList>{}</DataList>", "<Datum/>".repeat(5 << 20)));
    let bomb = asperity::archive::pack(&[("main.xml", xml.as_bytes())]).unwrap();
    assert!(bomb.len() < 1 << 20);
    let fault = read_bytes(&bomb, &ReadOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("\"main.xml\" unpacks to more than"), "{fault}");
}

#[test]
fn another_zip_is_no_surface() {
    let fault = read_bytes(&handmade::zip_stored(&[("word/document.xml", b"<a/>")]), &ReadOptions::default());
    assert!(fault.unwrap_err().to_string().contains("without main.xml"));
}

#[test]
fn real_files_cut_short_are_faults() {
    for name in [
        "real/x3p-2.x3p",
        "real/opd-1.opd",
        "real/valid_zygo_dat_file.dat",
        "real/al3d-1.al3d",
        "real/sur-2.sur",
        "real/bcrf-1.bcrf",
        "real/nms-1.nms",
        "real/plu-1.plu",
        "converted/al3d-1.gwy",
        "converted/al3d-1.binary.sdf",
        "converted/opd-1.mimic.datx",
    ] {
        let Some(path) = shared(name) else { continue };
        let bytes = std::fs::read(path).unwrap();
        // Later parts of some files are pictures and remarks that the heights do not need.
        for share in [1, 10, 100, 300] {
            let cut = &bytes[..bytes.len() * share / 1000];
            assert!(read_bytes(cut, &ReadOptions::default()).is_err(), "{name} cut to {share} per mille");
        }
    }
}
