//! Gloss straight from facets, against flat glass, a tilted mirror, the microfacet model and beams thrown one by one.

use asperity::facets::slopes;
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::frame::normal_of_slope;
use asperity::math::random::CounterRng;
use asperity::math::reflect;
use asperity::meter::stop::{Shape, Stop};
use asperity::meter::{Azimuths, Geometry, Options, facet_gloss, gloss, traced_gloss};
use asperity::model::parse;
use asperity::optics::{Material, fresnel};
use asperity::sample::TableBrdf;
use asperity::scatter::{self, Method, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use std::f64::consts::{PI, TAU};

const GLASS: Material = Material::Dielectric { n: 1.5 };

fn rough(sq: f64, seed: u64) -> HeightMap {
    let grid = synth::Grid { width: 320, height: 256, pitch: [0.5e-6, 0.6e-6] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl: 8e-6, seed, exact: false }).unwrap();
    level::keep_tilt(&raw, Edges::Periodic)
}

fn ramp(slopes: [f64; 2]) -> HeightMap {
    let grid = synth::Grid { width: 21, height: 34, pitch: [1e-6, 2e-6] };
    level::keep_tilt(&synth::ramp(grid, slopes).unwrap(), Edges::Open)
}

#[test]
fn a_flat_map_is_flat_glass() {
    let brdf = parse("dielectric:n=1.5", 550e-9).unwrap();
    let three = Geometry::standard_three();
    for azimuths in [Azimuths::All, Azimuths::At(vec![0.3, 2.0])] {
        let got = facet_gloss(&ramp([0.0, 0.0]), &GLASS, &three, &azimuths).unwrap();
        for (e, g) in got.gloss.iter().zip(&three) {
            // The facets' rule is exact to second order over the source.
            assert!((e.value - gloss(&*brdf, g, &Options::default()).value).abs() < 2e-4, "{e:?}");
            assert!(e.standard_error < 1e-12);
        }
        assert_eq!(got.hidden, [0.0; 3]);
    }
}

/// A tilted mirror is one facet: its cell is exact, wherever the kink of a stop lies. The reference counts directions
/// of the source whose mirror image the receptor accepts.
#[test]
fn a_tilted_mirror_is_exact() {
    let r = f64::to_radians;
    for slopes in [[0.006, 0.0], [0.0, 0.02], [-0.004, 0.011], [0.03, 0.05]] {
        let map = ramp(slopes);
        // Heights are stored in f32: ask the facets.
        let mut stored = (0.0, 0.0);
        slopes::visit_row(&map, 3, |f| stored = (f.p, f.q));
        let n = normal_of_slope(stored.0, stored.1);
        for g in Geometry::standard_three() {
            for phi in [0.0, 1.0] {
                let source = Stop::new(Shape::Rectangle(g.source), g.theta_i, phi, 0.0);
                let receptor = Stop::new(Shape::Rectangle(g.receptor), g.theta_i, phi + PI, 0.0);
                let (mut flux, mut standard) = (0.0, 0.0);
                const N: i32 = 600;
                for k in 0..N * N {
                    let at = |k: i32, half: f64| ((f64::from(k) + 0.5) / f64::from(N) * 2.0 - 1.0) * half;
                    let [a, b] = source.half();
                    let wi = source.direction([at(k % N, a), at(k / N, b)]);
                    let weight = wi.dot(source.axes()[0]).powi(3);
                    let beam = wi.dot(n) / n.z;
                    if receptor.contains(reflect(wi, n)) {
                        flux += weight * beam * GLASS.reflectance(wi.dot(n));
                    }
                    standard += weight * wi.z * fresnel::dielectric(wi.z, g.standard_index);
                }
                let want = 100.0 * flux / standard;
                let got = facet_gloss(&map, &GLASS, std::slice::from_ref(&g), &Azimuths::At(vec![phi])).unwrap();
                // Counting is good to a row or column of the grid.
                let tolerance = 100.0 / f64::from(N);
                assert!(
                    (got.gloss[0].value - want).abs() < tolerance,
                    "{slopes:?} {} {phi}: {:?} {want}",
                    g.theta_i / r(1.0),
                    got.gloss[0]
                );
            }
        }
    }
}

/// Every facet by itself, many random source directions and azimuths: no cells, no polygons.
#[test]
fn agrees_with_beams_thrown_one_by_one() {
    for (sq, azimuths) in [(0.03e-6, None), (0.1e-6, None), (0.1e-6, Some(0.7))] {
        let map = rough(sq, 4);
        let three = Geometry::standard_three();
        let list = azimuths.map_or(Azimuths::All, |phi| Azimuths::At(vec![phi]));
        let got = facet_gloss(&map, &GLASS, &three, &list).unwrap();
        for (e, g) in got.gloss.iter().zip(&three) {
            let mut rng = CounterRng::new(3, 0, 0);
            let (mut flux, mut squares, mut count, mut standard) = (0.0, 0.0, 0.0, 0.0);
            for row in 0..slopes::cells(&map).1 {
                slopes::visit_row(&map, row, |f| {
                    let n = normal_of_slope(f.p, f.q);
                    for _ in 0..4 {
                        let phi = azimuths.unwrap_or_else(|| TAU * rng.uniform());
                        let source = Stop::new(Shape::Rectangle(g.source), g.theta_i, phi, 0.0);
                        let receptor = Stop::new(Shape::Rectangle(g.receptor), g.theta_i, phi + PI, 0.0);
                        let [a, b] = source.half();
                        let wi = source.direction([(2.0 * rng.uniform() - 1.0) * a, (2.0 * rng.uniform() - 1.0) * b]);
                        let weight = wi.dot(source.axes()[0]).powi(3);
                        let through = receptor.contains(reflect(wi, n));
                        let cos = wi.dot(n);
                        let x = if through { weight * cos.max(0.0) / n.z * GLASS.reflectance(cos) } else { 0.0 };
                        flux += x;
                        squares += x * x;
                        count += 1.0;
                        standard += weight * wi.z * fresnel::dielectric(wi.z, g.standard_index);
                    }
                });
            }
            let want = 100.0 * flux / standard;
            let error = 100.0 / (standard / count) * ((squares / count - (flux / count).powi(2)) / count).sqrt();
            let d = e.value - want;
            // 85 deg hides a little of the steeper map: thrown beams do not know.
            let hidden = 100.0 * got.hidden.iter().fold(0.0f64, |a, &b| a.max(b));
            assert!(d.abs() < 4.0 * error + 2.0 * hidden + 1e-3, "{sq} {:.2}: {e:?} {want} +- {error}", g.theta_i);
            assert!(error < 0.3);
        }
    }
}

/// A Gaussian map against the Beckmann model of the same slopes: `alpha^2 = Sdq^2`, and the error that is claimed.
#[test]
fn gaussian_maps_read_what_the_beckmann_model_reads() {
    for (sq, acl) in [(0.06e-6, 6e-6), (0.2e-6, 6e-6)] {
        let mut squares = [0.0f64; 3];
        let runs = 6;
        for seed in 0..runs {
            let grid = synth::Grid { width: 512, height: 512, pitch: [0.5e-6; 2] };
            let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: false }).unwrap();
            let map = level::keep_tilt(&raw, Edges::Periodic);
            // Slopes of forward differences: TV46.
            let x2 = (0.5e-6 / acl).powi(2);
            let alpha = (4.0 * (sq / acl).powi(2) * (1.0 - (-x2).exp()) / x2).sqrt();
            let model = parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).unwrap();
            let three = Geometry::standard_three();
            let got = facet_gloss(&map, &GLASS, &three, &Azimuths::All).unwrap();
            for (k, (e, g)) in got.gloss.iter().zip(&three).enumerate() {
                let want = gloss(&*model, g, &Options::default()).value;
                assert!((e.value - want).abs() < 5.0 * e.standard_error + 0.05, "{sq} {k}: {e:?} {want}");
                squares[k] += ((e.value - want) / e.standard_error.hypot(0.03)).powi(2);
            }
        }
        for sum in squares {
            assert!((sum / f64::from(runs as u32)).sqrt() < 2.2, "errors are {squares:?} times what is claimed");
        }
    }
}

/// A Gaussian map that is well sampled, and its gloss through a table of facets asked one by one.
fn masked(alpha: f64, seed: u64) -> (HeightMap, scatter::Options, [f64; 3]) {
    let grid = synth::Grid { width: 512, height: 512, pitch: [1e-6; 2] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq: 5e-6 * alpha, acl: 10e-6, seed, exact: true }).unwrap();
    let map = level::keep_tilt(&raw, Edges::Periodic);
    let theta_i = [0.0f64, 19.0, 20.0, 21.0, 59.0, 60.0, 61.0, 80.0, 83.0, 84.5, 85.0, 85.5, 87.0].map(f64::to_radians);
    let (symmetry, method) = (Symmetry::Isotropic, Method::Facets);
    let options = scatter::Options { theta_i: theta_i.to_vec(), symmetry, method, ..scatter::Options::default() };
    let scattered = scatter(&map, &options, &|_| ()).unwrap();
    let brdf = TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).unwrap();
    let by_table = Geometry::standard_three().map(|g| gloss(&brdf, &g, &Options::default()).value);
    (map, options, by_table)
}

/// Facets that hide one another, straight into the stops and by way of a table: the same within what a table is good for and four
/// standard errors of the asking, where single reflections under Smith's function are farther off at 85 deg.
#[test]
fn hidden_facets_are_asked() {
    let three = Geometry::standard_three();
    for (alpha, seed) in [(0.1, 1), (0.3, 2)] {
        let (map, options, by_table) = masked(alpha, seed);
        let smith = facet_gloss(&map, &GLASS, &three, &Azimuths::All).unwrap().gloss;
        let traced = traced_gloss(&map, &three, &Azimuths::All, &options).unwrap().gloss;
        println!("alpha {alpha}: table {by_table:.3?}, traced {traced:.3?}, Smith {smith:.3?}");
        for k in 0..3 {
            let asking = (traced[k].standard_error.powi(2) - smith[k].standard_error.powi(2)).max(0.0).sqrt();
            assert!((traced[k].value - by_table[k]).abs() < 0.1 + 4.0 * asking, "{alpha}: {traced:?} {by_table:?}");
        }
        // Hardly anything hides at 20 deg from the gentler one: nobody is asked.
        assert_eq!(traced[0] == smith[0], alpha < 0.2);
        assert!((smith[2].value - by_table[2]).abs() > 0.2, "{alpha}: {smith:?} {by_table:?}");
    }
}

/// Where nothing hides, asking changes nothing; a source at one azimuth of a map turned by a quarter reads what the other reads.
#[test]
fn asking_knows_when_and_where() {
    let three = Geometry::standard_three();
    let options = scatter::Options::default();
    let gentle = rough(0.03e-6, 3);
    let at = Azimuths::At(vec![0.3, 1.9]);
    let asked = traced_gloss(&gentle, &three, &at, &options).unwrap();
    assert_eq!(asked, facet_gloss(&gentle, &GLASS, &three, &at).unwrap());
    let (map, _, _) = masked(0.2, 5);
    let n = map.width();
    // Column grows with x, row with -y: what lay along +x lies along +y.
    let turned = ndarray::Array2::from_shape_fn((n, n), |(r, c)| map.heights[[c, n - 1 - r]]);
    let turned = HeightMap { heights: turned, ..map.clone() };
    let read = |map: &HeightMap, phi: f64| {
        traced_gloss(map, &three[2..], &Azimuths::At(vec![phi]), &options).unwrap().gloss[0]
    };
    let [one, other, across] = [read(&map, 0.4), read(&turned, 0.4 + TAU / 4.0), read(&turned, 0.4)];
    let error = |e: asperity::math::Estimate| e.standard_error;
    println!("{one:.3?} turned {other:.3?}, not turned {across:.3?}");
    // The same surface but for the diagonals of its cells and the facets that are asked; from another side it reads otherwise.
    assert!((one.value - other.value).abs() < 0.5 * error(one).hypot(error(other)), "{one:?} {other:?}");
    assert!((one.value - across.value).abs() > 2.0 * (one.value - other.value).abs(), "{one:?} {other:?} {across:?}");
}

#[test]
fn refuses_what_it_cannot_read() {
    let map = rough(0.1e-6, 1);
    let good = Geometry::gloss60();
    assert!(facet_gloss(&map, &GLASS, std::slice::from_ref(&good), &Azimuths::At(vec![])).is_err());
    let bad = Geometry { theta_i: 1.6, ..good.clone() };
    assert!(facet_gloss(&map, &GLASS, &[bad], &Azimuths::All).is_err());
    let empty = HeightMap { heights: map.heights.mapv(|_| f32::NAN), ..map };
    assert!(facet_gloss(&empty, &GLASS, &[good], &Azimuths::All).unwrap_err().to_string().contains("no facet"));
}
