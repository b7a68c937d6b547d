//! The facet sum side by side against the same sum one facet at a time in f64, and against closed forms.

use asperity::facets::slopes;
use asperity::facets::visibility::Fate;
use asperity::facets::{HeightField, SlopeStatistics};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::{direction, random::CounterRng};
use asperity::optics::Material;
use asperity::scatter::accumulator::Accumulator;
use asperity::scatter::bounce::{Arrival, Walk};
use asperity::scatter::detectors::{Detectors, Rings};
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::facing::facing;
use asperity::scatter::rays::trace_rays;
use asperity::scatter::selection::{Part, Selection};
use asperity::scatter::slope_histogram::SlopeDensity;
use asperity::scatter::{HalfVectorCells, Tally};
use ndarray::Array2;

const GLASS: Material = Material::Dielectric { n: 1.5 };

fn gaussian(alpha: f64, edges: Edges) -> HeightMap {
    let grid = synth::Grid { width: 200, height: 150, pitch: [0.5e-6, 0.7e-6] };
    let surface = synth::Gaussian { sq: alpha * 3e-6, acl: 6e-6, seed: 3, exact: true };
    HeightMap { edges, ..level::keep_tilt(&synth::gaussian(grid, surface).unwrap(), Edges::Periodic) }
}

/// A map whose height depends on the column alone.
fn profile(width: usize, edges: Edges, pitch: f64, height: impl Fn(usize) -> f64) -> HeightMap {
    let heights = Array2::from_shape_fn((16, width), |(_, c)| height(c) as f32);
    HeightMap { heights, pitch_x: pitch, pitch_y: 1.3 * pitch, edges, removed_slopes: [0.0; 2] }
}

struct Scene<'a> {
    walk: Walk<'a>,
    cells: HalfVectorCells,
    facets: f64,
}

fn scene<'a>(field: &'a HeightField<'a>, material: Material) -> Scene<'a> {
    let statistics = SlopeStatistics::measure(field.map()).unwrap();
    let cells = HalfVectorCells::for_lobe(&statistics, false, 0.01);
    let walk = Walk { field, material, max_bounces: 8, steepest: statistics.steepest };
    Scene { walk, cells, facets: statistics.facets as f64 }
}

/// The facet sum as its formula says it.
fn one_by_one<D: Detectors>(walk: &Walk, detectors: &D, theta_i: f64, phi: f64) -> Tally {
    let map = walk.field.map();
    let wi = direction(theta_i, phi);
    let mut sum = Accumulator::new(detectors.len());
    for row in 0..slopes::cells(map).1 {
        slopes::visit_row(map, row, |f| {
            let cell = detectors.slope_cells().map(|cells| cells.locate(f.p, f.q));
            if let Some(cell) = cell {
                sum.asked(cell, 1);
            }
            let Some(beam) = facing(f.p, f.q, wi) else { return };
            let [a, b, c, d] = walk.field.corners(f.column, f.row).map(f64::from);
            let (place, third) = if f.upper { ([2.0 / 3.0, 1.0 / 3.0], b) } else { ([1.0 / 3.0, 2.0 / 3.0], c) };
            let arrival = Arrival {
                point: [f.column as f64 + place[0], f.row as f64 + place[1], (a + d + third) / 3.0],
                facet: ([f.column, f.row], f.upper),
                slope: (f.p, f.q),
                back: wi,
                flip: [1.0; 2],
            };
            if let Fate::Hit(_) = walk.onward(&arrival, wi) {
                sum.shadowed(beam.weight);
                return;
            }
            let end = walk.follow(arrival);
            match (end.escaped, cell) {
                (None, _) => sum.lost(beam.weight, end.lost),
                (Some((_, energy)), Some(cell)) if end.bounces == 1 => sum.escaped(cell, 1, beam.weight, energy),
                (Some((wo, energy)), _) => sum.escaped(detectors.index(wi, wo), end.bounces, beam.weight, energy),
            }
        });
    }
    sum.tally()
}

fn assert_same(fast: &Tally, slow: &Tally, what: &str) {
    let close = |a: f64, b: f64| (a - b).abs() <= 2e-6 * slow.incident;
    for (a, b) in [
        (fast.incident, slow.incident),
        (fast.absorbed, slow.absorbed),
        (fast.lost, slow.lost),
        (fast.multiple, slow.multiple),
        (fast.shadowed * fast.incident, slow.shadowed * slow.incident),
    ] {
        assert!(close(a, b), "{what}: {a} {b}");
    }
    // A slope within rounding of a border may be counted on the other side of it: a few facets of all.
    let moved: f64 = fast.energy.iter().zip(&slow.energy).map(|(a, b)| (a - b).abs()).sum();
    let all: f64 = slow.energy.iter().sum();
    let equal = fast.energy.iter().zip(&slow.energy).filter(|(a, b)| (*a - *b).abs() <= 1e-5 * b.abs() + 1e-7).count();
    assert!(moved <= 2e-4 * all && equal + 20 >= fast.energy.len(), "{what}: {moved} of {all}, {equal} equal");
    let moved: u64 = fast.asked.iter().zip(&slow.asked).map(|(a, b)| a.abs_diff(*b)).sum();
    assert!(moved <= 20, "{what}: {moved}");
}

#[test]
fn side_by_side_equals_one_by_one() {
    let mut seen = [0.0f64; 2];
    for edges in [Edges::Open, Edges::Periodic, Edges::Mirrored] {
        for gaps in [false, true] {
            let mut map = gaussian(0.3, edges);
            if gaps {
                let mut rng = CounterRng::new(8, 0, 0);
                map.heights.iter_mut().for_each(|h| *h = if rng.uniform() < 0.01 { f32::NAN } else { *h });
            }
            let field = HeightField::new(&map);
            for material in [GLASS, Material::Mirror, Material::Conductor { n: 1.0, k: 6.6 }] {
                let Scene { walk, cells, .. } = scene(&field, material);
                for (degrees, phi) in [(0.0, 0.0), (45.0, 0.0), (60.0, 2.5), (75.0, 0.6), (86.0, 4.0), (89.9, 1.0f64)] {
                    let what = format!("{edges:?} {gaps} {material} {degrees} {phi}");
                    let theta_i = f64::to_radians(degrees);
                    let azimuth = Azimuth::Fixed(phi);
                    let fast = facet_sum(&walk, &cells, theta_i, azimuth, &Selection::default()).tally();
                    assert_same(&fast, &one_by_one(&walk, &cells, theta_i, phi), &what);
                    seen = [seen[0].max(fast.shadowed), seen[1].max(fast.multiple / fast.incident)];
                    if material == GLASS {
                        let klems = Rings::klems();
                        let fast = facet_sum(&walk, &klems, theta_i, azimuth, &Selection::default()).tally();
                        assert_same(&fast, &one_by_one(&walk, &klems, theta_i, phi), &what);
                    }
                }
            }
        }
    }
    assert!(seen[0] > 0.3 && seen[1] > 0.05, "nothing hidden was tested: {seen:?}");
}

#[test]
fn threads_and_parts_give_the_same_bits() {
    let map = gaussian(0.4, Edges::Periodic);
    let field = HeightField::new(&map);
    let Scene { walk, cells, .. } = scene(&field, GLASS);
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    for azimuth in [Azimuth::Fixed(0.4), Azimuth::Averaged] {
        let facets = |part: Part| facet_sum(&walk, &cells, 1.2, azimuth, &Selection { part, ..Selection::default() });
        let rays = |part: Part| {
            trace_rays(&walk, &cells, 1.2, azimuth, 100_000, 1, &Selection { part, ..Selection::default() })
        };
        for run in [&facets as &(dyn Fn(Part) -> Accumulator + Sync), &rays] {
            let whole = pool(1).install(|| run(Part::default()));
            assert_eq!(pool(3).install(|| run(Part::default())), whole);
            let parts = (1..=4).rev().map(|k| run(Part::new(k, 4).unwrap()));
            assert_eq!(parts.reduce(Accumulator::merged).unwrap(), whole);
        }
    }
}

/// Averaging over azimuth is even: the mean of many fixed azimuths.
#[test]
fn averaged_azimuths_are_the_mean_of_fixed_ones() {
    let map = gaussian(0.3, Edges::Periodic);
    let field = HeightField::new(&map);
    let Scene { walk, cells, .. } = scene(&field, Material::Mirror);
    let theta_i = 75f64.to_radians();
    let run = |azimuth| facet_sum(&walk, &cells, theta_i, azimuth, &Selection::default()).tally();
    let averaged = run(Azimuth::Averaged);
    let fixed: Vec<Tally> = (0..24).map(|k| run(Azimuth::Fixed(f64::from(k) * std::f64::consts::TAU / 24.0))).collect();
    for share in [|t: &Tally| t.multiple / t.incident, |t: &Tally| t.shadowed] {
        let values: Vec<f64> = fixed.iter().map(share).collect();
        let mean = values.iter().sum::<f64>() / 24.0;
        let spread = values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        assert!((share(&averaged) - mean).abs() < 0.5 * spread, "{} {mean} {spread}", share(&averaged));
    }
}

/// TV43: weights (1 -+ m tan theta_i) / 2 at 41.421 and 18.579 deg for slopes +-0.1 and 30 deg.
#[test]
fn sawtooth() {
    let map = profile(64, Edges::Periodic, 1e-6, |c| 1e-7 * (c % 2) as f64);
    let field = HeightField::new(&map);
    let walk = scene(&field, Material::Mirror).walk;
    let theta_i = 30f64.to_radians();
    let detectors = Rings::equal_angle(0.5f64.to_radians(), 1f64.to_radians()).unwrap();
    for (phi, turn) in [(0.0, 0.0), (std::f64::consts::PI, std::f64::consts::PI)] {
        let tally = facet_sum(&walk, &detectors, theta_i, Azimuth::Fixed(phi), &Selection::default()).tally();
        for (weight, degrees) in [(0.4711324865, 41.4211862750), (0.5288675135, 18.5788137250f64)] {
            let detector =
                detectors.index(direction(theta_i, phi), direction(degrees.to_radians(), std::f64::consts::PI + turn));
            assert!((tally.energy[detector] / tally.incident - weight).abs() < 1e-6, "{degrees}: {tally:?}");
        }
    }
}

/// Grooves of 90 deg send light back where it came from after two bounces.
#[test]
fn right_angled_grooves_reflect_back() {
    let map = profile(128, Edges::Periodic, 1e-6, |c| 1e-6 * (c % 64).min(64 - c % 64) as f64);
    let field = HeightField::new(&map);
    let Scene { walk, cells, .. } = scene(&field, Material::Mirror);
    for degrees in [0.0, 5.0, 20.0, 40.0f64] {
        let wi = direction(degrees.to_radians(), 0.0);
        let home = cells.locate_pair(wi, wi);
        let tally = facet_sum(&walk, &cells, degrees.to_radians(), Azimuth::Fixed(0.0), &Selection::default()).tally();
        let back = tally.by_bounce[home][1];
        assert!(
            (back - tally.bounces[1]).abs() < 1e-9 * tally.incident && tally.bounces[2] == 0.0,
            "{degrees}: {tally:?}"
        );
        // Light at theta_i misses the second wall from a part tan(theta_i) of the lit one.
        let expected = 1.0 - degrees.to_radians().tan();
        assert!((back / tally.incident - expected).abs() < 0.03, "{degrees}: {} {expected}", back / tally.incident);
    }
}

/// TV44: on a periodic map the facets' projected areas sum to the mean plane's while none faces away. TV45: clamped at
/// zero they exceed it by Smith's Lambda, for alpha .495 by .0125 at 60 deg and .3903 at 80 deg.
#[test]
fn projected_areas_sum_to_one_plus_lambda() {
    let map = gaussian(0.1, Edges::Periodic);
    let field = HeightField::new(&map);
    let Scene { walk, cells, facets } = scene(&field, GLASS);
    let tally = facet_sum(&walk, &cells, 45f64.to_radians(), Azimuth::Fixed(1.0), &Selection::default()).tally();
    assert!((tally.incident / facets - 1.0).abs() < 1e-6 && tally.shadowed == 0.0);

    let grid = synth::Grid { width: 1024, height: 1024, pitch: [0.5e-6; 2] };
    let surface = synth::Gaussian { sq: 1.485e-6, acl: 6e-6, seed: 5, exact: true };
    let raw = synth::gaussian(grid, surface).unwrap();
    let mut map = level::keep_tilt(&raw, Edges::Periodic);
    let scale = (0.495 / SlopeStatistics::measure(&map).unwrap().sdq) as f32;
    map.heights.iter_mut().for_each(|h| *h *= scale);
    let field = HeightField::new(&map);
    let Scene { walk, cells, facets } = scene(&field, GLASS);
    for (degrees, expected, tolerance) in [(60.0, 1.0125, 0.002), (80.0, 1.3903, 0.01f64)] {
        let theta_i = f64::to_radians(degrees);
        let tally = facet_sum(&walk, &cells, theta_i, Azimuth::Fixed(0.0), &Selection::default()).tally();
        let facing = tally.incident * (1.0 + tally.shadowed) / facets;
        assert!((facing - expected).abs() < tolerance, "{degrees}: {facing}");
        // What is counted twice is what is hidden.
        assert!((tally.incident / facets - 1.0).abs() < 0.01, "{degrees}: lit {}", tally.incident / facets);
    }
}

/// A sphere of radius R has the slope density R^2 / (1 + p^2 + q^2)^2 per unit of plan area.
#[test]
fn slopes_of_a_sphere() {
    let (side, radius) = (1201, 1000.0f64);
    let middle = (side - 1) as f64 / 2.0;
    let heights = Array2::from_shape_fn((side, side), |(r, c)| {
        let (x, y) = (c as f64 - middle, r as f64 - middle);
        ((radius * radius - x * x - y * y).sqrt() - radius) as f32
    });
    let map = HeightMap { heights, pitch_x: 1.0, pitch_y: 1.0, edges: Edges::Open, removed_slopes: [0.0; 2] };
    let cells = HalfVectorCells::new([0.0; 2], [0.3; 2], 0.0, 0.05);
    let area = (2.0 * middle).powi(2);
    // Cells: sides are 150 facets long and parallel to the rows, so along each axis one line of facets more or less may count.
    // Rings: even out the density across a third of a cell, and at either end of a cell one is covered in part, which misses
    // w |P'| / 24 of P at most; here w = 0.05 and |P'| < 1.7 P. Facets along a circle are counted better than 0.15 %.
    for (isotropic, tolerance) in [(false, 2.0 / 150.0), (true, 0.05 * 1.7 / 24.0 + 0.0015)] {
        let density = SlopeDensity::measure(&map, &cells, isotropic).density;
        let mut checked = 0;
        for (cell, &found) in density.iter().enumerate() {
            let points = cells.points(cell);
            // Inside the circle of slopes that the square map holds whole.
            if points.iter().all(|x| x.p.hypot(x.q) < 0.55) {
                let weight: f64 = points.iter().map(|x| x.area).sum();
                let square = |x: f64| x * x;
                let value = |p: f64, q: f64| radius * radius / square(1.0 + p * p + q * q) / area;
                let expected = points.iter().map(|x| x.area * value(x.p, x.q)).sum::<f64>() / weight;
                assert!((found / expected - 1.0).abs() < tolerance, "{isotropic} cell {cell}: {found} {expected}");
                checked += 1;
            }
        }
        assert!(checked > 20, "{checked}");
    }
}
