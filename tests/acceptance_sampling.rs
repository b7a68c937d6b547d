//! What the sampler draws against what its pdf says, over ten million draws, in two partitions of the directions.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::frame::{phi, theta};
use asperity::math::random::CounterRng;
use asperity::math::statistics::chi_square_test;
use asperity::math::{direction, reflect};
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::scatter::cells::facing;
use asperity::scatter::{Method, Options, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

const DRAWS: u64 = 10_000_000;

/// On a node of the table, between two, on a node.
const THETA_I: [f64; 3] = [20.0, 47.0, 75.0];

fn table(map: &HeightMap, symmetry: Symmetry, material: Material) -> TableBrdf {
    // Visibility for every facet: an anisotropic table then has a node for every azimuth.
    let options = Options { method: Method::Facets, symmetry, material, ..Options::default() };
    let s = scatter(map, &options, &|_| ()).unwrap();
    TableBrdf::new(Table::from_scatter(&s, Provenance::default())).unwrap()
}

fn rough(pitch: [f64; 2], tilt: [f64; 2]) -> HeightMap {
    let grid = synth::Grid { width: 256, height: 192, pitch: [1e-6; 2] };
    let surface = synth::Gaussian { sq: 0.8e-6, acl: 8e-6, seed: 6, exact: false };
    let mut raw = synth::gaussian(grid, surface).unwrap();
    (raw.pitch_x, raw.pitch_y) = (pitch[0], pitch[1]);
    let plane = synth::ramp(synth::Grid { pitch, ..grid }, tilt).unwrap();
    raw.heights += &plane.heights;
    level::keep_tilt(&raw, Edges::Open)
}

fn isotropic() -> TableBrdf {
    table(&rough([1e-6; 2], [0.0; 2]), Symmetry::Isotropic, Material::Dielectric { n: 1.5 })
}

/// Stretched threefold along y and tilted, so that every frame error shows.
fn anisotropic() -> TableBrdf {
    table(&rough([1e-6, 3e-6], [0.04, -0.02]), Symmetry::Anisotropic, Material::Dielectric { n: 1.5 })
}

/// How many of the draws `place` puts into each of `bins` bins; the last counts those that carry nothing.
fn count(brdf: &TableBrdf, wi: DVec3, bins: usize, place: impl Fn(DVec3) -> usize + Sync) -> Vec<f64> {
    let streams = 64;
    let parts: Vec<Vec<u64>> = (0..streams)
        .into_par_iter()
        .map(|stream| {
            let mut rng = CounterRng::new(17, 3, stream);
            let mut counts = vec![0; bins + 1];
            for _ in 0..DRAWS / streams {
                match brdf.sample(wi, [rng.uniform(), rng.uniform()]) {
                    Some(s) => counts[place(s.wo)] += 1,
                    None => counts[bins] += 1,
                }
            }
            counts
        })
        .collect();
    (0..=bins).map(|k| parts.iter().map(|p| p[k] as f64).sum()).collect()
}

/// Expected draws of every bin, and of nothing in the last: 1 minus the integral of the pdf.
fn expectation(mut masses: Vec<f64>) -> Vec<f64> {
    let nothing = 1.0 - masses.iter().sum::<f64>();
    assert!(nothing > -2e-4, "the pdf integrates to more than 1: {}", 1.0 - nothing);
    masses.push(nothing.max(0.0));
    masses.iter().map(|m| m * DRAWS as f64).collect()
}

#[track_caller]
fn accept(counts: &[f64], expected: &[f64], what: &str) {
    let (chi2, dof, p) = chi_square_test(counts, expected, 20.0);
    println!("{what}: chi-square {chi2:.0} for {dof} degrees of freedom, p {p:.4}");
    assert!(dof > 50.0 && p > 1e-4, "{what}: chi-square {chi2} for {dof} degrees of freedom, p {p}");
}

/// Half-vector cells of the table. Within a cell the draw is uniform in slope, so the mass of a cell is its pdf times
/// `d omega = 4 cos_beta cos^3 theta_h dp dq` over the part that reflects above the horizon; many points find that part.
fn by_cells(brdf: &TableBrdf, wi: DVec3) -> (Vec<f64>, Vec<f64>) {
    let cells = brdf.table().cells();
    let turn = if brdf.table().is_isotropic() { phi(wi) } else { 0.0 };
    let turned = |v: DVec3, angle: f64| {
        let (s, c) = angle.sin_cos();
        DVec3::new(c * v.x - s * v.y, s * v.x + c * v.y, v.z)
    };
    let side = 24;
    let masses = (0..cells.len())
        .into_par_iter()
        .map(|k| {
            let part = |j: i32| (f64::from(j) + 0.5) / f64::from(side);
            let share = cells.area(k) / f64::from(side * side);
            let points = (0..side * side).map(|j| cells.slope_in(k, part(j % side), part(j / side)));
            points
                .filter_map(|(p, q)| {
                    let slope = turned(DVec3::new(p, q, 0.0), turn);
                    let f = facing(slope.x, slope.y, wi).filter(|f| f.wo.z > 0.0)?;
                    let ch = 1.0 / (1.0 + p * p + q * q).sqrt();
                    Some(brdf.pdf(wi, f.wo) * 4.0 * f.cos_beta * ch * ch * ch * share)
                })
                .sum()
        })
        .collect();
    let place = |wo: DVec3| cells.locate_pair(turned(wi, -turn), turned(wo, -turn));
    (count(brdf, wi, cells.len(), place), expectation(masses))
}

/// One degree of theta_r by three of phi_r, which know nothing of half vectors, cells or Jacobians. The pdf jumps at the
/// borders of the cells; a fine grid of midpoints makes up for it.
fn by_angles(brdf: &TableBrdf, wi: DVec3) -> (Vec<f64>, Vec<f64>) {
    let (rows, columns, side) = (90, 120, 48);
    let masses = (0..rows * columns)
        .into_par_iter()
        .map(|k| {
            let (row, column) = ((k / columns) as f64, (k % columns) as f64);
            let (t0, t1) = (row.to_radians().cos(), (row + 1.0).to_radians().cos());
            let solid_angle = (t0 - t1) * TAU / columns as f64;
            let mut sum = 0.0;
            for i in 0..side {
                // Even steps in cos(theta) are even in solid angle.
                let cos = t1 + (t0 - t1) * (i as f64 + 0.5) / side as f64;
                for j in 0..side {
                    let phi = TAU * (column + (j as f64 + 0.5) / side as f64) / columns as f64;
                    sum += brdf.pdf(wi, direction(cos.acos(), phi));
                }
            }
            sum * solid_angle / (side * side) as f64
        })
        .collect();
    let place = |wo: DVec3| {
        let row = (theta(wo).to_degrees() as usize).min(rows - 1);
        row * columns + ((phi(wo) / TAU * columns as f64) as usize).min(columns - 1)
    };
    (count(brdf, wi, rows * columns, place), expectation(masses))
}

#[test]
fn ten_million_draws_follow_the_pdf() {
    for (name, brdf, phi_i) in [("isotropic", isotropic(), 130.0f64), ("anisotropic", anisotropic(), 25.0)] {
        for theta_i in THETA_I {
            let wi = direction(theta_i.to_radians(), phi_i.to_radians());
            let (counts, expected) = by_cells(&brdf, wi);
            accept(&counts, &expected, &format!("{name}, {theta_i} deg, half-vector cells"));
            let (counts, expected) = by_angles(&brdf, wi);
            accept(&counts, &expected, &format!("{name}, {theta_i} deg, angles"));
        }
    }
}

/// The control: draws for a source half a degree away must not pass.
#[test]
fn a_wrong_direction_is_noticed() {
    let brdf = isotropic();
    let wi = direction(0.5, 1.0);
    let (_, expected) = by_angles(&brdf, wi);
    let (counts, _) = by_angles(&brdf, direction(0.5 + 0.5f64.to_radians(), 1.0));
    assert!(chi_square_test(&counts, &expected, 20.0).2 < 1e-6);
}

/// Every node's alias columns add up to the probabilities, and these to the energy that the node reflects.
#[test]
fn alias_mass_is_that_of_the_table() {
    for brdf in [isotropic(), anisotropic()] {
        let table = brdf.table();
        let phis = table.phi_i().len();
        for node in 0..table.theta_i().len() * phis {
            let alias = brdf.alias(node).expect("a rough surface has a lobe at every node");
            let columns = alias.reconstruct();
            assert_eq!(columns.len(), table.cells().len());
            for (k, p) in columns.iter().enumerate() {
                assert!((p - alias.probability(k)).abs() < 1e-12, "node {node}, cell {k}");
            }
            assert!((columns.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Cells below the horizon keep a thousandth of their density as weight, for directions between the nodes.
            let albedo = table.node(node / phis, node % phis).albedo;
            let surplus = alias.total() / albedo - 1.0;
            assert!((-1e-9..2e-3).contains(&surplus), "node {node}: {} {albedo}", alias.total());
        }
    }
}

/// A flat map of which one cell in a hundred is steep. Without tilt the flat part is the specular core; with a tilt it is
/// one hot cell at its own slope. Either way most cells are empty.
fn near_mirror(tilt: f64) -> TableBrdf {
    let grid = synth::Grid { width: 201, height: 201, pitch: [1e-6; 2] };
    let mut raw = synth::ramp(grid, [tilt, 0.0]).unwrap();
    let mut rng = CounterRng::new(4, 0, 0);
    for r in (5..200).step_by(20) {
        for c in (5..200).step_by(20) {
            // A bump of one vertex tilts six facets; a hundred bumps are 0.75 % of the 80 000 facets.
            raw.heights[[r, c]] += 1e-7 * (1.0 + 3.0 * rng.uniform());
        }
    }
    table(&level::keep_tilt(&raw, Edges::Open), Symmetry::Anisotropic, Material::Mirror)
}

#[test]
fn a_near_mirror_never_draws_an_empty_cell() {
    for tilt in [0.0, 0.003] {
        let brdf = near_mirror(tilt);
        let cells = brdf.table().cells();
        let filled = (0..cells.len()).filter(|&k| brdf.alias(0).unwrap().probability(k) > 0.0).count();
        assert!(4 * filled < cells.len(), "{filled} of {} cells", cells.len());
        let mirror = |wi: DVec3| reflect(wi, asperity::math::frame::normal_of_slope(tilt, 0.0));
        for theta_i in [0.0, 20.0, 47.0, 60.0] {
            let wi = direction(f64::to_radians(theta_i), 0.7);
            let mut rng = CounterRng::new(9, 0, 0);
            let draws = 1_000_000;
            let (mut hot, mut dark) = (0, 0);
            for _ in 0..draws {
                let Some(s) = brdf.sample(wi, [rng.uniform(), rng.uniform()]) else { continue };
                assert!(s.weight.is_finite() && s.weight >= 0.0);
                hot += i32::from((s.wo - mirror(wi)).length() < 1e-3);
                if !s.specular {
                    dark += i32::from(brdf.eval(wi, s.wo) == 0.0);
                    assert!(s.pdf > 0.0 && brdf.pdf(wi, s.wo) > 0.0);
                }
            }
            println!("tilt {tilt}, {theta_i} deg: {hot} of {draws} along the mirror, {dark} in the dark");
            assert_eq!(dark, 0);
            // Facets of weight 1 along the mirror: 99.25 %, less what the steep ones hide.
            assert!((f64::from(hot) / f64::from(draws) - 0.9925).abs() < 0.01, "{hot}");
        }
    }
}
