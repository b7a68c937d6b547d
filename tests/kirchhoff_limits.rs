//! Where the wave calculation ends: bad maps, grazing light, real maps; threads; a polished surface.

use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::meter::{Holds, Warning};
use asperity::optics::Material;
use asperity::report::{Settings, predict};
use asperity::scatter::detectors::Partition;
use asperity::scatter::{Counting, Method, Options, Run, Scatter, Wave, count, scatter};
use std::path::PathBuf;

fn gaussian(sq: f64, acl: f64, size: [usize; 2], edges: Edges) -> HeightMap {
    let grid = synth::Grid { width: size[0], height: size[1], pitch: [0.5e-6, 0.7e-6] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed: 4, exact: false }).unwrap();
    level::level(&raw, edges).unwrap()
}

fn run(map: &HeightMap, options: &Options) -> Scatter {
    let s = scatter(map, options, &|_| ()).unwrap();
    for (row, theta) in s.tallies.iter().zip(&s.theta_i) {
        for tally in row {
            let book = tally.book();
            assert!((book.escaped + book.absorbed + book.lost - 1.0).abs() < 1e-9, "{theta}: {book:?}");
            assert!(tally.energy.iter().chain([&tally.core, &tally.lost]).all(|e| e.is_finite() && *e >= 0.0));
        }
    }
    s
}

fn waves() -> Options {
    let theta_i = [0.0f64, 30.0, 60.0, 85.0, 89.9].map(f64::to_radians).to_vec();
    Options { method: Method::Kirchhoff, theta_i, ..Options::default() }
}

#[test]
fn bad_maps_give_numbers_and_a_closed_book() {
    let flat = gaussian(0.0, 5e-6, [64, 48], Edges::Open);
    let mut walls = flat.clone();
    walls.heights.indexed_iter_mut().for_each(|((_, c), h)| *h = if c / 8 % 2 == 0 { 0.0 } else { 5e-6 });
    let mut spike = flat.clone();
    spike.heights[[20, 30]] = 1e-5;
    let mut gaps = gaussian(80e-9, 5e-6, [96, 80], Edges::Open);
    gaps.heights.indexed_iter_mut().filter(|((r, c), _)| (r * 7 + c * 13) % 10 < 4).for_each(|(_, h)| *h = f32::NAN);
    let mut steps = gaussian(30e-9, 5e-6, [96, 80], Edges::Periodic);
    steps.heights.mapv_inplace(|h| (h / 2e-8).round() * 2e-8);
    let mut one = gaussian(80e-9, 5e-6, [96, 80], Edges::Open);
    one.heights.indexed_iter_mut().filter(|((r, c), _)| *r > 1 || *c > 1).for_each(|(_, h)| *h = f32::NAN);
    for (name, map) in
        [("flat", flat), ("walls", walls), ("spike", spike), ("gaps", gaps), ("steps", steps), ("one facet", one)]
    {
        println!("{name}");
        let s = run(&map, &waves());
        if name == "flat" {
            assert!(
                s.tallies.iter().all(|row| (row[0].core - s.material.reflectance(direction(0.0, 0.0).z)).abs() < 1.0)
            );
            assert!(s.tallies[1][0].energy.iter().sum::<f64>() < 1e-9);
        }
        if name == "walls" {
            assert!(s.decisions.iter().any(|d| d.undersampled > 0.05 && d.tangent_plane < 1.0));
        }
    }
}

/// Missing points neither diffract the mirror beam nor change its share. The lobe they do widen a little, since it is seen
/// through them; at grazing incidence that sends part of it below the horizon, so it is compared up to 60 deg.
#[test]
fn gaps_do_not_diffract() {
    let whole = gaussian(20e-9, 6e-6, [256, 256], Edges::Open);
    let mut holed = whole.clone();
    holed
        .heights
        .indexed_iter_mut()
        .filter(|((r, c), _)| r / 4 % 3 == 0 && c / 4 % 3 == 0)
        .for_each(|(_, h)| *h = f32::NAN);
    let [a, b] = [&whole, &holed].map(|map| run(map, &waves()));
    for ((x, y), theta_i) in a.tallies.iter().zip(&b.tallies).zip(&a.theta_i) {
        let lobe = |t: &asperity::scatter::Tally| t.energy.iter().sum::<f64>();
        assert!((x[0].core / y[0].core - 1.0).abs() < 0.01);
        let off = (lobe(&x[0]) / lobe(&y[0]) - 1.0).abs();
        assert!(off < 0.1 || *theta_i > 1.1, "{} {}", lobe(&x[0]), lobe(&y[0]));
    }
}

/// A band of wavelengths and a wide source smooth the lobe but keep its light.
#[test]
fn band_and_source_keep_the_light() {
    let map = gaussian(120e-9, 6e-6, [256, 200], Edges::Open);
    let one = run(&map, &waves());
    let wave = Wave { band: 40e-9, source: 2f64.to_radians(), ..Wave::default() };
    let many = run(&map, &Options { wave, ..waves() });
    for (x, y) in one.tallies.iter().zip(&many.tallies).take(3) {
        let (a, b) = (x[0].book(), y[0].book());
        assert!((a.escaped / b.escaped - 1.0).abs() < 0.02, "{a:?} {b:?}");
    }
}

/// A few patches of correlation: the mirror beam stands out from the speckle at some angles and not at their neighbours. Slopes of
/// a degree hide nothing, so that all the light that falls in comes out, to whatever is counted.
#[test]
fn a_beam_on_the_edge_of_the_speckle_takes_no_light_away() {
    let theta_i: Vec<f64> =
        [15.0f64, 20.0, 25.0].into_iter().chain((56..66).map(f64::from)).map(f64::to_radians).collect();
    let grid = synth::Grid { width: 320, height: 320, pitch: [1e-6; 2] };
    for seed in [1, 3, 7] {
        let raw = synth::gaussian(grid, synth::Gaussian { sq: 0.1e-6, acl: 40e-6, seed, exact: false }).unwrap();
        let map = level::level(&raw, Edges::Open).unwrap();
        let options = Options { theta_i: theta_i.clone(), material: Material::Mirror, ..waves() };
        let scattered = run(&map, &options);
        let cores: Vec<bool> = scattered.tallies.iter().map(|row| row[0].core > 0.0).collect();
        println!("{seed}: {cores:?}");
        for (row, theta) in scattered.tallies.iter().zip(&theta_i) {
            let lost = row[0].book().lost;
            assert!(lost < 0.005, "{seed}: {:.0} deg: {lost}", theta.to_degrees());
        }
        // Method auto counts waves where rays do not hold.
        let options = Options { method: Method::Auto, ..options };
        let counting = Counting { partition: Partition::Klems, averaged: true };
        let counted = count(&map, &options, &counting, &mut Run::Whole, &|_| ()).unwrap();
        for direction in &counted.directions {
            let lost = direction.tally.book().lost;
            assert!(lost < 0.005, "{seed}: {:.0} deg in detectors: {lost}", direction.theta_i.to_degrees());
        }
    }
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let map = gaussian(120e-9, 6e-6, [200, 256], Edges::Open);
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&map, &waves()))
    });
    assert_eq!(one.tallies, two.tallies);
}

fn real() -> Option<PathBuf> {
    let shared = std::env::var_os("ASPERITY_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let folder = shared.join("heightmaps/real");
    if !folder.is_dir() {
        eprintln!("SKIPPED: {} is not there; set ASPERITY_SHARED", folder.display());
        return None;
    }
    Some(folder)
}

/// The polished map: a mirror through its coherent beam, which rays alone turn into a semi-matt surface.
#[test]
fn a_polished_surface_is_a_mirror() {
    let Some(folder) = real() else { return };
    let map = level::level(&read(&folder.join("opd-1.opd"), &ReadOptions::default()).unwrap(), Edges::Open).unwrap();
    let p = predict(&map, "opd-1", &Settings::default(), &|_| ()).unwrap();
    let rays = p.ray_gloss.unwrap();
    println!("waves {:?}, rays {rays:?}", p.gloss);
    assert_eq!(p.holds(), [Holds::Waves; 3]);
    // A flat surface of n = 1.5 reads 82.0 at 20 deg; exp(-g) of Sq 6.7 nm leaves 98 % of it to the mirror.
    assert!(p.gloss[0].value > 0.97 * 82.0 && rays[0].value < 40.0);
    let said = |k: f64| {
        let about = |w: &&Warning| matches!(w, Warning::WavesInstead { theta_i, .. } if (theta_i - k.to_radians()).abs() < 1e-9);
        p.warnings.iter().find(about).map(ToString::to_string)
    };
    let text = said(20.0).unwrap();
    assert!(text.contains("Rayleigh parameter is 0.021") && text.contains("rays alone would give 30."), "{text}");
}

#[test]
fn every_real_map_gives_numbers() {
    let Some(folder) = real() else { return };
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let Ok(raw) = read(&entry.path(), &ReadOptions::default()) else { continue };
        let map = level::level(&raw, Edges::Open).unwrap();
        let s = run(&map, &Options { theta_i: vec![0.3, 1.0, 1.48], ..waves() });
        println!("{}: {}", entry.path().display(), s.decisions[1]);
    }
}
