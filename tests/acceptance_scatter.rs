//! The facet sum against naive rays on two measured and two made surfaces, cell by cell.
//!
//! Rays are independent draws, so a cell's count is binomial about the facet sum's expectation. Three statements hold
//! each direction: (1) every cell that expects [`ENOUGH`] hits or more lies within 4 standard errors, taken from
//! the facet sum's expectation as well as from the rays themselves; (2) every cell with fewer, where neither error is
//! normal, keeps its exact Poisson tail above the chance of 4 sigma; (3) chi-square over all cells. With some
//! 10^4 cells about one would leave 4 sigma by chance; the seed is fixed, and at this seed none does.

use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::math::statistics::chi_square_p_value;
use asperity::optics::Material;
use asperity::scatter::facing::cell_weight;
use asperity::scatter::{HalfVectorCells, Method, Options, Scatter, Symmetry, Tally, scatter};
use glam::DVec3;
use std::path::PathBuf;

/// Hits from which the standard error of a count is that of a normal distribution, skewness below 0.1.
const ENOUGH: f64 = 100.0;

/// One-sided chance of 4 standard deviations.
const FOUR_SIGMA: f64 = 3.17e-5;

const GLASS: Material = Material::Dielectric { n: 1.5 };
const THETA_I: [f64; 2] = [20.0, 60.0];
const PHI_I: [f64; 2] = [0.0, 37.0];

/// A levelled map of the shared collection, or `None` with a loud line if the collection is not there.
fn shared(name: &str) -> Option<HeightMap> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = folder.join("heightmaps").join(name);
    if !path.exists() {
        eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder that holds heightmaps/", path.display());
        return None;
    }
    Some(level::level(&read(&path, &ReadOptions::default()).unwrap(), Edges::Open).unwrap())
}

fn run(map: &HeightMap, method: Method, rays: u64) -> Scatter {
    let options = Options {
        method,
        symmetry: Symmetry::Anisotropic,
        material: GLASS,
        theta_i: THETA_I.map(f64::to_radians).to_vec(),
        phi_i: PHI_I.map(f64::to_radians).to_vec(),
        rays,
        seed: 21,
        ..Options::default()
    };
    scatter(map, &options, &|_| ()).unwrap()
}

/// `P(X <= count)` or `P(X >= count)`, whichever is the tail, for a Poisson mean.
fn poisson_tail(count: f64, mean: f64) -> f64 {
    if mean == 0.0 {
        return if count == 0.0 { 1.0 } else { 0.0 };
    }
    let term = |k: f64| (k * mean.ln() - mean - libm::lgamma(k + 1.0)).exp();
    if count <= mean {
        (0..=count as u64).map(|k| term(k as f64)).sum()
    } else {
        (0..200).map(|k| term(count + f64::from(k))).sum()
    }
}

/// Mean reflectance of the facets of a cell, to turn energy into hits.
fn reflectance(cells: &HalfVectorCells, cell: usize, wi: DVec3) -> f64 {
    let (reflected, _) = cell_weight(cells, cell, wi, &GLASS);
    let (all, _) = cell_weight(cells, cell, wi, &Material::Mirror);
    if all > 0.0 { reflected / all } else { GLASS.reflectance(wi.z) }
}

/// What a comparison found.
#[derive(Default, Debug)]
struct Found {
    cells: usize,
    /// Cells beyond 4 standard errors or beyond the Poisson chance of as much.
    beyond: Vec<String>,
    /// Largest deviation in standard errors, over cells that expect enough hits.
    largest: f64,
    chi2: f64,
    dof: f64,
}

fn compare(cells: &HalfVectorCells, sum: &Tally, rays: &Tally, wi: DVec3) -> Found {
    let n = rays.beams as f64;
    let mut found = Found::default();
    let mut few = [0.0; 2];
    for k in 0..cells.len() {
        let (expected, got) = (sum.fraction(k).value, rays.fraction(k));
        let r = reflectance(cells, k, wi);
        let (mean_hits, hits) = (n * expected / r, n * got.value / r);
        found.cells += usize::from(mean_hits > 0.0 || hits > 0.0);
        if mean_hits >= ENOUGH {
            let standard_error = ((r * expected - expected * expected) / n).sqrt();
            let d = (got.value - expected).abs();
            let deviation = (d / standard_error).max(d / got.standard_error);
            if deviation > 4.0 {
                found.beyond.push(format!("cell {k}: facets {expected}, rays {got:?}, {deviation} standard errors"));
            }
            found.largest = found.largest.max(deviation);
            found.chi2 += (d / standard_error).powi(2);
            found.dof += 1.0;
        } else {
            // The facet sum has one beam per facet: what it never sent may still be as frequent as one of them.
            let upper = mean_hits.max(n / sum.beams as f64);
            let expected = if hits > mean_hits { upper } else { mean_hits };
            if poisson_tail(hits.round(), expected) < FOUR_SIGMA {
                found.beyond.push(format!("cell {k}: {hits} hits where {mean_hits} are expected"));
            }
            few[0] += mean_hits;
            few[1] += hits;
        }
    }
    if few[0] > 10.0 {
        found.chi2 += (few[1] - few[0]).powi(2) / few[0];
        found.dof += 1.0;
    }
    found
}

/// A periodic Gaussian surface of so many samples along x and y, with a pitch for each axis.
fn gaussian(size: [usize; 2], sq: f64, acl: f64, seed: u64, pitch: [f64; 2]) -> HeightMap {
    let grid = synth::Grid { width: size[0], height: size[1], pitch: [pitch[0]; 2] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: true }).unwrap();
    HeightMap { pitch_y: pitch[1], ..level::keep_tilt(&raw, Edges::Periodic) }
}

/// The comparison in every direction, over at least so many cells with enough hits; returns the shares of light that was hidden and that bounced more than once at the most.
fn facets_equal_rays(name: &str, map: &HeightMap, cells: f64) -> [f64; 2] {
    let rays = 2_000_000;
    let (sum, traced) = (run(map, Method::Facets, rays), run(map, Method::Rays, rays));
    let mut most = [0.0f64; 2];
    for (t, theta_i) in THETA_I.into_iter().enumerate() {
        for (p, phi_i) in PHI_I.into_iter().enumerate() {
            let what = format!("{name} at {theta_i} deg, azimuth {phi_i} deg");
            let (a, b) = (&sum.tallies[t][p], &traced.tallies[t][p]);
            most = [most[0].max(a.shadowed), most[1].max(1.0 - a.bounce_fractions()[0] / a.book().escaped)];
            for tally in [a, b] {
                let book = tally.book();
                assert!((book.escaped + book.absorbed + book.lost - 1.0).abs() < 1e-12, "{what}: {book:?}");
            }
            let found = compare(&sum.cells, a, b, direction(theta_i.to_radians(), phi_i.to_radians()));
            let chance = chi_square_p_value(found.chi2, found.dof);
            println!("{what}: {found:?}, p {chance:.3}");
            assert!(found.beyond.is_empty(), "{what}: {:#?}", found.beyond);
            assert!(found.dof > cells, "{what}: too few cells for a test: {found:?}");
            assert!(chance > 1e-4, "{what}: {found:?}, p {chance}");

            // The core and the energies of the book, each a mean over the same rays.
            let n = b.beams as f64;
            let r = GLASS.reflectance(theta_i.to_radians().cos());
            let close = |x: f64, y: f64, variance: f64| (x - y).abs() <= 4.0 * (variance / n).sqrt() + 1e-12;
            let (core_a, core_b) = (a.core / a.incident, b.core / b.incident);
            assert!(close(core_a, core_b, core_a.max(1.0 / n) * r), "{what}: core {core_a} {core_b}");
            // A ray gives all it has to one of the three, so no share scatters more than sqrt(share (1 - share)).
            let (x, y) = (a.book(), b.book());
            for (x, y) in [(x.escaped, y.escaped), (x.absorbed, y.absorbed), (x.lost, y.lost)] {
                assert!(close(x, y, (x * (1.0 - x)).max(1.0 / n)), "{what}: {x} {y}");
            }
        }
    }
    most
}

#[test]
fn polished_surface_with_gaps() {
    let name = "converted/opd-1.int16.x3p";
    if let Some(map) = shared(name) {
        facets_equal_rays(name, &map, 300.0);
    }
}

#[test]
fn grooved_surface_with_oblong_pixels() {
    let name = "real/x3p-2.x3p";
    if let Some(map) = shared(name) {
        facets_equal_rays(name, &map, 300.0);
    }
}

/// Gradients of 1 and more: much is hidden, and much of what is not meets the surface again. The lobe fills the hemisphere, which a
/// hundred of its cells cover.
#[test]
fn steep_surface() {
    let map = gaussian([768, 640], 4.8e-6, 8e-6, 11, [0.4e-6; 2]);
    let [hidden, again] = facets_equal_rays("steep", &map, 80.0);
    assert!(hidden > 0.1 && again > 0.01, "hidden {hidden}, again {again}");
}

/// Slopes four times as large along x as along y, on oblong pixels.
#[test]
fn brushed_surface() {
    let map = gaussian([768, 640], 1.2e-6, 6e-6, 12, [0.5e-6, 2e-6]);
    let slopes = asperity::facets::SlopeStatistics::measure(&map).unwrap();
    assert!((slopes.rms[0] / slopes.rms[1] - 4.0).abs() < 0.2, "{:?}", slopes.rms);
    facets_equal_rays("brushed", &map, 300.0);
}

/// The control: rays from 37 deg against facets lit from 0 deg must not pass.
#[test]
fn a_turned_source_is_noticed() {
    let Some(map) = shared("real/x3p-2.x3p") else { return };
    let rays = 2_000_000;
    let (sum, traced) = (run(&map, Method::Facets, rays), run(&map, Method::Rays, rays));
    let wi = direction(THETA_I[1].to_radians(), 0.0);
    let found = compare(&sum.cells, &sum.tallies[1][0], &traced.tallies[1][1], wi);
    assert!(!found.beyond.is_empty() || chi_square_p_value(found.chi2, found.dof) < 1e-6, "{found:?}");
}
