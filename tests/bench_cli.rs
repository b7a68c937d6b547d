//! `asperity bench` as a user meets it: files, words, and that the errors do not depend on the machine.

use asperity::bench::choice::{ANGLES, choose};
use asperity::bench::surface::gaussian;
use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Edges, HeightMap, level::level};
use asperity::scatter::Footprint;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

fn bench(folder: &Path, flags: &[&str]) -> Run {
    let mut call = Command::new(env!("CARGO_BIN_EXE_asperity"));
    let out = call.arg("bench").args(flags).arg("-o").arg(folder).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    let (stdout, stderr) = (text(out.stdout), text(out.stderr));
    assert!(!stderr.contains("panicked"), "{stderr}");
    Run { code: out.status.code().expect("no signal"), stdout, stderr }
}

/// Fields of the rows of a CSV, without the comment and the head.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.starts_with("# ") && text.lines().next().unwrap().contains("core"), "the machine is stated");
    let fields = |line: &str| {
        let mut fields = vec![String::new()];
        let mut quoted = false;
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => fields.push(String::new()),
                c => fields.last_mut().unwrap().push(c),
            }
        }
        fields
    };
    text.lines().skip(2).map(fields).collect()
}

/// Every family and method is in files and charts, whatever the budget; the errors at an effort are those of any other run.
#[test]
fn a_small_budget_gives_all_files_and_repeatable_errors() {
    let dir = tempfile::tempdir().unwrap();
    let (one, two) = (dir.path().join("one"), dir.path().join("two"));
    for (folder, threads) in [(&one, "1"), (&two, "2")] {
        let run = bench(folder, &["--budget", "0.5s", "--repeats", "2", "--threads", threads]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(run.stdout.contains("naive rays") && run.stdout.contains("default"), "{}", run.stdout);
        for name in ["bench.csv", "bench.json", "accuracy_vs_time.svg", "accuracy_vs_time.png", "scatter_counts.svg"] {
            assert!(folder.join(name).metadata().unwrap().len() > 500, "{name}");
        }
    }
    let (a, b) = (rows(&one.join("bench.csv")), rows(&two.join("bench.csv")));
    let mut compared = 0;
    for row in &a {
        let same = b.iter().find(|other| other[..4] == row[..4]);
        if let Some(other) = same {
            assert_eq!(row[8..11], other[8..11], "{row:?}");
            compared += 1;
        }
    }
    assert!(compared >= 27, "{compared} of {} rows: every method has at least one", a.len());
    let families: std::collections::BTreeSet<&str> = a.iter().map(|r| r[0].as_str()).collect();
    assert_eq!(
        families.into_iter().collect::<Vec<_>>(),
        ["meter", "render", "sampling", "scatter_45", "scatter_75", "table"]
    );
    // Where all facets fit into the time, rays are compared with them at equal time.
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(one.join("bench.json")).unwrap()).unwrap();
    for found in json["equal_time"].as_array().unwrap() {
        let [ratio, rays, facets] = ["rays_error", "facets_error", "ratio"].map(|key| found[key].as_f64().unwrap());
        assert!((ratio / rays / facets - 1.0).abs() < 1e-9, "{found}");
    }
    let svg = std::fs::read_to_string(one.join("accuracy_vs_time.svg")).unwrap();
    for word in ["naive rays, random places", "Kirchhoff", "alias tables", "subdivision", "slope -1/2", "seed 1"] {
        assert!(svg.contains(word), "{word}");
    }
}

/// Rows that must hold: within the tolerance, exactly, of the costliest method in the same cells, plus the standard error of that
/// reference; and the cells move less than the tolerance plus the error of the count, or than another map of the surface would.
fn assert_chosen_well(map: &HeightMap, name: &str, tolerances: &[f64], taken: &mut BTreeSet<String>) {
    let rows = choose(map, name, tolerances).unwrap();
    assert_eq!(rows.len(), tolerances.len() * ANGLES.len());
    for row in rows {
        let text = format!(
            "{name} at {} deg for {}: {}, {:?} off facets, {:?} off the count, {:.4} map, {:?} off waves",
            row.theta_i_deg, row.tolerance, row.taken, row.from_facets, row.from_count, row.map_error, row.from_waves
        );
        eprintln!("{text}");
        let costliest = if row.taken == "waves" { row.from_waves } else { row.from_facets };
        assert!(costliest.unwrap() <= row.tolerance + row.from_facets_se.unwrap_or(0.0) && row.within, "{text}");
        let counted = row.from_count.unwrap_or(0.0);
        assert!(counted <= (row.tolerance + row.from_count_se.unwrap_or(0.0)).max(row.map_error), "{text}");
        // The average over azimuths is smooth enough for the cells of every tolerance, whatever the map's own error.
        assert!(!row.isotropic || counted <= row.tolerance + row.from_count_se.unwrap_or(0.0), "{text}");
        assert!(row.resolved, "{text}");
        // Rays serve only where waves say the same.
        assert!(row.waves_agree != Some(false), "{text}");
        taken.insert(row.taken);
    }
}

#[test]
fn auto_is_never_further_from_the_costliest_method_than_its_tolerance() {
    let mut taken = BTreeSet::new();
    for (name, sq, acl) in [("smooth", 0.1e-6, 20e-6), ("satin", 0.5e-6, 12e-6), ("steep", 1.5e-6, 8e-6)] {
        let map = gaussian(256, 0.5e-6, sq, acl, 1).unwrap();
        assert_chosen_well(&map, name, &[0.05, 0.01], &mut taken);
    }
    // The finest tolerance, on a map small enough for a test.
    assert_chosen_well(&gaussian(256, 0.5e-6, 0.5e-6, 12e-6, 2).unwrap(), "satin", &[0.001], &mut taken);
    // All three ways to serve an angle occur, so the test is about a choice.
    assert_eq!(
        taken.iter().map(String::as_str).collect::<Vec<_>>(),
        ["facet visibility", "slope distribution", "waves"]
    );
}

/// Maps that instruments wrote: one whose heights come in steps, one with gaps and walls, both with a direction; one of a polished
/// surface, which waves serve. At most 256 x 256 points of each.
#[test]
fn auto_holds_its_tolerance_on_real_maps() {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/heightmaps");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let mut taken = BTreeSet::new();
    for name in ["al3d-1.al3d", "sample-land.x3p", "nms-1.nms"] {
        let path = folder.join("real").join(name);
        if !path.exists() {
            eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder of real height maps", path.display());
            return;
        }
        let whole = level(&read(&path, &ReadOptions::default()).unwrap(), Edges::Open).unwrap();
        let part = |n: usize| [0, n.min(255)];
        let cells = [whole.width() - 1, whole.height() - 1].map(part);
        let map = Footprint { columns: cells[0], rows: cells[1] }.cut(&whole);
        assert_chosen_well(&map, name, &[0.05, 0.01], &mut taken);
    }
    assert_eq!(taken.len(), 3, "{taken:?}");
}

/// The file and the words of `--choice`.
#[test]
fn choices_are_written_down() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("small.x3p");
    let made = Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(["synth", "--sq", "0.3um", "--acl", "6um", "--size", "96", "--pitch", "0.5um", "--exact", "-o"])
        .arg(&path)
        .output()
        .unwrap();
    assert!(made.status.success());
    let out = dir.path().join("out");
    let run = bench(&out, &["--choice", "--tolerance", "5%,0.02", &path.display().to_string()]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("lie beyond their tolerance of the costliest method"), "{}", run.stdout);
    let found = rows(&out.join("choice.csv"));
    assert_eq!(found.len(), 2 * ANGLES.len());
    assert!(found[0][1] == "0.05" && found[ANGLES.len()][1] == "0.02", "in the order asked for: {found:?}");
    for row in &found {
        assert_eq!(row.len(), 21, "{row:?}");
        let [tolerance, off, error] = [1, 10, 11].map(|k| row[k].parse::<f64>());
        if let (Ok(tolerance), Ok(off), Ok(error)) = (tolerance, off, error) {
            assert_eq!(row[19] == "true", off <= tolerance + error, "the file tells what lies beyond: {row:?}");
        }
    }
}

/// `asperity ... | head -1` ends without a word of Rust.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_left_quietly() {
    for flags in [&["models"][..], &["models", "--json"]] {
        // The reader has gone before the program starts: a pipe takes the whole text of a quick one.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut call = Command::new(env!("CARGO_BIN_EXE_asperity"));
        let out = call.args(flags).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(out.status.code(), Some(141), "{}", String::from_utf8_lossy(&out.stderr));
        assert!(out.stderr.is_empty(), "{}", String::from_utf8_lossy(&out.stderr));
    }
}

#[test]
fn bad_words_get_one_clear_error() {
    let dir = tempfile::tempdir().unwrap();
    for (flags, word) in [
        (&["--budget", "soon"][..], "no time"),
        (&["--scaling", "--budgets"], "cannot be used with"),
        (&["--choice", "--tolerance", "200%"], "not between 0% and 100%"),
        (&["a.x3p", "b.x3p"], "one map is measured at a time"),
        (&["--budgets", "a.x3p"], "leave the MAP out"),
        (&["absent.x3p"], "absent.x3p"),
    ] {
        let run = bench(&dir.path().join("out"), flags);
        assert!(run.code != 0 && run.stderr.contains(word), "{flags:?}: {}", run.stderr);
    }
}
