//! Shares of one, two and more bounces on Gaussian surfaces, against ray tracing by other programs: a table of reference on its
//! own surfaces ([`super::published_maps`]), and [`super::plain_tracer`].

use super::plain_tracer::PlainTracer;
use super::published_maps::{self, NumpyNormals};
use super::{reference, surface, with_walk};
use asperity::facets::SlopeStatistics;
use asperity::optics::Material;
use asperity::scatter::Selection;
use asperity::scatter::detectors::Rings;
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::rays::trace_rays;

/// Largest difference in a share.
const TOLERANCE: f64 = 0.005;
/// Rays of the reference per row: its shares are whole multiples of 1e-5.
const REFERENCE_RAYS: f64 = 1e5;

/// A steep map that another tracer takes too.
const SIDE: usize = 512;
const PER_LENGTH: f64 = 12.0;

/// On the very maps of the reference, so no scatter of surfaces: every share within 0.005 and one standard error of the
/// reference's rays (0.0016 at most), 35 of the 36 rows within 0.005 alone.
#[test]
fn bounces_of_gaussian_surfaces() {
    let Some(table) = reference::table("heightfield_bounces.csv") else { return };
    let rows: Vec<_> = table.rows().collect();
    assert_eq!(rows.len(), 36);
    let all = Rings::equal_area(1).unwrap();
    let mut normals = NumpyNormals::new();
    let (mut worst, mut beyond) = ([0.0f64; 2], 0);
    for of_map in rows.chunks(6) {
        let map = published_maps::next_map(&mut normals, of_map[0]["rms_slope_1d"]);
        let slope = SlopeStatistics::measure(&map).unwrap().rms[0];
        let named = of_map[0]["measured_slope_1d_forward"];
        assert!((slope - named).abs() < 1e-6, "not the map of the reference: slope {slope}, named {named}");
        for row in of_map {
            let (alpha, theta_i) = (row["alpha_beckmann"], row["theta_i"]);
            let shares: [f64; 3] = with_walk(&map, Material::Mirror, 60, |walk| {
                let tally =
                    facet_sum(walk, &all, theta_i.to_radians(), Azimuth::Fixed(0.0), &Selection::default()).tally();
                assert!(tally.book().lost < 1e-3, "{theta_i}: {:?}", tally.book());
                tally.bounce_fractions()
            });
            let known = ["frac_1_bounce", "frac_2", "frac_ge3"].map(|name| row[name]);
            let off = [0, 1, 2].map(|b| (shares[b] - known[b]).abs());
            println!("alpha {alpha:.2} at {theta_i} deg: {shares:.4?}, reference {known:.4?}, off by {off:.4?}");
            for b in 0..3 {
                let of_rays = (known[b] * (1.0 - known[b]) / REFERENCE_RAYS).sqrt();
                assert!(off[b] <= TOLERANCE + of_rays, "alpha {alpha} at {theta_i} deg: {shares:?} against {known:?}");
            }
            let largest = off.into_iter().fold(0.0, f64::max);
            worst[usize::from(alpha > 0.6)] = worst[usize::from(alpha > 0.6)].max(largest);
            beyond += usize::from(largest > TOLERANCE);
        }
    }
    println!(
        "largest difference {:.4} up to alpha 0.5, {:.4} at alpha 1; {beyond} rows beyond 0.005",
        worst[0], worst[1]
    );
    assert!(beyond <= 1, "{beyond} rows are more than 0.005 off");
}

/// The same map, so no scatter of surfaces: rays against another tracer within 4 standard errors of both, and the facet sum within
/// 0.002 (it asks every facet at its middle).
#[test]
fn bounces_of_a_steep_surface_are_those_of_a_plain_tracer() {
    const RAYS: u64 = 400_000;
    let map = surface(SIDE, PER_LENGTH, 0.7072, 7, false);
    let plain = PlainTracer::new(&map);
    let all = Rings::equal_area(1).unwrap();
    with_walk(&map, Material::Mirror, 60, |walk| {
        for theta_i in [0.0f64, 20.0, 45.0, 60.0, 75.0, 85.0] {
            let (theta, fixed, lit) = (theta_i.to_radians(), Azimuth::Fixed(0.0), Selection::default());
            let rays: [f64; 3] = trace_rays(walk, &all, theta, fixed, RAYS, 7, &lit).tally().bounce_fractions();
            let facets: [f64; 3] = facet_sum(walk, &all, theta, fixed, &lit).tally().bounce_fractions();
            let known = plain.shares(theta, RAYS, 11);
            println!("{theta_i} deg: rays {rays:.4?}, facets {facets:.4?}, plain tracer {known:.4?}");
            for b in 0..3 {
                let error = (2.0 * known[b] * (1.0 - known[b]) / RAYS as f64).sqrt();
                assert!((rays[b] - known[b]).abs() < 4.0 * error, "{theta_i} deg, rays {rays:?}, plain {known:?}");
                assert!(
                    (facets[b] - known[b]).abs() < 0.002 + 4.0 * error,
                    "{theta_i} deg, {facets:?}, plain {known:?}"
                );
            }
        }
    });
}
