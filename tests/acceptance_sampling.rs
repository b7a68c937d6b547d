//! What the sampler draws against what its pdf says, over ten million draws, in two partitions of the directions.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::frame::{phi, theta};
use asperity::math::random::CounterRng;
use asperity::math::statistics::chi_square_test;
use asperity::math::{Estimate, direction, reflect};
use asperity::optics::{Brdf, Material};
use asperity::sample::TableBrdf;
use asperity::scatter::facing::facing;
use asperity::scatter::{Method, Options, Symmetry, scatter};
use asperity::table::{Provenance, Table};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::OnceLock;

const DRAWS: u64 = 10_000_000;

/// On a node of the table, between two, on a node.
const THETA_I: [f64; 3] = [20.0, 47.0, 75.0];

fn table(map: &HeightMap, symmetry: Symmetry, material: Material) -> TableBrdf {
    // Visibility for every facet: an anisotropic table then has a node for every azimuth.
    let theta_i = [0.0f64, 20.0, 40.0, 60.0, 75.0, 86.0].map(f64::to_radians).to_vec();
    let options = Options { method: Method::Facets, symmetry, material, theta_i, ..Options::default() };
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

/// An isotropic table, and one of a surface stretched threefold along y and tilted, so that every frame error shows.
fn tables() -> &'static [TableBrdf; 2] {
    static TABLES: OnceLock<[TableBrdf; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let glass = Material::Dielectric { n: 1.5 };
        [
            table(&rough([1e-6; 2], [0.0; 2]), Symmetry::Isotropic, glass),
            table(&rough([1e-6, 3e-6], [0.04, -0.02]), Symmetry::Anisotropic, glass),
        ]
    })
}

/// A partition of the upper hemisphere: the bin of a direction and the integral of the pdf over each bin.
struct Partition<'a> {
    name: &'static str,
    place: Box<dyn Fn(DVec3) -> usize + Sync + 'a>,
    masses: Vec<f64>,
}

/// How many of the draws fall into each bin of each partition; after the bins, how many carry nothing.
fn count(brdf: &TableBrdf, wi: DVec3, partitions: &[Partition]) -> Vec<Vec<f64>> {
    let streams = 64;
    let empty = || partitions.iter().map(|p| vec![0.0; p.masses.len() + 1]).collect::<Vec<_>>();
    let parts: Vec<Vec<Vec<f64>>> = (0..streams)
        .into_par_iter()
        .map(|stream| {
            let mut rng = CounterRng::new(17, 3, stream);
            let mut counts = empty();
            // Some of every thousand in runs, some one by one.
            let (together, alone) = (1000, 50);
            let mut drawn = vec![None; together];
            for from in (0..DRAWS / streams).step_by(together) {
                let count = together.min((DRAWS / streams - from) as usize);
                let u: Vec<[f64; 2]> = (0..count).map(|_| [rng.uniform(), rng.uniform()]).collect();
                let drawn = &mut drawn[..count];
                brdf.sample_many(&vec![wi; count], &u, drawn);
                drawn.iter_mut().zip(&u).take(alone).for_each(|(s, u)| *s = brdf.sample(wi, *u));
                for wo in drawn.iter().map(|s| s.map(|s| s.wo)) {
                    for (partition, counts) in partitions.iter().zip(&mut counts) {
                        counts[wo.map_or(partition.masses.len(), &partition.place)] += 1.0;
                    }
                }
            }
            counts
        })
        .collect();
    // Counts are whole numbers: their sum does not depend on the order.
    parts.iter().flatten().flatten().for_each(|c| assert!(c.fract() == 0.0));
    let mut total = empty();
    for part in parts {
        for (total, part) in total.iter_mut().flatten().zip(part.into_iter().flatten()) {
            *total += part;
        }
    }
    total
}

/// Chi-square of the draws that landed against the masses scaled to them, after the share of those that carry nothing
/// was found to be what the masses lack to 1.
fn test(counts: &[f64], masses: &[f64]) -> (f64, f64, f64) {
    let (nothing, landed) = counts.split_last().expect("the count of nothing");
    let total: f64 = masses.iter().sum();
    let lack = nothing / DRAWS as f64;
    // 1e-4: the quadrature of the masses.
    let tolerance = 1e-4 + 4.0 * (lack / DRAWS as f64).sqrt();
    assert!((1.0 - total - lack).abs() < tolerance, "the pdf integrates to {total}, {lack} of the draws carry nothing");
    let all: f64 = landed.iter().sum();
    let expected: Vec<f64> = masses.iter().map(|m| m / total * all).collect();
    chi_square_test(landed, &expected, 20.0)
}

/// The mass of a bin by side x side midpoints: the more draws it expects, the more exactly its mass must be known, and the
/// pdf has kinks at the centre lines of the cells.
fn refined(mass: impl Fn(u32) -> f64) -> f64 {
    let draws = mass(8) * DRAWS as f64;
    mass(((draws.sqrt() / 2.0) as u32).clamp(12, 250))
}

/// Half-vector cells of the table: `d omega = 4 cos_beta cos^3 theta_h dp dq` takes the pdf to the slope plane, where it is
/// bilinear in each quarter of a cell and cut where the mirror direction sinks below the horizon.
fn by_cells(brdf: &TableBrdf, wi: DVec3) -> Partition<'_> {
    let cells = brdf.table().cells();
    let turn = if brdf.table().is_isotropic() { phi(wi) } else { 0.0 };
    let turned = |v: DVec3, angle: f64| {
        let (s, c) = angle.sin_cos();
        DVec3::new(c * v.x - s * v.y, s * v.x + c * v.y, v.z)
    };
    let mass = |k: usize, side: u32| -> f64 {
        let part = |j: u32| (f64::from(j) + 0.5) / f64::from(side);
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
    };
    let masses = (0..cells.len()).into_par_iter().map(|k| refined(|side| mass(k, side))).collect();
    let place = move |wo: DVec3| cells.locate_pair(turned(wi, -turn), turned(wo, -turn));
    Partition { name: "half-vector cells", place: Box::new(place), masses }
}

/// One degree of theta_r by three of phi_r, which know nothing of half vectors, cells or Jacobians.
fn by_angles(brdf: &TableBrdf, wi: DVec3) -> Partition<'_> {
    let (rows, columns) = (90, 120);
    let integral = |k: usize, side: u32| -> f64 {
        let (row, column) = ((k / columns) as f64, (k % columns) as f64);
        let (t0, t1) = (row.to_radians().cos(), (row + 1.0).to_radians().cos());
        let part = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let sum: f64 = (0..side * side)
            .map(|j| {
                // Even steps in cos(theta) are even in solid angle.
                let cos = t1 + (t0 - t1) * part(j / side);
                brdf.pdf(wi, direction(cos.acos(), TAU * (column + part(j % side)) / columns as f64))
            })
            .sum();
        sum * (t0 - t1) * TAU / columns as f64 / f64::from(side * side)
    };
    let masses = (0..rows * columns).into_par_iter().map(|k| refined(|side| integral(k, side))).collect();
    let place = move |wo: DVec3| {
        let row = (theta(wo).to_degrees() as usize).min(rows - 1);
        row * columns + ((phi(wo) / TAU * columns as f64) as usize).min(columns - 1)
    };
    Partition { name: "angles", place: Box::new(place), masses }
}

#[test]
fn ten_million_draws_follow_the_pdf() {
    for (name, brdf, phi_i) in [("isotropic", &tables()[0], 130.0f64), ("anisotropic", &tables()[1], 25.0)] {
        for theta_i in THETA_I {
            let wi = direction(theta_i.to_radians(), phi_i.to_radians());
            let partitions = [by_cells(brdf, wi), by_angles(brdf, wi)];
            for (partition, counts) in partitions.iter().zip(count(brdf, wi, &partitions)) {
                let (chi2, dof, p) = test(&counts, &partition.masses);
                let what = format!("{name}, {theta_i} deg, {}", partition.name);
                println!("{what}: chi-square {chi2:.0} for {dof} degrees of freedom, p {p:.4}");
                assert!(dof > 50.0 && p > 1e-4, "{what}: chi-square {chi2} for {dof} degrees of freedom, p {p}");
            }
        }
    }
}

/// Runs of draws are the draws one by one, for every material, for light from above, along the horizon and from below.
#[test]
fn many_draws_are_single_draws() {
    let metal = Material::Conductor { n: 0.2, k: 3.4 };
    let plain = |material| table(&rough([1e-6; 2], [0.0; 2]), Symmetry::Isotropic, material);
    let others = [plain(Material::Mirror), plain(metal), near_mirror(0.0)];
    for brdf in tables().iter().chain(&others) {
        let mut rng = CounterRng::new(21, 0, 0);
        let n = 5003;
        let mut wi: Vec<DVec3> = (0..n).map(|_| direction(1.65 * rng.uniform(), TAU * rng.uniform())).collect();
        (wi[3], wi[40]) = (DVec3::Z, direction(FRAC_PI_2 - 1e-6, 1.0));
        let u: Vec<[f64; 2]> = (0..n).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let mut many = vec![None; n];
        brdf.sample_many(&wi, &u, &mut many);
        let mut landed = 0;
        for k in 0..n {
            match (many[k], brdf.sample(wi[k], u[k])) {
                (Some(a), Some(b)) => {
                    landed += 1;
                    let specular = a.specular && b.specular && a.pdf == b.pdf;
                    assert!(specular || (a.pdf / b.pdf - 1.0).abs() < 1e-4, "{a:?} {b:?}");
                    assert!((a.wo - b.wo).length() < 1e-6 && (a.weight / b.weight - 1.0).abs() < 1e-4, "{a:?} {b:?}");
                }
                (None, None) => {}
                // At the very horizon rounding decides.
                (a, b) => assert!(a.or(b).is_some_and(|s| s.wo.z < 1e-6), "{a:?} {b:?} for {:?}", wi[k]),
            }
        }
        assert!(landed > n / 2, "{landed}");
    }
}

/// Runs of lookups are the lookups one by one: near the lobe and far from it, for light from above, along the horizon and from
/// below, for exits below, and for a list that is no whole number of runs.
#[test]
fn many_lookups_are_single_lookups() {
    let metal = Material::Conductor { n: 0.2, k: 3.4 };
    let plain = |material| table(&rough([1e-6; 2], [0.0; 2]), Symmetry::Isotropic, material);
    let others = [plain(Material::Mirror), plain(metal), near_mirror(0.0)];
    for brdf in tables().iter().chain(&others) {
        let mut rng = CounterRng::new(22, 0, 0);
        let n = 5003;
        let mut wi: Vec<DVec3> = (0..n).map(|_| direction(1.65 * rng.uniform(), TAU * rng.uniform())).collect();
        (wi[3], wi[40]) = (DVec3::Z, direction(FRAC_PI_2 - 1e-6, 1.0));
        let anywhere = |rng: &mut CounterRng| direction(1.65 * rng.uniform(), TAU * rng.uniform());
        let mut wo: Vec<DVec3> = wi
            .iter()
            .enumerate()
            .map(|(k, &wi)| {
                let drawn = brdf.sample(wi, [rng.uniform(), rng.uniform()]).map(|s| s.wo);
                drawn.filter(|_| k % 2 == 0).unwrap_or_else(|| anywhere(&mut rng))
            })
            .collect();
        (wo[3], wo[5], wo[7]) = (DVec3::Z, direction(FRAC_PI_2 - 1e-8, 2.0), wi[7]);
        let mut many = vec![(f64::NAN, f64::NAN); n];
        brdf.eval_and_pdf_many(&wi, &wo, &mut many);
        let mut above = 0;
        for k in 0..n {
            let one = brdf.eval_and_pdf(wi[k], wo[k]);
            // Steep flanks between cells carry the rounding of f32 further, see below.
            let corner =
                brightest_corner(brdf, wi[k], wo[k]).filter(|_| one.0 > 0.0).map_or(1.0, |c| (c / one.0).max(1.0));
            for (a, b) in [(many[k].0, one.0), (many[k].1, one.1)] {
                assert!((a - b).abs() <= 2e-6 * corner * b + 1e-30, "{a} {b} {corner} for {} {}", wi[k], wo[k]);
            }
            above += usize::from(one.0 > 0.0);
        }
        // A mirror with a little haze leaves few.
        assert!(above > 100, "{above}");
    }
}

/// The value at the brightest of the four cells between which a lookup interpolates; `None` if one lies below the horizon.
fn brightest_corner(brdf: &TableBrdf, wi: DVec3, wo: DVec3) -> Option<f64> {
    let cells = brdf.table().cells();
    let angle = if brdf.table().is_isotropic() { phi(wi) } else { 0.0 };
    let turned = |x: f64, y: f64, angle: f64| {
        let (s, c) = angle.sin_cos();
        (c * x - s * y, s * x + c * y)
    };
    let sum = wi + wo;
    let (p, q) = turned(-sum.x / sum.z, -sum.y / sum.z, -angle);
    let at = |cell: usize| {
        let (p, q) = cells.slope_in(cell, 0.5, 0.5);
        let (p, q) = turned(p, q, angle);
        let wo = facing(p, q, wi).filter(|f| f.wo.z > 0.01)?.wo;
        Some(brdf.table().eval(wi, wo))
    };
    cells.stencil(p, q).iter().map(|&(cell, _)| at(cell)).try_fold(0.0, |most, f| Some(f64::max(most, f?)))
}

/// The sampler's lookups, in f32 and without searching, are those of the table in f64: at nodes, between and beyond them, for
/// light from above and along the horizon, near the lobe and far from it. A share of f32 is off by 6e-8 of the cells that
/// it lies between.
#[test]
fn lookups_are_those_of_the_table() {
    let mirror = table(&rough([1e-6; 2], [0.0; 2]), Symmetry::Isotropic, Material::Mirror);
    for brdf in tables().iter().chain([&mirror]) {
        let mut rng = CounterRng::new(31, 0, 0);
        let mut compared = 0;
        for k in 0..40_000 {
            let theta_i = if k % 5 == 0 { 20f64.to_radians() } else { FRAC_PI_2 * rng.uniform() };
            let wi = if k % 97 == 0 { DVec3::Z } else { direction(theta_i, TAU * rng.uniform()) };
            let drawn = brdf.sample(wi, [rng.uniform(), rng.uniform()]).filter(|_| k % 2 == 0).map(|s| s.wo);
            let wo = drawn.unwrap_or_else(|| direction(FRAC_PI_2 * rng.uniform(), TAU * rng.uniform()));
            let (fast, honest) = (brdf.eval(wi, wo), brdf.table().eval(wi, wo));
            assert_eq!((fast, brdf.pdf(wi, wo)), brdf.eval_and_pdf(wi, wo));
            let Some(corner) = brightest_corner(brdf, wi, wo) else { continue };
            // Cells are kept in f32, whose range ends at 1e-38.
            let close = (fast - honest).abs() <= 1e-6 * honest.max(corner) + 1e-30;
            assert!(close, "{fast} {honest} {corner} for {wi} {wo}");
            compared += 1;
        }
        assert!(compared > 20_000, "{compared}");
    }
}

/// The control: draws for a source a third of a degree away must not pass.
#[test]
fn a_wrong_direction_is_noticed() {
    let brdf = &tables()[0];
    let partitions = [by_angles(brdf, direction(0.5, 1.0))];
    let counts = count(brdf, direction(0.5 + (1.0f64 / 3.0).to_radians(), 1.0), &partitions);
    assert!(test(&counts[0], &partitions[0].masses).2 < 1e-9);
}

/// Every node's alias columns add up to one, draw no empty cell, and their weights to the energy of the glossy rest.
#[test]
fn alias_mass_is_that_of_the_table() {
    for brdf in tables() {
        let table = brdf.table();
        let phis = table.phi_i().len();
        for node in 0..table.theta_i().len() * phis {
            let alias = brdf.alias(node).expect("a rough surface has a lobe at every node");
            let probabilities = alias.probabilities();
            assert_eq!(probabilities.len(), table.cells().len());
            assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let facts = table.node(node / phis, node % phis);
            let surplus = alias.total() / (facts.albedo - facts.diffuse) - 1.0;
            // What is more serves cells that lie below the horizon of this node. A node of a surface with a grain also serves the
            // azimuths up to its neighbours, in root mean square: next to nothing while light falls steeply. Where it grazes
            // a tilted surface, one side reflects much more than the other; tests/grain.rs holds those draws to their account.
            let steep = table.theta_i()[node / phis] < 0.8;
            let most = match (table.is_isotropic(), steep) {
                (true, _) => -1e-9..0.01,
                (false, true) => -2e-3..2e-3,
                (false, false) => -0.1..0.5,
            };
            assert!(most.contains(&surplus), "node {node}: {} {facts:?}", alias.total());
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
        let filled = brdf.alias(0).unwrap().probabilities().iter().filter(|&&p| p > 0.0).count();
        assert!(4 * filled < cells.len(), "{filled} of {} cells", cells.len());
        let mirror = |wi: DVec3| reflect(wi, asperity::math::frame::normal_of_slope(tilt, 0.0));
        for theta_i in [0.0, 20.0, 47.0, 60.0] {
            let wi = direction(f64::to_radians(theta_i), 0.7);
            let mut rng = CounterRng::new(9, 0, 0);
            let draws = 1_000_000usize;
            let (mut hot, mut energy) = (0, Vec::with_capacity(draws));
            for _ in 0..draws {
                let Some(s) = brdf.sample(wi, [rng.uniform(), rng.uniform()]) else {
                    energy.push(0.0);
                    continue;
                };
                energy.push(s.weight);
                hot += i32::from((s.wo - mirror(wi)).length() < 1e-3);
                if !s.specular {
                    assert!(s.weight > 0.0 && s.pdf > 0.0, "{s:?}");
                    assert!(brdf.eval(wi, s.wo) > 0.0 && brdf.pdf(wi, s.wo) > 0.0, "{s:?}");
                }
            }
            // The flat part reflects along the mirror: 99.25 % of the facets, less what bumps hide.
            assert!((f64::from(hot) / draws as f64 - 0.9925).abs() < 0.01, "{hot}");
            // Nothing that the table reflects is out of the draws' reach.
            let mean = Estimate::from_repeats(&energy);
            let albedo = brdf.table().albedo(wi);
            assert!((mean.value - albedo).abs() < 4.0 * mean.standard_error + 1e-3, "{mean:?} {albedo}");
        }
    }
}
