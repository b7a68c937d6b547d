//! The NEF-BM measurement protocol finds the material that a simulated goniometer measured.

use asperity::fit::Warning;
use asperity::fit::protocol::{Characterised, Law, Noise, Reflectance, Scans, Spectrum, carry, characterise, simulate};
use asperity::math::{Estimate, random::CounterRng};
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

/// Wavelength \[nm\], strength beside that of the scans at 633 nm, index of the first surface.
const COLOURS: [(f64, f64, f64); 5] =
    [(450.0, 0.35, 1.540), (550.0, 0.8, 1.528), (633.0, 1.0, 1.52), (850.0, 1.6, 1.508), (2000.0, 1.2, 1.49)];

/// The paint at another wavelength: everything that reflects is stronger or weaker, and the index another.
fn paint_at(strength: f64, n: f64) -> Definition {
    let mut planted = Definition::parse(PAINT).unwrap();
    for name in ["bias", "rho_D", "rho_V"] {
        planted.set(name, strength * planted.get(name).unwrap()).unwrap();
    }
    planted.set("n", n).unwrap();
    planted
}

/// What an integrating sphere would read with an error of `share`, the albedo by the model's own table.
fn sphere(share: f64, seed: u64) -> Spectrum {
    let mut rng = CounterRng::new(seed, 9, 0);
    let theta_i = 20f64.to_radians();
    let row = |(nm, strength, n): (f64, f64, f64)| {
        let dhr = paint_at(strength, n).build(nm * 1e-9).unwrap().albedo(theta_i);
        let dhr = Estimate { value: dhr * (1.0 + share * rng.normal_pair()[0]), standard_error: share * dhr };
        Reflectance { wavelength: nm * 1e-9, dhr, index: Some([n, 0.0]) }
    };
    Spectrum { theta_i, rows: COLOURS.map(row).to_vec() }
}

/// A spectral material from scans at one wavelength and the hemispherical reflectance at all.
#[test]
fn a_planted_spectrum_is_found() {
    for seed in [1, 2, 3] {
        let found = characterise(&scans(PAINT, noise(seed)), Law::Cauchy).unwrap();
        let (bands, warning) = carry(&found, &sphere(0.01, seed), Some(633e-9)).unwrap();
        assert_eq!((bands.len(), warning), (COLOURS.len(), None));
        for (band, (nm, strength, n)) in bands.iter().zip(COLOURS) {
            assert!((band.wavelength * 1e9 - nm).abs() < 1e-6);
            let truth = paint_at(strength, n);
            assert_eq!(band.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["bias", "rho_D", "rho_V"]);
            for p in &band.parameters {
                let (want, error) = (truth.get(&p.name).unwrap(), p.standard_error.unwrap());
                assert!((p.value - want).abs() < 3.0 * error, "seed {seed} {nm} nm {p:?}: planted {want}");
                assert!(error < 0.1 * want, "seed {seed} {nm} nm {p:?}");
                assert!((band.definition.get(&p.name).unwrap() / p.value - 1.0).abs() < 1e-9);
            }
            // The scale is 1 where the strength is; its own error is at least that of the sphere.
            assert!((band.scale.value - strength).abs() < 3.0 * band.scale.standard_error, "{nm}: {:?}", band.scale);
            assert!(band.scale.standard_error >= 0.0095 * band.scale.value, "{nm}: {:?}", band.scale);
            assert_eq!(band.definition.get("n"), Some(n));
        }
    }
}

/// Without noise the bands are the planted material, and reflect what the sphere read.
#[test]
fn a_spectrum_without_noise_is_right() {
    let exact = Noise { share: 1e-6, floor: 1e-9, seed: 1 };
    let found = characterise(&scans(PAINT, exact), Law::Cauchy).unwrap();
    let spectrum = sphere(0.0, 1);
    let (bands, _) = carry(&found, &spectrum, None).unwrap();
    for ((band, (_, strength, n)), row) in bands.iter().zip(COLOURS).zip(&spectrum.rows) {
        let truth = paint_at(strength, n);
        for p in &band.parameters {
            assert!((p.value / truth.get(&p.name).unwrap() - 1.0).abs() < 2e-4, "{p:?}");
        }
        let albedo = band.definition.build(row.wavelength).unwrap().albedo(spectrum.theta_i);
        assert!((albedo / row.dhr.value - 1.0).abs() < 1e-5, "{albedo} {row:?}");
    }
    // A scan as the law is scaled point by point, with the index of the scans.
    let scanned = characterise(&scans(PAINT, exact), Law::Scan).unwrap();
    let mut plain = spectrum.clone();
    plain.rows.iter_mut().for_each(|r| r.index = None);
    let (bands, _) = carry(&scanned, &plain, None).unwrap();
    let (wi, wo) = (asperity::math::direction(0.5, 0.0), asperity::math::direction(0.7, 2.8));
    let own = scanned.definition.build(633e-9).unwrap().eval(wi, wo);
    for band in &bands {
        let f = band.definition.build(band.wavelength).unwrap().eval(wi, wo);
        assert!((f / own / band.scale.value - 1.0).abs() < 1e-5, "{band:?}");
    }
}

/// Scans and sphere that contradict each other where both measured.
#[test]
fn a_badly_calibrated_sphere_is_noticed() {
    let found = characterise(&scans(PAINT, noise(4)), Law::Cauchy).unwrap();
    let mut spectrum = sphere(0.01, 4);
    spectrum.rows.iter_mut().for_each(|r| r.dhr.value *= 1.2);
    let (_, warning) = carry(&found, &spectrum, Some(633e-9)).unwrap();
    let Some(Warning::HemisphericalMismatch { scale, .. }) = warning else { panic!("{warning:?}") };
    assert!((scale / 1.2 - 1.0).abs() < 0.05, "{scale}");
    assert!(warning.unwrap().to_string().contains("633 nm"));
    // Outside its wavelengths nothing can be compared; more light than any paint can send back is refused.
    assert_eq!(carry(&found, &spectrum, Some(300e-9)).unwrap().1, None);
    spectrum.rows.iter_mut().for_each(|r| r.dhr.value = 50.0);
    let error = carry(&found, &spectrum, None).unwrap_err().to_string();
    assert!(error.contains("450 nm") && error.contains("rho_D"), "{error}");
}
