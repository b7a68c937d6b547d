//! What a table of a known lobe gives back: values, gloss, energy, place between nodes; and what it costs.

use asperity::facets::SlopeStatistics;
use asperity::heightmap::{Edges, HeightMap, level, read, synth};
use asperity::math::direction;
use asperity::math::frame::DVec3;
use asperity::meter::{self, Azimuths, Geometry, facet_gloss, gloss};
use asperity::model;
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::sample::audit::{self, audit};
use asperity::scatter::facing::facing;
use asperity::scatter::slope_histogram::SlopeDensity;
use asperity::scatter::{HalfVectorCells, Method, Options, Scatter, Symmetry, Tally, scatter};
use asperity::table::{Provenance, Table};
use std::path::Path;

fn gaussian(alpha: f64, size: usize) -> HeightMap {
    let grid = synth::Grid { width: size, height: size, pitch: [1e-6; 2] };
    let surface = synth::Gaussian { sq: alpha * 10e-6 / 2.0, acl: 10e-6, seed: 7, exact: true };
    level::keep_tilt(&synth::gaussian(grid, surface).unwrap(), Edges::Periodic)
}

/// `Lambda` of a Beckmann surface (physics of Smith 1967; Heitz 2014, equation 73).
fn lambda(alpha: f64, cos: f64) -> f64 {
    let v = cos / (1.0 - cos * cos).max(1e-300).sqrt() / alpha;
    0.5 * (libm::erf(v) - 1.0) + (-v * v).exp() / (2.0 * v * std::f64::consts::PI.sqrt())
}

/// The Beckmann formula as an instrument without noise would count it into cells.
fn by_formula(alpha: f64, material: Material, theta_i: &[f64], tolerance: f64) -> Table {
    let mut statistics = SlopeStatistics::measure(&gaussian(alpha, 256)).unwrap();
    statistics.sdq = alpha;
    statistics.core = 1.0;
    // A formula is a map of very many facets: nothing in it is low by chance.
    statistics.facets = 1 << 40;
    let cells = HalfVectorCells::for_lobe(&statistics, true, tolerance);
    let p22 = |p: f64, q: f64| (-(p * p + q * q) / (alpha * alpha)).exp() / (std::f64::consts::PI * alpha * alpha);
    let side = 6;
    let part = |k: usize| (k as f64 + 0.5) / side as f64;
    let tally = |theta: f64| {
        let wi = direction(theta, 0.0);
        let mut tally = Tally::new(cells.len());
        tally.incident = 1.0;
        for cell in 0..cells.len() {
            for k in 0..side * side {
                let (p, q) = cells.slope_in(cell, part(k % side), part(k / side));
                // Ten standard deviations out there is nothing to add up.
                if p22(p, q) * alpha * alpha < 1e-20 {
                    continue;
                }
                let Some(f) = facing(p, q, wi).filter(|f| f.wo.z > 0.0) else { continue };
                let g = 1.0 / (1.0 + lambda(alpha, wi.z) + lambda(alpha, f.wo.z));
                let area = cells.area(cell) / (side * side) as f64;
                tally.energy[cell] += p22(p, q) * area * f.weight * g * material.reflectance(f.cos_beta);
            }
        }
        tally.lost = 1.0 - tally.energy.iter().sum::<f64>();
        tally
    };
    let density = (0..cells.len()).map(|k| cells.points(k).iter().map(|x| p22(x.p, x.q)).sum::<f64>() / 4.0).collect();
    let scattered = Scatter {
        isotropic: true,
        material,
        method: Method::Geometric,
        theta_i: theta_i.to_vec(),
        phi_i: vec![0.0],
        tallies: theta_i.iter().map(|&t| vec![tally(t)]).collect(),
        density: SlopeDensity { density, core: 0.0, subareas: Vec::new() },
        statistics,
        decisions: Vec::new(),
        wave: None,
        core_error: Vec::new(),
        cells,
    };
    Table::from_scatter(&scattered, Provenance::default())
}

/// `integral of |f - g| cos dw / integral of g cos dw`, by draws of `g`.
fn mean_difference(f: &dyn Brdf, g: &dyn Brdf, theta_i: f64) -> f64 {
    let wi = direction(theta_i, 0.3);
    let n = 20_000;
    let (mut difference, mut sum) = (0.0, 0.0);
    for k in 0..n {
        let u = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|a| (0.5 + a * f64::from(k)).fract());
        if let Some(s) = g.sample(wi, u) {
            difference += (f.eval(wi, s.wo) - g.eval(wi, s.wo)).abs() * s.wo.z / s.pdf;
            sum += s.weight;
        }
    }
    difference / sum
}

/// Evaluation error and gloss against table size, over two decades of roughness. The error is below
/// the tolerance at every angle, gloss within 0.2 GU; a finer table is nearer.
#[test]
fn a_beckmann_lobe_keeps_its_values_and_its_gloss() {
    let theta_i = Options::default().theta_i;
    println!("alpha   tolerance  cells x angles   L1 20 / 47 / 70 deg             gloss error 20 / 60 / 85 deg, GU");
    for alpha in [0.003, 0.01, 0.03, 0.1, 0.3, 0.5] {
        let formula = model::parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).unwrap();
        let mut before = f64::INFINITY;
        for tolerance in [0.04, 0.01, 0.0025] {
            let table = by_formula(alpha, Material::Dielectric { n: 1.5 }, &theta_i, tolerance);
            let size = format!("{} x {}", table.cells().len(), table.theta_i().len());
            let brdf = TableBrdf::new(table).unwrap();
            let l1 = [20.0f64, 47.0, 70.0].map(|t| mean_difference(&brdf, formula.as_ref(), t.to_radians()));
            let options = meter::Options::default();
            let errors = Geometry::standard_three()
                .map(|g| gloss(&brdf, &g, &options).value - gloss(formula.as_ref(), &g, &options).value);
            println!(
                "{alpha:<6}  {tolerance:<9}  {size:<15}  {:.4} {:.4} {:.4}            {:+.3} {:+.3} {:+.3}",
                l1[0], l1[1], l1[2], errors[0], errors[1], errors[2]
            );
            assert!(l1.iter().all(|e| *e < tolerance), "alpha {alpha}, tolerance {tolerance}: {l1:?}");
            if tolerance <= 0.01 {
                assert!(errors.iter().all(|e| e.abs() < 0.2), "alpha {alpha}, tolerance {tolerance}: {errors:?}");
            }
            assert!(l1[0] < before, "alpha {alpha}: a finer table is nearer");
            before = l1[0];
        }
    }
}

/// Whose word is taken on what a table's facets hide.
#[derive(Clone, Copy, PartialEq)]
enum Sight {
    /// Each facet is asked where it matters.
    Default,
    /// Smith's function everywhere, as the gloss of the facets has it.
    Smith,
}

fn table_gloss(map: &HeightMap, symmetry: Symmetry, sight: Sight) -> ([f64; 3], bool, usize) {
    // The facets tell of single reflections only; at 85 deg second ones bring a rough map some units more.
    let options = Options { method: Method::Geometric, symmetry, bounces: 1, ..Options::default() };
    let mut scattered = scatter(map, &options, &|_| ()).unwrap();
    if sight == Sight::Smith {
        let hiding = scattered.statistics.hiding();
        for (&theta, row) in scattered.theta_i.iter().zip(&mut scattered.tallies) {
            for (&phi, tally) in scattered.phi_i.iter().zip(row) {
                *tally = scattered.density.tally(&scattered.cells, direction(theta, phi), &options.material, &hiding);
            }
        }
    }
    let isotropic = scattered.isotropic;
    let brdf = TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).unwrap();
    let azimuths = if isotropic { vec![0.0] } else { vec![0.0, 0.7, 1.5, 2.3] };
    let reading = meter::Options::default().with_azimuths(azimuths);
    (Geometry::standard_three().map(|g| gloss(&brdf, &g, &reading).value), isotropic, brdf.table().cells().len())
}

/// Gloss of the table less that of the facets at 20, 60, 85 deg, which must be below 0.2 GU.
fn same_gloss(name: &str, map: &HeightMap, symmetry: Symmetry, sight: Sight) {
    let (by_table, isotropic, cells) = table_gloss(map, symmetry, sight);
    let azimuths = if isotropic { Azimuths::All } else { Azimuths::At(vec![0.0, 0.7, 1.5, 2.3]) };
    let glass = Material::Dielectric { n: 1.5 };
    let by_facets = facet_gloss(map, &glass, &Geometry::standard_three(), &azimuths).unwrap();
    for (k, facets) in by_facets.gloss.iter().enumerate() {
        let difference = by_table[k] - facets.value;
        println!(
            "{name} ({cells} cells): {} deg: table {:.3}, facets {:.3} +- {:.3}, difference {difference:+.3}",
            [20, 60, 85][k],
            by_table[k],
            facets.value,
            facets.standard_error
        );
        assert!(difference.abs() < 0.2, "{name}: {difference}");
    }
}

#[test]
fn gloss_of_a_synthesised_map_is_that_of_its_facets() {
    for alpha in [0.003, 0.01, 0.03] {
        same_gloss(&format!("alpha {alpha}"), &gaussian(alpha, 512), Symmetry::Isotropic, Sight::Default);
    }
}

/// From alpha 0.1 on, facets hide one another at 85 deg otherwise than Smith's function says, by a quarter of a gloss unit: with the same
/// word on what is hidden, table and facets say the same.
#[test]
fn gloss_of_a_rough_map_is_that_of_its_facets_under_the_same_masking() {
    for alpha in [0.1, 0.3] {
        same_gloss(&format!("alpha {alpha}, Smith"), &gaussian(alpha, 512), Symmetry::Isotropic, Sight::Smith);
    }
    let map = gaussian(0.1, 512);
    let [traced, smith] =
        [Sight::Default, Sight::Smith].map(|sight| table_gloss(&map, Symmetry::Isotropic, sight).0[2]);
    println!("alpha 0.1 at 85 deg: facets asked one by one {traced:.3}, Smith {smith:.3}");
    assert!((traced - smith).abs() > 0.1);
}

#[test]
fn gloss_of_every_bundled_map_is_that_of_its_facets() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("heightmaps");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "x3p") {
            let raw = read::read(&path, &read::ReadOptions::default()).unwrap();
            let map = level::level(&raw, Edges::Open).unwrap();
            same_gloss(&path.file_stem().unwrap().to_string_lossy(), &map, Symmetry::Auto, Sight::Default);
            seen += 1;
        }
    }
    assert!(seen >= 7, "{seen}");
}

/// Table size against error: as many incident angles as the tolerance asks for, and no more. Between them the formula is
/// met to the tolerance.
#[test]
fn tolerance_chooses_the_incident_angles() {
    let theta_i = Options::default().theta_i;
    println!("alpha   tolerance  cells  angles  bytes     L1 20 / 45 / 78 / 84.5 deg");
    for alpha in [0.003, 0.03, 0.1, 0.3, 0.5] {
        let formula = model::parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).unwrap();
        for tolerance in [0.04, 0.01] {
            let table = by_formula(alpha, Material::Dielectric { n: 1.5 }, &theta_i, tolerance);
            let kept = table.needed_theta_i(0.5 * tolerance);
            let small = table.at_nodes(&kept, &[0]);
            assert_eq!(small.needed_theta_i(0.0).len(), kept.len());
            assert!(kept.len() < theta_i.len(), "alpha {alpha}: {kept:?}");
            let bytes = small.cells().len() * kept.len() * 8;
            let brdf = TableBrdf::new(small).unwrap();
            let l1 = [20.0f64, 45.0, 78.0, 84.5].map(|t| mean_difference(&brdf, formula.as_ref(), t.to_radians()));
            println!(
                "{alpha:<6}  {tolerance:<9}  {:<5}  {:<6}  {bytes:<8}  {:.4} {:.4} {:.4} {:.4}",
                brdf.table().cells().len(),
                kept.len(),
                l1[0],
                l1[1],
                l1[2],
                l1[3]
            );
            assert!(l1.iter().all(|e| *e < tolerance), "alpha {alpha}, tolerance {tolerance}: {l1:?}");
        }
    }
}

/// A cell that no ray met is not known to be dark: its error is that of three rays.
#[test]
fn an_empty_cell_of_a_ray_table_has_an_error() {
    let options = Options { method: Method::Rays, rays: 2000, symmetry: Symmetry::Isotropic, ..Options::default() };
    let options = Options { theta_i: vec![30f64.to_radians()], ..options };
    let table = Table::from_scatter(&scatter(&gaussian(0.1, 128), &options, &|_| ()).unwrap(), Provenance::default());
    let wi = direction(30f64.to_radians(), 0.0);
    let mut empty = 0;
    for k in 0..2000 {
        let (theta, phi) = (0.0005 * f64::from(k) * 1.4, 0.7 * f64::from(k));
        let e = table.estimate(wi, direction(theta, phi));
        assert!(e.standard_error > 0.0 && e.standard_error.is_finite(), "{theta} {phi}: {e:?}");
        empty += i32::from(e.value == 0.0);
    }
    assert!(empty > 100, "{empty}");
}

/// Full width at half maximum 2 deg, nodes at 40 and 50 deg, source at 45: one lobe, at its place, as high as it should be.
#[test]
fn a_lobe_between_two_nodes_neither_doubles_nor_fades() {
    let std = 2.0 / (8.0 * 2f64.ln()).sqrt();
    let alpha = std.to_radians() / std::f64::consts::SQRT_2;
    let formula = model::parse(&format!("beckmann:alpha={alpha},n=1.5"), 550e-9).unwrap();
    let nodes = [40f64, 50.0].map(f64::to_radians);
    let brdf = TableBrdf::new(by_formula(alpha, Material::Dielectric { n: 1.5 }, &nodes, 0.01)).unwrap();
    let wi = direction(45f64.to_radians(), 0.0);
    let profile = |b: &dyn Brdf| -> Vec<f64> {
        (0..2000)
            .map(|k| b.eval(wi, direction((40.0 + 0.005 * f64::from(k)).to_radians(), std::f64::consts::PI)))
            .collect()
    };
    let (got, exact) = (profile(&brdf), profile(formula.as_ref()));
    let centre = |v: &[f64]| {
        let sum: f64 = v.iter().sum();
        40.0 + 0.005 * v.iter().enumerate().map(|(k, f)| k as f64 * f).sum::<f64>() / sum
    };
    let peak = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
    assert!((centre(&got) - centre(&exact)).abs() < 0.05 * std, "{} {}", centre(&got), centre(&exact));
    assert!((peak(&got) / peak(&exact) - 1.0).abs() < 0.03, "{} {}", peak(&got), peak(&exact));
    // One lobe: it rises and falls once, but for the flats between cell centres.
    let top = got.iter().position(|f| *f == peak(&got)).unwrap();
    let slack = 1e-3 * peak(&got);
    assert!(got[..=top].windows(2).all(|w| w[1] > w[0] - slack) && got[top..].windows(2).all(|w| w[1] < w[0] + slack));
}

/// White furnace: mirror facets reflect what they do not lose, and draws carry what the table says.
#[test]
fn white_furnace() {
    let degrees = [0.0f64, 20.0, 40.0, 60.0, 75.0, 85.0];
    for (alpha, method) in [(0.02, Method::Geometric), (0.3, Method::Facets)] {
        let options = Options {
            method,
            symmetry: Symmetry::Isotropic,
            material: Material::Mirror,
            theta_i: degrees.map(f64::to_radians).to_vec(),
            ..Options::default()
        };
        let scattered = scatter(&gaussian(alpha, 256), &options, &|_| ()).unwrap();
        let table = Table::from_scatter(&scattered, Provenance::default());
        let brdf = TableBrdf::new(table).unwrap();
        let options = audit::Options { theta_i: options.theta_i, phi_i: vec![0.4], ..audit::Options::default() };
        for (row, t) in audit(&brdf, None, &options).rows.iter().zip(0..) {
            let node = brdf.table().node(t, 0);
            println!("alpha {alpha}, {:.0} deg: integral {:.5}, lost {:.5}", row.theta_i_deg, row.integral, node.lost);
            assert!((node.albedo + node.lost + node.absorbed - 1.0).abs() < 1e-9);
            assert!((row.integral + node.lost - 1.0).abs() < 1e-3, "{row:?} {node:?}");
            let noise = 4.0 * row.mean_weight.standard_error + 5e-4;
            assert!((row.mean_weight.value - row.albedo).abs() < noise, "{row:?}");
        }
    }
}

/// Lambertian counts with a third of the cells empty by chance, with and without a lobe: the floor is found. A Gaussian
/// lobe has none.
#[test]
fn the_floor_survives_noise_and_is_not_invented() {
    let theta_i = [30f64.to_radians()];
    let map = gaussian(0.05, 128);
    let statistics = SlopeStatistics::measure(&map).unwrap();
    let cells = HalfVectorCells::for_lobe(&statistics, true, 0.01);
    let wi = direction(theta_i[0], 0.0);
    let density = SlopeDensity { density: vec![0.0; cells.len()], core: 0.0, subareas: Vec::new() };
    let rays = 200_000;
    let run = |diffuse: f64| {
        let mut rng = asperity::math::random::CounterRng::new(8, 0, 0);
        let mut tally = Tally::new(cells.len());
        for _ in 0..rays {
            let wo = if rng.uniform() < diffuse {
                let (u, phi) = (rng.uniform(), std::f64::consts::TAU * rng.uniform());
                DVec3::new(u.sqrt() * phi.cos(), u.sqrt() * phi.sin(), (1.0 - u).sqrt())
            } else {
                let [p, q] = rng.normal_pair();
                match facing(0.035 * p, 0.035 * q, wi) {
                    Some(f) if f.wo.z > 0.0 => f.wo,
                    _ => continue,
                }
            };
            let cell = cells.locate_pair(wi, wo);
            tally.energy[cell] += 1.0;
            tally.energy_squared[cell] += 1.0;
            tally.incident += 1.0;
            tally.beams += 1;
        }
        let scattered = Scatter {
            cells: cells.clone(),
            isotropic: true,
            material: Material::Mirror,
            method: Method::Rays,
            theta_i: theta_i.to_vec(),
            phi_i: vec![0.0],
            tallies: vec![vec![tally]],
            density: density.clone(),
            statistics: statistics.clone(),
            decisions: Vec::new(),
            wave: None,
            core_error: Vec::new(),
        };
        Table::from_scatter(&scattered, Provenance::default())
    };
    for diffuse in [1.0, 0.3, 0.02, 0.0] {
        let table = run(diffuse);
        let node = table.node(0, 0);
        println!("diffuse {diffuse}: floor {:.4}, albedo {:.4}", node.diffuse, node.albedo);
        assert!((node.albedo - 1.0).abs() < 1e-9);
        assert!((node.diffuse - diffuse).abs() < 0.05 * diffuse + 2e-3, "{diffuse}: {node:?}");
        // Core + floor + rest is what was counted.
        let brdf = TableBrdf::new(table).unwrap();
        let options = audit::Options { theta_i: theta_i.to_vec(), phi_i: vec![0.0], ..audit::Options::default() };
        let row = &audit(&brdf, None, &options).rows[0];
        assert!((row.integral - 1.0).abs() < 2e-3, "{diffuse}: {row:?}");
        assert!(row.p_value > 1e-4, "{diffuse}: {row:?}");
    }
}
