//! Flat maps through the whole chain, file to gloss, against Fresnel closed forms.

use super::{asperity, words};
use asperity::optics::fresnel::dielectric;

const ANGLES: [&str; 3] = ["20", "60", "85"];

/// `100 R(n) / R(1.567)` of a flat n = 1.5, and of a perfect mirror, for a point source.
const GLASS: [f64; 3] = [82.0452, 89.1368, 98.9746];
const MIRROR: [f64; 3] = [2037.5687, 999.4400, 161.5122];

/// Gloss of a flat map for some flags.
fn flat(flags: &[&str]) -> [f64; 3] {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("flat.x3p");
    let made = asperity(words(&[&"synth", &"-o", &path, &"--sq", &"0", &"--size", &"96x64", &"--pitch", &"1um,1.5um"]));
    assert_eq!(made.code, 0, "{}", made.stderr);
    let mut call = words(&[&"gloss", &path, &"--json"]);
    call.extend(flags.iter().map(std::ffi::OsStr::new));
    let run = asperity(call);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let json = run.json();
    let gloss = &json["sources"][0]["gloss"];
    for angle in ANGLES {
        assert!(gloss[angle]["standard_error"].as_f64().unwrap() < 1e-6, "nothing here is random");
    }
    ANGLES.map(|angle| gloss[angle]["value"].as_f64().unwrap())
}

#[test]
fn a_small_source_reads_the_fresnel_ratio() {
    for (material, want) in [("n=1.5", GLASS), ("mirror", MIRROR)] {
        let standard = [20.0f64, 60.0, 85.0].map(|a| dielectric(a.to_radians().cos(), 1.567));
        if material == "mirror" {
            // The constants above are what the formula says.
            assert!(standard.iter().zip(want).all(|(r, g)| (100.0 / r - g).abs() < 5e-5));
        }
        let got = flat(&["--material", material, "--source-stop", "0.05,0.05"]);
        for (g, w) in got.iter().zip(want) {
            assert!((g - w).abs() < 2e-3, "{material}: {got:?}, expected {want:?}");
        }
    }
}

/// The instrument's source is 0.75 x 2.5 deg wide, over which R(1.567) cos(theta) bends: the flux of the standard
/// changes by +2e-5, +1.7e-4 and -5.9e-4 of itself at 20, 60 and 85 deg. Glass of n = 1.5 bends nearly alike, which
/// leaves 0.002 GU; a mirror does not bend, so its reading shifts by the standard's share: 0.17 GU at 60 deg and
/// 0.10 GU at 85 deg, more than the 0.05 GU that hold for the point source.
#[test]
fn the_standard_source_shifts_it_by_what_the_standard_bends() {
    let glass = flat(&["--material", "n=1.5"]);
    assert!(glass.iter().zip(GLASS).all(|(g, w)| (g - w).abs() < 2.5e-3), "{glass:?}");
    let mirror = flat(&["--material", "mirror"]);
    for ((g, w), shift) in mirror.iter().zip(MIRROR).zip([2e-5, 1.7e-4, -5.9e-4]) {
        assert!((g / (w * (1.0 - shift)) - 1.0).abs() < 1e-5, "{mirror:?}");
    }
}

/// The standard itself reads 100 at every angle with any source.
#[test]
fn black_glass_reads_100() {
    for source in ["0.75,2.5", "2,2"] {
        let got = flat(&["--material", "black-glass", "--source-stop", source]);
        assert!(got.iter().all(|g| (g - 100.0).abs() < 1e-6), "{got:?}");
    }
}
