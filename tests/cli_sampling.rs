//! `asperity eval`, `sample` and `check` as a user meets them: the files, the words, the exit code.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs in `folder`; words are split at spaces.
fn call(folder: &Path, line: &str) -> Output {
    let words = line.split_whitespace();
    Command::new(env!("CARGO_BIN_EXE_asperity")).current_dir(folder).args(words).output().expect("the program starts")
}

#[track_caller]
fn run(folder: &Path, line: &str) -> String {
    let done = call(folder, line);
    assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// A call that fails with one error that says all of `words`, and writes nothing.
#[track_caller]
fn refuse(folder: &Path, line: &str, words: &[&str]) {
    let before = names(folder);
    let done = call(folder, line);
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(!done.status.success(), "{line} should fail");
    assert!(words.iter().all(|w| text.contains(w)), "{line}: {text}");
    assert!(!text.contains("panicked"), "{line}: {text}");
    assert_eq!(names(folder), before, "{line}");
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

/// A folder with an anisotropic map, its table and a list of directions.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), "synth -o map.x3p --sq 0.3um --acl 6um --size 128x96 --pitch 1um,2.5um --seed 4");
    run(dir.path(), "brdf map.x3p -o table.npz --method geometric");
    let rows = "# a comment\nphi_r_deg, theta_i_deg,phi_i_deg,theta_r_deg\n180,30,0,30\n190,45,20,40\n0,30,180,30\n20,40,190,45\n";
    std::fs::write(dir.path().join("directions.csv"), rows).unwrap();
    dir
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn eval_tells_values_with_their_errors() {
    let dir = folder();
    let text = run(dir.path(), "eval table.npz --directions directions.csv");
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect();
    assert!(text.starts_with("theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg,f_r_per_sr,standard_error\n"), "{text}");
    assert_eq!(rows.len(), 4);
    assert_eq!(rows[1][..4], [45.0, 20.0, 40.0, 190.0]);
    // The scatter from sub-area to sub-area reaches the error of every value.
    assert!(rows.iter().all(|r| r[4] > 0.0 && r[5] > 0.0 && r[5] < r[4]), "{rows:?}");
    let answer = json(&run(dir.path(), "eval table.npz --directions directions.csv --reciprocal --json"));
    assert_eq!(answer["reciprocity_enforced"], true);
    let value = |k: usize| answer["directions"][k]["f_r_per_sr"].as_f64().unwrap();
    assert!((value(1) / value(3) - 1.0).abs() < 1e-12);
    assert!((2.0 * value(1) / (rows[1][4] + rows[3][4]) - 1.0).abs() < 1e-6);
    run(dir.path(), "eval table.npz --directions directions.csv -o values.csv");
    assert_eq!(std::fs::read_to_string(dir.path().join("values.csv")).unwrap(), text);
}

#[test]
fn eval_says_which_line_is_wrong() {
    let dir = folder();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    write("column.csv", "theta_i_deg,phi_i_deg,theta_r_deg\n1,2,3\n");
    write("number.csv", "theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg\n1,2,3,4\n1,2,x,4\n");
    write("angle.csv", "theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg\n95,2,3,4\n");
    write("empty.csv", "");
    write("header.csv", "theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg\n");
    let mut table = std::fs::read(dir.path().join("table.npz")).unwrap();
    table.truncate(table.len() / 2);
    std::fs::write(dir.path().join("half.npz"), table).unwrap();
    let eval = |name: &str, words: &[&str]| refuse(dir.path(), &format!("eval table.npz --directions {name}"), words);
    eval("column.csv", &["column.csv", "phi_r_deg"]);
    eval("number.csv", &["number.csv", "line 3", "theta_r_deg", "`x`"]);
    eval("angle.csv", &["angle.csv", "line 2", "95"]);
    eval("empty.csv", &["empty.csv", "empty"]);
    eval("header.csv", &["header.csv", "no rows"]);
    eval("none.csv", &["none.csv"]);
    refuse(dir.path(), "eval none.npz --directions directions.csv", &["none.npz"]);
    refuse(dir.path(), "eval half.npz --directions directions.csv", &["half.npz"]);
    refuse(dir.path(), "eval nonsense:alpha=1 --directions directions.csv", &["nonsense"]);
}

#[test]
fn sample_writes_draws_that_carry_the_albedo() {
    let dir = folder();
    let answer = json(&run(dir.path(), "sample table.npz --theta-i 50 --phi-i 30 -n 20000 -o draws.npy --json"));
    let bytes = std::fs::read(dir.path().join("draws.npy")).unwrap();
    assert!(bytes.starts_with(b"\x93NUMPY") && bytes.windows(10).any(|w| w == b"(20000, 5)"));
    let data = &bytes[bytes.len() - 20_000 * 40..];
    let values: Vec<f64> = data.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    for row in values.chunks(5).filter(|row| row[4] > 0.0) {
        assert!((row[0].hypot(row[1]).hypot(row[2]) - 1.0).abs() < 1e-9 && row[2] > 0.0 && row[3] > 0.0, "{row:?}");
    }
    let mean = &answer["mean_weight"];
    let (value, error) = (mean["value"].as_f64().unwrap(), mean["standard_error"].as_f64().unwrap());
    let albedo = answer["albedo"].as_f64().unwrap();
    assert!((value - albedo).abs() < 4.0 * error + 1e-3 * albedo, "{value} +- {error}, albedo {albedo}");
    run(dir.path(), "sample table.npz --theta-i 50 --phi-i 30 -n 20000 -o again.npy");
    assert_eq!(bytes, std::fs::read(dir.path().join("again.npy")).unwrap());
    refuse(dir.path(), "sample table.npz --theta-i 20,50 -o two.npy", &["--theta-i", "2 values"]);
    refuse(dir.path(), "sample table.npz --theta-i 90 -o below.npy", &["below 90"]);
    refuse(dir.path(), "sample table.npz -o none.npy", &["--theta-i"]);
}

#[test]
fn check_passes_what_is_sound_and_names_what_is_not() {
    let dir = folder();
    let answer = json(&run(dir.path(), "check table.npz --draws 20000 --json"));
    assert_eq!(answer["audit"]["passed"], true);
    assert_eq!(answer["reciprocity_enforced"], false);
    assert!(answer["audit"]["rows"].as_array().unwrap().len() >= 20);
    let text = run(dir.path(), "check beckmann:alpha=0.05,n=1.5 --draws 20000");
    assert!(text.contains("every statement holds"), "{text}");
    // Phong's first formula is not reciprocal and gains energy towards the horizon.
    let done = call(dir.path(), "check phong:rho_s=0.6,exponent=10,form=original --draws 20000");
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    assert_eq!(done.status.code(), Some(1), "{text}{}", String::from_utf8_lossy(&done.stderr));
    assert!(text.contains("FAULT"), "{text}");
    refuse(dir.path(), "check none.npz", &["none.npz"]);
}

/// Where one azimuth serves for all, those named are kept all the same; where the table is averaged over them, that is said.
#[test]
fn named_azimuths_are_kept_or_spoken_of() {
    let dir = folder();
    let few = json(&run(dir.path(), "brdf map.x3p -o one.npz --method kirchhoff --symmetry anisotropic --json"));
    assert_eq!(few["phi_i_deg"], serde_json::json!([0.0]));
    let named = "brdf map.x3p -o named.npz --method kirchhoff --theta-i 0,45,80 --phi-i 10,130,250 --symmetry anisotropic --json";
    let kept = json(&run(dir.path(), named));
    assert_eq!(kept["phi_i_deg"], serde_json::json!([10.0, 130.0, 250.0]));
    let done = call(dir.path(), "brdf map.x3p -o round.npz --symmetry isotropic --phi-i 10,130 --theta-i 0,45");
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success() && text.contains("--phi-i has no effect"), "{text}");
}
