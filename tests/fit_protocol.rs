//! The NEF-BM measurement protocol finds the material that a simulated goniometer measured.

use asperity::fit::protocol::{Characterised, Law, Noise, Scans, characterise, simulate};
use asperity::model::Definition;

const PAINT: &str = "nef-bm:sigma=0.08,bias=0.1,n=1.52,tau=0.3rad,omega=0.6rad,rho_D=0.04,rho_V=0.015";

fn scans(planted: &str, noise: Noise) -> Scans {
    simulate(&Definition::parse(planted).unwrap(), noise).unwrap()
}

fn noise(seed: u64) -> Noise {
    Noise { share: 0.01, floor: 2e-5, seed }
}

fn value(found: &Characterised, name: &str) -> (f64, f64) {
    let p = found.parameters.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no {name}: {found:?}"));
    (p.value, p.standard_error.unwrap_or_else(|| panic!("{name} has no error: {:?}", found.warnings)))
}

/// Every parameter within 3 standard errors, each known to better than a quarter, chi2 that of the noise.
fn recovers(planted: &str, law: Law, names: &[&str]) {
    let truth = Definition::parse(planted).unwrap();
    for seed in [1, 2, 3] {
        let found = characterise(&scans(planted, noise(seed)), law).unwrap();
        let limit = 4.0 * (2.0 / found.dof as f64).sqrt();
        let chi2 = found.chi2 / found.dof as f64;
        assert!((chi2 - 1.0).abs() < limit, "{planted} seed {seed}: chi2/dof {chi2} {:?}", found.steps);
        assert_eq!(found.parameters.len(), names.len(), "{planted} seed {seed}: {:?}", found.parameters);
        for name in names {
            let (value, error) = value(&found, name);
            let planted_value = truth.get(name).unwrap();
            assert!(
                (value - planted_value).abs() < 3.0 * error,
                "{planted} seed {seed} {name}: {value} +- {error}, planted {planted_value}"
            );
            assert!(error < 0.25 * planted_value, "{name}: {error}");
        }
    }
}

#[test]
fn a_planted_paint_is_found() {
    recovers(PAINT, Law::Cauchy, &["sigma", "bias", "n", "tau", "omega", "rho_D", "rho_V"]);
}

#[test]
fn a_planted_gaussian_surface_is_found() {
    let planted =
        "nef-bm:distribution=gaussian,sigma=0.12,bias=0.9,n=1.6,tau=0.4rad,omega=0.3rad,rho_D=0.02,rho_V=0.03";
    recovers(planted, Law::Gaussian, &["sigma", "bias", "n", "tau", "omega", "rho_D", "rho_V"]);
}

/// A metal: the protocol sees that a clear interface does not do.
#[test]
fn a_planted_metal_is_found() {
    let planted = "nef-bm:sigma=0.1,bias=0.08,n=2.5,k=3,tau=0.3rad,omega=0.6rad,rho_D=0.01,rho_V=0.005";
    recovers(planted, Law::Cauchy, &["sigma", "bias", "n", "k", "tau", "omega", "rho_D", "rho_V"]);
}

/// Without noise each step already ends near the planted values, and all together at them.
#[test]
fn without_noise_the_steps_are_right() {
    let exact = Noise { share: 1e-6, floor: 1e-9, seed: 1 };
    let found = characterise(&scans(PAINT, exact), Law::Cauchy).unwrap();
    let truth = Definition::parse(PAINT).unwrap();
    for step in &found.steps {
        for (name, value) in &step.found {
            assert!((value / truth.get(name).unwrap() - 1.0).abs() < 2e-3, "{step:?}");
        }
    }
    for p in &found.parameters {
        assert!((p.value / truth.get(&p.name).unwrap() - 1.0).abs() < 1e-4, "{p:?}");
    }
}

/// The scan as its own law: the model built from it gives the scan back, and the other parameters follow.
#[test]
fn the_scan_can_be_the_law() {
    let found = characterise(&scans(PAINT, Noise { share: 1e-4, floor: 1e-7, seed: 1 }), Law::Scan).unwrap();
    for (name, truth) in [("n", 1.52), ("tau", 0.3), ("omega", 0.6), ("rho_D", 0.04), ("rho_V", 0.015)] {
        // Interpolation between scanned angles is good to a few thousandths.
        assert!((value(&found, name).0 / truth - 1.0).abs() < 0.02, "{name} {:?}", found.parameters);
    }
    let built = found.definition.build(550e-9).unwrap();
    let planted = Definition::parse(PAINT).unwrap().build(550e-9).unwrap();
    for (theta_i, theta_r) in [(0.1, 0.4), (0.7, 0.6), (1.0, 0.3)] {
        let (wi, wo) = (asperity::math::direction(theta_i, 0.0), asperity::math::direction(theta_r, 2.5));
        assert!((built.eval(wi, wo) / planted.eval(wi, wo) - 1.0).abs() < 0.02);
    }
}

/// What is written is read; what is missing is said.
#[test]
fn files_round_trip_and_missing_scans_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let made = scans(PAINT, noise(1));
    let paths = ["zero.csv", "specular.csv", "bistatic.csv"].map(|n| dir.path().join(n));
    paths.iter().zip(made.to_csv()).for_each(|(p, text)| std::fs::write(p, text).unwrap());
    let read = Scans::read(&paths[0], &paths[1], &paths[2]).unwrap();
    let (a, b) = (characterise(&made, Law::Cauchy).unwrap(), characterise(&read, Law::Cauchy).unwrap());
    for (a, b) in a.parameters.iter().zip(&b.parameters) {
        assert!((a.value / b.value - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
    let without = |f: fn(&mut Scans)| {
        let mut scans = made.clone();
        f(&mut scans);
        characterise(&scans, Law::Cauchy).unwrap_err().to_string()
    };
    assert!(without(|s| s.specular.clear()).contains("index"));
    assert!(without(|s| s.bistatic.clear()).contains("tau"));
    assert!(without(|s| s.zero_bistatic.clear()).contains("zero-bistatic"));
}
