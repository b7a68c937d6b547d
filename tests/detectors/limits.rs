//! Where counting fails it says so: no number is NaN, every book closes, a warning is raised.

use super::gaussian;
use asperity::heightmap::sampling::Sampling;
use asperity::heightmap::{Edges, HeightMap};
use asperity::math::random::CounterRng;
use asperity::optics::Material;
use asperity::report::{Settings, predict};
use asperity::scatter::{Counting, Method, Options, Partition, Run, count};
use ndarray::Array2;

fn map(heights: Array2<f32>, edges: Edges) -> HeightMap {
    HeightMap { heights, pitch_x: 1e-6, pitch_y: 1.5e-6, edges, removed_slopes: [0.0; 2] }
}

/// A gentle surface, Sq about 0.4 um at 1 um.
fn gentle(size: usize, edges: Edges) -> HeightMap {
    let unit = gaussian(size, 8.0, 0.05, 9);
    map(unit.heights.mapv(|h| h * 1e-6), edges)
}

/// Counts by facets, by rays and by waves into two partitions and predicts table and gloss: all finite, all books closed. Returns every
/// warning on the way.
fn warnings(map: &HeightMap, theta_i: f64) -> Vec<String> {
    let mut said: Vec<String> = Sampling::examine(map).warnings.iter().map(ToString::to_string).collect();
    for material in [Material::Mirror, Material::Dielectric { n: 1.5 }] {
        for method in [Method::Facets, Method::Rays, Method::Kirchhoff] {
            let options = Options {
                method,
                material,
                theta_i: vec![theta_i.to_radians()],
                phi_i: vec![0.3],
                rays: 20_000,
                ..Options::default()
            };
            for partition in [Partition::Klems, Partition::HalfVector] {
                for averaged in [false, true] {
                    let counting = Counting { partition, averaged };
                    let counts = count(map, &options, &counting, &mut Run::Whole, &|_| ()).unwrap();
                    let d = &counts.directions[0];
                    let what = format!("{method:?} {material} {partition:?} averaged {averaged}");
                    for k in 0..counts.detectors.len() {
                        let f = d.f_r(k);
                        assert!(f.value.is_finite() && f.value >= 0.0, "{what}: detector {k} has {f:?}");
                        assert!(f.standard_error.is_finite(), "{what}: detector {k} has {f:?}");
                    }
                    let book = d.tally.book();
                    let sum = book.escaped + book.absorbed + book.lost;
                    assert!((sum - 1.0).abs() < 1e-12, "{what}: {book:?}");
                    let bounces: f64 = d.tally.bounce_fractions().iter().sum();
                    assert!((bounces - book.escaped).abs() < 1e-12, "{what}: {bounces} {book:?}");
                    said.extend(counts.warnings.iter().map(ToString::to_string));
                }
            }
        }
    }
    let scatter = Options { theta_i: [0.0, theta_i].map(f64::to_radians).to_vec(), ..Options::default() };
    let prediction = predict(map, "limit", &Settings { scatter, ..Settings::default() }, &|_| ()).unwrap();
    for gloss in prediction.gloss {
        assert!(gloss.value.is_finite() && gloss.standard_error.is_finite(), "{gloss:?}");
    }
    let table = prediction.brdf.table();
    for t in 0..table.theta_i().len() {
        let node = table.node(t, 0);
        assert!((node.albedo + node.absorbed + node.lost - 1.0).abs() < 1e-9, "{node:?}");
    }
    said.extend(prediction.warnings.iter().map(ToString::to_string));
    said.sort();
    said.dedup();
    said
}

#[track_caller]
fn says(said: &[String], words: &[&str]) {
    assert!(said.iter().any(|w| words.iter().all(|word| w.contains(word))), "{words:?} not in {said:#?}");
}

#[test]
fn grazing_light() {
    for edges in [Edges::Open, Edges::Mirrored, Edges::Periodic] {
        let said = warnings(&gentle(128, edges), 89.9);
        says(&said, &["At 89.9 deg", "lies in the shadow", "another spot"]);
        if edges == Edges::Open {
            says(&said, &["At 89.9 deg", "nothing beyond its border", "--edges mirrored"]);
        }
    }
}

#[test]
fn vertical_walls() {
    // Steps of 100 um from one point to the next.
    let heights = Array2::from_shape_fn((60, 60), |(r, c)| if (r / 20 + c / 20) % 2 == 0 { 1e-4 } else { 0.0 });
    for edges in [Edges::Open, Edges::Mirrored] {
        let said = warnings(&map(heights.clone(), edges), 45.0);
        says(&said, &["are steeper than 84.3 deg", "slopes up to 1", "--region"]);
    }
}

#[test]
fn a_single_spike() {
    let mut surface = gentle(128, Edges::Periodic);
    surface.heights[[40, 77]] += 2e-5;
    let said = warnings(&surface, 60.0);
    says(&said, &["1 single point stands", "--despike"]);
    says(&said, &["are steeper than 84.3 deg"]);
}

#[test]
fn forty_per_cent_missing() {
    let mut surface = gentle(128, Edges::Open);
    let mut rng = CounterRng::new(5, 0, 0);
    surface.heights.mapv_inplace(|h| if rng.uniform() < 0.4 { f32::NAN } else { h });
    let said = warnings(&surface, 60.0);
    says(&said, &["% of the points are missing", "steep facets first"]);
}

#[test]
fn one_valid_facet() {
    let mut heights = Array2::from_elem((9, 12), f32::NAN);
    for (place, h) in [([4, 5], 0.0), ([4, 6], 1e-7), ([5, 6], 3e-8)] {
        heights[place] = h;
    }
    for edges in [Edges::Open, Edges::Mirrored, Edges::Periodic] {
        let said = warnings(&map(heights.clone(), edges), 30.0);
        says(&said, &["only 1 beam met the surface", "single glints"]);
        says(&said, &["% of the points are missing"]);
    }
}

#[test]
fn heights_in_steps() {
    let mut surface = gentle(128, Edges::Periodic);
    surface.heights.mapv_inplace(|h| (h / 1e-7).round() * 1e-7);
    let said = warnings(&surface, 60.0);
    says(&said, &["The heights come in steps of 100 nm", "glints"]);
}

#[test]
fn smoother_than_the_wavelength() {
    let mut surface = gentle(128, Edges::Periodic);
    // Sq of 4 nm at 550 nm.
    surface.heights.mapv_inplace(|h| h * 0.01);
    let said = warnings(&surface, 60.0);
    says(&said, &["Rayleigh parameter", "wave"]);
}
