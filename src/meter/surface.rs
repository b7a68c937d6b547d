//! Gloss of a measured surface with the error that the surface itself brings.

use super::{Geometry, Options, gloss};
use crate::error::Result;
use crate::math::Estimate;
use crate::sample::TableBrdf;
use rayon::prelude::*;

/// Gloss of a table, its standard error from the integration and from the scatter of the map's sub-areas:
/// `s_G / sqrt(S)` over S sub-areas, joined in quadrature.
///
/// # Errors
/// `Error::Parameter` if a sub-area's density cannot be sampled.
pub fn surface_gloss(brdf: &TableBrdf, geometry: &[Geometry], options: &Options) -> Result<Vec<Estimate>> {
    let table = brdf.table();
    // Twice the integration points would not tell more about a surface whose sub-areas differ by percents.
    let quick = Options { azimuths: options.azimuths.clone(), ..Options::quick() };
    let parts: Vec<TableBrdf> =
        (0..table.subareas()).into_par_iter().map(|k| TableBrdf::new(table.of_subarea(k))).collect::<Result<_>>()?;
    Ok(geometry
        .par_iter()
        .map(|g| {
            let repeats: Vec<f64> = parts.par_iter().map(|part| gloss(part, g, &quick).value).collect();
            gloss(brdf, g, options).with_error(Estimate::from_repeats(&repeats).standard_error)
        })
        .collect())
}
