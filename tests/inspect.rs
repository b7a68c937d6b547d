//! `inspect`, `convert` and `synth` as a user runs them.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn asperity(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asperity"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}

fn good(folder: &Path, arguments: &str) -> Output {
    let output = asperity(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON object on stdout")
}

/// Names that other programs rely on, and the values of a surface that is known.
#[test]
fn json_has_the_fields_of_the_contract() {
    let folder = tempfile::tempdir().unwrap();
    let made =
        "synth -o m.x3p --sq 100nm --acl 8um --size 256x192 --pitch 0.5um,0.75um --exact --seed 3 --dropouts 0.01";
    good(folder.path(), made);
    let output = good(folder.path(), "inspect m.x3p --json --keep-tilt");
    let found = json(&output);
    for name in [
        "width",
        "height",
        "pitch_x_m",
        "pitch_y_m",
        "missing_fraction",
        "Sa_m",
        "Sq_m",
        "Ssk",
        "Sku",
        "Sz_m",
        "Sdq",
        "Sdr",
        "Sal_m",
        "Str",
        "slope_rms_x",
        "slope_rms_y",
    ] {
        assert!(found[name].is_number(), "{name} in {found}");
    }
    assert_eq!((found["width"].as_u64(), found["height"].as_u64()), (Some(256), Some(192)));
    let number = |name: &str| found[name].as_f64().unwrap();
    let close = |name: &str, expected: f64, relative: f64| {
        assert!((number(name) / expected - 1.0).abs() < relative, "{name}: {} {expected}", number(name));
    };
    close("pitch_x_m", 0.5e-6, 1e-12);
    close("pitch_y_m", 0.75e-6, 1e-12);
    close("Sq_m", 1e-7, 5e-3);
    // round(0.01 * 256 * 192) of them.
    close("missing_fraction", 492.0 / 49152.0, 1e-9);
    close("Sal_m", 8e-6 * 5f64.ln().sqrt(), 0.1);
    close("slope_rms_x", 1e-7 * 2f64.sqrt() / 8e-6, 0.05);
    close("Sdq", number("slope_rms_x").hypot(number("slope_rms_y")), 1e-9);
    assert!(found["rays"]["60"]["ray_valid"] == false && found["rays"]["20"]["rayleigh_g"].as_f64().unwrap() > 4.0);
    // Too smooth for rays: said on stderr, not on stdout.
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("warning") && said.contains("Rayleigh"), "{said}");
}

#[test]
fn one_screen_of_facts() {
    let folder = tempfile::tempdir().unwrap();
    good(folder.path(), "synth -o m.npy --sq 100nm --acl 8um --size 128 --pitch 0.5um");
    let output = good(folder.path(), "inspect m.npy --pitch 0.5um --unit m");
    let text = String::from_utf8(output.stdout).unwrap();
    for word in
        ["read as", "npy", "128 x 128", "500.0 nm", "Sq", "Sdr", "Sal", "slope rms x", "bandwidth", "g = ", "missing"]
    {
        assert!(text.contains(word), "{word} in\n{text}");
    }
    assert!(text.lines().count() <= 24 && text.lines().all(|l| l.chars().count() <= 120), "{text}");
}

/// The page is a picture of four panels: each has ink, and the margins have none.
#[test]
fn the_page_is_filled_and_kept_inside_its_margins() {
    let folder = tempfile::tempdir().unwrap();
    for (k, made) in [
        "--sq 300nm --acl 6um --size 200x150 --pitch 0.5um,1um --dropouts 0.02",
        "--shape brushed --acl 40um,3um --angle 20 --size 300 --pitch 0.5um",
        "--sq 0 --size 40x300 --pitch 1mm",
        "--shape cap --radius 20mm --size 900x100 --pitch 1um",
        "--shape sawtooth --slope 2 --period 8um --size 64 --pitch 0.5um --spikes 0.01 --spike-height 50um",
    ]
    .into_iter()
    .enumerate()
    {
        good(folder.path(), &format!("synth -o m{k}.x3p --samples f64 {made}"));
        good(folder.path(), &format!("inspect m{k}.x3p -o p{k}.png --keep-tilt"));
        let page = image::open(folder.path().join(format!("p{k}.png"))).unwrap().to_rgb8();
        let (w, h) = page.dimensions();
        assert!(w == 1680 && h > 1300, "{w} x {h}");
        let white = |x: u32, y: u32| page.get_pixel(x, y).0 == [255; 3];
        assert!(
            (0..h).all(|y| (0..12).all(|d| white(d, y) && white(w - 1 - d, y))),
            "ink in the side margins of {made}"
        );
        assert!(
            (0..w).all(|x| (0..12).all(|d| white(x, d) && white(x, h - 1 - d))),
            "ink in the other margins of {made}"
        );
        for (x0, y0) in [(40, 76), (860, 76), (40, 656), (860, 656)] {
            let ink = (x0..x0 + 780).flat_map(|x| (y0..y0 + 540).map(move |y| (x, y))).filter(|&(x, y)| !white(x, y));
            assert!(ink.count() > 4000, "panel at {x0}, {y0} of {made} is empty");
        }
        // The same map, the same bytes.
        good(folder.path(), &format!("--threads 1 inspect m{k}.x3p -o q{k}.png --keep-tilt"));
        let bytes = |name: String| std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes(format!("p{k}.png")) == bytes(format!("q{k}.png")));
    }
}

#[test]
fn a_map_survives_every_conversion() {
    let folder = tempfile::tempdir().unwrap();
    let made = "synth -o a.sdf --sq 100nm --acl 8um --size 65x48 --pitch 0.5um,0.75um --dropouts 0.05 --seed 8";
    good(folder.path(), made);
    let facts =
        |file: &str, flags: &str| json(&good(folder.path(), &format!("inspect {file} --json --form none {flags}")));
    let original = facts("a.sdf", "");
    for (file, flags, bound) in [
        ("b.x3p", "", 1e-9),
        ("b.npy", "--pitch 0.5um,0.75um --unit m", 1e-9),
        ("b.sdf", "", 1e-9),
        ("b.png", "", 1e-3),
    ] {
        good(folder.path(), &format!("convert a.sdf -o {file}"));
        let copy = facts(file, flags);
        for name in ["width", "height", "missing_fraction"] {
            assert_eq!(copy[name], original[name], "{file}: {name}");
        }
        for name in ["pitch_x_m", "pitch_y_m", "Sq_m", "Ssk", "Sdq", "slope_rms_y", "Sal_m"] {
            let (found, known) = (copy[name].as_f64().unwrap(), original[name].as_f64().unwrap());
            assert!((found / known - 1.0).abs() < bound, "{file}: {name} {found} {known}");
        }
    }
    good(folder.path(), "convert a.sdf -o view.png --preview --width 500");
    let view = image::open(folder.path().join("view.png")).unwrap();
    assert_eq!(view.width(), 500);
}

#[test]
fn mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    good(folder.path(), "synth -o m.x3p --size 64 --acl 6um");
    for (arguments, code, words) in [
        ("inspect absent.x3p", 1, "absent.x3p"),
        ("inspect m.x3p -o page.jpg", 2, "name it .png"),
        ("convert m.x3p -o m.docx", 2, "name it .x3p, .sdf, .npy or .png"),
        ("convert m.x3p -o m.x3p.npy --preview", 1, "name it .png"),
        ("synth -o m.txt", 2, "name it .x3p"),
        ("synth -o n.x3p --shape ramp", 2, "--ramp 0.1,0"),
        ("synth -o n.x3p --shape cap --radius 1um", 2, "larger --radius"),
        ("synth -o n.x3p --shape sinusoid --period 1um", 2, "--period"),
        ("synth -o n.x3p --spikes 0.1", 2, "--spike-height"),
        ("synth -o n.x3p --dropouts 3", 2, "write 3% or 0.03"),
        ("synth -o n.x3p --acl 1um,2um,3um", 2, "--acl"),
    ] {
        let output = asperity(folder.path(), arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments}: {said}");
        assert!(said.contains(words), "{arguments}: {said}");
    }
    assert!(!folder.path().join("n.x3p").exists());
}

/// A pitch given for a file that has its own is not dropped in silence; what goes wrong is said once, with advice.
#[test]
fn what_is_not_used_or_not_there_is_said() {
    let folder = tempfile::tempdir().unwrap();
    good(folder.path(), "synth -o m.x3p --size 64 --pitch 0.5um --acl 4um");
    let said = |output: Output| String::from_utf8(output.stderr).unwrap();
    let text = said(good(folder.path(), "inspect m.x3p --pitch 2um"));
    assert!(text.contains("states a pitch of 0.500000") && text.contains("2.000000 um given"), "{text}");
    let text = said(good(folder.path(), "inspect m.x3p --pitch 0.5um"));
    assert!(!text.contains("states a pitch"), "{text}");
    for (arguments, says) in [
        ("inspect none.x3p", "none.x3p: cannot read: "),
        ("inspect m.x3p -o none/p.png", "make its folder first"),
        ("synth -o m.tif", "name it .x3p, .sdf, .npy or .png"),
        ("synth -o m.x3p --acl 0.1um", "length 0.1 um does not fit a map of 614.4 um x 614.4 um at pitch 0.6 um"),
    ] {
        let output = asperity(folder.path(), arguments);
        let text = said(output);
        assert!(text.contains(says) && text.matches("os error").count() <= 1, "{arguments}: {text}");
        assert!(!text.contains(".asperity-"), "{text}");
    }
}

/// Every kind of file that is written can be read again as the same map.
#[test]
fn synth_and_convert_write_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let sq = |file: &str, known: &str| {
        json(&good(folder.path(), &format!("inspect {file} --json {known}")))["Sq_m"].as_f64()
    };
    for (file, known) in [("m.x3p", ""), ("m.sdf", ""), ("m.png", ""), ("m.npy", "--unit m --pitch 0.6um")] {
        good(folder.path(), &format!("synth -o {file} --size 96 --acl 6um --exact"));
        let [direct, first] = [sq(file, known).unwrap(), sq("m.x3p", "").unwrap()];
        assert!((direct / first - 1.0).abs() < 1e-4, "{file}: {direct} {first}");
    }
    good(folder.path(), "convert m.x3p -o text.sdf --ascii");
    assert!(std::fs::read(folder.path().join("text.sdf")).unwrap().starts_with(b"aISO-1.0"));
    assert!((sq("text.sdf", "").unwrap() / sq("m.x3p", "").unwrap() - 1.0).abs() < 1e-9);
}
