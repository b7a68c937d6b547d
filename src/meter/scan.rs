//! A goniometer: the BRDF in the plane of incidence as a detector of finite size averages it.

use super::gloss::Options;
use super::instrument::{Instrument, Receptor, Specimen, Standard};
use super::stop::{Shape, in_degrees};
use crate::error::{Error, Result};
use crate::math::Estimate;
use crate::optics::Brdf;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// An in-plane scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Angle of incidence \[rad\].
    pub theta_i: f64,
    /// Azimuth of the source on the specimen \[rad\].
    pub phi_i: f64,
    /// Half angle of the beam's divergence \[rad\].
    pub source_half_angle: f64,
    /// Half angle that the detector subtends \[rad\].
    pub half_angle: f64,
    /// Detector angles \[rad\], positive on the side of the mirror direction.
    pub theta_r: Vec<f64>,
}

/// One position of the detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPoint {
    /// \[rad\], signed as in [`Scan::theta_r`].
    pub theta_r: f64,
    /// `Phi / (Omega_p source Omega_p detector)`: f_r averaged over both stops [1/sr], the specular beam included as the
    /// detector's size spreads it.
    pub f_r: Estimate,
}

/// Scans `brdf`. `options.tolerance` counts relative to the largest value of the scan; each point stops there or at its limit
/// of points, and tells its error.
///
/// # Errors
/// `Error::Parameter` if there is no angle, or source or detector reaches below the horizon.
pub fn scan(brdf: &dyn Brdf, scan: &Scan, options: &Options) -> Result<Vec<ScanPoint>> {
    if scan.theta_r.is_empty() {
        return Err(Error::parameter("the scan has no detector angle", "give from, to and step"));
    }
    let at = |theta_r: f64| Instrument {
        name: "scan".into(),
        about: String::new(),
        theta_i: scan.theta_i,
        source: Shape::Disc(2.0 * scan.source_half_angle),
        source_turn: 0.0,
        receptors: vec![Receptor {
            reading: "scan".into(),
            theta_r,
            phi_r: 0.0,
            shape: Shape::Disc(2.0 * scan.half_angle),
            turn: 0.0,
        }],
        standard: Standard::WhiteDiffuser,
        specimen: Specimen { azimuth: scan.phi_i, ..Specimen::default() },
    };
    let meters: Vec<Instrument> = scan.theta_r.iter().map(|&t| at(t)).collect();
    meters.iter().try_for_each(Instrument::validate)?;
    let read = |options: &Options| -> Result<Vec<ScanPoint>> {
        meters
            .par_iter()
            .zip(&scan.theta_r)
            .map(|(meter, &theta_r)| {
                let percent = meter.measure(brdf, options)?.remove(0).estimate;
                // The perfect diffuser has f_r = 1 / pi.
                let [value, standard_error] = [percent.value, percent.standard_error].map(|x| x / (100.0 * PI));
                Ok(ScanPoint { theta_r, f_r: Estimate { value, standard_error } })
            })
            .collect()
    };
    // A first look finds the height of the peak, by which the second is judged.
    let rough = read(&Options { tolerance: f64::MAX, points: 32, ..options.clone() })?;
    let peak = rough.iter().map(|p| p.f_r.value).fold(0.0, f64::max);
    if !(peak > 0.0) {
        return Ok(rough);
    }
    read(&Options { tolerance: options.tolerance * peak * 100.0 * PI, ..options.clone() })
}

/// Evenly spaced detector angles from `from` to `to` \[rad\]; those whose detector would dip below the horizon are left out.
///
/// # Errors
/// `Error::Parameter` if the step is not positive or there are more than a hundred thousand steps.
pub fn angles(from: f64, to: f64, step: f64, half_angle: f64) -> Result<Vec<f64>> {
    let count = ((to - from) / step + 1e-9).floor();
    if !(step > 0.0 && (0.0..1e5).contains(&count)) {
        return Err(Error::parameter(
            format!(
                "a scan from {} to {} deg in steps of {} deg is not a list of angles",
                in_degrees(from),
                in_degrees(to),
                in_degrees(step)
            ),
            "give a rising range and a step above 0, at most 100000 of them",
        ));
    }
    let list = (0..=count as u32).map(|k| from + f64::from(k) * step);
    Ok(list.filter(|t| t.abs() + 1.01 * half_angle < FRAC_PI_2).collect())
}
