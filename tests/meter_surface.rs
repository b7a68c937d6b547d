//! What a surface leaves open of its readings: sub-areas against other maps of the same surface, steps of the heights against heights
//! without, the mirror beam against its closed form.

use asperity::heightmap::sampling::Quantum;
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::Estimate;
use asperity::meter::{Appearance, Geometry, Options, Warning, appearance, gloss, surface_gloss, surface_scatter};
use asperity::optics::Brdf;
use asperity::report::{Settings, predict};
use asperity::sample::TableBrdf;
use asperity::scatter::{self, Method, Symmetry, scatter};
use asperity::table::{Provenance, Table};

fn raw(size: usize, sq: f64, acl: f64, seed: u64) -> asperity::heightmap::RawMap {
    let grid = synth::Grid { width: size, height: size, pitch: [0.438e-6; 2] };
    synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: false }).unwrap()
}

fn options(method: Method, degrees: &[f64]) -> scatter::Options {
    let theta_i = degrees.iter().map(|t| t.to_radians()).collect();
    scatter::Options { method, symmetry: Symmetry::Isotropic, theta_i, ..scatter::Options::default() }
}

fn table(map: &HeightMap, method: Method) -> TableBrdf {
    let scattered = scatter(map, &options(method, &[0.0, 20.0, 30.0, 60.0, 85.0]), &|_| ()).unwrap();
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).unwrap()
}

/// The usual set with everything that its errors hold.
fn read(brdf: &TableBrdf) -> Appearance {
    let options = Options::default();
    let found = appearance(brdf, &options).unwrap();
    let numbers = |part: &dyn Brdf, options: &Options| Ok(appearance(part, options)?.numbers());
    let errors = surface_scatter(brdf, &found.numbers(), &options, &numbers).unwrap();
    found.with_errors(&errors)
}

/// `+-` of every reading against the scatter over sixteen other maps of the same surface.
#[test]
fn every_error_is_the_scatter_of_other_maps() {
    let maps: Vec<Appearance> = (0..16)
        .map(|seed| {
            let map = level::keep_tilt(&raw(256, 0.15e-6, 4e-6, seed), Edges::Periodic);
            read(&table(&map, Method::Geometric))
        })
        .collect();
    let column = |of: fn(&Appearance) -> Estimate| maps.iter().map(of).collect::<Vec<_>>();
    for (name, estimates) in [
        ("gloss 20", column(|a| a.gloss[0].estimate)),
        ("gloss 60", column(|a| a.gloss[1].estimate)),
        ("haze", column(|a| a.haze.estimate)),
        ("log haze", column(|a| a.log_haze)),
        ("haze index", column(|a| a.haze_index)),
        ("DOI", column(|a| a.doi.as_ref().unwrap().estimate)),
        ("Rspec", column(|a| a.rspec.estimate)),
    ] {
        let n = estimates.len() as f64;
        let values: Vec<f64> = estimates.iter().map(|e| e.value).collect();
        let scatter = Estimate::from_repeats(&values).standard_error * n.sqrt();
        let stated = (estimates.iter().map(|e| e.standard_error.powi(2)).sum::<f64>() / n).sqrt();
        println!("{name:<10} {:>8.3}: stated +- {stated:.4}, scatter {scatter:.4}", values.iter().sum::<f64>() / n);
        // Sixteen maps know their scatter to 18 %, and sub-areas of a periodic map share its lowest waves.
        assert!((0.5..2.0).contains(&(stated / scatter)), "{name}: {stated} {scatter}");
    }
}

/// A flat mirror has nothing left open, and its readings say so.
#[test]
fn a_mirror_has_no_scatter() {
    let map = level::keep_tilt(
        &synth::ramp(synth::Grid { width: 40, height: 30, pitch: [1e-6, 2e-6] }, [0.0; 2]).unwrap(),
        Edges::Open,
    );
    let found = read(&table(&map, Method::Geometric));
    assert!(found.gloss.iter().chain([&found.haze, &found.rspec]).all(|r| r.estimate.standard_error < 1e-9));
    assert_eq!(found.doubt(), None);
}

/// What the beam loses the lobe gains: `dG = e (G_core - G_lobe c / (1 - c))` for a beam `c` of relative error `e`.
#[test]
fn a_weaker_beam_is_its_closed_form() {
    let map = level::keep_tilt(&raw(256, 0.06e-6, 3e-6, 4), Edges::Open);
    let brdf = table(&map, Method::Kirchhoff);
    let weaker = TableBrdf::new(brdf.table().of_weaker_beam().unwrap()).unwrap();
    for (k, geometry) in [1, 3, 4].into_iter().zip(Geometry::standard_three()) {
        let node = brdf.table().node(k, 0);
        let options = Options { tolerance: 0.005, ..Options::default() };
        let [whole, less] = [&brdf, &weaker].map(|b| gloss(b, &geometry, &options).value);
        let standard = asperity::optics::fresnel::dielectric(geometry.theta_i.cos(), 1.567);
        let own = asperity::optics::fresnel::dielectric(geometry.theta_i.cos(), 1.5);
        let core = 100.0 * node.core_share * own / standard;
        let change = node.core_error * (core - (whole - core) * node.core_share / (1.0 - node.core_share));
        println!(
            "core {:.4} +- {:.2e}: {:+.4}, closed form {change:+.4}",
            node.core_share,
            node.core_error,
            whole - less
        );
        assert!((whole - less - change).abs() < 0.02 + 0.02 * change.abs(), "{} {change}", whole - less);
        let stated = surface_gloss(&brdf, std::slice::from_ref(&geometry), &options).unwrap()[0];
        assert!(stated.standard_error >= (whole - less).abs());
    }
    assert!(table(&map, Method::Geometric).table().of_weaker_beam().is_none());
}

/// Heights rounded to the steps of a real focus-variation map. The truth is the same surface before it was rounded: the stated
/// error covers what rounding did, heights spread within their steps are nearer to the truth than those as they are, and the
/// result says so.
#[test]
fn steps_of_the_heights_are_in_the_error() {
    let step = 7.45e-9;
    let settings = Settings { scatter: options(Method::Geometric, &[0.0, 20.0, 60.0, 85.0]), ..Settings::default() };
    let (mut off, mut raw_error, mut spread_error) = (Vec::new(), 0.0, 0.0);
    for seed in 0..6 {
        let mut surface = raw(256, 0.27e-6, 6e-6, 40 + seed);
        // The plane of the instrument decides where the steps fall.
        surface
            .heights
            .indexed_iter_mut()
            .for_each(|((r, c), h)| *h += 0.438e-6 * (0.1767 * r as f64 - 0.1545 * c as f64));
        let truth = predict(&level::level(&surface, Edges::Open).unwrap(), "truth", &settings, &|_| ()).unwrap();
        assert!(truth.brdf.table().steps().is_none());
        surface.heights.mapv_inplace(|h| (h / step).round() * step);
        let map = level::level(&surface, Edges::Open).unwrap();
        let found = predict(&map, "steps", &settings, &|_| ()).unwrap();
        let steps = found.brdf.table().steps().expect("steps");
        assert!((steps.step / step - 1.0).abs() < 1e-3 && Quantum::of(&map).is_some());
        let raw_table = TableBrdf::new(found.brdf.table().of_raw_steps().unwrap()).unwrap();
        let raw_20 = gloss(&raw_table, &Geometry::gloss20(), &Options::default()).value;
        let (true_20, found_20, ray_20) = (truth.gloss[0].value, found.gloss[0], found.ray_gloss.unwrap()[0]);
        let change = found_20.value - raw_20;
        println!(
            "gloss at 20 deg {true_20:.3}, steps {:.3} +- {:.3} (as they are {raw_20:.3}); facets {:.3}, steps {:.3} +- {:.3}",
            found_20.value,
            found_20.standard_error,
            truth.ray_gloss.unwrap()[0].value,
            ray_20.value,
            ray_20.standard_error,
        );
        // The truth shares the scatter of the sub-areas, so the error stated for that is not to be counted on.
        assert!(found_20.standard_error >= change.abs());
        assert!((ray_20.value - true_20).abs() < ray_20.standard_error);
        off.push((found_20.value - true_20) / found_20.standard_error);
        raw_error += (raw_20 - true_20).abs();
        spread_error += (found_20.value - true_20).abs();
        let said =
            |p: &asperity::report::Prediction| p.warnings.iter().any(|w| matches!(w, Warning::HeightsInSteps { .. }));
        assert!(said(&found) && !said(&truth));
    }
    println!("errors at 20 deg in standard errors: {off:.2?}; as they are {raw_error:.3}, spread {spread_error:.3}");
    assert!(off.iter().all(|p| p.abs() < 1.5), "{off:?}");
    assert!(spread_error < 0.6 * raw_error, "{spread_error} {raw_error}");
}

/// What steps change travels with the file of the table.
#[test]
fn steps_are_saved_with_the_table() {
    let mut surface = raw(128, 0.27e-6, 6e-6, 2);
    surface.heights.mapv_inplace(|h| (h / 7e-9).round() * 7e-9);
    let settings = Settings { scatter: options(Method::Geometric, &[0.0, 60.0]), ..Settings::default() };
    let found = predict(&level::level(&surface, Edges::Open).unwrap(), "steps", &settings, &|_| ()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("steps.npz");
    found.brdf.table().save(&path).unwrap();
    let back = Table::load(&path).unwrap();
    let [a, b] = [found.brdf.table(), &back].map(|t| t.steps().unwrap().clone());
    assert!((a.step / b.step - 1.0).abs() < 1e-12 && (a.glint_spacing / b.glint_spacing - 1.0).abs() < 1e-12);
    assert_eq!((a.core, &a.change), (b.core, &b.change));
    assert!(a.change.iter().any(|c| *c != 0.0));
}
