//! Surfaces whose scatter can be written down.

use super::{counted, gaussian, with_walk};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::optics::Material;
use asperity::scatter::detectors::Rings;
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::{Detectors, Method, Options, Partition, Selection};
use glam::DVec3;
use ndarray::Array2;

fn steps(theta: f64, phi: f64) -> Partition {
    Partition::EqualAngle { theta: theta.to_radians(), phi: phi.to_radians() }
}

fn at(method: Method, material: Material, theta_i: f64) -> Options {
    Options { method, material, theta_i: vec![theta_i.to_radians()], rays: 200_000, ..Options::default() }
}

/// A map of pitch 1 x 3 with heights by column.
fn ridges(columns: usize, edges: Edges, height: impl Fn(usize) -> f64) -> HeightMap {
    let heights = Array2::from_shape_fn((9, columns), |(_, c)| height(c) as f32);
    HeightMap { heights, pitch_x: 1.0, pitch_y: 3.0, edges, removed_slopes: [0.0; 2] }
}

/// `f = R / Omega_p` in the one detector that sees the image of the source: 1645.18 /sr for n = 1.5 at 20 deg and a detector
/// from 19.75 to 20.25 deg, 0.5 deg wide.
#[test]
fn a_flat_mirror_fills_one_detector() {
    let map = ridges(40, Edges::Open, |_| 0.0);
    for method in [Method::Facets, Method::Rays] {
        let counts = counted(&map, &at(method, Material::Dielectric { n: 1.5 }, 20.0), steps(0.5, 0.5), false);
        let d = &counts.directions[0];
        let wo = direction(20f64.to_radians(), 180f64.to_radians());
        let hot = counts.detectors.index(direction(20f64.to_radians(), 0.0), wo);
        let b = counts.detectors.bounds(hot);
        assert!((b.theta[0].to_degrees() - 19.75).abs() < 1e-9 && (b.theta[1].to_degrees() - 20.25).abs() < 1e-9);
        assert!((b.phi[0].to_degrees() - 179.75).abs() < 1e-9 && (b.phi[1].to_degrees() - 180.25).abs() < 1e-9);
        assert!((d.f_r(hot).value - 1645.183).abs() < 1e-3, "{method:?}: {:?}", d.f_r(hot));
        assert!(d.share[hot].standard_error < 1e-12, "{:?}", d.share[hot]);
        assert!((0..counts.detectors.len()).all(|k| k == hot || d.share[k].value == 0.0));
        // An empty detector is known to the rule of three, not exactly.
        let empty = d.f_r(hot + 1);
        let bound = 3.0 / (d.tally.beams as f64 * d.projected_solid_angle[hot + 1]);
        assert!(empty.value == 0.0 && (empty.standard_error / bound - 1.0).abs() < 1e-12);
    }
}

/// TV43: slopes +-0.1 at 30 deg reflect to 41.421 and 18.579 deg with weights 0.47113 and 0.52887.
#[test]
fn a_sawtooth_has_two_directions() {
    let map = ridges(40, Edges::Periodic, |c| 0.1 * (c % 2) as f64);
    for method in [Method::Facets, Method::Rays] {
        for partition in [steps(0.2, 5.0), Partition::EqualArea { count: 5000 }, Partition::ShirleyChiu { k: 6 }] {
            let counts = counted(&map, &at(method, Material::Mirror, 30.0), partition, false);
            let (d, wi) = (&counts.directions[0], direction(30f64.to_radians(), 0.0));
            for (theta_r, weight) in [(41.4211862750f64, 0.4711324865), (18.5788137250, 0.5288675135)] {
                let wo = direction(theta_r.to_radians(), std::f64::consts::PI);
                let e = d.share[counts.detectors.index(wi, wo)];
                // f32 heights carry the slope to 1e-7. Sub-areas of odd width hold more of one slope than of the other,
                // which the standard error sees.
                let tolerance = if method == Method::Rays { 5.0 * e.standard_error + 1e-4 } else { 3e-7 };
                assert!((e.value - weight).abs() < tolerance, "{method:?} {partition:?} {theta_r}: {e:?}");
            }
            assert!((d.albedo.value - 1.0).abs() < 1e-12);
        }
    }
}

/// Walls of slope +-1: what is reflected twice goes back to the source, whatever the angle in the plane of the groove. At
/// theta_i < 45 deg the share tan(theta_i) leaves after one bounce, at 90 deg - theta_i on the source's side.
#[test]
fn a_right_angled_groove_sends_back() {
    let wall = 200;
    let map = ridges(2 * wall, Edges::Periodic, |c| c.abs_diff(wall) as f64);
    for method in [Method::Facets, Method::Rays] {
        for theta_i in [0.0f64, 10.0, 20.0, 32.0] {
            let counts = counted(&map, &at(method, Material::Mirror, theta_i), steps(1.0, 2.0), false);
            let (d, wi) = (&counts.directions[0], direction(theta_i.to_radians(), 0.0));
            let once = theta_i.to_radians().tan();
            // Facets by their centroids: half a facet of the lit wall.
            let tolerance =
                if method == Method::Rays { 4.0 * (once * (1.0 - once) / 2e5).sqrt() + 1e-9 } else { 0.005 };
            let [one, two, more] = d.tally.bounce_fractions();
            assert!((one - once).abs() < tolerance && (two - 1.0 + once).abs() < tolerance, "{theta_i}: {one} {two}");
            assert!(more == 0.0);
            let back = counts.detectors.index(wi, wi);
            let aside = counts.detectors.index(wi, direction((90.0 - theta_i).to_radians(), 0.0));
            assert!((d.tally.by_bounce[back][1] / d.tally.incident - two).abs() < 1e-12);
            assert!((d.tally.by_bounce[aside][0] / d.tally.incident - one).abs() < 1e-12);
        }
    }
}

/// A mirror sphere scatters evenly: `E_k = R^2 w_k / (4 A cos(theta_i))` for every detector of solid angle `w_k` whose
/// normals lie on the cap of plan area A, whatever the direction of the source.
#[test]
fn a_spherical_cap_scatters_evenly() {
    let grid = synth::Grid { width: 451, height: 301, pitch: [1.0, 1.5] };
    let radius = 600.0;
    let map = level::keep_tilt(&synth::cap(grid, radius).unwrap(), Edges::Open);
    let area = 450.0 * 300.0 * 1.5;
    for (theta_i, reach) in [(0.0f64, 42.0), (25.0, 15.0)] {
        let counts = counted(&map, &at(Method::Facets, Material::Mirror, theta_i), steps(5.0, 20.0), false);
        let d = &counts.directions[0];
        let (mut sum, mut wanted, mut used) = (0.0, 0.0, 0);
        for k in 0..counts.detectors.len() {
            let b = counts.detectors.bounds(k);
            if b.theta[1].to_degrees() > reach {
                continue;
            }
            let solid_angle = (b.theta[0].cos() - b.theta[1].cos()) * (b.phi[1] - b.phi[0]);
            let expected = radius * radius * solid_angle / (4.0 * area * theta_i.to_radians().cos());
            assert!((d.share[k].value / expected - 1.0).abs() < 0.03, "{theta_i} {b:?}: {:?} {expected}", d.share[k]);
            sum += d.share[k].value;
            wanted += expected;
            used += 1;
        }
        assert!(used > 30 && (sum / wanted - 1.0).abs() < 3e-3, "{theta_i}: {used} {sum} {wanted}");
    }
}

/// TV44 and TV45. Without facets that face away the weights of a periodic map sum to its area exactly; with them to
/// 1 + Lambda of Smith, and what is left in the light is again the area of the mean plane.
#[test]
fn lit_area_is_the_area_of_the_mean_plane() {
    let all = Rings::equal_area(1).unwrap();
    let smooth = gaussian(256, 8.0, 0.05, 2);
    let facing = |map: &HeightMap, theta_i: f64| {
        with_walk(map, Material::Mirror, 8, |walk| {
            let sum = facet_sum(walk, &all, theta_i.to_radians(), Azimuth::Fixed(0.7), &Selection::default());
            let tally = sum.tally();
            let facets = 2.0 * (map.width() * map.height()) as f64;
            (tally.incident * (1.0 + tally.shadowed) / facets, tally.incident / facets)
        })
    };
    let (weights, lit) = facing(&smooth, 60.0);
    // Weights are worked out in f32 side by side and summed exactly.
    assert!((weights - 1.0).abs() < 1e-9 && (lit - 1.0).abs() < 1e-9, "{weights} {lit}");
    // alpha = 0.495.
    let maps: Vec<HeightMap> = (0..4).map(|seed| gaussian(384, 10.0, 0.35, seed)).collect();
    for (theta_i, excess) in [(60.0, 1.0125), (80.0, 1.3903)] {
        let (mut weights, mut lit) = (0.0, 0.0);
        for map in &maps {
            let (w, l) = facing(map, theta_i);
            weights += w / 4.0;
            lit += l / 4.0;
        }
        println!("{theta_i} deg: sum of weights {weights}, lit {lit}");
        assert!((weights - excess).abs() < 0.005, "{theta_i}: {weights}");
        assert!((lit - 1.0).abs() < 0.01, "{theta_i}: {lit}");
    }
    assert_eq!(all.index(DVec3::Z, DVec3::Z), 0);
}
