//! `asperity brdf` with detectors, footprint and parts, as a user meets it: the files, the words, the exit code.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Output};

fn asperity<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).output().expect("the program starts")
}

/// A call that succeeds; words are split at spaces, paths given for `MAP` and `OUT`.
#[track_caller]
fn run(line: &str, map: &Path, out: &Path) -> Output {
    let done = call(line, map, out);
    assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
    done
}

fn call(line: &str, map: &Path, out: &Path) -> Output {
    asperity(line.split_whitespace().map(|word| match word {
        "MAP" => map.as_os_str(),
        "OUT" => out.as_os_str(),
        other => OsStr::new(other),
    }))
}

/// A steep map of 96 x 64 points at 1 um x 2 um.
fn synth(folder: &Path) -> std::path::PathBuf {
    let map = folder.join("map.x3p");
    run("synth -o OUT --sq 1.5um --acl 6um --size 96x64 --pitch 1um,2um --seed 4", &map, &map);
    map
}

/// Rows of a CSV by column.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(str::to_owned).collect();
    (names, lines.map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect())
}

#[test]
fn klems_rows_are_the_contract() {
    let dir = tempfile::tempdir().unwrap();
    let (map, out) = (synth(dir.path()), dir.path().join("k.csv"));
    let done = run("brdf MAP -o OUT --detectors klems --theta-i 20,60 --material mirror --json", &map, &out);
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let (names, rows) = table(&out);
    assert_eq!(
        names[..9],
        [
            "index",
            "theta_min_deg",
            "theta_max_deg",
            "phi_min_deg",
            "phi_max_deg",
            "projected_solid_angle_sr",
            "energy_fraction",
            "f_r_per_sr",
            "standard_error"
        ]
    );
    assert_eq!(rows.len(), 2 * 145);
    assert_eq!(rows[1][..5], [1.0, 5.0, 15.0, -22.5, 22.5]);
    for (t, rows) in rows.chunks(145).enumerate() {
        assert!(rows.iter().enumerate().all(|(k, row)| row[0] as usize == k));
        let energy: f64 = rows.iter().map(|row| row[6]).sum();
        assert!((energy - json["albedo"][t].as_f64().unwrap()).abs() < 1e-12);
        let omega: f64 = rows.iter().map(|row| row[5]).sum();
        assert!((omega - std::f64::consts::PI).abs() < 1e-12);
        for row in rows {
            assert!((row[7] * row[5] - row[6]).abs() < 1e-12 && row[8] > 0.0, "{row:?}");
        }
        let bounces: f64 = (0..3).map(|b| json["bounce_fractions"][t][b].as_f64().unwrap()).sum();
        assert!((bounces - energy).abs() < 1e-12);
    }
    for name in ["method", "seconds", "theta_i_deg", "albedo_se", "multiple_bounce_fraction", "lost_fraction"] {
        assert!(!json[name].is_null(), "{name}");
    }
    assert_eq!(json["facets"], 2 * 95 * 63);
    assert_eq!(json["theta_i_deg"], serde_json::json!([20.0, 60.0]));
}

#[test]
fn every_partition_writes_its_rows() {
    let dir = tempfile::tempdir().unwrap();
    let map = synth(dir.path());
    for (partition, rows) in
        [("theta-phi:10,30", 1 + 9 * 12), ("equal-area:100", 100), ("shirley-chiu:3", 64), ("half-vector", 0)]
    {
        let out = dir.path().join("d.csv");
        for more in [
            "",
            "--symmetry isotropic",
            "--method rays --rays 5000",
            "--footprint 0.2,0.2,0.8,0.8",
            "--method kirchhoff --symmetry isotropic",
            "--wavelength 40um",
        ] {
            let line = format!("brdf MAP -o OUT --detectors {partition} --theta-i 45 --phi-i 30 {more}");
            run(&line, &map, &out);
            let (_, found) = table(&out);
            assert!(found.len() == rows || rows == 0 && found.len() > 100, "{line}: {}", found.len());
            assert!(found.iter().flatten().all(|x| x.is_finite()), "{line}");
        }
    }
}

/// By default waves serve where the surface is too smooth for rays; it is said of every angle, in rows and tables alike.
#[test]
fn every_angle_has_its_reason() {
    let dir = tempfile::tempdir().unwrap();
    let map = synth(dir.path());
    for (file, more) in [("d.csv", "--detectors klems"), ("t.npz", ""), ("f.npz", "--footprint 0.2,0.2,0.8,0.8")] {
        let out = dir.path().join(file);
        let line = format!("brdf MAP -o OUT --theta-i 20,60 --wavelength 4um --json {more}");
        let json: serde_json::Value = serde_json::from_slice(&run(&line, &map, &out).stdout).unwrap();
        assert_eq!(json["waves"], serde_json::json!([false, true]), "{line}: {json}");
        assert!(json["reasons"][1].as_str().unwrap().contains("is below 9"), "{line}: {json}");
        assert!(json["method"].as_str().unwrap().contains("waves from 60 deg"), "{line}: {json}");
        let facets = json["facets"].as_u64().unwrap();
        assert_eq!(facets, if more.contains("footprint") { 2 * 57 * 38 } else { 2 * 95 * 63 });
        let text = run(&line.replace("--json", ""), &map, &out).stdout;
        assert!(String::from_utf8_lossy(&text).contains("wave (Kirchhoff): g = "));
    }
}

/// One run, two threads, and four parts on either number of threads: the same bytes.
#[test]
fn threads_and_parts_give_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let map = synth(dir.path());
    for (name, flags) in [
        ("k.csv", "--detectors klems --theta-i 0,75 --method facets"),
        ("r.csv", "--detectors equal-area:50 --theta-i 70 --method rays --rays 100000 --footprint 0.1,0.1,0.9,0.9"),
        ("t.npz", "--theta-i 0,45,80 --phi-i 0,90 --symmetry anisotropic"),
        ("w.csv", "--detectors klems --theta-i 0,75 --wavelength 8um"),
        ("f.npz", "--theta-i 0,60 --footprint 0.1,0.1,0.9,0.9 --method facets"),
        ("u.npz", "--theta-i 0,45,80 --method rays --rays 100000 --symmetry isotropic --edges mirrored"),
    ] {
        let file = |folder: &str| {
            std::fs::create_dir_all(dir.path().join(folder)).unwrap();
            dir.path().join(folder).join(name)
        };
        let (one, two, merged) = (file("one"), file("two"), file("merged"));
        run(&format!("brdf MAP -o OUT --threads 1 {flags}"), &map, &one);
        run(&format!("brdf MAP -o OUT --threads 2 {flags}"), &map, &two);
        let parts: Vec<String> = (1..=4)
            .map(|k| {
                let part = dir.path().join(format!("{name}-{k}.json"));
                run(&format!("brdf MAP -o OUT --threads {} {flags} --part {k}/4", 1 + k % 2), &map, &part);
                part.display().to_string()
            })
            .collect();
        run(&format!("brdf MAP -o OUT {flags} --merge {}", parts.join(" ")), &map, &merged);
        let [one, two, merged] = [one, two, merged].map(|path| std::fs::read(path).unwrap());
        assert!(one == two, "{name}: threads show");
        assert!(one == merged, "{name}: parts show");
        // The parts of another run are refused.
        let other =
            call(&format!("brdf MAP -o OUT {flags} --seed 9 --merge {}", parts.join(" ")), &map, &file("other"));
        let said = String::from_utf8_lossy(&other.stderr).into_owned();
        assert!(!other.status.success() && said.contains("other options"), "{said}");
    }
}

#[test]
fn mistakes_are_explained() {
    let dir = tempfile::tempdir().unwrap();
    let map = synth(dir.path());
    for (line, code, word) in [
        ("brdf MAP -o out.npz --detectors klems", 2, "go to a .csv file"),
        ("brdf MAP -o out.txt", 2, "name it .npz for a table"),
        ("brdf MAP -o out.csv --detectors kelms", 2, "half-vector, klems"),
        ("brdf MAP -o out.csv --detectors theta-phi:5,7", 2, "divides 360"),
        ("brdf MAP -o out.csv --footprint 0.9,0,0.1,1", 2, "X0 < X1"),
        ("brdf MAP -o out.csv --footprint 0,0,2,1", 2, "beyond"),
        ("brdf MAP -o out.csv --part 5/4", 2, "no part 5 of 4"),
        ("brdf MAP -o out.csv --part 1/4", 2, "name it .json"),
        ("brdf MAP -o out.csv --merge absent.json", 1, "absent.json"),
        ("brdf MAP -o out.csv --part 1/2 --merge a", 2, "cannot be used with"),
    ] {
        let done = call(line, &map, &map);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "{line}: {said}");
        assert!(said.contains(word) && !said.contains("panicked"), "{line}: {said}");
    }
}

/// Ctrl-C ends a long run at once; the old output stays, nothing half written is left.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing_half_done() {
    let dir = tempfile::tempdir().unwrap();
    let map = synth(dir.path());
    let out = dir.path().join("t.csv");
    std::fs::write(&out, "old").unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(["brdf", "--method", "rays", "--rays", "100000000000", "--theta-i", "60", "-o"])
        .arg(&out)
        .arg(&map)
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(child.try_wait().unwrap().is_none(), "the run ended before it could be interrupted");
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "old");
    let names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
}
