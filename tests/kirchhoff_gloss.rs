//! Gloss by the phase integral, through the table and the meter, against Beckmann's series (`gloss_ray_vs_wave.csv`: gloss with a
//! collimated source, Smith's G, computed by scipy).

mod reference;

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::direction;
use asperity::meter::{self, Geometry, gloss};
use asperity::optics::fresnel;
use asperity::sample::TableBrdf;
use asperity::scatter::{Method, Options, scatter};
use asperity::table::{Provenance, Table};
use rayon::prelude::*;
use std::collections::HashMap;

const WAVELENGTH: f64 = 550e-9;

fn gaussian(size: usize, pitch: f64, sq: f64, acl: f64) -> HeightMap {
    let grid = synth::Grid { width: size, height: size, pitch: [pitch; 2] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed: 1, exact: true }).unwrap();
    level::keep_tilt(&raw, Edges::Periodic)
}

/// Every row and angle within 2 % or 0.5 gloss units, and the mirror beam by itself within the same.
#[test]
fn gloss_is_that_of_the_series() {
    let Some(table) = reference::table("gloss_ray_vs_wave.csv") else { return };
    let rows: Vec<_> = table.rows().flat_map(|row| Geometry::standard_three().map(|g| (row.clone(), g))).collect();
    // A calculation leaves cores idle between its transforms: several at once do not.
    let offs: Vec<f64> = rows.into_par_iter().map(|(row, geometry)| off_by(&row, geometry)).collect();
    println!("worst deviation: {:.2} of the tolerance", offs.iter().copied().fold(0.0, f64::max));
    assert_eq!(offs.len(), 72);
}

/// Gloss by waves of a surface of the reference less that of the series, in units of the tolerance.
fn off_by(row: &HashMap<String, f64>, geometry: Geometry) -> f64 {
    let (sq, acl) = (row["sigma_nm"] * 1e-9, row["ell_um"] * 1e-6);
    let theta_i = geometry.theta_i;
    let name = format!("G{:.0}_wave", theta_i.to_degrees());
    // Four standard deviations of slope stay below the phase-sampling limit.
    let limit = WAVELENGTH / (4.0 * theta_i.cos() * 4.0 * std::f64::consts::SQRT_2 * sq / acl);
    let size = if sq > 100e-9 { 768 } else { 512 };
    let map = gaussian(size, limit.min(acl / 8.0), sq, acl);
    let options = Options { method: Method::Kirchhoff, theta_i: vec![theta_i], ..Options::default() };
    let s = scatter(&map, &options, &|_| ()).unwrap();
    let brdf = TableBrdf::new(Table::from_scatter(&s, Provenance::default())).unwrap();
    let collimated = Geometry { source: [1e-6, 1e-6], ..geometry };
    let value = gloss(&brdf, &collimated, &meter::Options::default()).value;
    let (wanted, coherent) = (row[&name], row[&format!("{name}_coherent")]);
    let standard = fresnel::dielectric(theta_i.cos(), 1.567);
    let core = 100.0 * brdf.table().core(direction(theta_i, 0.0)) / standard;
    let off = (value - wanted).abs() / (0.02 * wanted).max(0.5);
    println!(
        "{:>4.0} nm {:>4.0} um {name}: {value:.3}, series {wanted:.3} ({off:.2} of the tolerance), core {core:.3} of {coherent:.3}",
        sq * 1e9,
        acl * 1e6
    );
    assert!(off < 1.0, "{name} of {sq:e}, {acl:e}: {value} instead of {wanted}");
    // The mirror beam by itself; at g of some units a map of finite size knows it to a few percent only.
    assert!((core - coherent).abs() < 0.02 * coherent + 0.5, "{name} of {sq:e}, {acl:e}: {core} {coherent}");
    off
}

/// From one node to the next, waves below g = 9 and rays above agree about the lobe: no step of gloss in a table of both.
#[test]
fn waves_join_rays() {
    let map = gaussian(1024, 0.6e-6, 201e-9, 20e-6);
    let theta_i: Vec<f64> = [40.0f64, 44.0, 48.0, 50.0, 54.0, 58.0].map(f64::to_radians).to_vec();
    let s = scatter(&map, &Options { theta_i, ..Options::default() }, &|_| ()).unwrap();
    let waves: Vec<bool> = s.decisions.iter().map(|d| d.wave).collect();
    assert_eq!(waves, [false, false, false, true, true, true]);
    for d in &s.decisions {
        println!("{:.0} deg: {d}", d.theta_i.to_degrees());
    }
    let brdf = TableBrdf::new(Table::from_scatter(&s, Provenance::default())).unwrap();
    let read = |degrees: f64| {
        let geometry = Geometry::with_receptor(degrees, [4.4, 11.7]);
        gloss(&brdf, &geometry, &meter::Options::default()).value
    };
    let series: Vec<f64> = (0..10).map(|k| read(42.0 + 1.5 * f64::from(k))).collect();
    println!("{series:?}");
    for w in series.windows(3) {
        // Second difference: a step would show as one.
        assert!((w[0] - 2.0 * w[1] + w[2]).abs() < 1.0, "{series:?}");
    }
}
