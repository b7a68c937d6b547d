//! Gloss of Gaussian surfaces by rays and by waves, over rms height and autocorrelation length: where rays fail.
//!
//! `g = (4 pi Sq cos_theta_i / lambda)^2`: from 9 on rays and waves should agree, below waves keep a mirror beam `exp(-g)`
//! that rays do not have.
//!
//! Every pair is one periodic map whose Sq and spectrum are exactly those asked for; rays are the facets read straight into
//! the stops, waves the phase integral through a table of one angle. The question is that of McKnight, Vorburger et al.,
//! J. Res. NIST 106, 2001, and of physics text books since Beckmann and Spizzichino 1963.

use super::facets::Azimuths;
use super::traced::traced_gloss;
use super::validity::{check_waves, rayleigh_parameter};
use super::{Geometry, Options, gloss};
use crate::error::{Error, Result};
use crate::heightmap::{Edges, HeightMap, level, synth};
use crate::math::Estimate;
use crate::optics::Material;
use crate::sample::TableBrdf;
use crate::scatter::{self, Method, scatter};
use crate::table::{Provenance, Table};
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// What is compared, and how hard.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Rms heights \[m\].
    pub sq: Vec<f64>,
    /// Autocorrelation lengths \[m\].
    pub acl: Vec<f64>,
    /// \[m\].
    pub wavelength: f64,
    pub material: Material,
    /// Points of a map along each side.
    pub size: usize,
    pub seed: u64,
}

/// One surface at one geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// \[m\].
    pub sq: f64,
    /// \[m\].
    pub acl: f64,
    /// \[rad\].
    pub theta_i: f64,
    /// Rayleigh parameter.
    pub g: f64,
    /// Gloss \[GU\] with the scatter of the map's sub-areas.
    pub ray: Estimate,
    /// Gloss \[GU\] with the error of the integration.
    pub wave: Estimate,
    /// Whether the wave calculation itself is in doubt: much light bounces again or facets bend within a wavelength.
    pub doubt: bool,
}

impl Plan {
    /// # Errors
    /// `Error::Parameter` if a list is empty, or a length or the size is not one that a map can have.
    pub fn validate(&self) -> Result<()> {
        let lengths = || self.sq.iter().chain(&self.acl).chain([&self.wavelength]);
        if self.sq.is_empty() || self.acl.is_empty() || lengths().any(|v| !(*v > 0.0 && v.is_finite())) {
            return Err(Error::parameter(
                "rms heights, autocorrelation lengths and the wavelength must be above 0",
                "give at least one of each",
            ));
        }
        if !(32..=4096).contains(&self.size) {
            return Err(Error::parameter(
                format!("maps of {0} x {0} points", self.size),
                "give a size from 32 to 4096",
            ));
        }
        Ok(())
    }
}

/// Readings at 20, 60 and 85 deg of every surface, the Sq outermost; `progress` is told the share done.
///
/// # Errors
/// Those of [`Plan::validate`], of the synthesis and of scattering.
pub fn ray_wave(plan: &Plan, progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<Reading>> {
    plan.validate()?;
    let geometries = Geometry::standard_three();
    let wanted: Vec<(f64, f64, Geometry)> = (plan.sq.iter())
        .flat_map(|&sq| plan.acl.iter().map(move |&acl| (sq, acl)))
        .flat_map(|(sq, acl)| geometries.clone().map(|g| (sq, acl, g)))
        .collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let one = |(sq, acl, geometry): &(f64, f64, Geometry)| {
        let reading = plan.read(*sq, *acl, geometry);
        let count = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        progress(count as f64 / wanted.len() as f64);
        reading
    };
    wanted.par_iter().map(one).collect()
}

impl Plan {
    fn read(&self, sq: f64, acl: f64, geometry: &Geometry) -> Result<Reading> {
        let theta_i = geometry.theta_i;
        let map = self.surface(sq, acl, theta_i)?;
        let geometries = std::slice::from_ref(geometry);
        let mut options = scatter::Options { method: Method::Kirchhoff, theta_i: vec![theta_i], ..Default::default() };
        options.material = self.material;
        options.wave.wavelength = self.wavelength;
        let ray = traced_gloss(&map, geometries, &Azimuths::All, &options)?.gloss[0];
        let scattered = scatter(&map, &options, &|_| ())?;
        let doubt = scattered.decisions.iter().any(|d| !check_waves(d).is_empty());
        let brdf = TableBrdf::new(Table::from_scatter(&scattered, Provenance::default()))?;
        let wave = gloss(&brdf, geometry, &Options::default());
        Ok(Reading { sq, acl, theta_i, g: rayleigh_parameter(sq, theta_i, self.wavelength), ray, wave, doubt })
    }

    /// Sampled so finely that an eighth of the autocorrelation length is seen, and that the phase of four standard
    /// deviations of slope turns by less than half from point to point.
    fn surface(&self, sq: f64, acl: f64, theta_i: f64) -> Result<HeightMap> {
        let phase = self.wavelength / (16.0 * SQRT_2 * theta_i.cos() * sq / acl);
        let grid = synth::Grid { width: self.size, height: self.size, pitch: [phase.min(acl / 8.0); 2] };
        let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed: self.seed, exact: true })?;
        Ok(level::keep_tilt(&raw, Edges::Periodic))
    }
}
