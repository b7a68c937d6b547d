//! Where the methods fail, row by row of the physics reference, section 10: which test holds each row, and the tests that no
//! other file has.

use asperity::facets::SlopeStatistics;
use asperity::heightmap::{Edges, HeightMap, RawMap, level, synth};
use asperity::math::{direction, frame, half_vector};
use asperity::meter::{Azimuths, Geometry, facet_gloss};
use asperity::model;
use asperity::optics::Material;
use asperity::scatter::detectors::{Rings, ShirleyChiu};
use asperity::scatter::{self, Counting, Detectors, Method, Options, Partition, Run, count, scatter};
use asperity::table::{Provenance, Table};
use glam::DVec3;
use ndarray::Array2;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// Row, its subject, file and test. A test that is renamed or removed takes its row with it, and this list says so.
const HELD: [(u32, &str, &str, &str); 34] = [
    (1, "grazing directions", "tests/models_audit.rs", "extreme_draws"),
    (1, "grazing light on a map", "tests/detectors/limits.rs", "grazing_light"),
    (2, "roughness 0", "tests/meter.rs", "narrow_lobes_join_the_specular_core"),
    (3, "detectors wider than the lobe", "tests/where_methods_fail.rs", "wide_detectors_say_what_the_peak_loses"),
    (4, "missing points", "tests/detectors/limits.rs", "forty_per_cent_missing"),
    (5, "spikes", "tests/detectors/limits.rs", "a_single_spike"),
    (6, "coarse sampling", "tests/parameters.rs", "sampling_too_coarse_and_surfaces_without_slope"),
    (7, "noise", "tests/parameters.rs", "every_fault_is_diagnosed_and_nothing_else"),
    (8, "quantised heights", "tests/detectors/limits.rs", "heights_in_steps"),
    (9, "tilt left in", "tests/pipeline_physics.rs", "a_tilted_mirror_reflects_where_geometry_says"),
    (9, "form left in", "tests/parameters.rs", "form_is_recognised_as_form"),
    (10, "smoother than the wavelength", "tests/detectors/limits.rs", "smoother_than_the_wavelength"),
    (10, "rays against waves", "tests/meter_ray_wave.rs", "agreement_above_and_a_mirror_beam_below"),
    (11, "band of the instrument", "tests/where_methods_fail.rs", "the_band_decides_the_slope_and_is_told"),
    (12, "a small map", "tests/where_methods_fail.rs", "errors_of_gloss_are_those_of_other_maps"),
    (13, "edges", "tests/detectors/limits.rs", "grazing_light"),
    (14, "a seam", "tests/where_methods_fail.rs", "a_seam_is_never_made_unasked"),
    (15, "energy above 1", "tests/models_audit.rs", "energy_as_documented_and_bounded_on_request"),
    (16, "not reciprocal", "tests/models_audit.rs", "reciprocal_as_documented_non_negative_and_dark_below_the_horizon"),
    (17, "weights", "src/sample/alias.rs", "degenerate_weights"),
    (18, "last cells and u near 1", "src/sample/alias.rs", "a_hot_cell_never_lets_an_empty_one_be_drawn"),
    (19, "large offsets", "tests/where_methods_fail.rs", "a_nanometre_on_ten_millimetres"),
    (20, "small angles", "tests/where_methods_fail.rs", "small_angles_are_resolved"),
    (21, "rays that meet their own facet", "tests/where_methods_fail.rs", "a_dome_is_never_hit_twice"),
    (22, "a flat map", "tests/meter_facets.rs", "a_flat_map_is_flat_glass"),
    (22, "a flat mirror in one detector", "tests/detectors/closed_forms.rs", "a_flat_mirror_fills_one_detector"),
    (23, "walls", "tests/detectors/limits.rs", "vertical_walls"),
    (24, "narrow lobes in the meter", "tests/meter.rs", "rough_black_glass_core_values"),
    (25, "no rms slope", "tests/parameters.rs", "sampling_too_coarse_and_surfaces_without_slope"),
    (26, "masking functions", "tests/models.rs", "albedos_against_the_reference_tables"),
    (27, "opposite directions and the pole", "tests/where_methods_fail.rs", "the_pole_and_opposite_directions"),
    (28, "the last detector", "tests/where_methods_fail.rs", "every_direction_has_a_detector"),
    (0, "one valid facet", "tests/detectors/limits.rs", "one_valid_facet"),
    (0, "bad maps by waves", "tests/kirchhoff_limits.rs", "bad_maps_give_numbers_and_a_closed_book"),
];

#[test]
fn every_row_has_its_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (row, subject, file, test) in HELD {
        let text = std::fs::read_to_string(root.join(file)).unwrap_or_else(|e| panic!("{row}: {file}: {e}"));
        assert!(text.contains(&format!("fn {test}()")), "{row}, {subject}: no {test} in {file}");
    }
    assert!((1..=28).all(|row| HELD.iter().any(|held| held.0 == row)));
}

fn gaussian(size: usize, sq: f64, acl: f64, seed: u64) -> RawMap {
    let grid = synth::Grid { width: size, height: size, pitch: [1e-6; 2] };
    synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: true }).unwrap()
}

fn map(heights: Array2<f32>, edges: Edges) -> HeightMap {
    HeightMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, edges, removed_slopes: [0.0; 2] }
}

/// Klems patches are ten degrees wide: a lobe of a few reads far below its peak, and the warning says how far, against
/// cells that follow the lobe.
#[test]
fn wide_detectors_say_what_the_peak_loses() {
    let surface = level::keep_tilt(&gaussian(256, 0.4e-6, 10e-6, 1), Edges::Periodic);
    let options = Options {
        method: Method::Facets,
        material: Material::Mirror,
        theta_i: vec![20f64.to_radians()],
        ..Options::default()
    };
    let peak = |partition: Partition| {
        let counting = Counting { partition, averaged: true };
        let counts = count(&surface, &options, &counting, &mut Run::Whole, &|_| ()).unwrap();
        let d = &counts.directions[0];
        let highest = (0..counts.detectors.len()).map(|k| d.f_r(k).value).fold(0.0, f64::max);
        let said: Vec<_> =
            counts.warnings.iter().filter(|w| matches!(w, scatter::Warning::WideDetectors { .. })).cloned().collect();
        (highest, said)
    };
    let (coarse, said) = peak(Partition::EqualAngle { theta: 6f64.to_radians(), phi: 20f64.to_radians() });
    // Slopes of 2 Sq / ACL / sqrt 2 along an axis: the lobe's closed peak, R D / (4 cos^2).
    let statistics = SlopeStatistics::measure(&surface).unwrap();
    let alpha = 2f64.sqrt() * statistics.axes[0];
    let closed = 1.0 / (PI * alpha * alpha * 4.0 * 20f64.to_radians().cos().powi(2));
    let [warning] = said.as_slice() else { panic!("{said:?}") };
    let text = warning.to_string();
    let told: f64 = text.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let lost = 100.0 * (1.0 - coarse / closed);
    assert!(told > 2.0 && (told - lost).abs() < 2.0, "{lost:.1} % lost of {closed}: {text}");
    // Fine detectors and cells of slopes have nothing to say.
    let fine = Partition::EqualAngle { theta: 0.5f64.to_radians(), phi: 1f64.to_radians() };
    assert!(peak(fine).1.is_empty() && peak(Partition::HalfVector).1.is_empty());
}

/// The same surface seen through a coarser pitch has smaller slopes: the band belongs to the number, and inspecting tells it.
#[test]
fn the_band_decides_the_slope_and_is_told() {
    let raw = gaussian(256, 0.2e-6, 6e-6, 3);
    let fine = level::keep_tilt(&raw, Edges::Periodic);
    let coarse = map(Array2::from_shape_fn((64, 64), |(r, c)| fine.heights[[4 * r, 4 * c]]), Edges::Periodic);
    let coarse = HeightMap { pitch_x: 4e-6, pitch_y: 4e-6, ..coarse };
    let rms = |m: &HeightMap| SlopeStatistics::measure(m).unwrap().rms[0];
    // Forward differences over d of a Gaussian ACF: variance 2 Sq^2 (1 - exp(-d^2 / l^2)) / d^2.
    let due = |d: f64| (2.0 * 0.04e-12 * (1.0 - (-(d / 6e-6f64).powi(2)).exp())).sqrt() / d;
    let (a, b) = (rms(&fine) / due(1e-6), rms(&coarse) / due(4e-6));
    assert!((a - 1.0).abs() < 0.01 && (b - 1.0).abs() < 0.05, "{a} {b}");
    assert!(rms(&coarse) < 0.95 * rms(&fine));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.npy");
    let asperity = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).output().unwrap()
    };
    let name = file.to_str().unwrap();
    let size = ["--size", "64", "--pitch", "1um", "--seed", "1"];
    assert!(asperity(&[&["synth", "-o", name, "--sq", "0.1um", "--acl", "8um"][..], &size].concat()).status.success());
    let page = asperity(&["inspect", name, "--unit", "m", "--pitch", "1um"]);
    let text = String::from_utf8(page.stdout).unwrap();
    assert!(text.contains("bandwidth") && text.contains("2.000 \u{b5}m"), "{text}");
}

/// The standard error that one map gives is the scatter over other maps of the same surface.
#[test]
fn errors_of_gloss_are_those_of_other_maps() {
    let geometry = [Geometry::gloss60()];
    let read = |seed: u64| {
        let grid = synth::Grid { width: 192, height: 192, pitch: [1e-6; 2] };
        let raw = synth::gaussian(grid, synth::Gaussian { sq: 0.3e-6, acl: 8e-6, seed, exact: false }).unwrap();
        let surface = level::keep_tilt(&raw, Edges::Open);
        facet_gloss(&surface, &Material::Dielectric { n: 1.5 }, &geometry, &Azimuths::All).unwrap().gloss[0]
    };
    let readings: Vec<_> = (1..=40).map(read).collect();
    let n = readings.len() as f64;
    let mean = readings.iter().map(|r| r.value).sum::<f64>() / n;
    let scatter = (readings.iter().map(|r| (r.value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let told = (readings.iter().map(|r| r.standard_error.powi(2)).sum::<f64>() / n).sqrt();
    // A standard deviation of 40 values is known to 11 %; sub-areas of six autocorrelation lengths are not quite independent.
    assert!((told / scatter - 1.0).abs() < 0.4, "{told} told, {scatter} found");
}

/// A ramp that is wrapped has a cliff at the seam; nothing wraps a map unless it is told that the surface repeats.
#[test]
fn a_seam_is_never_made_unasked() {
    let ramp = Array2::from_shape_fn((40, 60), |(_, c)| 5e-8 * c as f32);
    let steepest = |edges: Edges| SlopeStatistics::measure(&map(ramp.clone(), edges)).unwrap().steepest;
    assert!((steepest(Edges::Open) - 0.05).abs() < 1e-6 && (steepest(Edges::Mirrored) - 0.05).abs() < 1e-6);
    assert!((steepest(Edges::Periodic) - 59.0 * 0.05).abs() < 1e-3);
    let raw = RawMap { heights: ramp.mapv(f64::from), pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: Vec::new() };
    // Levelled as files are: the plane goes first, and then even a wrap finds no cliff.
    let levelled = level::level(&raw, Edges::Periodic).unwrap();
    assert!(SlopeStatistics::measure(&levelled).unwrap().steepest < 1e-3);
}

/// Roughness of one nanometre under an offset of ten millimetres, where f32 steps by one nanometre.
#[test]
fn a_nanometre_on_ten_millimetres() {
    let plain = gaussian(128, 1e-9, 8e-6, 2);
    let mut lifted = plain.clone();
    lifted.heights.indexed_iter_mut().for_each(|((r, c), h)| *h += 1e-2 + 1e-7 * (r as f64) - 2e-7 * c as f64);
    let [a, b] = [plain, lifted].map(|raw| level::level(&raw, Edges::Open).unwrap());
    let largest = a.heights.iter().zip(&b.heights).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
    assert!(largest < 1e-14, "{largest}");
}

/// An angle of a billionth of a degree is itself, not what an arc cosine makes of it.
#[test]
fn small_angles_are_resolved() {
    for degrees in [1e-9f64, 1e-6, 0.01, 0.05, 1.0] {
        let t = degrees.to_radians();
        assert!((frame::theta(direction(t, 2.0)) / t - 1.0).abs() < 1e-12, "{degrees}");
    }
    // And a mirror tilted by a millionth of a degree turns its beam by two.
    let slope = 1e-6f64.to_radians().tan();
    let wi = direction(0.4, 0.0);
    let wo = asperity::math::reflect(wi, frame::normal_of_slope(slope, 0.0));
    let turned = frame::theta(wo) - 0.4;
    assert!((turned.abs().to_degrees() / 2e-6 - 1.0).abs() < 1e-6, "{turned:e}");
}

/// On a convex surface no reflected ray meets anything, least of all the facet it comes from.
#[test]
fn a_dome_is_never_hit_twice() {
    let dome = Array2::from_shape_fn((80, 100), |(r, c)| {
        let (x, y) = ((c as f64 - 49.5) * 1e-6, (r as f64 - 39.5) * 1e-6);
        ((200e-6f64.powi(2) - x * x - y * y).sqrt() - 200e-6) as f32
    });
    let surface = map(dome, Edges::Open);
    for method in [Method::Facets, Method::Rays] {
        for theta_i in [0.0f64, 45.0, 70.0] {
            let options = Options {
                method,
                material: Material::Mirror,
                theta_i: vec![theta_i.to_radians()],
                rays: 50_000,
                ..Options::default()
            };
            let counting = Counting { partition: Partition::Klems, averaged: false };
            let counts = count(&surface, &options, &counting, &mut Run::Whole, &|_| ()).unwrap();
            let tally = &counts.directions[0].tally;
            assert_eq!((tally.multiple, tally.shadowed), (0.0, 0.0), "{method:?} {theta_i}");
        }
    }
}

/// Where an angle is not defined it does not matter.
#[test]
fn the_pole_and_opposite_directions() {
    let w = direction(1.0, 2.0);
    assert_eq!(half_vector(w, -w), DVec3::Z);
    assert_eq!((frame::phi(DVec3::Z), frame::theta(DVec3::Z)), (0.0, 0.0));
    let surface = level::keep_tilt(&gaussian(128, 0.4e-6, 10e-6, 1), Edges::Periodic);
    let options = Options { method: Method::Geometric, theta_i: vec![0.0, 0.5], ..Options::default() };
    let table = Table::from_scatter(&scatter(&surface, &options, &|_| ()).unwrap(), Provenance::default());
    let o = direction(0.05, 1.0);
    for text in
        ["ggx:alpha=0.2,n=1.5", "oren-nayar:rho=0.5,sigma=20deg", "minnaert:rho=0.5,k=0.7", "phong:rho_s=1,exponent=9"]
    {
        let brdf = model::parse(text, 550e-9).unwrap();
        let (f, turned) = (brdf.eval(DVec3::Z, o), brdf.eval(DVec3::Z, direction(0.05, 4.0)));
        assert!(f.is_finite() && f > 0.0 && (f / turned - 1.0).abs() < 1e-12, "{text}: {f} {turned}");
        assert!(brdf.eval(DVec3::Z, DVec3::Z).is_finite());
    }
    let f = table.eval(DVec3::Z, DVec3::Z);
    assert!(f.is_finite() && f > 0.0 && table.eval(DVec3::Z, o).is_finite(), "{f}");
}

/// The pole, the horizon and either side of azimuth 0 fall into a detector that holds them.
#[test]
fn every_direction_has_a_detector() {
    let fixed: Vec<Box<dyn Detectors>> = vec![
        Box::new(Rings::klems()),
        Box::new(Rings::equal_angle(6f64.to_radians(), 6f64.to_radians()).unwrap()),
        Box::new(Rings::equal_area(777).unwrap()),
        Box::new(ShirleyChiu::new(3).unwrap()),
    ];
    let wi = direction(0.4, 0.0);
    for d in &fixed {
        for theta in [0.0, 1e-300, 1e-9, 0.5, PI / 2.0 - 1e-16, PI / 2.0] {
            for phi in [0.0, 1e-300, -1e-300, TAU - 1e-16, TAU, PI, -PI] {
                let wo = direction(theta, phi);
                let k = d.index(wi, DVec3::new(wo.x, wo.y, wo.z.max(0.0)));
                assert!(k < d.len(), "{theta} {phi}: {k} of {}", d.len());
                let b = d.bounds(k);
                assert!(theta >= b.theta[0] - 1e-9 && theta <= b.theta[1] + 1e-9, "{theta} {phi}: {b:?}");
            }
        }
    }
}
