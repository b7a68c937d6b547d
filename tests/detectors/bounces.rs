//! Shares of one, two and more bounces on Gaussian surfaces, against ray tracing by other programs: a table of reference, and
//! [`super::plain_tracer`].

use super::plain_tracer::PlainTracer;
use super::{gaussian, reference, surface, with_walk};
use asperity::facets::SlopeStatistics;
use asperity::heightmap::HeightMap;
use asperity::math::Estimate;
use asperity::optics::Material;
use asperity::scatter::Selection;
use asperity::scatter::detectors::Rings;
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::rays::trace_rays;

/// Largest difference in a share, beyond the scatter of the reference.
const TOLERANCE: f64 = 0.005;

/// The reference has one map per slope, lit along +x by so many rays, and names the rms slope of that map along x: it is up to
/// 1.4 %, and in the root mean square 0.76 %, off the nominal one. The slope of a map of L correlation lengths scatters by
/// `0.63 l / L`, so its maps are about 85 correlation lengths wide.
const REFERENCE_SIDE: f64 = 85.0;
const REFERENCE_RAYS: f64 = 1e5;

/// Steep surfaces scatter from map to map: many of them, as those of the reference.
const STEEP_MAPS: u64 = 12;
const SIDE: usize = 512;
const GENTLE_PER_LENGTH: f64 = 12.0;
const STEEP_PER_LENGTH: f64 = 8.0;

/// Shares of 1, 2 and more bounces of each map, stretched to the rms slope of its facets along x.
fn shares(maps: &mut [HeightMap], slope: f64, theta_i: f64, azimuth: Azimuth) -> Vec<[f64; 3]> {
    let all = Rings::equal_area(1).unwrap();
    maps.iter_mut()
        .map(|map| {
            let factor = (slope / SlopeStatistics::measure(map).unwrap().rms[0]) as f32;
            map.heights.mapv_inplace(|h| h * factor);
            with_walk(map, Material::Mirror, 30, |walk| {
                // All facets: neighbours share an azimuth, and a part of them would scatter more.
                let lit = Selection::default();
                let tally = facet_sum(walk, &all, theta_i.to_radians(), azimuth, &lit).tally();
                assert!(tally.book().lost < 1e-3, "{theta_i}: {:?}", tally.book());
                tally.bounce_fractions()
            })
        })
        .collect()
}

/// Every share within 0.005 up to alpha 0.5. At alpha 1 within 0.005 and twice the scatter of the reference, that is of one map
/// of its size at one azimuth and of its rays, as measured here. The mean of a map is one over independent places, so its
/// scatter falls with the side of the map.
#[test]
fn bounces_of_gaussian_surfaces() {
    let Some(table) = reference::table("heightfield_bounces.csv") else { return };
    let mut gentle: Vec<HeightMap> = (0..2).map(|k| gaussian(SIDE, GENTLE_PER_LENGTH, 0.1, 40 + k)).collect();
    let mut steep: Vec<HeightMap> =
        (0..STEEP_MAPS).map(|k| surface(SIDE, STEEP_PER_LENGTH, 0.1, 100 + k, false)).collect();
    let shrink = SIDE as f64 / STEEP_PER_LENGTH / REFERENCE_SIDE;
    let mut worst = [0.0f64; 2];
    let mut rows = 0;
    for row in table.rows() {
        let (slope, theta_i) = (row["measured_slope_1d_forward"], row["theta_i"]);
        let is_steep = slope > 0.5;
        let found = match is_steep {
            true => shares(&mut steep, slope, theta_i, Azimuth::Fixed(0.0)),
            // Isotropic: the mean over all azimuths, which scatters less.
            false => shares(&mut gentle, slope, theta_i, Azimuth::Averaged),
        };
        for (b, name) in ["frac_1_bounce", "frac_2", "frac_ge3"].into_iter().enumerate() {
            let e = Estimate::from_repeats(&found.iter().map(|s| s[b]).collect::<Vec<_>>());
            let of_one_map = e.standard_error * (found.len() as f64).sqrt() * shrink;
            let of_rays = (e.value * (1.0 - e.value) / REFERENCE_RAYS).sqrt();
            let scatter = if is_steep { of_one_map.hypot(of_rays) } else { 0.0 };
            let off = (e.value - row[name]).abs();
            println!(
                "alpha {:.2} at {theta_i} deg, {name}: {:.4} +- {:.4}, reference {:.4} +- {scatter:.4}, off by {off:.4}",
                row["alpha_beckmann"], e.value, e.standard_error, row[name]
            );
            assert!(
                off <= TOLERANCE + 2.0 * scatter,
                "slope {slope} at {theta_i} deg, {name}: {e:?} against {} +- {scatter}",
                row[name]
            );
            worst[usize::from(is_steep)] = worst[usize::from(is_steep)].max(off);
        }
        rows += 1;
    }
    println!("{rows} rows, largest difference {:.4} up to alpha 0.5, {:.4} at alpha 1", worst[0], worst[1]);
    assert_eq!(rows, 36);
}

/// The same map, so no scatter of surfaces: rays against another tracer within 4 standard errors of both, and the facet sum within
/// 0.002 (it asks every facet at its middle).
#[test]
fn bounces_of_a_steep_surface_are_those_of_a_plain_tracer() {
    const RAYS: u64 = 400_000;
    let map = surface(SIDE, GENTLE_PER_LENGTH, 0.7072, 7, false);
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
