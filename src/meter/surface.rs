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
    // One sub-area's sampler at a time per thread: together they would hold sixteen times the table.
    let repeats: Vec<Vec<f64>> = (0..table.subareas())
        .into_par_iter()
        .map(|k| {
            let part = TableBrdf::new(table.of_subarea(k))?;
            Ok(geometry.iter().map(|g| gloss(&part, g, &quick).value).collect())
        })
        .collect::<Result<_>>()?;
    let map_to_map =
        |k: usize| Estimate::from_repeats(&repeats.iter().map(|r| r[k]).collect::<Vec<_>>()).standard_error;
    let values = geometry.par_iter().map(|g| gloss(brdf, g, options)).collect::<Vec<_>>();
    Ok(values.into_iter().enumerate().map(|(k, value)| value.with_error(map_to_map(k))).collect())
}
