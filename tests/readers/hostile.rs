//! Damaged, lying and mislabelled files: a typed fault with a sentence, never a panic or a huge allocation.

use crate::{handmade, shared};
use asperity::Error;
use asperity::error::Fault;
use asperity::heightmap::read::{ReadOptions, read, read_bytes};
use asperity::math::random::CounterRng;
use rand::Rng;

/// One small valid file per reader, with the options it needs.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let values = [1.0f32, 2.0, 3.0, 4.0, f32::NAN, 6.0];
    let big =
        b"\x93NUMPY\x02\x00\x3a\x00\x00\x00{'descr': '>f4', 'fortran_order': True, 'shape': (3, 2), }\n\0\0\0\0\0\
        \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    vec![
        ("metropro", handmade::metropro(1)),
        ("wyko", handmade::wyko()),
        ("x3p", handmade::x3p()),
        ("x3p text", handmade::x3p_text()),
        ("npy", asperity::npy::encode(&[2, 3], values)),
        ("npy big-endian", big.to_vec()),
    ]
}

fn everything_known() -> ReadOptions {
    ReadOptions { pitch: Some([1e-6, 1e-6]), unit: Some(1e-6), ..Default::default() }
}

#[test]
fn the_seeds_are_valid() {
    for (name, file) in seeds() {
        assert!(read_bytes(&file, &everything_known()).is_ok(), "{name}");
    }
}

#[test]
fn every_truncation_is_a_fault() {
    for (name, file) in seeds() {
        // The title of the Wyko file and the checksum of nothing come last; all shorter cuts lose something needed.
        for length in 0..file.len() - 1 {
            match read_bytes(&file[..length], &everything_known()) {
                Err(Fault::NotThisFormat(_)) => assert!(length < 64, "{name} cut at {length}"),
                Err(fault) => assert!(fault.to_string().len() > 20, "{fault}"),
                Ok(_) => panic!("{name} cut at {length} was read"),
            }
        }
    }
}

/// Bits flipped, stretches overwritten, removed and doubled, numbers replaced by extremes.
#[test]
fn mutations_never_panic() {
    let rounds = std::env::var("ASPERITY_FUZZ_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(4000);
    for (number, (name, file)) in seeds().into_iter().enumerate() {
        let (mut read, mut refused) = (0u32, 0u32);
        for round in 0..rounds {
            let mut rng = CounterRng::new(0x5eed, number as u32, round);
            let mutant = mutate(&file, &mut rng);
            match read_bytes(&mutant, &everything_known()) {
                // No stored point takes less than one bit of the unpacked file.
                Ok(map) => {
                    assert!(map.heights.len() <= 64 * 8 * mutant.len().max(1));
                    read += 1;
                }
                Err(fault) => {
                    assert!(!fault.to_string().is_empty());
                    refused += 1;
                }
            }
        }
        eprintln!("{name}: {read} mutants read, {refused} refused");
        // If nothing is ever refused or ever read, the mutations do not test the reader.
        assert!(refused > 0 && read > 0, "{name}");
    }
}

fn mutate(file: &[u8], rng: &mut CounterRng) -> Vec<u8> {
    let mut bytes = file.to_vec();
    let below = |rng: &mut CounterRng, n: usize| (rng.uniform() * n as f64) as usize;
    for _ in 0..=below(rng, 3) {
        if bytes.is_empty() {
            break;
        }
        let at = below(rng, bytes.len());
        let length = 1 + below(rng, 8.min(bytes.len() - at));
        match below(rng, 6) {
            0 => bytes[at] ^= 1 << below(rng, 8),
            1 => bytes[at] = rng.next_u32() as u8,
            2 => bytes[at..at + length].fill([0, 0xff, 0x7f, 0x80, b'9', b'-'][below(rng, 6)]),
            3 => drop(bytes.drain(at..at + length)),
            4 => {
                let piece = bytes[at..at + length].to_vec();
                let to = below(rng, bytes.len());
                bytes.splice(to..to, piece);
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// The ZIP checksum keeps mutants of the archive away from the document, so these are packed after the change.
#[test]
fn mutated_documents_never_panic() {
    let whole = |kind: &str| {
        let list = "<DataList><Datum>1</Datum><Datum>2;3;4</Datum><Datum/></DataList>";
        let link = "<DataLink><PointDataLink>d</PointDataLink><ValidPointsLink>v</ValidPointsLink></DataLink>";
        let xml = handmade::x3p_xml(if kind == "link" { link } else { list });
        if kind == "absolute" { xml.replace("<AxisType>I</AxisType>", "<AxisType>A</AxisType>") } else { xml }
    };
    let mut outcomes = std::collections::BTreeSet::new();
    for (number, kind) in ["link", "list", "absolute"].into_iter().enumerate() {
        for round in 0..3000 {
            let mut rng = CounterRng::new(0xd0c, number as u32, round);
            let xml = mutate(whole(kind).as_bytes(), &mut rng);
            let archive = handmade::zip_stored(&[("main.xml", &xml), ("d", &[1; 24]), ("v", &[255; 2])]);
            let outcome = read_bytes(&archive, &everything_known());
            outcomes.insert(outcome.map_or_else(|f| format!("{f:?}")[..7].to_owned(), |_| "read".to_owned()));
        }
    }
    assert!(["read", "Corrupt", "Unsuppo"].iter().all(|o| outcomes.contains(*o)), "{outcomes:?}");
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
}

#[test]
fn another_zip_is_no_surface() {
    let fault = read_bytes(&handmade::zip_stored(&[("word/document.xml", b"<a/>")]), &ReadOptions::default());
    assert!(fault.unwrap_err().to_string().contains("without main.xml"));
}

#[test]
fn real_files_cut_short_are_faults() {
    for name in ["real/x3p-2.x3p", "real/opd-1.opd", "real/valid_zygo_dat_file.dat"] {
        let Some(path) = shared(name) else { continue };
        let bytes = std::fs::read(path).unwrap();
        for share in [1, 10, 100, 500, 900, 990] {
            let cut = &bytes[..bytes.len() * share / 1000];
            // The last percent of the .opd file is remarks that the heights do not need.
            if !(name.ends_with("opd") && share >= 900) {
                assert!(read_bytes(cut, &ReadOptions::default()).is_err(), "{name} cut to {share} per mille");
            }
        }
    }
}
