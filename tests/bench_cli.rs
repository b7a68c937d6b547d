//! `asperity bench` as a user meets it: files, words, and that the errors do not depend on the machine.

use std::path::Path;
use std::process::Command;

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
    let svg = std::fs::read_to_string(one.join("accuracy_vs_time.svg")).unwrap();
    for word in ["naive rays, random places", "Kirchhoff", "alias tables", "subdivision", "slope -1/2", "seed 1"] {
        assert!(svg.contains(word), "{word}");
    }
}

/// What auto takes is within 5 % of every facet with its visibility when asked for 5 %. Asked for less, the tables' own
/// resolution on so small a map is in the comparison too: steep surfaces are up to 1.6 % off at cells for 1 %, but within
/// 0.1 % at the cells of the reference; the slope distribution of the satin one is 0.3 % off.
#[test]
fn choices_are_near_their_tolerance_and_the_file_tells_which_lie_beyond() {
    let dir = tempfile::tempdir().unwrap();
    let mut maps = Vec::new();
    for (name, sq, acl) in [("smooth", "0.1um", "20um"), ("satin", "0.5um", "12um"), ("steep", "1.5um", "8um")] {
        let path = dir.path().join(format!("{name}.x3p"));
        let made = Command::new(env!("CARGO_BIN_EXE_asperity"))
            .args(["synth", "--sq", sq, "--acl", acl, "--size", "256", "--pitch", "0.5um", "--exact", "-o"])
            .arg(&path)
            .output()
            .unwrap();
        assert!(made.status.success());
        maps.push(path.display().to_string());
    }
    let out = dir.path().join("out");
    let mut flags = vec!["--choice"];
    flags.extend(maps.iter().map(String::as_str));
    let run = bench(&out, &flags);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found = rows(&out.join("choice.csv"));
    assert_eq!(found.len(), 3 * 3 * 5);
    for row in &found {
        // Finer than 5 % the cells of the table of so small a map, not the method, decide: measured 1.6 % and 0.3 % at the most.
        let limit = match row[1].as_str() {
            "0.05" => 0.05,
            "0.01" => 0.02,
            _ => 0.005,
        };
        // Where waves serve there is nothing to compare with.
        let off = row[9].parse::<f64>().unwrap_or(0.0);
        assert!(off <= limit, "{row:?}");
        assert_eq!(row[12] == "true", off <= row[1].parse().unwrap(), "the file tells what lies beyond: {row:?}");
    }
    // All three ways to serve an angle occur, so the test is about a choice.
    for taken in ["waves", "slope distribution", "facet visibility"] {
        assert!(found.iter().any(|r| r[4] == taken), "{taken}");
    }
}

#[test]
fn bad_words_get_one_clear_error() {
    let dir = tempfile::tempdir().unwrap();
    for (flags, word) in [
        (&["--budget", "soon"][..], "no time"),
        (&["--scaling", "--budgets"], "cannot be used with"),
        (&["a.x3p", "b.x3p"], "one map is measured at a time"),
        (&["--budgets", "a.x3p"], "leave the MAP out"),
        (&["absent.x3p"], "absent.x3p"),
    ] {
        let run = bench(&dir.path().join("out"), flags);
        assert!(run.code != 0 && run.stderr.contains(word), "{flags:?}: {}", run.stderr);
    }
}
