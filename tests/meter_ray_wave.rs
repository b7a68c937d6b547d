//! Gloss by rays and by waves: where they agree, where the mirror beam makes the difference, where neither holds.

use asperity::meter::ray_wave::{Plan, Reading, ray_wave};
use asperity::optics::{Material, fresnel};

fn plan(sq: &[f64], acl: &[f64]) -> Plan {
    Plan {
        sq: sq.to_vec(),
        acl: acl.to_vec(),
        wavelength: 550e-9,
        material: Material::Dielectric { n: 1.567 },
        size: 256,
        seed: 1,
    }
}

fn at(readings: &[Reading], sq: f64, degrees: f64) -> Reading {
    *readings.iter().find(|r| r.sq == sq && (r.theta_i.to_degrees() - degrees).abs() < 1e-9).unwrap()
}

/// The Rayleigh parameter decides: well above 9 both read the same, below waves read at least their mirror beam, `100
/// exp(-g)`, and rays do not know of it.
#[test]
fn agreement_above_and_a_mirror_beam_below() {
    let (smooth, rough) = (60e-9, 600e-9);
    let readings = ray_wave(&plan(&[smooth, rough], &[5e-6]), &|_| ()).unwrap();
    assert_eq!(readings.len(), 6);
    for angle in [20.0, 60.0] {
        let r = at(&readings, rough, angle);
        let allowed = 0.1 + 4.0 * r.ray.standard_error.hypot(r.wave.standard_error);
        assert!(r.g > 30.0 && (r.wave.value - r.ray.value).abs() < allowed, "{r:?}");
    }
    for (sq, angle) in [(smooth, 20.0), (smooth, 60.0), (smooth, 85.0), (rough, 85.0)] {
        let r = at(&readings, sq, angle);
        let beam = 100.0 * (-r.g).exp();
        // Facets of the rough one hide part of the beam at 85 deg.
        let hidden = sq == rough;
        assert!(r.g < 9.0 && (hidden || r.wave.value > 0.97 * beam), "{r:?} {beam}");
        assert!(r.wave.value - r.ray.value > 4.0 * r.ray.standard_error, "{r:?}");
    }
    // The same map at every angle has the same parameter but for the cosine.
    let g = |angle: f64| at(&readings, smooth, angle).g / f64::to_radians(angle).cos().powi(2);
    assert!((g(20.0) / g(85.0) - 1.0).abs() < 1e-12);
    // All that glass of that index can reflect into the stop, and no more.
    let most = 100.0 / fresnel::dielectric(85f64.to_radians().cos(), 1.567);
    assert!(readings.iter().all(|r| r.wave.value < most && r.ray.value < most));
}

/// Slopes of one half: light bounces again, and the wave calculation says that it does not follow.
#[test]
fn steep_surfaces_are_marked() {
    let readings = ray_wave(&plan(&[1e-6], &[3e-6, 60e-6]), &|_| ()).unwrap();
    let doubt = |acl: f64| readings.iter().filter(|r| r.acl == acl && r.doubt).count();
    assert!(doubt(3e-6) >= 2 && doubt(60e-6) == 0, "{readings:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_and_nonsense_is_refused() {
    let small = Plan { size: 64, ..plan(&[100e-9], &[5e-6, 10e-6]) };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ray_wave(&small, &|_| ()).unwrap())
    };
    assert_eq!(run(1), run(3));
    for bad in [plan(&[], &[5e-6]), plan(&[0.0], &[5e-6]), plan(&[1e-7], &[f64::NAN]), Plan { size: 8, ..small }] {
        assert!(ray_wave(&bad, &|_| ()).is_err(), "{bad:?}");
    }
}
