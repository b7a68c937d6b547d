//! Tables of surfaces with a grain that keep one azimuth for all: what is drawn, what is reflected, what is said of it.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::math::random::CounterRng;
use asperity::optics::Brdf;
use asperity::sample::TableBrdf;
use asperity::sample::audit::{self, Finding, Statement, audit};
use asperity::scatter::{Method, Options, Scatter, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// A tilted surface with three times the slopes along x as along y.
fn map(sq: f64) -> HeightMap {
    let grid = synth::Grid { width: 192, height: 144, pitch: [1e-6; 2] };
    let mut raw = synth::gaussian(grid, synth::Gaussian { sq, acl: 6e-6, seed: 9, exact: true }).unwrap();
    raw.heights += &synth::ramp(synth::Grid { pitch: [1e-6, 3e-6], ..grid }, [0.02, -0.01]).unwrap().heights;
    raw.pitch_y = 3e-6;
    level::keep_tilt(&raw, Edges::Open)
}

fn scattered(map: &HeightMap, options: Options) -> Scatter {
    let options = Options { symmetry: Symmetry::Anisotropic, ..options };
    scatter(map, &options, &|_| ()).unwrap()
}

fn brdf(scattered: &Scatter) -> TableBrdf {
    TableBrdf::new(Table::from_scatter(scattered, Provenance::default())).unwrap()
}

/// By waves, and by the slope density without visibility: with so wide a tolerance none is traced.
fn tables() -> &'static [(&'static str, TableBrdf); 2] {
    static TABLES: OnceLock<[(&str, TableBrdf); 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let angles = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect();
        let theta_i = angles(&[0.0, 30.0, 60.0, 75.0, 85.0, 88.0]);
        let waves = scattered(&map(0.3e-6), Options { method: Method::Kirchhoff, theta_i, ..Options::default() });
        assert!(waves.decisions.iter().all(|d| d.wave));
        let theta_i = angles(&[0.0, 40.0, 70.0, 80.0, 85.0]);
        let wide = Options { method: Method::Geometric, tolerance: 0.999, theta_i, ..Options::default() };
        let density = scattered(&map(0.08e-6), wide);
        assert!(density.decisions.iter().all(|d| !d.wave && !d.visibility), "{:?}", density.decisions);
        let tables = [("waves", brdf(&waves)), ("density", brdf(&density))];
        for (name, brdf) in &tables {
            assert_eq!((brdf.table().phi_i().len(), brdf.table().is_isotropic()), (1, false), "{name}");
        }
        tables
    })
}

fn at(theta_deg: f64, phi_deg: f64) -> DVec3 {
    direction(theta_deg.to_radians(), phi_deg.to_radians())
}

/// `integral of f_r cos_theta_r dw` and core: midpoints in the slope plane, `dw = 4 cos_beta cos^3 theta_h dp dq`.
fn reflected(brdf: &TableBrdf, wi: DVec3) -> f64 {
    const SIDE: usize = 1600;
    let reach = 0.75;
    let step = 2.0 * reach / SIDE as f64;
    let of_row = |r: usize| -> f64 {
        let q = (r as f64 + 0.5) * step - reach;
        (0..SIDE)
            .map(|c| {
                let p = (c as f64 + 0.5) * step - reach;
                let h = DVec3::new(-p, -q, 1.0).normalize();
                let wo = 2.0 * wi.dot(h) * h - wi;
                if wi.dot(h) > 0.0 && wo.z > 0.0 {
                    brdf.eval(wi, wo) * wo.z * 4.0 * wi.dot(h) * h.z.powi(3)
                } else {
                    0.0
                }
            })
            .sum()
    };
    let rows: Vec<f64> = (0..SIDE).into_par_iter().map(of_row).collect();
    brdf.specular_core(wi) + rows.iter().sum::<f64>() * step * step
}

/// Mean weight, its standard error and the largest weight.
fn drawn(brdf: &TableBrdf, wi: DVec3, draws: usize) -> (f64, f64, f64) {
    let mut rng = CounterRng::new(3, 14, (wi.x * 1e6) as i64 as u64);
    let u: Vec<[f64; 2]> = (0..draws).map(|_| [rng.uniform(), rng.uniform()]).collect();
    let mut found = vec![None; draws];
    brdf.sample_many(&vec![wi; draws], &u, &mut found);
    let weights: Vec<f64> = found.iter().map(|s| s.map_or(0.0, |s| s.weight)).collect();
    let mean = weights.iter().sum::<f64>() / draws as f64;
    let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / draws as f64;
    (mean, (variance / draws as f64).sqrt(), weights.iter().fold(0.0, |a, b| a.max(*b)))
}

#[test]
fn no_draw_weighs_much_from_any_side() {
    for (name, brdf) in tables() {
        let grid: Vec<(f64, f64)> = [0.0, 20.0, 45.0, 68.0, 80.0, 85.0, 87.0]
            .iter()
            .flat_map(|&t| (0..36).map(move |k| (t, 10.0 * f64::from(k))))
            .collect();
        let largest = grid
            .par_iter()
            .map(|&(t, p)| (drawn(brdf, at(t, p), 20_000).2, t, p))
            .reduce(|| (0.0, 0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        println!("{name}: largest weight {:.2} at {} deg, azimuth {} deg", largest.0, largest.1, largest.2);
        assert!(largest.0 < 10.0, "{name}: {largest:?}");
    }
}

#[test]
fn draws_carry_what_is_reflected_towards_every_side() {
    for (name, brdf) in tables() {
        let mut at_85 = Vec::new();
        for (theta, phi) in [
            (45.0, 110.0),
            (70.0, 90.0),
            (85.0, 0.0),
            (85.0, 40.0),
            (85.0, 110.0),
            (85.0, 200.0),
            (85.0, 290.0),
            (87.0, 180.0),
        ] {
            let wi = at(theta, phi);
            let (due, stated) = (reflected(brdf, wi), brdf.albedo_towards(wi));
            let (mean, error, _) = drawn(brdf, wi, 100_000);
            println!("{name} {theta} {phi}: reflects {due:.5}, states {stated:.5}, draws {mean:.5} +- {error:.5}");
            assert!((stated - due).abs() < 1e-3 * due, "{name} {theta} {phi}: states {stated}, reflects {due}");
            assert!((mean - due).abs() < 4.0 * error + 2e-4 * due, "{name} {theta} {phi}: {mean} +- {error}, {due}");
            if theta == 85.0 {
                at_85.push(due);
            }
        }
        let [least, most] = [f64::min, f64::max].map(|f| at_85.iter().copied().reduce(f).unwrap());
        assert!(most > 1.02 * least, "{name}: no grain to be seen in {at_85:?}");
    }
}

#[test]
fn the_albedo_of_an_angle_is_the_mean_over_azimuths() {
    for (name, brdf) in tables() {
        for theta in [0.0f64, 40.0, 80.0, 85.0] {
            let mean = (0..45).map(|k| brdf.albedo_towards(at(theta, 8.0 * f64::from(k)))).sum::<f64>() / 45.0;
            let stated = brdf.albedo(theta.to_radians());
            // It runs straight over steps of 0.7 deg, across the bend at a node.
            assert!((stated - mean).abs() < 5e-3 * mean, "{name} {theta}: {stated} against {mean}");
        }
    }
}

#[test]
fn the_audit_finds_no_fault() {
    let degrees = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect();
    let options = audit::Options {
        theta_i: degrees(&[0.0, 33.0, 75.0, 85.0]),
        phi_i: degrees(&[0.0, 37.0, 110.0, 250.0]),
        draws: 50_000,
        ..audit::Options::default()
    };
    for (name, brdf) in tables() {
        let estimate = |wi, wo| brdf.table().estimate(wi, wo);
        let found = audit(brdf, Some(&estimate), &options);
        // With no visibility traced this table is not reciprocal at 85 deg (56 %), as the audit says; that is none of its draws.
        let misjudged =
            |f: &Finding| *name == "density" && f.statement == Statement::Reciprocity && f.theta_i_deg > 80.0;
        let others: Vec<_> = found.findings.iter().filter(|f| !misjudged(f)).collect();
        assert!(others.is_empty(), "{name}: {others:#?}");
    }
}

/// Light between two nodes of azimuth a right angle apart.
#[test]
fn few_azimuths_serve_those_between_them() {
    let phi_i: Vec<f64> = (0..4).map(|k| TAU * f64::from(k) / 4.0).collect();
    let options = Options {
        method: Method::Kirchhoff,
        phi_i: phi_i.clone(),
        all_phi_i: true,
        theta_i: vec![0.0, 1.0, 1.4, 1.5],
        ..Options::default()
    };
    let scattered = scattered(&map(0.3e-6), options);
    let brdf = brdf(&scattered);
    assert_eq!(brdf.table().phi_i(), phi_i, "azimuths asked for are kept though one would serve");
    for phi in [0.0, 10.0, 45.0, 80.0, 130.0, 220.0, 315.0] {
        let (mean, error, most) = drawn(&brdf, at(85.0, phi), 50_000);
        let stated = brdf.albedo_towards(at(85.0, phi));
        assert!(most < 20.0, "{phi}: {most}");
        assert!((mean - stated).abs() < 4.0 * error + 3e-4 * stated, "{phi}: {mean} +- {error}, {stated}");
    }
}

#[test]
fn a_file_gives_the_same_draws() {
    let folder = tempfile::tempdir().unwrap();
    for (name, brdf) in tables() {
        let path = folder.path().join("table.npz");
        brdf.table().save(&path).unwrap();
        let read = TableBrdf::new(Table::load(&path).unwrap()).unwrap();
        for (theta, phi) in [(45.0, 110.0), (85.0, 290.0)] {
            let wi = at(theta, phi);
            for k in 0..500 {
                let u = [(0.5 + 0.754_877_666 * f64::from(k)).fract(), (0.5 + 0.569_840_291 * f64::from(k)).fract()];
                assert_eq!(brdf.sample(wi, u), read.sample(wi, u), "{name} {theta} {phi} {k}");
            }
            assert_eq!(brdf.albedo_towards(wi), read.albedo_towards(wi), "{name}");
        }
    }
}
