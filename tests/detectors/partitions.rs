//! Every partition covers the hemisphere once, with the solid angles it states.

use super::reference;
use asperity::math::random::CounterRng;
use asperity::math::statistics::chi_square_test;
use asperity::math::{direction, frame, half_vector};
use asperity::scatter::detectors::{Bounds, Rings, ShirleyChiu};
use asperity::scatter::{Detectors, HalfVectorCells, Partition};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Partitions that do not depend on the source.
fn fixed() -> Vec<(&'static str, Box<dyn Detectors>)> {
    vec![
        ("klems", Box::new(Rings::klems())),
        ("theta-phi:5,10", Box::new(Rings::equal_angle(5f64.to_radians(), 10f64.to_radians()).unwrap())),
        ("theta-phi:7,360", Box::new(Rings::equal_angle(7f64.to_radians(), TAU).unwrap())),
        ("equal-area:1", Box::new(Rings::equal_area(1).unwrap())),
        ("equal-area:200", Box::new(Rings::equal_area(200).unwrap())),
        ("shirley-chiu:0", Box::new(ShirleyChiu::new(0).unwrap())),
        ("shirley-chiu:4", Box::new(ShirleyChiu::new(4).unwrap())),
    ]
}

/// A lobe about as wide as the hemisphere, off centre and elliptic.
fn slopes() -> HalfVectorCells {
    HalfVectorCells::new([0.1, -0.05], [0.9, 0.5], 0.4, 0.01)
}

/// Uniform over the disc of direction cosines: density `cos(theta) / pi` per solid angle.
fn cosine_direction(rng: &mut CounterRng) -> DVec3 {
    let (r2, phi) = (rng.uniform(), TAU * rng.uniform());
    let (s, c) = phi.sin_cos();
    DVec3::new(r2.sqrt() * c, r2.sqrt() * s, (1.0 - r2).sqrt())
}

#[track_caller]
fn inside(what: &str, bounds: Bounds, w: DVec3) {
    let theta = frame::theta(w);
    let slack = 1e-9;
    assert!(theta >= bounds.theta[0] - slack && theta <= bounds.theta[1] + slack, "{what}: {theta} in {bounds:?}");
    let turn = (frame::phi(w) - bounds.phi[0] + slack).rem_euclid(TAU);
    assert!(turn <= bounds.phi[1] - bounds.phi[0] + 2.0 * slack, "{what}: {} in {bounds:?}", frame::phi(w));
}

#[test]
fn projected_solid_angles_add_up_to_pi() {
    for (name, d) in fixed() {
        let sum: f64 = (0..d.len()).map(|k| d.projected_solid_angle(k, DVec3::Z)).sum();
        assert!((sum - PI).abs() < 1e-12, "{name}: {sum}");
    }
    // Cells follow the lobe, not the horizon: those it cuts are integrated by points.
    for theta_i in [0.0f64, 30.0, 70.0] {
        let wi = direction(theta_i.to_radians(), 0.3);
        let cells = slopes();
        let sum: f64 = (0..Detectors::len(&cells)).map(|k| cells.projected_solid_angle(k, wi)).sum();
        assert!((sum / PI - 1.0).abs() < 5e-4, "{theta_i}: {sum}");
    }
}

#[test]
fn directions_lie_in_the_box_of_their_detector_and_hit_it_as_often_as_it_is_large() {
    let mut partitions = fixed();
    partitions.push(("half-vector", Box::new(slopes())));
    let wi = direction(0.5, 1.0);
    for (name, d) in partitions {
        let mut rng = CounterRng::new(4, 0, 0);
        let n = 200_000;
        let mut counts = vec![0.0; d.len()];
        for k in 0..n {
            let wo = cosine_direction(&mut rng);
            let index = d.index(wi, wo);
            counts[index] += 1.0;
            if k < 20_000 {
                let seen = if d.slope_cells().is_some() { half_vector(wi, wo) } else { wo };
                // A box about a curved side is known to a step of its scan.
                let b = d.bounds(index);
                let b = if d.slope_cells().is_some() { widened(b) } else { b };
                inside(name, b, seen);
            }
        }
        let expected: Vec<f64> = (0..d.len()).map(|k| f64::from(n) * d.projected_solid_angle(k, wi) / PI).collect();
        let (chi2, dof, p) = chi_square_test(&counts, &expected, 20.0);
        assert!(d.len() < 3 || p > 1e-4, "{name}: chi2 {chi2}, {dof} degrees of freedom, p {p}");
    }
}

fn widened(b: Bounds) -> Bounds {
    let (t, p) = (0.03 * (b.theta[1] - b.theta[0]), 0.03 * (b.phi[1] - b.phi[0]));
    Bounds { theta: [b.theta[0] - t, b.theta[1] + t], phi: [b.phi[0] - p, b.phi[1] + p] }
}

/// The definition of LBNL, ring by ring.
#[test]
fn klems_patches_are_the_published_ones() {
    let klems = Rings::klems();
    assert_eq!(klems.len(), 145);
    // TV36.
    assert!((klems.projected_solid_angle(0, DVec3::Z) - 0.023864).abs() < 1e-6);
    assert!((klems.projected_solid_angle(144, DVec3::Z) - 0.017537).abs() < 1e-6);
    // Patches turn with phi from a centre at 0.
    let at = |theta: f64, phi: f64| klems.index(DVec3::Z, direction(theta.to_radians(), phi.to_radians()));
    assert_eq!([at(3.0, 77.0), at(10.0, 0.0), at(10.0, -22.0), at(10.0, 23.0), at(10.0, 337.0)], [0, 1, 1, 2, 8]);
    assert_eq!([at(80.0, 14.0), at(80.0, 16.0), at(80.0, 344.0)], [133, 134, 144]);
    let Some(table) = reference::table("klems_full.csv") else { return };
    let mut first = 0;
    for row in table.rows() {
        let n = row["nphi"] as usize;
        for k in first..first + n {
            let b = klems.bounds(k);
            assert!((b.theta[0].to_degrees() - row["theta_lo"]).abs() < 1e-9, "{k}");
            assert!((b.theta[1].to_degrees() - row["theta_hi"]).abs() < 1e-9, "{k}");
            assert!((b.phi[1] - b.phi[0] - TAU / n as f64).abs() < 1e-12, "{k}");
            assert!((klems.projected_solid_angle(k, DVec3::Z) - row["omega_proj_patch"]).abs() < 1e-8, "{k}");
        }
        first += n;
    }
    assert_eq!(first, 145);
}

#[test]
fn equal_detectors_are_equal_and_nearly_square() {
    for count in [1, 2, 3, 7, 50, 145, 1000, 40_000] {
        let d = Rings::equal_area(count).unwrap();
        assert_eq!(d.len(), count);
        for k in (0..count).step_by(1 + count / 97) {
            assert!((d.projected_solid_angle(k, DVec3::Z) / (PI / count as f64) - 1.0).abs() < 1e-9, "{count} {k}");
            let b = d.bounds(k);
            if count >= 50 && b.theta[0] > 0.0 {
                let radius = b.theta.map(f64::sin);
                let aspect = (b.phi[1] - b.phi[0]) * 0.5 * (radius[0] + radius[1]) / (radius[1] - radius[0]);
                assert!((0.6..1.7).contains(&aspect), "{count} {k}: {aspect}");
            }
        }
    }
}

/// The bent grid keeps neighbours: a cell's corners lie in its box, its middle in the cell.
#[test]
fn shirley_chiu_cells_are_the_square_grid() {
    let d = ShirleyChiu::new(3).unwrap();
    // Along +x and +y the map is the identity.
    for (x, cell) in [(0.1, 4 * 8 + 4), (0.3, 4 * 8 + 5), (0.9, 4 * 8 + 7), (-0.1, 4 * 8 + 3), (-0.9, 4 * 8)] {
        let phi = if x < 0.0 { PI - 1e-6 } else { 1e-6 };
        assert_eq!(d.index(DVec3::Z, direction(f64::asin(f64::abs(x)), phi)), cell, "{x}");
    }
    // The diagonal of the square is the direction of 45 deg at the same largest coordinate.
    assert_eq!(d.index(DVec3::Z, direction(f64::asin(0.6), PI / 4.0)), 6 * 8 + 6);
    assert_eq!(d.index(DVec3::Z, direction(f64::asin(0.6), -3.0 * PI / 4.0)), 8 + 1);
}

#[test]
fn names_are_read_and_refused() {
    let degrees = f64::to_radians;
    for (text, expected) in [
        ("half-vector", Partition::HalfVector),
        ("klems", Partition::Klems),
        ("theta-phi:0.5, 2", Partition::EqualAngle { theta: degrees(0.5), phi: degrees(2.0) }),
        ("equal-area:1000", Partition::EqualArea { count: 1000 }),
        ("shirley-chiu:7", Partition::ShirleyChiu { k: 7 }),
    ] {
        assert_eq!(Partition::parse(text).unwrap(), expected);
    }
    for (text, word) in [
        ("", "unknown"),
        ("klems:2", "unknown"),
        ("theta-phi", "unknown"),
        ("theta-phi:5", "unknown"),
        ("theta-phi:5,7", "close the circle"),
        ("theta-phi:0,10", "0 deg by"),
        ("theta-phi:nan,10", "theta-phi:DT,DP in degrees"),
        ("theta-phi:0.001,0.001", "are more than"),
        ("equal-area:0", "0 detectors"),
        ("equal-area:99999999", "detectors of equal"),
        ("shirley-chiu:11", "too many"),
        ("shirley-chiu:99", "too many"),
    ] {
        let error = Partition::parse(text).unwrap_err().to_string();
        assert!(error.contains(word), "{text}: {error}");
    }
}
