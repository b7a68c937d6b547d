//! Gloss by the phase integral against Beckmann's series (`gloss_ray_vs_wave.csv`), through the table and the meter.

mod reference;

use asperity::heightmap::{Edges, level, synth};
use asperity::meter::{self, Geometry, gloss};
use asperity::sample::TableBrdf;
use asperity::scatter::{Method, Options, scatter};
use asperity::table::{Provenance, Table};

#[test]
fn wave_gloss() {
    let Some(table) = reference::table("gloss_ray_vs_wave.csv") else { return };
    let collimated = Geometry::standard_three().map(|g| Geometry { source: [1e-6, 1e-6], ..g });
    for row in table.rows() {
        let (sq, acl) = (row["sigma_nm"] * 1e-9, row["ell_um"] * 1e-6);
        let pitch = (acl / 10.0).min(0.4 * 0.55e-6 / (4.0 * 4.0 * 1.4 * sq / acl));
        let start = std::time::Instant::now();
        let mut sums = [[0.0; 4]; 4];
        let maps = 2;
        for seed in 0..maps {
            let grid = synth::Grid { width: 1024, height: 1024, pitch: [pitch; 2] };
            let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed: seed + 1, exact: true }).unwrap();
            let map = level::keep_tilt(&raw, Edges::Periodic);
            let options = Options { method: Method::Kirchhoff, ..Options::default() };
            let s = scatter(&map, &options, &|_| ()).unwrap();
            let brdf = TableBrdf::new(Table::from_scatter(&s, Provenance::default())).unwrap();
            for (k, g) in collimated.iter().enumerate() {
                let v = gloss(&brdf, g, &meter::Options::default()).value;
                sums[k][0] += v / maps as f64;
                sums[k][1] += v * v / maps as f64;
            }
        }
        print!("{:>4} {:>4} {:.2}um {:.1}s ", row["sigma_nm"], row["ell_um"], pitch * 1e6, start.elapsed().as_secs_f64());
        for (k, a) in ["20", "60", "85"].iter().enumerate() {
            let mean = sums[k][0];
            let se = ((sums[k][1] - mean * mean).max(0.0) / (maps - 1) as f64).sqrt();
            let want = row[&format!("G{a}_wave")];
            let off = mean - want;
            print!("  | {mean:8.3} +- {se:.3} want {want:8.3} off {off:+.3} {}", if off.abs() < 0.5f64.max(0.02 * want) { ' ' } else { '!' });
        }
        println!();
    }
}
