//! Counting into any detectors: one incident direction after the other, the map in sub-areas.

use super::accumulator::Accumulator;
use super::bounce::Walk;
use super::choice::{Method, Options};
use super::detectors::{Detectors, Partition};
use super::facet_sum::{Azimuth, facet_sum};
use super::rays::trace_rays;
use super::run::{Run, fingerprint};
use super::selection::{Footprint, Selection};
use super::slope_histogram::SUBAREAS_PER_AXIS;
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
    /// Cells that are lit; the rest of the map shadows and reflects.
    pub footprint: Option<Footprint>,
    /// Average over the azimuth of the source; detectors then lie in its frame.
    pub averaged: bool,
}

/// Shares of the energy in every detector, for every incident direction.
pub struct Counts {
    pub detectors: Box<dyn Detectors>,
    /// `theta_i` outside, `phi_i` inside.
    pub directions: Vec<Direction>,
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
        let standard_error = if self.tally.hits[detector] == 0 && share.value == 0.0 {
            3.0 / (self.tally.beams.max(1) as f64 * omega)
        } else {
            share.standard_error / omega
        };
        Estimate { value: share.value / omega, standard_error }
    }
}

/// Counts the light of every `options.theta_i` and `options.phi_i` by [`Method::Rays`] if that is asked for, by the facet
/// sum otherwise.
///
/// Every sub-area of the lit cells is counted on its own; their scatter is the standard error, which so holds both the
/// noise of rays and the scatter of the surface from place to place.
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
    if options.method == Method::Kirchhoff {
        return Err(Error::parameter(
            "waves are not counted into these detectors",
            "make a table (-o T.npz) and read it with `asperity eval`, or count with --method facets or rays",
        ));
    }
    let statistics = SlopeStatistics::measure(map)?;
    let detectors = counting.partition.detectors(&statistics, counting.averaged)?;
    let field = HeightField::new(map);
    let whole = Footprint::whole(field.cells());
    let lit = counting.footprint.unwrap_or(whole);
    let subareas = subareas(lit);
    let phis = if counting.averaged { &[0.0][..] } else { &options.phi_i };
    let items = options.theta_i.len() * phis.len() * subareas.len();
    run.check(&fingerprint(map, options, &format!("{counting:?}")), items)?;
    let walk =
        Walk { field: &field, material: options.material, max_bounces: options.bounces, steepest: statistics.steepest };
    let mut done = 0.0;
    let mut directions = Vec::new();
    for &theta_i in &options.theta_i {
        for &phi_i in phis {
            let azimuth = if counting.averaged { Azimuth::Averaged } else { Azimuth::Fixed(phi_i) };
            let mut sum = Accumulator::new(detectors.len());
            let mut scatter = Scatter::new(detectors.len());
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
                scatter.add(&part.tally());
                sum.merge(&part);
                done += 1.0;
                progress(done / items as f64);
            }
            directions.push(finish(theta_i, phi_i, detectors.as_ref(), sum.tally(), &scatter));
        }
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
    Ok(Counts { detectors, directions, statistics, warnings })
}

/// 4 x 4 pieces of the lit cells, fewer if there are few cells.
fn subareas(lit: Footprint) -> Vec<Footprint> {
    let across = SUBAREAS_PER_AXIS;
    let pieces = (0..across * across).map(|k| lit.piece(k % across, k / across, across));
    pieces.filter(|piece| !piece.is_empty()).collect()
}

/// Scatter over sub-areas: sums of `d_s^2`, `d_s I_s` and `I_s^2` with all `I_s` that came in and `d_s = E_s - first I_s`, the
/// energy of a detector against its share in the first sub-area. The shift keeps the digits when all are alike.
struct Scatter {
    first: Vec<f64>,
    squares: Vec<f64>,
    cross: Vec<f64>,
    incident2: f64,
    places: f64,
}

impl Scatter {
    /// The last place counts all that escaped.
    fn new(detectors: usize) -> Self {
        let zero = vec![0.0; detectors + 1];
        Scatter { first: zero.clone(), squares: zero.clone(), cross: zero, incident2: 0.0, places: 0.0 }
    }

    fn add(&mut self, tally: &Tally) {
        let incident = tally.incident;
        if incident <= 0.0 {
            return;
        }
        self.places += 1.0;
        self.incident2 += incident * incident;
        let all = tally.book().escaped * incident;
        for (k, &e) in tally.energy.iter().chain([&all]).enumerate() {
            if self.places == 1.0 {
                self.first[k] = e / incident;
            } else {
                let d = e - self.first[k] * incident;
                self.squares[k] += d * d;
                self.cross[k] += d * incident;
            }
        }
    }

    /// Standard error of the ratio `R = sum E / sum I` of n sub-areas: `sqrt(n / (n - 1) sum (E_s - R I_s)^2) / sum I`
    /// (Cochran, Sampling Techniques, 1977, eq. 6.9). One place alone falls back on its beams.
    fn estimate(&self, tally: &Tally, k: usize, r: f64) -> Estimate {
        if self.places < 2.0 {
            return tally.hits.get(k).map_or(Estimate::exact(r), |_| tally.fraction(k));
        }
        let shift = r - self.first[k];
        let squares = self.squares[k] - 2.0 * shift * self.cross[k] + shift * shift * self.incident2;
        let standard_error = (self.places / (self.places - 1.0) * squares.max(0.0)).sqrt() / tally.incident;
        Estimate { value: r, standard_error }
    }
}

fn finish(theta_i: f64, phi_i: f64, detectors: &dyn Detectors, mut tally: Tally, scatter: &Scatter) -> Direction {
    let wi = direction(theta_i, phi_i);
    let mut share: Vec<Estimate> =
        (0..detectors.len()).map(|k| scatter.estimate(&tally, k, tally.fraction(k).value)).collect();
    let albedo = scatter.estimate(&tally, detectors.len(), tally.book().escaped);
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
