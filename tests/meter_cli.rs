//! The light meter on the command line: what a script relies on, and what a bad instrument says.

use std::process::Command;

fn asperity(arguments: &[&str]) -> (i32, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (run.status.code().unwrap_or(-1), text(&run.stdout), text(&run.stderr))
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let (code, out, err) = asperity(arguments);
    assert_eq!(code, 0, "{err}");
    serde_json::from_str(&out).expect("one JSON object")
}

#[test]
fn gloss_json_carries_the_usual_set_and_the_instruments() {
    let dir = tempfile::tempdir().unwrap();
    let csv = dir.path().join("gloss.csv").display().to_string();
    let found = json(&["gloss", "dielectric:n=1.567", "--instrument", "haze-20", "--check", "--csv", &csv, "--json"]);
    let source = &found["sources"][0];
    for angle in ["20", "60", "85"] {
        assert!((source["gloss"][angle]["value"].as_f64().unwrap() - 100.0).abs() < 1e-9);
        assert_eq!(source["gloss"][angle]["standard_error"], 0.0);
    }
    assert_eq!(source["haze"]["value"], 0.0);
    assert_eq!(source["doi"]["value"], 100.0);
    assert_eq!(source["method"], "model");
    assert_eq!(source["converged"], true);
    let reading = &source["instruments"][0]["readings"][0];
    assert_eq!(reading["name"], "gloss");
    assert!((reading["by_subdivision"]["value"].as_f64().unwrap() - 100.0).abs() < 1e-9);
    let rows = std::fs::read_to_string(&csv).unwrap();
    assert!(rows.starts_with("source,instrument,reading,value,standard_error\n") && rows.contains(",haze-20,haze,0.0"));
}

#[test]
fn an_instrument_is_printed_changed_and_read_with() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("mine.toml");
    let (code, toml, _) = asperity(&["instrument", "gloss-60"]);
    assert_eq!(code, 0);
    std::fs::write(&file, toml.replace("gloss-60", "ours").replace("index = 1.567", "index = 1.5")).unwrap();
    let path = file.display().to_string();
    let found = json(&["gloss", "dielectric:n=1.5", "--instrument", &path, "--json"]);
    let sheet = &found["sources"][0]["instruments"][0];
    assert_eq!(sheet["instrument"], "ours");
    assert!((sheet["readings"][0]["value"].as_f64().unwrap() - 100.0).abs() < 1e-9);
    std::fs::write(&file, toml.replacen("4.4", "-4.4", 1)).unwrap();
    let (code, _, error) = asperity(&["gloss", "mirror", "--instrument", &path]);
    assert!(code == 1 && error.contains("mine.toml") && error.contains("-4.4 deg"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    let (code, _, error) = asperity(&["gloss", "mirror", "--instrument", "gloss-61"]);
    assert!(code == 2 && error.contains("gloss-60"), "{error}");
}

#[test]
fn a_scan_is_csv_and_chart() {
    let dir = tempfile::tempdir().unwrap();
    let (csv, png) = (dir.path().join("s.csv"), dir.path().join("s.png"));
    let (code, out, error) = asperity(&[
        "scan",
        "lambert:rho=0.5",
        "--theta-i",
        "20",
        "--from",
        "-60",
        "--to",
        "60",
        "--step",
        "20",
        "-o",
        &csv.display().to_string(),
        "--chart",
        &png.display().to_string(),
    ]);
    assert!(code == 0 && out.contains("wrote"), "{error}");
    let text = std::fs::read_to_string(csv).unwrap();
    assert_eq!(text.lines().count(), 8);
    for line in text.lines().skip(1) {
        let f_r: f64 = line.split(',').nth(4).unwrap().parse().unwrap();
        assert!((f_r - 0.5 / std::f64::consts::PI).abs() < 1e-3, "{line}");
    }
    assert!(std::fs::read(png).unwrap().starts_with(b"\x89PNG"));
    let (code, _, error) = asperity(&["scan", "lambert:rho=0.5", "--step", "0"]);
    assert!(code == 2 && error.contains("step"), "{error}");
}

#[test]
fn correspondence_prints_a_table_of_any_model() {
    let found = json(&["correspondence", "beckmann:n=1.567", "--vary", "alpha=0.01..0.02", "--steps", "2", "--json"]);
    let rows = found["correspondence"][0]["rows"].as_array().unwrap();
    assert!((rows[0]["gloss"]["20"]["value"].as_f64().unwrap() - 65.656).abs() < 0.05);
    assert!((rows[1]["haze"]["value"].as_f64().unwrap() - 40.752).abs() < 0.05);
    let (code, _, error) = asperity(&["correspondence", "ward:rho_s=0.1", "--vary", "alpha=0.5..0.1"]);
    assert!(code == 2 && error.contains("rising"), "{error}");
}
