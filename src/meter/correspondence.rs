//! What the meters read along one parameter of a model: the correspondence tables between models and appearance scales.
//!
//! The way back, from readings to parameters, is [`crate::fit::target`]. Idea and first tables: Westlund and Meyer,
//! Applying appearance standards to light reflection models, SIGGRAPH 2001.

use super::gloss::Options;
use super::measure::Reading;
use super::standards;
use crate::error::Result;
use crate::math::Estimate;
use crate::optics::Brdf;
use rayon::prelude::*;

/// Readings at one value of the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub parameter: f64,
    /// Gloss at 20, 60 and 85 deg \[GU\].
    pub gloss: [Estimate; 3],
    /// Haze of `haze-20`: both sides added.
    pub haze: Estimate,
}

/// One row per value, in their order; `model` makes the surface.
///
/// # Errors
/// What `model` says about a value, `Error::Parameter` if `options` ask for nothing.
pub fn correspondence(
    model: &(dyn Fn(f64) -> Result<Box<dyn Brdf>> + Sync),
    values: &[f64],
    options: &Options,
) -> Result<Vec<Row>> {
    let read = |name: &str, brdf: &dyn Brdf| -> Result<Vec<Reading>> {
        standards::by_name(name).expect("a named instrument").measure(brdf, options)
    };
    values
        .par_iter()
        .map(|&parameter| {
            let brdf = model(parameter)?;
            let beside = read("haze-20", brdf.as_ref())?;
            let gloss = [&beside[0], &read("gloss-60", brdf.as_ref())?[0], &read("gloss-85", brdf.as_ref())?[0]];
            Ok(Row { parameter, gloss: gloss.map(|r| r.estimate), haze: beside[1].estimate })
        })
        .collect()
}

/// `count` values from `low` to `high` in equal ratios.
pub fn ratios(low: f64, high: f64, count: usize) -> Vec<f64> {
    let last = count.max(2) - 1;
    (0..=last).map(|k| low * (high / low).powf(k as f64 / last as f64)).collect()
}
