//! Maps from three instruments through the whole chain.

use super::{QUICK, asperity, listing, shared, words};

/// File, Sq [nm] and missing points [%] as the collection's README states them, and half a unit of the last digit
/// of the latter.
const MAPS: [(&str, f64, f64, f64); 3] = [
    ("real/opd-1.opd", 6.71, 0.038, 0.0005),
    ("real/x3p-2.x3p", 77.193, 0.0, 0.0),
    ("real/valid_zygo_dat_file.dat", 44.6, 25.7, 0.05),
];

#[test]
fn instrument_files_report_what_the_collection_says() {
    let Some(paths) = MAPS.iter().map(|m| shared(m.0)).collect::<Option<Vec<_>>>() else { return };
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    // Few angles: this is about reading and reporting, not about lobes.
    let run = asperity(words(&[
        &"predict",
        &paths[0],
        &paths[1],
        &paths[2],
        &"-o",
        &out,
        &"--theta-i",
        &"0,30,60",
        &"--json",
        &QUICK[0],
        &QUICK[1],
        &QUICK[2],
        &QUICK[3],
    ]));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let json = run.json();
    for (path, sq, missing, half_digit) in MAPS {
        let name = path.rsplit('/').next().unwrap();
        let one = json["maps"].as_array().unwrap().iter().find(|m| m["map"] == name).expect(name);
        let got = one["Sq_m"].as_f64().unwrap() * 1e9;
        assert!((got / sq - 1.0).abs() < 1e-3, "{name}: Sq {got} nm, README {sq} nm");
        let got = one["missing_fraction"].as_f64().unwrap() * 100.0;
        assert!((got - missing).abs() <= half_digit, "{name}: {got} % missing, README {missing} %");
        for angle in ["20", "60", "85"] {
            let g = &one["gloss"][angle];
            let (value, error) = (g["value"].as_f64().unwrap(), g["standard_error"].as_f64().unwrap());
            // No surface of n = 1.5 outshines its own mirror: 98.97 GU at 85 deg is the most.
            assert!(value > 0.0 && value < 99.0 + 3.0 * error, "{name} at {angle}: {g}");
        }
    }
    // The grooves of x3p-2 make it anisotropic; its loss of gloss is real.
    let grooved = json["maps"].as_array().unwrap().iter().find(|m| m["map"] == "x3p-2.x3p").unwrap();
    assert_eq!(grooved["isotropic"], false);
    assert_eq!(
        listing(&out),
        [
            "gloss.csv",
            "gloss_vs_roughness.svg",
            "opd-1.npz",
            "report.html",
            "tiles.exr",
            "tiles.png",
            "valid_zygo_dat_file.npz",
            "x3p-2.npz"
        ]
    );
    let csv = std::fs::read_to_string(out.join("gloss.csv")).unwrap();
    let row = csv.lines().find(|l| l.starts_with("valid_zygo")).unwrap();
    let fraction: f64 = row.split(',').nth(3).unwrap().parse().unwrap();
    assert!((fraction - 0.257).abs() <= 0.0005, "{row}");
}
