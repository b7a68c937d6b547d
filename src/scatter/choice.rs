//! How to scatter, and the run over all incident directions.

use super::bounce::Walk;
use super::cells::{HalfVectorCells, TOLERANCE};
use super::decision::{Decision, Judge, wave_cosines};
use super::facet_sum::{Azimuth, facet_sum};
use super::kirchhoff::{Wave, WaveDensity, WaveField};
use super::rays::trace_rays;
use super::run::{Run, fingerprint};
use super::selection::{Footprint, Selection, enough};
use super::slope_histogram::SlopeDensity;
use super::tally::Tally;
use crate::error::{Error, Result};
use crate::facets::{HeightField, SlopeStatistics};
use crate::heightmap::HeightMap;
use crate::math::direction;
use crate::optics::Material;
use serde::{Deserialize, Serialize};

/// Facets that `auto` asks about visibility at least, per incident polar angle of an average over azimuths and per direction
/// otherwise; more where the tolerance asks for them. The slope distribution comes from all facets; only the visible share of
/// each cell is estimated.
const FEWEST_AVERAGED: u64 = 1 << 19;
const FEWEST_FIXED: u64 = 1 << 16;

/// How to scatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Per incident angle the cheapest that holds: [`Method::Kirchhoff`] where the Rayleigh parameter is below 9, elsewhere
    /// [`Method::Geometric`].
    #[default]
    Auto,
    /// Rays only: the slope distribution alone where less than a tenth of the tolerance is hidden, the facet sum elsewhere.
    Geometric,
    /// Facet sum with visibility at every incident angle.
    Facets,
    /// Naive rays at every incident angle.
    Rays,
    /// Phase integral of the map at every incident angle, with its mirror beam as the specular core.
    Kirchhoff,
}

/// Whether the table depends on the azimuth of the source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Isotropic if the principal slopes agree within 15 % and no tilt is left.
    #[default]
    Auto,
    Isotropic,
    Anisotropic,
}

/// Settings of a scatter run.
#[derive(Debug, Clone)]
pub struct Options {
    pub method: Method,
    pub symmetry: Symmetry,
    pub material: Material,
    /// Light by which rays are judged, and that of the wave calculation.
    pub wave: Wave,
    /// Incident polar angles \[rad\], rising, each in `[0, 90 deg)`.
    pub theta_i: Vec<f64>,
    /// Source azimuths \[rad\] of an anisotropic table.
    pub phi_i: Vec<f64>,
    /// Keep all of them even where no visibility is traced: facets then have one density for every azimuth, and a single node
    /// serves.
    pub all_phi_i: bool,
    /// Cells that are lit; the rest of the map shadows and reflects. `None` lights all.
    pub footprint: Option<Footprint>,
    /// Share of the energy that may go unaccounted for.
    pub tolerance: f64,
    pub rays: u64,
    pub bounces: u32,
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        let degrees = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 85.0, 86.0, 88.0];
        Options {
            method: Method::Auto,
            symmetry: Symmetry::Auto,
            material: Material::Dielectric { n: 1.5 },
            wave: Wave::default(),
            theta_i: degrees.map(f64::to_radians).to_vec(),
            phi_i: (0..12).map(|k| (30.0 * f64::from(k)).to_radians()).collect(),
            all_phi_i: false,
            footprint: None,
            tolerance: TOLERANCE,
            rays: 1_000_000,
            bounces: 8,
            seed: 1,
        }
    }
}

impl Options {
    /// Whether angles, rays, bounces and tolerance lie in their ranges.
    ///
    /// # Errors
    /// `Error::Parameter` with the first that does not.
    pub fn check(&self) -> Result<()> {
        let rising = |v: &[f64]| v.windows(2).all(|w| w[0] < w[1]);
        let bad = |what: String, advice: &str| Err(Error::parameter(what, advice));
        if self.theta_i.is_empty()
            || !rising(&self.theta_i)
            || self.theta_i.iter().any(|&t| !(0.0..89.95f64.to_radians()).contains(&t))
        {
            return bad("the incident angles are not a rising list".into(), "give --theta-i between 0 and 89.9 deg");
        }
        if self.phi_i.is_empty()
            || !rising(&self.phi_i)
            || self.phi_i.iter().any(|&p| !(0.0..std::f64::consts::TAU).contains(&p))
        {
            return bad("the source azimuths are not a rising list".into(), "give --phi-i between 0 and 359.9 deg");
        }
        if self.rays == 0 || self.bounces == 0 {
            return bad("no ray would be counted".into(), "give --rays and --bounces of at least 1");
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return bad(format!("tolerance {} is not a share", self.tolerance), "give --tolerance between 0 and 1");
        }
        let Wave { wavelength, band, source } = self.wave;
        if !(wavelength > 0.0 && wavelength.is_finite() && band >= 0.0 && band < wavelength) {
            return bad("the wavelength or its band is out of range".into(), "give --wavelength such as 550nm");
        }
        if !(0.0..0.5).contains(&source) {
            return bad("the source is wider than a wave table can average".into(), "give a full angle below 28 deg");
        }
        Ok(())
    }
}

/// The scattered energy of a map over all incident directions.
#[derive(Debug, Clone)]
pub struct Scatter {
    pub cells: HalfVectorCells,
    pub isotropic: bool,
    pub material: Material,
    pub method: Method,
    pub theta_i: Vec<f64>,
    /// One azimuth 0 if isotropic.
    pub phi_i: Vec<f64>,
    /// `tallies[theta][phi]`.
    pub tallies: Vec<Vec<Tally>>,
    pub density: SlopeDensity,
    /// The lobe of the wave where a decision was for it.
    pub wave: Option<WaveDensity>,
    /// Relative standard error of the mirror beam per incident angle; 0 for rays.
    pub core_error: Vec<f64>,
    pub statistics: SlopeStatistics,
    pub decisions: Vec<Decision>,
}

/// Runs `options.method` on `map` for every incident direction.
///
/// # Errors
/// `Error::Parameter` for a map without facets, or angles, rays, bounces outside their ranges.
pub fn scatter(map: &HeightMap, options: &Options, progress: &(dyn Fn(f64) + Sync)) -> Result<Scatter> {
    scatter_run(map, options, &mut Run::Whole, progress)
}

/// As [`scatter()`], but a part of it, or with the sums of all parts instead of beams.
///
/// # Errors
/// As [`scatter()`]; also if the parts in `run` are not of this map and these options.
pub fn scatter_run(
    map: &HeightMap,
    options: &Options,
    run: &mut Run,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Scatter> {
    options.check()?;
    let part = options.footprint.map(|footprint| footprint.cut(map));
    let lit = part.as_ref().unwrap_or(map);
    let statistics = SlopeStatistics::measure(lit)?;
    let isotropic = match options.symmetry {
        Symmetry::Auto => statistics.looks_isotropic(),
        Symmetry::Isotropic => true,
        Symmetry::Anisotropic => false,
    };
    let judge = Judge::new(lit, &statistics, options, isotropic);
    let mut decisions = judge.decide_all();
    let waves = wave_cosines(&decisions);
    let field = waves.map(|_| WaveField::new(lit, &statistics, options.wave));
    let cells = judge.cells(&decisions, field.as_ref());
    let density = SlopeDensity::measure(lit, &cells, isotropic);
    let hiding = statistics.hiding();
    for decision in &mut decisions {
        judge.ask_visibility(decision, &density, &cells, &hiding);
    }
    let any_visibility = decisions.iter().any(|d| d.visibility);
    let phi_i = match isotropic {
        false if any_visibility || options.all_phi_i => options.phi_i.clone(),
        _ => vec![0.0],
    };
    let heights = HeightField::new(map);
    let walk = Walk {
        field: &heights,
        material: options.material,
        max_bounces: options.bounces,
        steepest: if part.is_some() { SlopeStatistics::measure(map)?.steepest } else { statistics.steepest },
    };
    for decision in &mut decisions {
        let hidden = decision.predicted_shadowed + decision.predicted_blocked;
        let enough = enough(hidden, options.tolerance, statistics.facets, isotropic);
        decision.asked = match options.method {
            _ if !decision.visibility => 0.0,
            Method::Auto | Method::Geometric | Method::Kirchhoff => {
                let fewest = if isotropic { FEWEST_AVERAGED } else { FEWEST_FIXED };
                (fewest as f64 / statistics.facets as f64).min(1.0).max(enough)
            }
            Method::Facets => enough.max(1.0),
            Method::Rays => 1.0,
        };
    }
    let nodes = (decisions.len() * phi_i.len()) as f64;
    run.check(&fingerprint(map, options, "table"), phi_i.len() * decisions.iter().filter(|d| d.visibility).count())?;
    // The slices of the wave take longer than all that is made of them.
    let wave_part = if field.is_some() { 0.8 } else { 0.0 };
    let wave = field
        .as_ref()
        .zip(waves)
        .map(|(field, range)| field.density(&cells, isotropic, range, &|share| progress(wave_part * share)));
    let mut core_error = Vec::with_capacity(decisions.len());
    let mut done = 0.0;
    let mut tallies = Vec::with_capacity(decisions.len());
    for decision in &mut decisions {
        let mut row = Vec::with_capacity(phi_i.len());
        let cos = decision.theta_i.cos();
        let (mirror, mirror_error) = match &field {
            Some(field) if decision.wave => field.mirror_share(field.v_z(cos, cos)),
            _ => (0.0, 0.0),
        };
        core_error.push(mirror_error);
        for &phi in &phi_i {
            let azimuth = if isotropic { Azimuth::Averaged } else { Azimuth::Fixed(phi) };
            let theta_i = decision.theta_i;
            let tally = if let Some(wave) = wave.as_ref().filter(|_| decision.wave) {
                wave.tally(&cells, direction(theta_i, phi), mirror, &options.material, &hiding)
            } else if decision.visibility {
                let sum = run.sum(|part| {
                    let selection = Selection { share: decision.asked, part, footprint: options.footprint };
                    if options.method == Method::Rays {
                        trace_rays(&walk, &cells, theta_i, azimuth, options.rays, options.seed, &selection)
                    } else {
                        facet_sum(&walk, &cells, theta_i, azimuth, &selection)
                    }
                });
                sum.tally()
            } else {
                density.tally(&cells, direction(theta_i, phi), &options.material, &hiding)
            };
            row.push(tally);
            done += 1.0;
            progress(wave_part + (1.0 - wave_part) * done / nodes);
        }
        if decision.wave {
            decision.unfollowed = row.iter().map(|tally: &Tally| tally.book().lost).fold(0.0, f64::max);
        }
        tallies.push(row);
    }
    Ok(Scatter {
        cells,
        isotropic,
        material: options.material,
        method: options.method,
        theta_i: options.theta_i.clone(),
        phi_i,
        tallies,
        density,
        wave,
        core_error,
        statistics,
        decisions,
    })
}
