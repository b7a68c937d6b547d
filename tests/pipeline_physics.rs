//! The chain from heights to table against closed forms and against its own slow twin.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::{direction, half_vector, slope_of_half_vector};
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::scatter::{Method, Options, Symmetry, scatter};
use asperity::table::{Provenance, Table};

fn gaussian(sq: f64, acl: f64, seed: u64) -> HeightMap {
    let grid = synth::Grid { width: 512, height: 512, pitch: [0.6e-6; 2] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: true }).unwrap();
    level::keep_tilt(&raw, Edges::Periodic)
}

fn tilted(slopes: [f64; 2]) -> HeightMap {
    let grid = synth::Grid { width: 40, height: 25, pitch: [0.7e-6, 1.9e-6] };
    level::keep_tilt(&synth::ramp(grid, slopes).unwrap(), Edges::Open)
}

fn run(map: &HeightMap, options: &Options) -> (asperity::scatter::Scatter, TableBrdf) {
    let s = scatter(map, options, &|_| ()).unwrap();
    let table = Table::from_scatter(&s, Provenance::default());
    (s, TableBrdf::new(table).unwrap())
}

/// Rotates azimuths of the source over a tilted mirror: the energy must sit in the cell of the one slope there is,
/// and the brightest direction of the table must be the mirror direction.
#[test]
fn a_tilted_mirror_reflects_where_geometry_says() {
    let slopes = [0.08, -0.05];
    let map = tilted(slopes);
    for method in [Method::Geometric, Method::Facets, Method::Rays] {
        let phis = [0.0, 37.0, 90.0];
        let options = Options {
            method,
            material: Material::Mirror,
            theta_i: [0.0f64, 20.0, 45.0, 60.0].map(f64::to_radians).to_vec(),
            phi_i: phis.map(f64::to_radians).to_vec(),
            rays: 20_000,
            ..Options::default()
        };
        let (s, brdf) = run(&map, &options);
        assert!(!s.isotropic);
        for (t, row) in s.tallies.iter().enumerate() {
            for (p, tally) in row.iter().enumerate() {
                let hot = (0..s.cells.len()).max_by(|&a, &b| tally.energy[a].total_cmp(&tally.energy[b])).unwrap();
                assert_eq!(hot, s.cells.locate(slopes[0], slopes[1]));
                assert!((tally.energy[hot] / tally.incident - 1.0).abs() < 1e-9, "{method:?} {t} {p}");
            }
        }
        let n = asperity::math::frame::normal_of_slope(slopes[0], slopes[1]);
        for (theta, phi) in [(20.0f64, 0.0f64), (45.0, 90.0), (60.0, 37.0), (30.0, 200.0)] {
            let wi = direction(theta.to_radians(), phi.to_radians());
            let expected = asperity::math::reflect(wi, n);
            for k in 0..50 {
                let sample = brdf.sample(wi, [(f64::from(k) + 0.5) / 50.0, 0.3]).unwrap();
                // Cells here are 1e-5 wide in slope; the outer half of the first ring is the farthest.
                assert!((sample.wo - expected).length() < 2e-4, "{} {expected}", sample.wo);
            }
        }
    }
}

/// The two-slope sawtooth of slopes +-0.1 at 30 deg (TV43): weights and angles.
#[test]
fn sawtooth_weights_and_angles() {
    let heights = ndarray::Array2::from_shape_fn((12, 40), |(_, c)| 0.1 * 1e-6 * (c % 2) as f32);
    let map = HeightMap { heights, pitch_x: 1e-6, pitch_y: 3e-6, edges: Edges::Periodic, removed_slopes: [0.0; 2] };
    for method in [Method::Geometric, Method::Facets, Method::Rays] {
        let options = Options {
            method,
            symmetry: Symmetry::Anisotropic,
            material: Material::Mirror,
            theta_i: vec![30f64.to_radians()],
            phi_i: vec![0.0],
            rays: 1 << 18,
            ..Options::default()
        };
        let s = scatter(&map, &options, &|_| ()).unwrap();
        let tally = &s.tallies[0][0];
        for (slope, weight) in [(0.1, 0.4711324865), (-0.1, 0.5288675135)] {
            let e = tally.fraction(s.cells.locate(slope, 0.0));
            // f32 heights carry the slope to 1e-7; rays to their standard error; the slope distribution takes
            // the weight from the middle of a cell, here up to 0.01 of slope away: times tan 30 deg, halved.
            let tolerance = match method {
                Method::Kirchhoff | Method::Auto => unreachable!("not in the list"),
                Method::Rays => 4.0 * e.standard_error,
                Method::Facets => 3e-7,
                Method::Geometric => 0.003,
            };
            assert!((e.value - weight).abs() < tolerance, "{method:?} {slope} {e:?}");
            let wo = asperity::math::reflect(
                direction(30f64.to_radians(), 0.0),
                asperity::math::frame::normal_of_slope(slope, 0.0),
            );
            let theta_r = if slope > 0.0 { 41.4211862750f64 } else { 18.5788137250 };
            assert!((asperity::math::frame::theta(wo).to_degrees() - theta_r).abs() < 1e-8);
            assert!(wo.x < 0.0, "specular side is away from the source");
        }
    }
}

/// Gaussian surface against F D G / (4 cos cos) with height-correlated Smith (physics of Heitz 2014): the table's
/// values within 3 % of the lobe's peak plus 4 standard errors.
#[test]
fn gaussian_lobe_is_the_microfacet_formula() {
    let (sq, acl) = (0.7e-6, 10e-6);
    let map = gaussian(sq, acl, 4);
    let (s, brdf) = run(
        &map,
        &Options { method: Method::Geometric, material: Material::Dielectric { n: 1.5 }, ..Options::default() },
    );
    assert!(s.isotropic);
    let alpha = s.statistics.sdq;
    let lambda = |cos: f64| {
        let v = cos / (1.0 - cos * cos).max(1e-30).sqrt() / alpha;
        (libm::erf(v) - 1.0) / 2.0 + (-v * v).exp() / (2.0 * v * std::f64::consts::PI.sqrt())
    };
    let formula = |wi: glam::DVec3, wo: glam::DVec3| {
        let wh = half_vector(wi, wo);
        let (p, q) = slope_of_half_vector(wh);
        let d = (-(p * p + q * q) / alpha.powi(2)).exp() / (std::f64::consts::PI * alpha.powi(2) * wh.z.powi(4));
        let g = 1.0 / (1.0 + lambda(wi.z) + lambda(wo.z));
        asperity::optics::fresnel::dielectric(wh.dot(wi), 1.5) * d * g / (4.0 * wi.z * wo.z)
    };
    for theta_i in [5.0f64, 20.0, 45.0, 60.0, 75.0] {
        let wi = direction(theta_i.to_radians(), 0.4);
        let mut peak = 0.0f64;
        let mut worst = (0.0f64, 0.0);
        for step in -40..=40 {
            let theta_r = theta_i + f64::from(step);
            if !(0.0..89.0).contains(&theta_r) {
                continue;
            }
            let wo = direction(theta_r.to_radians(), 0.4 + std::f64::consts::PI);
            let expected = formula(wi, wo);
            peak = peak.max(expected);
            let e = brdf.table().estimate(wi, wo);
            let excess = (e.value - expected).abs() - 4.0 * e.standard_error;
            if excess > worst.0 {
                worst = (excess, theta_r);
            }
        }
        assert!(worst.0 < 0.03 * peak, "theta_i {theta_i}: off by {} of the peak at {}", worst.0 / peak, worst.1);
    }
}

/// Energy book and albedo: white surfaces lose nothing but what the book lists.
#[test]
fn the_energy_book_closes() {
    let map = gaussian(1.2e-6, 8e-6, 2);
    for method in [Method::Geometric, Method::Facets, Method::Rays] {
        for material in [Material::Mirror, Material::Dielectric { n: 1.5 }] {
            let (s, brdf) = run(&map, &Options { method, material, rays: 100_000, ..Options::default() });
            for (t, row) in s.tallies.iter().enumerate() {
                let book = row[0].book();
                assert!((book.escaped + book.absorbed + book.lost - 1.0).abs() < 1e-12, "{method:?} {t} {book:?}");
                if material == Material::Mirror {
                    assert!(book.absorbed == 0.0 && book.escaped > 0.995, "{method:?} {t} {book:?}");
                }
                let wi = direction(s.theta_i[t], 0.0);
                assert!((brdf.table().albedo(wi) - book.escaped).abs() < 1e-12, "{method:?} {t}");
                // The integral of what the table gives back by interpolation.
                let albedo = brdf.albedo(s.theta_i[t]);
                assert!((albedo / book.escaped - 1.0).abs() < 5e-3, "{method:?} {t}: {albedo} {book:?}");
            }
        }
    }
}

/// Mean weight of the samples is the albedo of the interpolated table, at nodes and between them.
#[test]
fn sampled_energy_is_the_albedo() {
    let map = gaussian(0.8e-6, 12e-6, 7);
    let (_, brdf) = run(&map, &Options { method: Method::Geometric, material: Material::Mirror, ..Options::default() });
    for theta_i in [0.0f64, 12.0, 20.0, 47.0, 75.0, 84.0] {
        let wi = direction(theta_i.to_radians(), 1.0);
        let mut rng = asperity::math::random::CounterRng::new(1, 0, 0);
        let weights: Vec<f64> =
            (0..200_000).map(|_| brdf.sample(wi, [rng.uniform(), rng.uniform()]).map_or(0.0, |s| s.weight)).collect();
        let e = asperity::math::Estimate::from_repeats(&weights);
        let albedo = brdf.albedo(theta_i.to_radians());
        // Between nodes the albedo is interpolated linearly: 1e-3 for that.
        assert!((e.value - albedo).abs() < 4.0 * e.standard_error + 1e-3, "{theta_i}: {e:?} {albedo}");
    }
}

/// The three faces of one sampler agree: weight = f cos / pdf of the direction drawn.
#[test]
fn weight_is_f_cos_over_pdf() {
    let map = gaussian(0.5e-6, 10e-6, 3);
    for symmetry in [Symmetry::Isotropic, Symmetry::Anisotropic] {
        let (_, brdf) = run(&map, &Options { method: Method::Geometric, symmetry, ..Options::default() });
        let mut rng = asperity::math::random::CounterRng::new(8, 0, 0);
        let mut checked = 0;
        for _ in 0..20_000 {
            let wi = direction(1.5 * rng.uniform(), std::f64::consts::TAU * rng.uniform());
            let Some(s) = brdf.sample(wi, [rng.uniform(), rng.uniform()]) else { continue };
            let (f, pdf) = (brdf.eval(wi, s.wo), brdf.pdf(wi, s.wo));
            // A direction within rounding of a cell's border may be looked up in the neighbour.
            if (pdf / s.pdf - 1.0).abs() > 1e-6 {
                continue;
            }
            checked += 1;
            assert!((f * s.wo.z / pdf - s.weight).abs() < 1e-6 * (1.0 + s.weight), "{wi} {s:?} {f} {pdf}");
        }
        assert!(checked > 19_000, "{checked}");
    }
}
