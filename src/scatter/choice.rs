//! Which method serves which incident direction, and the run over all of them.

use super::bounce::Walk;
use super::cells::{HalfVectorCells, TOLERANCE};
use super::facet_sum::{Azimuth, facet_sum};
use super::rays::trace_rays;
use super::selection::Selection;
use super::slope_histogram::SlopeDensity;
use super::tally::Tally;
use crate::error::{Error, Result};
use crate::facets::{HeightField, SlopeStatistics};
use crate::heightmap::HeightMap;
use crate::math::direction;
use crate::optics::Material;
use serde::{Deserialize, Serialize};

/// Facets that `auto` asks about visibility per incident polar angle, over all azimuths. The slope distribution comes from
/// all facets; only the visible share of each cell is estimated, to better than the map-to-map scatter.
const BEAMS_PER_ANGLE: u64 = 1 << 19;
/// ... but at least so many per direction.
const FEWEST_BEAMS: u64 = 1 << 16;

/// How to scatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The slope distribution alone where less than a tenth of the tolerance is hidden, the facet sum elsewhere.
    #[default]
    Auto,
    /// Facet sum with visibility at every incident angle.
    Facets,
    /// Naive rays at every incident angle.
    Rays,
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
    /// Incident polar angles \[rad\], rising, each in `[0, 90 deg)`.
    pub theta_i: Vec<f64>,
    /// Source azimuths \[rad\] of an anisotropic table; one node serves while nothing is hidden.
    pub phi_i: Vec<f64>,
    /// Share of the energy that may go unaccounted for.
    pub tolerance: f64,
    pub rays: u64,
    pub bounces: u32,
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        let degrees = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 86.0, 88.0];
        Options {
            method: Method::Auto,
            symmetry: Symmetry::Auto,
            material: Material::Dielectric { n: 1.5 },
            theta_i: degrees.map(f64::to_radians).to_vec(),
            phi_i: (0..12).map(|k| (30.0 * f64::from(k)).to_radians()).collect(),
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
        Ok(())
    }
}

/// What was done for one incident polar angle, and why.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    pub theta_i: f64,
    /// Facets or rays were tested for visibility; otherwise the slope distribution with Smith's masking served.
    pub visibility: bool,
    /// Share of the energy that Smith's function predicts to be hidden from source or exit.
    pub predicted_blocked: f64,
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
    pub statistics: SlopeStatistics,
    pub decisions: Vec<Decision>,
}

/// Runs `options.method` on `map` for every incident direction.
///
/// # Errors
/// `Error::Parameter` for a map without facets, or angles, rays, bounces outside their ranges.
pub fn scatter(map: &HeightMap, options: &Options, progress: &(dyn Fn(f64) + Sync)) -> Result<Scatter> {
    options.check()?;
    let statistics = SlopeStatistics::measure(map)?;
    let isotropic = match options.symmetry {
        Symmetry::Auto => statistics.looks_isotropic(),
        Symmetry::Isotropic => true,
        Symmetry::Anisotropic => false,
    };
    let cells = HalfVectorCells::for_lobe(&statistics, isotropic, options.tolerance);
    let density = SlopeDensity::measure(map, &cells, isotropic);
    let hiding = statistics.hiding();
    let decisions: Vec<Decision> = options
        .theta_i
        .iter()
        .map(|&theta_i| {
            // Geometry only: what a mirror would lose, in the worst of four azimuths.
            let predicted_blocked = (0..if isotropic { 1 } else { 4 })
                .map(|quarter| {
                    let wi = direction(theta_i, f64::from(quarter) * std::f64::consts::FRAC_PI_2);
                    density.tally(&cells, wi, &Material::Mirror, &hiding).book().lost
                })
                .fold(0.0, f64::max);
            let visibility = match options.method {
                Method::Auto => predicted_blocked > 0.1 * options.tolerance,
                Method::Facets | Method::Rays => true,
            };
            Decision { theta_i, visibility, predicted_blocked }
        })
        .collect();
    let any_visibility = decisions.iter().any(|d| d.visibility);
    let phi_i = if isotropic || !any_visibility { vec![0.0] } else { options.phi_i.clone() };
    let field = HeightField::new(map);
    let walk =
        Walk { field: &field, material: options.material, max_bounces: options.bounces, steepest: statistics.steepest };
    let share = match options.method {
        // Every azimuth of an anisotropic table asks its own facets, so fewer per azimuth do.
        Method::Auto => {
            let wanted = (BEAMS_PER_ANGLE / phi_i.len() as u64).max(FEWEST_BEAMS);
            wanted as f64 / statistics.facets as f64
        }
        Method::Facets | Method::Rays => 1.0,
    };
    let nodes = (decisions.len() * phi_i.len()) as f64;
    let mut done = 0.0;
    let mut tallies = Vec::with_capacity(decisions.len());
    for decision in &decisions {
        let mut row = Vec::with_capacity(phi_i.len());
        for &phi in &phi_i {
            let azimuth = if isotropic { Azimuth::Averaged } else { Azimuth::Fixed(phi) };
            let theta_i = decision.theta_i;
            row.push(match options.method {
                Method::Rays => {
                    trace_rays(&walk, &cells, theta_i, azimuth, options.rays, options.seed, &Selection::default())
                        .tally()
                }
                _ if decision.visibility => {
                    facet_sum(&walk, &cells, theta_i, azimuth, &Selection::share(share)).tally()
                }
                _ => density.tally(&cells, direction(theta_i, phi), &options.material, &hiding),
            });
            done += 1.0;
            progress(done / nodes);
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
        statistics,
        decisions,
    })
}
