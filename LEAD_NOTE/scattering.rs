//! Where the light of one incident direction goes: rays, facets, slopes, waves.

use super::contests::Subject;
use super::race::{Contest, Method, Outcome, Reference};
use crate::error::Result;
use crate::facets::distribution::Hiding;
use crate::facets::{HeightField, SlopeStatistics};
use crate::math::direction;
use crate::math::random::CounterRng;
use crate::sample::TableBrdf;
use crate::scatter::beam::Beam;
use crate::scatter::bounce::Walk;
use crate::scatter::facet_sum::{Azimuth, facet_sum};
use crate::scatter::kirchhoff::WaveField;
use crate::scatter::rays::trace_rays;
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::{Accumulator, Detectors, HalfVectorCells, Selection, Tally};
use rayon::prelude::*;

/// Relative error that the half-vector cells are laid out for: some hundreds of cells, enough to see the shape of the lobe.
const CELLS: f64 = 0.2;
/// Rays of the reference that everything but rays is held against.
const REFERENCE_RAYS: u64 = 1 << 22;
const BATCH: u64 = 1 << 13;

/// Shares of the incident energy per cell; the mirror beam last.
fn shares(tally: &Tally) -> Vec<f64> {
    let all = tally.energy.iter().copied().chain([tally.core]);
    all.map(|e| e / tally.incident.max(f64::MIN_POSITIVE)).collect()
}

/// Half the sum of all differences over the energy that escapes.
fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
    0.5 * difference / b.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Rays aimed at random points of the mean plane: the method of 2002, without patches.
fn random_rays(walk: &Walk, cells: &HalfVectorCells, theta_i: f64, rays: u64, seed: u64) -> Tally {
    let wi = direction(theta_i, 0.0);
    let beam = Beam::new(walk.field, wi, None);
    let sum = (0..rays.div_ceil(BATCH))
        .into_par_iter()
        .fold(
            || Accumulator::new(cells.len()),
            |mut sum, batch| {
                for ray in batch * BATCH..((batch + 1) * BATCH).min(rays) {
                    let [x, y, ..] = CounterRng::four(seed, 7, ray);
                    let Some(arrival) = beam.strike([x, y]) else { continue };
                    let end = walk.follow(arrival);
                    match end.escaped {
                        Some((wo, energy)) => sum.escaped(cells.index(wi, wo), end.bounces, 1.0, energy),
                        None => sum.lost(1.0, end.lost),
                    }
                }
                sum
            },
        )
        .reduce(|| Accumulator::new(cells.len()), Accumulator::merged);
    sum.tally()
}

struct Bench<'a> {
    subject: &'a Subject<'a>,
    statistics: SlopeStatistics,
    cells: HalfVectorCells,
    field: HeightField<'a>,
}

impl Bench<'_> {
    fn walk(&self) -> Walk<'_> {
        Walk {
            field: &self.field,
            material: self.subject.material,
            max_bounces: self.subject.bounces,
            steepest: self.statistics.steepest,
        }
    }

    fn rays(&self, rays: u64, seed: u64) -> Vec<f64> {
        let all = Selection::default();
        let azimuth = Azimuth::Fixed(0.0);
        shares(&trace_rays(&self.walk(), &self.cells, self.subject.theta_i, azimuth, rays, seed, &all).tally())
    }

    fn facets(&self, share: f64) -> Vec<f64> {
        let selection = Selection::share(share.min(1.0));
        shares(&facet_sum(&self.walk(), &self.cells, self.subject.theta_i, Azimuth::Fixed(0.0), &selection).tally())
    }

    fn slopes(&self, hiding: &Hiding) -> Vec<f64> {
        let density = SlopeDensity::measure(self.subject.map, &self.cells, false);
        let wi = direction(self.subject.theta_i, 0.0);
        shares(&density.tally(&self.cells, wi, &self.subject.material, hiding))
    }

    fn waves(&self) -> Vec<f64> {
        let Subject { map, wave, theta_i, material, .. } = self.subject;
        let field = WaveField::new(map, &self.statistics, *wave);
        let cos = theta_i.cos();
        let density = field.density(&self.cells, false, [cos, cos], &|_| ());
        let (mirror, _) = field.mirror_share(field.v_z(cos, cos));
        let hiding = self.statistics.hiding();
        shares(&density.tally(&self.cells, direction(*theta_i, 0.0), mirror, material, &hiding))
    }
}

/// Rays are held against the facet sum, which has no noise; the facet sum and all others against rays.
pub fn contest<'a>(subject: &'a Subject<'a>, _: &'a TableBrdf) -> Result<Contest<'a>> {
    let statistics = SlopeStatistics::measure(subject.map)?;
    let cells = HalfVectorCells::for_lobe(&statistics, false, CELLS);
    let facets = statistics.facets as f64;
    let bench = std::sync::Arc::new(Bench { subject, statistics, cells, field: HeightField::new(subject.map) });
    let halves = [1, 2].map(|k| bench.rays(REFERENCE_RAYS / 2, subject.seed ^ (0x5EED << k)));
    // Two halves differ by twice what their mean is off.
    let noise = 0.5 * total_variation(&halves[0], &halves[1]);
    let mean = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let references = vec![
        Reference { name: "facet sum with visibility, all facets".into(), values: bench.facets(1.0), noise: 0.0 },
        Reference { name: format!("naive rays, {REFERENCE_RAYS}"), values: mean, noise },
    ];
    let decades = |from: i32, to: i32| (from..=to).map(|e| 10f64.powi(e)).collect::<Vec<_>>();
    let by = |reference: usize, name: &str, ladder: Vec<f64>, chosen: Option<f64>, random: bool, run| Method {
        name: name.to_owned(),
        ladder,
        chosen,
        random,
        reference,
        run,
    };
    let with = |run: fn(&Bench, f64, u64) -> Vec<f64>| -> super::race::Run<'a> {
        let bench = bench.clone();
        Box::new(move |effort, seed| Ok(Outcome::from(run(&bench, effort, seed))))
    };
    let thinned: Vec<f64> = (0..6).rev().map(|k| (facets / 4f64.powi(k)).round()).collect();
    let methods = vec![
        by(0, "naive rays, random", decades(3, 8), None, true, with(|b, n, seed| {
            shares(&random_rays(&b.walk(), &b.cells, b.subject.theta_i, n as u64, seed))
        })),
        by(0, "naive rays, stratified", decades(3, 8), Some(1e6), true, with(|b, n, seed| b.rays(n as u64, seed))),
        by(1, "facet sum with visibility", thinned, Some(facets), false, with(|b, n, _| {
            b.facets(n / b.statistics.facets as f64)
        })),
        by(1, "slopes, Smith's masking", vec![facets], Some(facets), false, with(|b, _, _| {
            b.slopes(&b.statistics.hiding())
        })),
        by(1, "slopes, nothing hidden", vec![facets], None, false, with(|b, _, _| b.slopes(&Hiding::tabulate(|_| 0.0)))),
        by(1, "phase integral (Kirchhoff)", vec![facets], Some(facets), false, with(|b, _, _| b.waves())),
    ];
    Ok(Contest {
        key: "scattering",
        title: format!("Scattering at {:.0}\u{b0}: {}", subject.theta_i.to_degrees(), subject.name),
        error: "total variation over half-vector cells",
        effort: "rays or facets",
        size: None,
        references,
        methods,
        distance: total_variation,
    })
}
