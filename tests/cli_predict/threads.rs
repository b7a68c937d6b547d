//! Same seed, same bytes, whatever `--threads`.

use super::{QUICK, asperity, listing, synth, words};
use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::write::x3p;
use std::path::Path;

/// Two maps: one isotropic, one stretched threefold along y and hence anisotropic.
fn maps(folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    let even = folder.join("even.x3p");
    synth(&even, "0.5um", "3");
    let mut map = read(&even, &ReadOptions::default()).unwrap();
    map.pitch_y *= 3.0;
    x3p::write(&folder.join("grooved.x3p"), &map, x3p::Samples::Float64).unwrap();
}

/// All outputs of one call, by name.
fn outputs(maps: &Path, out: &Path, threads: &str, flags: &[&str]) -> Vec<(String, Vec<u8>)> {
    let mut call =
        words(&[&"predict", &maps, &"-o", &out, &"--threads", &threads, &QUICK[0], &QUICK[1], &QUICK[2], &QUICK[3]]);
    call.extend(flags.iter().map(std::ffi::OsStr::new));
    let run = asperity(call);
    assert_eq!(run.code, 0, "{}", run.stderr);
    listing(out).into_iter().map(|name| (name.clone(), std::fs::read(out.join(name)).unwrap())).collect()
}

#[track_caller]
fn same(a: &[(String, Vec<u8>)], b: &[(String, Vec<u8>)], flags: &[&str]) {
    assert_eq!(a.len(), 7, "tables of two maps, CSV, chart, two pictures, report");
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.0, b.0);
        assert!(a.1 == b.1, "{} differs with {flags:?}", a.0);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("maps");
    maps(&folder);
    let mut by_rays = Vec::new();
    let angles = ["--theta-i", "0,45,80", "--phi-i", "0,60,150"];
    for (k, method) in [
        ["--method", "auto", "--seed", "1"].as_slice(),
        &["--method", "facets", "--material", "al"],
        &["--method", "rays", "--rays", "40000", "--seed", "5"],
    ]
    .into_iter()
    .enumerate()
    {
        let flags: Vec<&str> = method.iter().chain(&angles).copied().collect();
        let [one, two, three] = ["1", "2", "3"]
            .map(|threads| outputs(&folder, &dir.path().join(format!("out-{k}-{threads}")), threads, &flags));
        same(&one, &two, &flags);
        same(&one, &three, &flags);
        by_rays = one;
    }
    // Another seed gives other rays: the comparison above is not between constants.
    let flags: Vec<&str> =
        ["--method", "rays", "--rays", "40000", "--seed", "6"].iter().chain(&angles).copied().collect();
    let other = outputs(&folder, &dir.path().join("out-seed"), "2", &flags);
    let table = |files: &[(String, Vec<u8>)]| files.iter().find(|f| f.0 == "grooved.npz").unwrap().1.clone();
    assert!(table(&other) != table(&by_rays));
}

#[test]
fn synthesis_and_single_tables_too() {
    let dir = tempfile::tempdir().unwrap();
    let files = ["1", "2"].map(|threads| {
        let map = dir.path().join(format!("map-{threads}.x3p"));
        let made = asperity(words(&[
            &"synth",
            &"-o",
            &map,
            &"--sq",
            &"0.3um",
            &"--acl",
            &"6um",
            &"--size",
            &"200x120",
            &"--pitch",
            &"1um",
            &"--threads",
            &threads,
        ]));
        assert_eq!(made.code, 0, "{}", made.stderr);
        let table = dir.path().join(format!("table-{threads}.npz"));
        // The name of the map is part of the table: both read the first one.
        let first = dir.path().join("map-1.x3p");
        let run = asperity(words(&[&"brdf", &first, &"-o", &table, &"--threads", &threads, &"--method", &"facets"]));
        assert_eq!(run.code, 0, "{}", run.stderr);
        (std::fs::read(map).unwrap(), std::fs::read(table).unwrap())
    });
    assert!(files[0] == files[1]);
}
