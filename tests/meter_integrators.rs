//! Half vectors against adaptive subdivision, and both where either could fail: lobes from a delta to a half sphere.

mod reference;

use asperity::meter::{Instrument, Options, Reading, Shape, standards};
use asperity::model::parse;
use asperity::optics::Brdf;

fn model(text: &str) -> Box<dyn Brdf> {
    parse(text, 587.6e-9).expect(text)
}

fn fine() -> Options {
    Options { tolerance: 0.01, max_points: 65536, ..Options::default() }
}

fn both(meter: &Instrument, text: &str) -> Vec<(Reading, Reading)> {
    let brdf = model(text);
    let drawn = meter.measure(&*brdf, &fine()).unwrap();
    let divided = meter.subdivide(&*brdf, &Options { tolerance: 0.05, ..fine() }).unwrap();
    drawn.into_iter().zip(divided).collect()
}

#[track_caller]
fn agree(meter: &Instrument, text: &str) {
    for (a, b) in both(meter, text) {
        let d = a.estimate.value - b.estimate.value;
        let allowed = 4.0 * a.estimate.standard_error + b.estimate.standard_error + 1e-3;
        assert!(a.converged && b.converged, "{} {text}: {a:?} {b:?}", meter.name);
        assert!(d.abs() < allowed, "{} {text}: {a:?} {b:?}", meter.name);
    }
}

#[test]
fn the_two_integrators_agree_from_mirror_to_matt() {
    for meter in ["gloss-20", "gloss-85", "haze-20", "gloss-20-paper"] {
        let meter = standards::by_name(meter).unwrap();
        for text in [
            "dielectric:n=1.5",
            "beckmann:alpha=0.002,n=1.567",
            "ggx:alpha=0.1,n=1.5",
            "phong:rho_s=0.05,exponent=3000,rho_d=0.9",
            "ward:rho_s=0.05,alpha_x=0.02,alpha_y=0.1",
            "lambert:rho=1",
        ] {
            agree(&meter, text);
        }
    }
}

/// Geometries away from the mirror direction, a source behind the receptor, discs and turned stops, a tilted specimen.
#[test]
fn the_two_integrators_agree_off_the_beaten_track() {
    let metallic = standards::by_name("metallic-5").unwrap();
    agree(&metallic, "ggx:alpha=0.3,material=al");
    let mut odd = standards::by_name("gloss-60").unwrap();
    odd.source = Shape::Disc(0.03);
    odd.receptors[0].shape = Shape::Rectangle([0.05, 0.1]);
    odd.receptors[0].turn = 0.6;
    odd.specimen.tilt = 0.01;
    odd.specimen.tilt_azimuth = 0.8;
    odd.specimen.azimuth = 0.5;
    agree(&odd, "ward:rho_s=0.05,alpha_x=0.02,alpha_y=0.1");
    odd.receptors[0].theta_r = 58f64.to_radians();
    odd.receptors[0].phi_r = 0.05;
    agree(&odd, "beckmann:alpha=0.05,n=1.5");
}

/// The silent failure of fixed nodes: alpha = 0.002 at 85 deg reads 99.99, not 80.
#[test]
fn a_narrow_lobe_at_grazing_is_not_lost() {
    let meter = standards::by_name("gloss-85").unwrap();
    for (a, b) in both(&meter, "beckmann:alpha=0.002,n=1.567") {
        assert!((a.estimate.value - 99.9912).abs() < 0.01, "{a:?}");
        assert!((b.estimate.value - 99.9912).abs() < 0.05, "{b:?}");
    }
}

/// A Gaussian lobe 0.01 deg wide (standard deviation of the reflected beam: sqrt 2 alpha) reads what a delta reads.
#[test]
fn a_lobe_of_a_hundredth_of_a_degree_reads_as_a_delta() {
    let alpha = 0.01f64.to_radians() / 2f64.sqrt();
    for meter in ["gloss-20", "gloss-60", "gloss-85"] {
        let meter = standards::by_name(meter).unwrap();
        let delta = meter.measure(&*model("dielectric:n=1.567"), &fine()).unwrap();
        assert!((delta[0].estimate.value - 100.0).abs() < 1e-9 && delta[0].estimate.standard_error == 0.0);
        for (a, b) in both(&meter, &format!("beckmann:alpha={alpha},n=1.567")) {
            assert!((a.estimate.value - 100.0).abs() < 0.01, "{} {a:?}", meter.name);
            assert!((b.estimate.value - 100.0).abs() < 0.05, "{} {b:?}", meter.name);
        }
    }
}

/// `haze` of two receptors against the reference, and the haze of a Phong lobe.
#[test]
fn two_sided_haze_against_the_reference() {
    let meter = standards::by_name("haze-20").unwrap();
    let finer = Options { tolerance: 0.004, ..fine() };
    let read = |text: String| {
        let readings = meter.measure(&*model(&text), &finer).unwrap();
        assert_eq!((readings[0].name.as_str(), readings[1].name.as_str()), ("gloss", "haze"));
        readings[1].estimate
    };
    let rho = asperity::optics::fresnel::dielectric(20f64.to_radians().cos(), 1.567);
    let Some(table) = reference::table("gloss_vs_alpha.csv") else { return };
    for row in table.rows() {
        let alpha = row["alpha"];
        for (column, text) in [
            ("beck1567", format!("beckmann:alpha={alpha},n=1.567")),
            ("beck1500", format!("beckmann:alpha={alpha},n=1.5")),
            ("ggx1567", format!("ggx:alpha={alpha},n=1.567")),
            ("ward92", format!("ward:rho_s={rho},alpha={alpha}")),
        ] {
            let (got, want) = (read(text.clone()), row[&format!("{column}_H20sum")]);
            assert!((got.value - want).abs() < 0.02, "{text}: {got:?} {want}");
        }
    }
    let Some(table) = reference::table("gloss_vs_phong.csv") else { return };
    for row in table.rows() {
        let (got, want) = (read(format!("phong:rho_s={rho},exponent={}", row["n"])), row["H20sum"]);
        assert!((got.value - want).abs() < 0.02, "{}: {got:?} {want}", row["n"]);
    }
}

/// With too few points the reading says so.
#[test]
fn what_has_not_converged_says_so() {
    let meter = standards::by_name("gloss-60").unwrap();
    let brdf = model("ggx:alpha=0.05,n=1.5");
    let starved = Options { tolerance: 1e-6, points: 16, max_points: 64, ..Options::default() };
    assert!(!meter.measure(&*brdf, &starved).unwrap()[0].converged);
    assert!(!meter.subdivide(&*brdf, &Options { tolerance: 1e-9, ..Options::default() }).unwrap()[0].converged);
    assert!(meter.measure(&*brdf, &Options::default()).unwrap()[0].converged);
    for bad in [
        Options { tolerance: 0.0, ..Options::default() },
        Options { tolerance: f64::NAN, ..Options::default() },
        Options::default().with_azimuths([]),
        Options::default().with_azimuths([f64::NAN]),
    ] {
        assert!(meter.measure(&*brdf, &bad).is_err() && meter.subdivide(&*brdf, &bad).is_err());
    }
}
