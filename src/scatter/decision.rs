//! Which method serves which incident angle, and why.

use super::cells::HalfVectorCells;
use super::choice::{Method, Options};
use super::kirchhoff::{SMALLEST_FOR_RAYS, TangentPlane, WaveField, rayleigh_parameter};
use super::slope_histogram::SlopeDensity;
use crate::facets::SlopeStatistics;
use crate::facets::distribution::Hiding;
use crate::heightmap::{HeightMap, parameters};
use crate::math::direction;
use crate::optics::Material;
use serde::{Deserialize, Serialize};

/// What was done for one incident polar angle, and the numbers it was decided by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    pub theta_i: f64,
    /// The phase integral of the map served (Kirchhoff).
    pub wave: bool,
    /// Facets or rays were tested for visibility; otherwise the slope distribution with Smith's masking served, or the wave.
    pub visibility: bool,
    /// Rayleigh parameter `(4 pi Sq cos_theta / lambda)^2` at specular reflection: `exp(-g)` of the light stays a mirror beam.
    pub rayleigh: f64,
    /// Share of the facets, by projected area, that Smith's function predicts to lie in shadow.
    pub predicted_shadowed: f64,
    /// Share of the energy that Smith's function predicts to be hidden from the exit, that is to bounce more than once.
    pub predicted_blocked: f64,
    /// Share of the facets too steep for the map's pitch: their phase changes by more than half a turn between two points.
    pub undersampled: f64,
    /// `4 pi r cos_theta / lambda` with the radius of curvature r; the tangent plane of the wave calculation asks for more than 1.
    pub tangent_plane: f64,
    /// Share of the light that the wave calculation does not follow: hidden by Smith's factor or sent below the horizon.
    pub unfollowed: f64,
    /// Share of the facets that were asked about visibility; above 1: all, each for so many azimuths of the source.
    #[serde(default)]
    pub asked: f64,
    /// Largest hidden share that the slope distribution may leave to Smith's function: a tenth of the tolerance.
    pub limit: f64,
}

impl std::fmt::Display for Decision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let g = self.rayleigh;
        let hidden = format!(
            "{:.3} % predicted in shadow, {:.3} % to bounce again",
            100.0 * self.predicted_shadowed,
            100.0 * self.predicted_blocked
        );
        if self.wave {
            let below = if g < SMALLEST_FOR_RAYS { "below" } else { "not below" };
            return write!(
                f,
                "wave (Kirchhoff): g = {g:.3} is {below} {SMALLEST_FOR_RAYS}, exp(-g) = {:.3} % of the light a mirror beam; \
                 {hidden}, left to Smith's factor",
                100.0 * (-g).exp()
            );
        }
        let needed = self.predicted_blocked > self.limit;
        let against = if needed { "above" } else { "not above" };
        let how = match (self.visibility, needed) {
            (true, true) => "rays, visibility traced",
            (true, false) => "rays, visibility traced without need",
            (false, _) => "rays, slope distribution",
        };
        write!(f, "{how}: {hidden}, {against} {:.3} %; g = {g:.3}", 100.0 * self.limit)?;
        match self.asked {
            // Rays ask no facet, and of all there is nothing to say.
            share if share == 0.0 || share == 1.0 => Ok(()),
            share if share < 1.0 => write!(f, "; {:.1} % of the facets asked", 100.0 * share),
            azimuths => write!(f, "; every facet asked for {azimuths:.0} azimuths of the source"),
        }
    }
}

/// What decisions are made from.
pub(super) struct Judge<'a> {
    /// Root-mean-square height \[m\].
    sq: f64,
    options: &'a Options,
    statistics: &'a SlopeStatistics,
    plane: TangentPlane,
    isotropic: bool,
}

impl<'a> Judge<'a> {
    /// Of the lit part of a map.
    pub fn new(map: &HeightMap, statistics: &'a SlopeStatistics, options: &'a Options, isotropic: bool) -> Self {
        Judge { sq: parameters::sq(map), options, statistics, plane: TangentPlane::measure(map), isotropic }
    }

    /// Rays or wave, for every incident angle.
    pub fn decide_all(&self) -> Vec<Decision> {
        self.options.theta_i.iter().map(|&theta_i| self.decide(theta_i)).collect()
    }

    /// Cells in the plane of the half vector that follow the lobes, that of a wave too where one serves.
    pub fn cells(&self, decisions: &[Decision], field: Option<&WaveField>) -> HalfVectorCells {
        let (statistics, isotropic, tolerance) = (self.statistics, self.isotropic, self.options.tolerance);
        let Some(field) = field else { return HalfVectorCells::for_lobe(statistics, isotropic, tolerance) };
        let cosines = decisions.iter().filter(|d| d.wave).map(|d| d.theta_i.cos());
        let steepest = cosines.fold(0.0, f64::max);
        // The lobe of a wave is narrowest, in slope, where v_z is largest.
        let wave = field.lobe_core(field.v_z(steepest, steepest), statistics, isotropic);
        let core = if decisions.iter().all(|d| d.wave) { wave } else { wave.min(statistics.core) };
        HalfVectorCells::for_core(statistics, core, isotropic, tolerance)
    }

    /// Rays or wave: decided by the Rayleigh parameter alone, since below 9 no ray method holds. An exactly flat map is a mirror
    /// to both.
    fn decide(&self, theta_i: f64) -> Decision {
        let wavelength = self.options.wave.wavelength;
        let rayleigh = rayleigh_parameter(self.sq, theta_i, wavelength);
        Decision {
            theta_i,
            wave: match self.options.method {
                Method::Auto => self.sq > 0.0 && rayleigh < SMALLEST_FOR_RAYS,
                Method::Kirchhoff => true,
                Method::Geometric | Method::Facets | Method::Rays => false,
            },
            visibility: false,
            rayleigh,
            predicted_shadowed: 0.0,
            predicted_blocked: 0.0,
            undersampled: self.plane.undersampled(self.statistics, theta_i, wavelength),
            tangent_plane: self.plane.brekhovskikh(theta_i, wavelength),
            unfollowed: 0.0,
            asked: 0.0,
            limit: 0.1 * self.options.tolerance,
        }
    }

    /// Smith's predictions, and for rays whether visibility is to be traced.
    pub fn ask_visibility(
        &self,
        decision: &mut Decision,
        density: &SlopeDensity,
        cells: &HalfVectorCells,
        hiding: &Hiding,
    ) {
        // Geometry only: what a mirror would lose, in the worst of four azimuths.
        decision.predicted_blocked = (0..if self.isotropic { 1 } else { 4 })
            .map(|quarter| {
                let wi = direction(decision.theta_i, f64::from(quarter) * std::f64::consts::FRAC_PI_2);
                density.tally(cells, wi, &Material::Mirror, hiding).book().lost
            })
            .fold(0.0, f64::max);
        let lambda = hiding.lambda(decision.theta_i.cos());
        decision.predicted_shadowed = lambda / (1.0 + lambda);
        decision.visibility = match self.options.method {
            Method::Auto | Method::Geometric => !decision.wave && decision.predicted_blocked > decision.limit,
            Method::Facets | Method::Rays => true,
            Method::Kirchhoff => false,
        };
    }
}

/// Cosines of the smallest and largest angle that a wave serves; `None` if none is.
pub(super) fn wave_cosines(decisions: &[Decision]) -> Option<[f64; 2]> {
    let cosines = || decisions.iter().filter(|d| d.wave).map(|d| d.theta_i.cos());
    cosines().next()?;
    Some([cosines().fold(1.0, f64::min), cosines().fold(0.0, f64::max)])
}
