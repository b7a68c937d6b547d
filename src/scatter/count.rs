//! Counting into any detectors: one incident direction after the other, the map in sub-areas.

use super::accumulator::Accumulator;
use super::bounce::Walk;
use super::choice::{Method, Options};
use super::count_wave::WaveCount;
use super::decision::{Decision, Judge, wave_cosines};
use super::detectors::{Detectors, Partition};
use super::facet_sum::{Azimuth, facet_sum};
use super::kirchhoff::WaveField;
use super::ratio::Ratio;
use super::rays::trace_rays;
use super::run::{Run, fingerprint};
use super::selection::{Footprint, Selection};
use super::slope_histogram::{SUBAREAS_PER_AXIS, SlopeDensity};
use super::tally::Tally;
use super::warning::{self, Warning};
use crate::error::{Error, Result};
use crate::facets::{HeightField, SlopeStatistics};
use crate::heightmap::HeightMap;
use crate::math::{Estimate, direction, reflect};
use glam::DVec3;

/// What to count into, and from where.
#[derive(Debug, Clone, PartialEq)]
pub struct Counting {
    pub partition: Partition,
    /// Average over the azimuth of the source; detectors then lie in its frame.
    pub averaged: bool,
}

/// Shares of the energy in every detector, for every incident direction.
pub struct Counts {
    pub detectors: Box<dyn Detectors>,
    /// `theta_i` outside, `phi_i` inside.
    pub directions: Vec<Direction>,
    /// What served each `theta_i`, and why.
    pub decisions: Vec<Decision>,
    pub statistics: SlopeStatistics,
    pub warnings: Vec<Warning>,
}

/// One incident direction.
#[derive(Debug, Clone)]
pub struct Direction {
    /// \[rad\]
    pub theta_i: f64,
    /// \[rad\]
    pub phi_i: f64,
    /// The specular core lies in the detector of the mean normal's mirror direction.
    pub tally: Tally,
    /// Share of the incident energy that escaped.
    pub albedo: Estimate,
    /// Share of the incident energy per detector.
    pub share: Vec<Estimate>,
    /// Projected solid angle per detector \[sr\].
    pub projected_solid_angle: Vec<f64>,
}

impl Direction {
    /// `f_r = E_k / Omega_p,k` \[1/sr\], the mean over the detector. For a detector that nothing reached the standard error is
    /// the 95 % bound `3 / (N Omega_p,k)` of N beams (rule of three); 0 where no direction is above the horizon.
    pub fn f_r(&self, detector: usize) -> Estimate {
        let omega = self.projected_solid_angle[detector];
        if omega <= 0.0 {
            return Estimate::exact(0.0);
        }
        let share = self.share[detector];
        // Waves have no beams.
        let standard_error = if self.tally.hits.get(detector) == Some(&0) && share.value == 0.0 {
            3.0 / (self.tally.beams.max(1) as f64 * omega)
        } else {
            share.standard_error / omega
        };
        Estimate { value: share.value / omega, standard_error }
    }
}

/// Counts the light of every `options.theta_i` and `options.phi_i`: by waves where [`Method::Auto`] finds them to be needed, or
/// [`Method::Kirchhoff`] asks for them, by naive rays for [`Method::Rays`], else by the facet sum with visibility.
///
/// Every sub-area of the lit cells is counted on its own; their scatter is the standard error, which so holds both the
/// noise of rays, or the speckle of waves, and the scatter of the surface from place to place.
///
/// # Errors
/// `Error::Parameter` for a map without facets, options out of range, or sums in `run` that are not of this map.
pub fn count(
    map: &HeightMap,
    options: &Options,
    counting: &Counting,
    run: &mut Run,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Counts> {
    options.check()?;
    let cut = options.footprint.map(|footprint| footprint.cut(map));
    let lit_map = cut.as_ref().unwrap_or(map);
    let statistics = SlopeStatistics::measure(lit_map)?;
    let judge = Judge::new(lit_map, &statistics, options, counting.averaged);
    let mut decisions = judge.decide_all();
    let waves = wave_cosines(&decisions);
    let wave_field = waves.map(|_| WaveField::new(lit_map, &statistics, options.wave));
    let cells = judge.cells(&decisions, wave_field.as_ref());
    let hiding = statistics.hiding();
    let density = SlopeDensity::measure(lit_map, &cells, counting.averaged);
    for decision in &mut decisions {
        judge.ask_visibility(decision, &density, &cells, &hiding);
        decision.visibility = !decision.wave;
    }
    let detectors: Box<dyn Detectors> = match counting.partition {
        Partition::HalfVector => Box::new(cells),
        other => other.detectors(&statistics, counting.averaged)?,
    };
    let field = HeightField::new(map);
    let whole = Footprint::whole(field.cells());
    let lit = options.footprint.unwrap_or(whole);
    let subareas = subareas(lit);
    let phis = if counting.averaged { &[0.0][..] } else { &options.phi_i };
    let of = |wave: bool| -> Vec<(f64, f64)> {
        let served = decisions.iter().filter(|d| d.wave == wave);
        served.flat_map(|d| phis.iter().map(|&phi_i| (d.theta_i, phi_i))).collect()
    };
    let (traced, waved) = (of(false), of(true));
    let items = traced.len() * subareas.len();
    run.check(&fingerprint(map, options, &format!("{counting:?}")), items)?;
    let steepest = if cut.is_some() { SlopeStatistics::measure(map)?.steepest } else { statistics.steepest };
    let walk = Walk { field: &field, material: options.material, max_bounces: options.bounces, steepest };
    let traced_part = traced.len() as f64 / (traced.len() + waved.len()) as f64;
    let mut done = 0.0;
    let mut directions = Vec::new();
    for (theta_i, phi_i) in traced {
        let azimuth = if counting.averaged { Azimuth::Averaged } else { Azimuth::Fixed(phi_i) };
        let mut sum = Accumulator::new(detectors.len());
        let mut ratio = Ratio::new(detectors.len());
        for (k, &piece) in subareas.iter().enumerate() {
            // One piece that is the whole map needs no test where a ray came from.
            let footprint = (piece != whole).then_some(piece);
            let part = run.sum(|part| {
                let selection = Selection { share: 1.0, part, footprint };
                match options.method {
                    Method::Rays => {
                        let n = subareas.len() as u64;
                        let rays = options.rays / n + u64::from((k as u64) < options.rays % n);
                        let seed = options.seed.wrapping_add(k as u64 * 0x9E37_79B9_7F4A_7C15);
                        trace_rays(&walk, detectors.as_ref(), theta_i, azimuth, rays, seed, &selection)
                    }
                    _ => facet_sum(&walk, detectors.as_ref(), theta_i, azimuth, &selection),
                }
            });
            let tally = part.tally();
            ratio.add(&tally.energy, tally.book().escaped * tally.incident, tally.incident);
            sum.merge(&part);
            done += traced_part;
            progress(done / items as f64);
        }
        directions.push(finish(theta_i, phi_i, detectors.as_ref(), sum.tally(), &ratio));
    }
    if run.is_whole() && directions.iter().any(|d| d.tally.beams == 0) {
        return Err(Error::parameter(
            "no beam met a lit facet",
            "light more of the map: --footprint holds no measured facet that faces the source",
        ));
    }
    let mut warnings = Vec::new();
    if run.is_whole() {
        for d in &directions {
            warnings.extend(warning::of_tally(d.theta_i, &d.tally, options.tolerance));
            warnings.extend(warning::of_border(&field, &statistics, d.theta_i, &d.tally, lit, options.tolerance));
        }
        warnings.extend(warning::of_walls(map, &statistics, lit));
        warnings.extend(warning::of_detectors(detectors.as_ref(), &statistics, &options.theta_i));
    }
    // Parts share beams; a wave is whole or not at all.
    if let (Some(field), Some(range), true) = (&wave_field, waves, run.is_whole()) {
        let (detectors, material) = (detectors.as_ref(), options.material);
        let count = WaveCount { field, detectors, material, hiding: &hiding, averaged: counting.averaged, range };
        directions.extend(count.run(&waved, &|share| progress(traced_part + (1.0 - traced_part) * share)));
        // In the order they were asked for.
        directions.sort_by(|a, b| (a.theta_i, a.phi_i).partial_cmp(&(b.theta_i, b.phi_i)).expect("angles are numbers"));
        for decision in decisions.iter_mut().filter(|d| d.wave) {
            let there = directions.iter().filter(|d| d.theta_i == decision.theta_i);
            decision.unfollowed = there.map(|d| d.tally.lost).fold(0.0, f64::max);
        }
    }
    Ok(Counts { detectors, directions, decisions, statistics, warnings })
}

/// 4 x 4 pieces of the lit cells, fewer if there are few cells.
fn subareas(lit: Footprint) -> Vec<Footprint> {
    let across = SUBAREAS_PER_AXIS;
    let pieces = (0..across * across).map(|k| lit.piece(k % across, k / across, across));
    pieces.filter(|piece| !piece.is_empty()).collect()
}

/// A share with its standard error over sub-areas; one alone falls back on its beams.
fn estimate(ratio: &Ratio, tally: &Tally, k: usize, value: f64) -> Estimate {
    match ratio.standard_error(k, value) {
        Some(standard_error) => Estimate { value, standard_error },
        None => tally.hits.get(k).map_or(Estimate::exact(value), |_| tally.fraction(k)),
    }
}

fn finish(theta_i: f64, phi_i: f64, detectors: &dyn Detectors, mut tally: Tally, ratio: &Ratio) -> Direction {
    let wi = direction(theta_i, phi_i);
    let mut share: Vec<Estimate> =
        (0..detectors.len()).map(|k| estimate(ratio, &tally, k, tally.fraction(k).value)).collect();
    let albedo = estimate(ratio, &tally, detectors.len(), tally.book().escaped);
    if tally.core > 0.0 {
        let k = detectors.index(wi, reflect(wi, DVec3::Z));
        tally.energy[k] += tally.core;
        tally.by_bounce[k][0] += tally.core;
        share[k].value = tally.energy[k] / tally.incident;
        tally.core = 0.0;
    }
    let projected_solid_angle = (0..detectors.len()).map(|k| detectors.projected_solid_angle(k, wi)).collect();
    Direction { theta_i, phi_i, tally, albedo, share, projected_solid_angle }
}
