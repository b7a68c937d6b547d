//! The mirror beam between the incident angles of a table, and the angles that a glossmeter needs.

use asperity::heightmap::{Edges, HeightMap, level, read, synth};
use asperity::math::direction;
use asperity::math::random::CounterRng;
use asperity::meter::{Geometry, Options, gloss};
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::scatter::{self, Method, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

const SQ: f64 = 50e-9;
const WAVELENGTH: f64 = 550e-9;

/// Gaussian heights whose mean phase factor is that of the law to the digits asked for.
fn surface() -> HeightMap {
    let grid = synth::Grid { width: 512, height: 384, pitch: [0.5e-6, 0.6e-6] };
    let surface = synth::Gaussian { sq: SQ, acl: 4e-6, seed: 5, exact: true };
    level::keep_tilt(&synth::gaussian(grid, surface).unwrap(), Edges::Periodic)
}

fn table(degrees: &[f64], material: Material) -> Table {
    let options = scatter::Options {
        method: Method::Kirchhoff,
        symmetry: Symmetry::Isotropic,
        theta_i: degrees.iter().map(|t| t.to_radians()).collect(),
        material,
        ..scatter::Options::default()
    };
    Table::from_scatter(&scatter(&surface(), &options, &|_| ()).unwrap(), Provenance::default())
}

/// `exp(-(4 pi Sq cos_theta_i / lambda)^2)` between nodes 25 and 45 deg apart, at least four times nearer than a straight line in
/// tan(theta_i); and light that the beam does not have is in the lobe: the albedo of a mirror is that of a table with nodes there.
#[test]
fn the_mirror_beam_follows_its_law_between_nodes() {
    let sparse = TableBrdf::new(table(&[0.0, 45.0, 70.0], Material::Mirror)).unwrap();
    let degrees = [10.0, 25.0, 35.0, 55.0, 62.0];
    let dense = TableBrdf::new(table(&degrees, Material::Mirror)).unwrap();
    let [mut worst, mut worst_straight] = [0.0f64; 2];
    for t in degrees.map(f64::to_radians) {
        let wi = direction(t, 0.4);
        let law = (-(4.0 * PI * SQ * t.cos() / WAVELENGTH).powi(2)).exp();
        let core = sparse.specular_core(wi);
        let [low, high] = if t.to_degrees() < 45.0 { [0.0f64, 45.0] } else { [45.0, 70.0] }.map(f64::to_radians);
        let u = (t.tan() - low.tan()) / (high.tan() - low.tan());
        let straight =
            (1.0 - u) * sparse.specular_core(direction(low, 0.0)) + u * sparse.specular_core(direction(high, 0.0));
        println!(
            "{:.0} deg: core {core:.5}, law {law:.5}, node there {:.5}, straight line {straight:.5}; albedo {:.5}, {:.5}",
            t.to_degrees(),
            dense.specular_core(wi),
            sparse.albedo(t),
            dense.albedo(t)
        );
        // The mean phase factor of a finite map differs from the law by a few per mille.
        assert!((core - law).abs() < 0.012, "{core} {law}");
        assert!((core - dense.specular_core(wi)).abs() < 0.01, "{core} {}", dense.specular_core(wi));
        assert!((sparse.albedo(t) - dense.albedo(t)).abs() < 4e-3, "{} {}", sparse.albedo(t), dense.albedo(t));
        worst = worst.max((core - dense.specular_core(wi)).abs());
        worst_straight = worst_straight.max((straight - dense.specular_core(wi)).abs());
    }
    println!("worst {worst:.5}, of a straight line {worst_straight:.5}");
    assert!(worst < 0.25 * worst_straight, "{worst} {worst_straight}");
}

/// Draws weigh what the core is, one by one and in runs: their mean is the albedo.
#[test]
fn draws_of_the_beam_carry_its_law() {
    let brdf = TableBrdf::new(table(&[0.0, 50.0, 80.0], Material::Dielectric { n: 1.5 })).unwrap();
    for degrees in [0.0f64, 25.0, 40.0, 65.0, 85.0] {
        let wi = direction(degrees.to_radians(), 0.7);
        let mut rng = CounterRng::new(9, 0, 0);
        let u: Vec<[f64; 2]> = (0..200_000).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let mut runs = vec![None; u.len()];
        brdf.sample_many(&vec![wi; u.len()], &u, &mut runs);
        let one_by_one: Vec<_> = u.iter().map(|&u| brdf.sample(wi, u)).collect();
        for draws in [runs, one_by_one] {
            let core: f64 = draws.iter().flatten().filter(|d| d.specular).map(|d| d.weight).sum();
            let (mean, n) = (core / u.len() as f64, u.len() as f64);
            let squares: f64 = draws.iter().flatten().filter(|d| d.specular).map(|d| d.weight * d.weight).sum();
            let error = (squares / n - mean * mean).sqrt() / n.sqrt();
            let expected = brdf.specular_core(wi);
            assert!((mean - expected).abs() < 4.0 * error, "{degrees}: {mean} {expected} +- {error}");
        }
    }
}

/// Gloss of the table with the angles that the default tolerance keeps, against the table of all angles and that of the meter.
fn kept_angles_serve_the_meter(path: &Path) {
    let raw = read::read(path, &read::ReadOptions::default()).unwrap();
    let mut map = level::level(&raw, Edges::Open).unwrap();
    // A part is enough, and quick; a smaller one would lose its mirror beam in speckle at some angles and not at others.
    let [rows, columns] = [map.heights.nrows(), map.heights.ncols()].map(|n| n.min(480));
    map.heights = map.heights.slice(ndarray::s![..rows, ..columns]).to_owned();
    let degrees = [0.0, 10.0, 20.0, 30.0, 40.0, 45.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 85.0, 86.0, 88.0];
    let theta_i = degrees.map(f64::to_radians).to_vec();
    let options = scatter::Options { theta_i, ..scatter::Options::default() };
    let scattered = scatter(&map, &options, &|_| ()).unwrap();
    let direct = Table::from_scatter(&scattered, Provenance::default());
    let azimuths: Vec<usize> = (0..direct.phi_i().len()).collect();
    // The default angles have no 45 deg to choose.
    let offered: Vec<usize> = (0..degrees.len()).filter(|&k| degrees[k] != 45.0).collect();
    let offered = direct.at_nodes(&offered, &azimuths);
    let kept = offered.needed_theta_i(0.5 * options.tolerance);
    let thin = TableBrdf::new(offered.at_nodes(&kept, &azimuths)).unwrap();
    let direct = TableBrdf::new(direct).unwrap();
    let azimuths = if thin.table().is_isotropic() { vec![0.0] } else { vec![0.0, 0.8, 1.6, 2.4] };
    let options = Options::default().with_azimuths(azimuths);
    let name = path.file_name().unwrap().to_string_lossy();
    print!("{name:<16} {:>2} angles:", kept.len());
    let others = [(45.0, [1.4, 3.0]), (75.0, [4.0, 6.0])].map(|(t, stop)| Geometry::with_receptor(t, stop));
    for geometry in Geometry::standard_three().iter().chain(&others) {
        let [a, b] = [&thin, &direct].map(|brdf| gloss(brdf, geometry, &options).value);
        print!("  {:.0} deg {a:.3} ({:+.3})", geometry.theta_i.to_degrees(), a - b);
        assert!((a - b).abs() < 0.2, "{name} at {:.0} deg: {a} instead of {b}", geometry.theta_i.to_degrees());
    }
    println!();
}

#[test]
fn angles_left_out_do_not_change_the_gloss_of_bundled_maps() {
    for name in ["003", "100", "201", "805"] {
        let file = format!("heightmaps/epoxy-{name}nm.x3p");
        kept_angles_serve_the_meter(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file));
    }
}

#[test]
fn angles_left_out_do_not_change_the_gloss_of_real_maps() {
    let shared = std::env::var_os("ASPERITY_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    for name in ["opd-1.opd", "bcrf-1.bcrf", "sdf-1.sdf"] {
        let path = shared.join("heightmaps/real").join(name);
        if path.is_file() {
            kept_angles_serve_the_meter(&path);
        } else {
            eprintln!("SKIPPED: {} is not there; set ASPERITY_SHARED", path.display());
        }
    }
}
