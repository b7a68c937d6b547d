//! Real maps as perfect mirrors, patch by patch, against Radiance and an independent facet sum.

use super::shared;
use asperity::facets::slopes;
use asperity::heightmap::crop::Region;
use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Edges, HeightMap, level};
use asperity::math::direction;
use asperity::optics::Material;
use asperity::scatter::detectors::Rings;
use asperity::scatter::facing::facing;
use asperity::scatter::{Accumulator, Counting, Detectors, Footprint, Method, Options, Partition, Run, count};

/// Columns of a reference file: energy by Radiance (several bounces, 4e5 rays) and by single bounces without shadows.
fn columns(name: &str) -> Option<[Vec<f64>; 2]> {
    let path = shared(&format!("reference/klems/{name}_klems.csv"))?;
    let text = std::fs::read_to_string(path).unwrap();
    let mut columns = [Vec::new(), Vec::new()];
    for (k, line) in text.lines().skip(1).enumerate() {
        let fields: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        assert_eq!(fields[0] as usize, k);
        columns[0].push(fields[2]);
        columns[1].push(fields[4]);
    }
    assert_eq!(columns[0].len(), 145);
    Some(columns)
}

fn load(file: &str) -> Option<(HeightMap, Footprint)> {
    let raw = read(&shared(&format!("heightmaps/{file}"))?, &ReadOptions::default()).unwrap();
    let map = level::level(&raw, Edges::Open).unwrap();
    let footprint = Footprint::of(Region::Fraction([0.15, 0.15, 0.85, 0.85]), &map).unwrap();
    Some((map, footprint))
}

/// Weights and mirror directions of the lit facets, nothing hidden.
fn single_bounce(map: &HeightMap, lit: Footprint, theta_i: f64) -> Vec<f64> {
    let (klems, wi) = (Rings::klems(), direction(theta_i, 0.0));
    let mut sum = Accumulator::new(klems.len());
    for row in lit.rows[0]..lit.rows[1] {
        slopes::visit_row(map, row, |facet| {
            if lit.holds([facet.column, facet.row])
                && let Some(f) = facing(facet.p, facet.q, wi)
            {
                if f.wo.z > 0.0 {
                    sum.escaped(klems.index(wi, f.wo), 1, f.weight, 1.0);
                } else {
                    sum.lost(f.weight, 1.0);
                }
            }
        });
    }
    let tally = sum.tally();
    tally.energy.iter().map(|e| e / tally.incident).collect()
}

fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

fn check(file: &str, name: &str, theta_i: f64, largest_distance: f64) {
    let (Some((map, footprint)), Some([radiance, numpy])) = (load(file), columns(name)) else { return };
    let theta_i = theta_i.to_radians();
    let ours = single_bounce(&map, footprint, theta_i);
    let worst = ours.iter().zip(&numpy).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let options = Options {
        method: Method::Facets,
        material: Material::Mirror,
        theta_i: vec![theta_i],
        phi_i: vec![0.0],
        footprint: Some(footprint),
        ..Options::default()
    };
    let counting = Counting { partition: Partition::Klems, averaged: false };
    let counts = count(&map, &options, &counting, &mut Run::Whole, &|_| ()).unwrap();
    let d = &counts.directions[0];
    let shares: Vec<f64> = d.share.iter().map(|e| e.value).collect();
    let distance = total_variation(&shares, &radiance);
    let alone = total_variation(&ours, &radiance);
    let [one, two, more] = d.tally.bounce_fractions();
    println!(
        "{name}: single bounce off by {worst:.1e} at most; distance to Radiance {distance:.4} (single bounce {alone:.4}); \
         bounces {one:.4} {two:.4} {more:.4}, lost {:.4}, shadowed {:.4}; Radiance sums to {:.4}",
        d.tally.book().lost,
        d.tally.shadowed,
        radiance.iter().sum::<f64>(),
    );
    assert!(worst < 1e-6, "{name}: a patch is off by {worst}");
    assert!(distance <= largest_distance, "{name}: total-variation distance {distance}");
}

#[test]
fn al3d_1_at_normal_incidence() {
    check("real/al3d-1.al3d", "al3d-1_inc0_0", 0.0, 0.006);
}

#[test]
fn al3d_1_at_20_deg() {
    check("real/al3d-1.al3d", "al3d-1_inc20_0", 20.0, 0.006);
}

#[test]
fn x3p_2_at_20_deg() {
    check("real/x3p-2.x3p", "x3p-2_inc20_0", 20.0, 0.006);
}

#[test]
fn x3p_2_at_60_deg() {
    check("real/x3p-2.x3p", "x3p-2_inc60_0", 60.0, 0.006);
}

#[test]
fn di_1_where_a_tenth_bounces_more_than_once() {
    check("converted/di-1.x3p", "di-1_inc0_0", 0.0, 0.01);
}
