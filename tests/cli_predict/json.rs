//! `--json`: one object on stdout, everything else on stderr.

use super::{QUICK, asperity, synth, words};
use serde_json::Value;

#[track_caller]
fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("{v} is not a number"))
}

#[track_caller]
fn check_gloss(gloss: &Value) {
    for angle in ["20", "60", "85"] {
        let g = &gloss[angle];
        assert!(number(&g["value"]) > 0.0 && number(&g["value"]) < 100.0);
        assert!(number(&g["standard_error"]) >= 0.0);
        assert!(number(&g["rayleigh_g"]) > 0.0 && g["ray_valid"].is_boolean());
    }
}

#[test]
fn predict_prints_one_object() {
    let dir = tempfile::tempdir().unwrap();
    let (map, bad, out) = (dir.path().join("a.x3p"), dir.path().join("b.x3p"), dir.path().join("out"));
    synth(&map, "0.2um", "1");
    std::fs::write(&bad, "no map").unwrap();
    let run =
        asperity(words(&[&"predict", &map, &bad, &"-o", &out, &"--json", &QUICK[0], &QUICK[1], &QUICK[2], &QUICK[3]]));
    // The failure is in the object, on stderr and in the exit code.
    assert_eq!(run.code, 1);
    let json = run.json();
    let maps = json["maps"].as_array().unwrap();
    assert_eq!(maps.len(), 1);
    let one = &maps[0];
    assert_eq!(one["map"], "a.x3p");
    // 24 correlation lengths wide: one map's Sq scatters by about 4 % about the 0.2 um asked for.
    assert!((number(&one["Sq_m"]) / 0.2e-6 - 1.0).abs() < 0.2);
    assert!((number(&one["Sdq"]) / (2.0 * 0.2 / 8.0) - 1.0).abs() < 0.2);
    assert_eq!(number(&one["missing_fraction"]), 0.0);
    assert_eq!(one["isotropic"], true);
    assert!(one["method"].is_string() && number(&one["seconds"]) >= 0.0);
    assert!(std::path::Path::new(one["table"].as_str().unwrap()).is_file());
    check_gloss(&one["gloss"]);
    assert!(one["warnings"].as_array().unwrap().iter().all(Value::is_string));
    assert_eq!(json["failed"].as_array().unwrap().len(), 1);
    assert_eq!(json["failed"][0]["file"], bad.display().to_string());
    assert!(json["failed"][0]["error"].as_str().unwrap().contains("b.x3p"));
    let outputs = json["outputs"].as_array().unwrap();
    assert_eq!(outputs.len(), 6, "table, CSV, chart, two pictures, report");
    assert!(outputs.iter().all(|o| std::path::Path::new(o.as_str().unwrap()).is_file()));
    assert!(number(&json["seconds"]) > 0.0);
    // At 0.2 um rays do not hold at 85 deg: the warning is for people, on stderr.
    assert!(run.stderr.contains("warning:") && run.stderr.contains("b.x3p"), "{}", run.stderr);
}

#[test]
fn brdf_gloss_tiles_synth_and_models_print_one_object() {
    let dir = tempfile::tempdir().unwrap();
    let (map, table, picture) = (dir.path().join("a.x3p"), dir.path().join("a.npz"), dir.path().join("a.png"));
    let made = asperity(words(&[
        &"synth", &"-o", &map, &"--sq", &"0.2um", &"--acl", &"8um", &"--size", &"128", &"--pitch", &"1um", &"--json",
    ]))
    .json();
    for field in ["width", "height", "pitch_x_m", "pitch_y_m", "Sq_m", "Sdq"] {
        assert!(number(&made[field]) > 0.0, "{field}");
    }

    let brdf = asperity(words(&[&"brdf", &map, &"-o", &table, &"--theta-i", &"0,30,60,80", &"--json"]));
    assert_eq!(brdf.code, 0, "{}", brdf.stderr);
    let brdf = brdf.json();
    assert!(brdf["method"].is_string() && number(&brdf["seconds"]) > 0.0);
    for field in ["theta_i_deg", "albedo", "albedo_se", "multiple_bounce_fraction", "lost_fraction"] {
        let list = brdf[field].as_array().unwrap_or_else(|| panic!("{field}"));
        assert_eq!(list.len(), 4, "{field}");
        assert!(list.iter().all(|v| number(v) >= 0.0), "{field}");
    }
    for (v, want) in brdf["theta_i_deg"].as_array().unwrap().iter().zip([0.0, 30.0, 60.0, 80.0]) {
        assert!((number(v) - want).abs() < 1e-12);
    }
    // R(0) of n = 1.5 is 0.04; slopes of 0.05 hardly change it.
    assert!((number(&brdf["albedo"][0]) - 0.04).abs() < 1e-4);

    let gloss = asperity(words(&[&"gloss", &table, &"beckmann:alpha=0.1,n=1.5", &"--json"]));
    assert_eq!(gloss.code, 0, "{}", gloss.stderr);
    let gloss = gloss.json();
    let sources = gloss["sources"].as_array().unwrap();
    assert_eq!(sources.len(), 2);
    check_gloss(&sources[0]["gloss"]);
    assert!(sources.iter().all(|s| s["source"].is_string() && s["method"].is_string()));

    let tiles =
        asperity(words(&[&"tiles", &table, &"-o", &picture, &"--json", &QUICK[0], &QUICK[1], &QUICK[2], &QUICK[3]]));
    assert_eq!(tiles.code, 0, "{}", tiles.stderr);
    assert_eq!(tiles.json()["outputs"][0], picture.display().to_string());
    assert!(picture.is_file());
    assert!(!asperity(["models", "--json"]).json()["models"].as_array().unwrap().is_empty());
}

/// A pipe shows no progress bar: stdout holds the table alone, stderr what was done to the map and the warnings.
#[test]
fn a_pipe_sees_no_progress_bar() {
    let dir = tempfile::tempdir().unwrap();
    let (map, out) = (dir.path().join("a.x3p"), dir.path().join("out"));
    synth(&map, "0.2um", "1");
    let run = asperity(words(&[&"predict", &map, &"-o", &out, &QUICK[0], &QUICK[1], &QUICK[2], &QUICK[3]]));
    assert_eq!(run.code, 0, "{}", run.stderr);
    for text in [&run.stdout, &run.stderr] {
        assert!(!text.contains('\r') && !text.contains('\u{1b}'), "{text}");
    }
    assert!(run.stderr.starts_with("a.x3p: removed plane") && run.stderr.contains("\nwarning:"), "{}", run.stderr);
    assert!(run.stdout.contains("a.x3p") && !run.stdout.contains("warning:"), "{}", run.stdout);
}
