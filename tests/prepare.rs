//! Preparing a map end to end: the order of the steps, what the report says, and what the command line prints.

use asperity::heightmap::crop::Region;
use asperity::heightmap::despike::Despike;
use asperity::heightmap::fill::Fill;
use asperity::heightmap::form::Form;
use asperity::heightmap::level::level;
use asperity::heightmap::orient::{Orientation, Rotation};
use asperity::heightmap::prepare::Action;
use asperity::heightmap::warning::Warning;
use asperity::heightmap::{Edges, HeightMap, Preparation, RawMap, prepare, write};
use ndarray::Array2;
use std::f64::consts::TAU;
use std::process::Command;

const PITCH: [f64; 2] = [0.5e-6, 0.8e-6];
const WAVE: f64 = 12e-6;

/// Roughness of 10 nm amplitude along x on a dome, far from zero, with dx != dy and width != height.
fn rough_dome() -> RawMap {
    let heights = Array2::from_shape_fn((150, 240), |(r, c)| {
        let (x, y) = ((c as f64 - 119.5) * PITCH[0], (74.5 - r as f64) * PITCH[1]);
        let radius = 5e-3f64;
        0.02 + 0.01 * x + (radius * radius - x * x - y * y).sqrt() - radius + 10e-9 * (TAU * x / WAVE).sin()
    });
    RawMap { heights, pitch_x: PITCH[0], pitch_y: PITCH[1], format: "test", notes: vec![] }
}

#[test]
fn by_default_only_the_plane_goes() {
    let raw = rough_dome();
    let expected = level(&raw, Edges::Open).unwrap();
    let prepared = prepare(raw, &Preparation::default()).unwrap();
    assert_eq!(prepared.map.heights, expected.heights);
    assert_eq!(prepared.map.removed_slopes, expected.removed_slopes);
    assert!(prepared.report.warnings.is_empty());
    let text = prepared.report.to_string();
    // The sine adds a little to the slope of 0.01.
    assert!(text.starts_with("removed plane (slopes 9.98") && text.ends_with(')'), "{text}");
    // Two coarse pitches to the longer side.
    assert!((prepared.report.band_m[0] - 1.6e-6).abs() < 1e-18 && (prepared.report.band_m[1] - 120e-6).abs() < 1e-15);
}

/// Amplitude of the roughness over its eight inner periods, away from the edges.
fn amplitude(map: &HeightMap) -> f64 {
    let (mut n, mut sum) = (0.0, 0.0);
    for ((r, c), h) in map.heights.indexed_iter() {
        if (24..216).contains(&c) && (24..map.height() - 24).contains(&r) {
            n += 1.0;
            sum += f64::from(*h) * (TAU * (c as f64 - 119.5) * PITCH[0] / WAVE).sin();
        }
    }
    2.0 * sum / n
}

#[test]
fn sphere_and_polynomial_leave_the_roughness_and_filters_take_half_of_it() {
    for form in [Form::Sphere, Form::Polynomial(2), Form::Polynomial(4)] {
        let only_form = Preparation { form, ..Preparation::default() };
        let found = amplitude(&prepare(rough_dome(), &only_form).unwrap().map);
        // Ten periods of a sine are not quite orthogonal to a polynomial, which takes up a little of it.
        assert!((found - 10e-9).abs() < 0.3e-9, "{form:?}: {found}");
        for filtered in [
            Preparation { s_filter: Some(WAVE), ..only_form.clone() },
            Preparation { l_filter: Some(WAVE), ..only_form.clone() },
        ] {
            let half = amplitude(&prepare(rough_dome(), &filtered).unwrap().map);
            assert!((half - 5e-9).abs() < 0.3e-9, "{form:?}: {half}");
        }
    }
    let prepared = prepare(rough_dome(), &Preparation { form: Form::Sphere, ..Preparation::default() }).unwrap();
    let [Action::FormRemoved(removed)] = &prepared.report.actions[..] else { panic!("{:?}", prepared.report) };
    // The sine's linear part, 10 nm over 60 um, and nothing else of it reaches the radius.
    assert!((removed.sphere.unwrap().radius / 5e-3 - 1.0).abs() < 1e-2, "{removed:?}");
    assert!(prepared.report.to_string().contains("dome of radius 5.0"), "{}", prepared.report);
}

#[test]
fn every_step_is_reported_in_the_stated_order() {
    let mut raw = rough_dome();
    let planted = [(20, 30), (60, 70), (100, 200)];
    planted.iter().for_each(|p| raw.heights[*p] += 2e-6);
    (40..44).for_each(|r| (90..93).for_each(|c| raw.heights[[r, c]] = f64::NAN));
    let all = Preparation {
        edges: Edges::Mirrored,
        orientation: Orientation { rotation: Rotation::By90, ..Orientation::default() },
        region: Some(Region::Fraction([0.0, 0.0, 1.0, 0.9])),
        despike: Some(Despike::default()),
        form: Form::Polynomial(3),
        fill: Some(Fill::default()),
        s_filter: Some(2.5e-6),
        l_filter: Some(60e-6),
        noise: Some(0.1e-9),
    };
    let prepared = prepare(raw, &all).unwrap();
    assert_eq!((prepared.map.width(), prepared.map.height()), (150, 216));
    assert_eq!([prepared.map.pitch_x, prepared.map.pitch_y], [PITCH[1], PITCH[0]]);
    assert_eq!(prepared.map.missing_fraction(), 0.0);
    assert_eq!(prepared.map.edges, Edges::Mirrored);
    let names: Vec<String> = serde_json::to_value(&prepared.report).unwrap()["actions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|a| a["action"].as_str().unwrap().to_owned())
        .collect();
    let order = ["oriented", "cropped", "despiked", "form_removed", "filled", "filtered", "filtered", "noise_judged"];
    assert_eq!(names, order);
    let Action::Despiked(spikes) = prepared.report.actions[2] else { panic!() };
    let Action::Filled(filled) = prepared.report.actions[4] else { panic!() };
    // The groove tops of a noise-free sine are smooth: the three planted points and no other.
    assert_eq!((spikes.points, filled.points, filled.holes), (3, 3 + 12, 4));
    assert_eq!(prepared.report.band_m, [2.5e-6, 60e-6]);
}

#[test]
fn noise_and_vain_filters_are_warned_of_and_contradictions_refused() {
    let noisy = Preparation { noise: Some(3e-9), s_filter: Some(1e-6), ..Preparation::default() };
    let prepared = prepare(rough_dome(), &noisy).unwrap();
    let [Warning::SFilterBelowSampling { .. }, Warning::NoiseInSlopes { share, sdq: [measured, corrected], .. }] =
        prepared.report.warnings[..]
    else {
        panic!("{:?}", prepared.report.warnings)
    };
    // 2 sigma^2 / d^2 per axis.
    let noise = 2.0 * 3e-9f64.powi(2) * (PITCH[0].powi(-2) + PITCH[1].powi(-2));
    assert!(share > 0.05 && ((measured * measured - corrected * corrected) / noise - 1.0).abs() < 1e-9);
    for warning in &prepared.report.warnings {
        assert!(warning.to_string().ends_with('.'));
    }
    for (bad, says) in [
        (Preparation { s_filter: Some(9e-6), l_filter: Some(8e-6), ..Preparation::default() }, "exchange"),
        (Preparation { l_filter: Some(1e-3), ..Preparation::default() }, "120.0"),
        (Preparation { l_filter: Some(1e-6), ..Preparation::default() }, "two pitches"),
        (Preparation { form: Form::Polynomial(13), ..Preparation::default() }, "degree"),
        (
            Preparation {
                edges: Edges::Periodic,
                region: Some(Region::Fraction([0.0, 0.0, 0.5, 0.5])),
                ..Preparation::default()
            },
            "periodic",
        ),
    ] {
        let error = prepare(rough_dome(), &bad).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let all = |raw| {
        let p = Preparation {
            form: Form::Sphere,
            despike: Some(Despike::default()),
            fill: Some(Fill::default()),
            s_filter: Some(3e-6),
            l_filter: Some(50e-6),
            ..Preparation::default()
        };
        prepare(raw, &p).unwrap()
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| all(rough_dome()))
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.map.heights.mapv(f32::to_bits), three.map.heights.mapv(f32::to_bits));
    assert_eq!(one.report, three.report);
}

#[test]
fn the_command_line_says_what_was_done() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("dome.x3p");
    let mut raw = rough_dome();
    raw.heights[[10, 10]] += 1e-6;
    raw.heights[[100, 10]] = f64::NAN;
    write::x3p::write(&map, &raw, write::x3p::Samples::Float64).unwrap();
    let run = |flags: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_asperity"))
            .arg("brdf")
            .arg(&map)
            .arg("-o")
            .arg(folder.path().join("t.npz"))
            .args(["--theta-i", "0,30", "--symmetry", "isotropic", "--json"])
            .args(flags)
            .output()
            .unwrap();
        (done.status.code(), String::from_utf8(done.stdout).unwrap(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, json, said) = run(&["--form", "poly:4", "--despike", "6", "--fill", "--region", "0,0,100um,100um"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("dome.x3p: cropped to 200 x 125 points") && said.contains("1 spikes"), "{said}");
    assert!(said.contains("removed polynomial of degree 4") && said.contains("filled 2 points (0.01 %)"), "{said}");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["preparation"]["actions"][3]["points"], 2);

    let (code, _, said) = run(&["--noise", "5nm"]);
    assert!(code == Some(0) && said.contains("warning: dome.x3p: Instrument noise of 5.000 nm"), "{said}");
    let (code, _, said) = run(&["--l-filter", "0.8mm"]);
    assert!(code == Some(1) && said.contains("dome.x3p: a filter of cut-off 800 um does not suit"), "{said}");
    assert_eq!(run(&["--form", "poly:x"]).0, Some(2));
    assert_eq!(run(&["--form", "plane", "--keep-tilt"]).0, Some(2));
    assert_eq!(run(&["--rotate", "45"]).0, Some(2));
}
