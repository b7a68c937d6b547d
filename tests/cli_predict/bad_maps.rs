//! Files that are no maps: one clear error each, exit code 1, and the others go on.

use super::{QUICK, asperity, listing, synth, words, write_npy};
use ndarray::Array2;
use std::path::Path;

/// Names and a word that the error must contain: what is wrong or what to do.
const BAD: [(&str, &str); 6] = [
    ("cut-early.x3p", "truncated"),
    ("cut-late.x3p", "truncated"),
    ("empty.x3p", "empty"),
    ("letter.x3p", "export it as"),
    ("missing.npy", "missing"),
    ("point.npy", "2 x 2"),
];

/// For the maps without pitch and unit.
const UNITS: [&str; 4] = ["--pitch", "1um", "--unit", "um"];

fn fill(folder: &Path) {
    synth(&folder.join("rough.x3p"), "0.4um", "1");
    synth(&folder.join("smooth.x3p"), "0.2um", "2");
    let whole = std::fs::read(folder.join("rough.x3p")).unwrap();
    std::fs::write(folder.join("cut-early.x3p"), &whole[..100]).unwrap();
    std::fs::write(folder.join("cut-late.x3p"), &whole[..whole.len() - 30]).unwrap();
    std::fs::write(folder.join("empty.x3p"), []).unwrap();
    std::fs::write(folder.join("letter.x3p"), "Dear lab,\nplease find the map attached.\n").unwrap();
    write_npy(&folder.join("missing.npy"), Array2::from_elem((12, 16), f64::NAN));
    write_npy(&folder.join("point.npy"), Array2::zeros((1, 1)));
    std::fs::write(folder.join("README.md"), "# Maps of last week\n").unwrap();
}

#[test]
fn a_folder_with_bad_maps_still_gives_the_good_ones() {
    let dir = tempfile::tempdir().unwrap();
    let (maps, out) = (dir.path().join("maps"), dir.path().join("out"));
    std::fs::create_dir(&maps).unwrap();
    fill(&maps);
    let run = asperity(
        words(&[&"predict", &maps, &"-o", &out])
            .into_iter()
            .chain(words(&[&UNITS[0], &UNITS[1], &UNITS[2], &UNITS[3], &QUICK[0], &QUICK[1], &QUICK[2], &QUICK[3]])),
    );
    assert_eq!(run.code, 1, "{}", run.stderr);

    // Exactly these files: nothing under a temporary name, nothing half written.
    assert_eq!(
        listing(&out),
        ["gloss.csv", "gloss_vs_roughness.svg", "report.html", "rough.npz", "smooth.npz", "tiles.exr", "tiles.png"]
    );
    let csv = std::fs::read_to_string(out.join("gloss.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().skip(1).map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(rows, ["smooth.x3p", "rough.x3p"], "one row per map, by rising Sq");
    let head = |name: &str| std::fs::read(out.join(name)).unwrap()[..4].to_vec();
    assert_eq!(head("tiles.png"), b"\x89PNG");
    assert_eq!(head("tiles.exr"), [0x76, 0x2f, 0x31, 0x01]);
    assert_eq!(head("rough.npz"), b"PK\x03\x04");
    assert!(std::fs::read_to_string(out.join("gloss_vs_roughness.svg")).unwrap().trim_end().ends_with("</svg>"));

    // One page with everything on it, and nothing to be fetched from anywhere.
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for part in
        ["smooth.x3p", "rough.x3p", "Rayleigh g", "<svg", "data:image/png;base64,", "could not be used", "</html>"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http") && !page.contains("url("));

    let errors = run.errors();
    let (closing, each) = errors.split_last().expect("errors");
    assert_eq!(each.len(), BAD.len(), "{}", run.stderr);
    for (name, word) in BAD {
        let path = maps.join(name).display().to_string();
        let own: Vec<_> = each.iter().filter(|e| e.contains(&path)).collect();
        assert_eq!(own.len(), 1, "{name}: {}", run.stderr);
        assert!(own[0].contains(word), "{name}: {}", own[0]);
        assert!(closing.contains(name), "{closing}");
        assert!(!run.stdout.contains(name));
    }
    assert!(closing.contains("6 of 8 maps failed"), "{closing}");
    assert!(!run.stderr.contains("README"), "{}", run.stderr);
}

#[test]
fn each_bad_map_alone_is_one_error() {
    let dir = tempfile::tempdir().unwrap();
    fill(dir.path());
    let out = dir.path().join("out");
    for (name, word) in BAD {
        let path = dir.path().join(name);
        let run = asperity(words(&[&"predict", &path, &"-o", &out, &UNITS[0], &UNITS[1], &UNITS[2], &UNITS[3]]));
        assert_eq!(run.code, 1, "{name}");
        let errors = run.errors();
        assert_eq!(errors.len(), 1, "{}", run.stderr);
        assert!(errors[0].contains(&path.display().to_string()) && errors[0].contains(word), "{}", errors[0]);
        // What is wrong; what to do.
        assert!(errors[0].contains(';'), "{}", errors[0]);
        assert_eq!(run.stderr.trim_end().lines().count(), 1, "{}", run.stderr);
        assert_eq!(run.stdout, "");
        assert_eq!(listing(&out), [""; 0]);
    }
}

#[test]
fn absent_maps_and_empty_folders() {
    let dir = tempfile::tempdir().unwrap();
    let (absent, empty, out) = (dir.path().join("absent.x3p"), dir.path().join("empty"), dir.path().join("out"));
    std::fs::create_dir(&empty).unwrap();
    for path in [&absent, &empty] {
        let run = asperity(words(&[&"predict", path, &"-o", &out]));
        assert_eq!(run.code, 1);
        assert_eq!(run.errors().len(), 1, "{}", run.stderr);
        assert!(run.stderr.contains(&path.display().to_string()), "{}", run.stderr);
    }
    // A file where the folder of results should be.
    let taken = dir.path().join("taken");
    std::fs::write(&taken, "mine").unwrap();
    let good = dir.path().join("good.x3p");
    synth(&good, "0.2um", "1");
    let run = asperity(words(&[&"predict", &good, &"-o", &taken]));
    assert_eq!((run.code, run.errors().len()), (1, 1), "{}", run.stderr);
    assert!(run.stderr.contains(&taken.display().to_string()), "{}", run.stderr);
    assert_eq!(std::fs::read(&taken).unwrap(), b"mine");
}

/// Results beside the maps must not become maps of the next run.
#[test]
fn a_second_run_into_the_folder_of_the_maps_sees_the_same_maps() {
    let dir = tempfile::tempdir().unwrap();
    synth(&dir.path().join("a.x3p"), "0.2um", "1");
    let call = || {
        let run = asperity(words(&[
            &"predict",
            &dir.path(),
            &"-o",
            &dir.path(),
            &"--theta-i",
            &"0,40,80",
            &QUICK[0],
            &QUICK[1],
            &QUICK[2],
            &QUICK[3],
        ]));
        assert_eq!(run.code, 0, "{}", run.stderr);
        (listing(dir.path()), std::fs::read(dir.path().join("gloss.csv")).unwrap())
    };
    let first = call();
    assert_eq!(first, call());
}
