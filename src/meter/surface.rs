//! Readings of a measured surface with the error that the surface itself brings.

use super::{Geometry, Options, gloss};
use crate::error::Result;
use crate::math::Estimate;
use crate::optics::Brdf;
use crate::sample::TableBrdf;
use crate::table::Table;
use rayon::prelude::*;

/// Numbers read on a surface, always the same ones in the same order.
pub type Read<'a> = dyn Fn(&dyn Brdf, &Options) -> Result<Vec<f64>> + Sync + 'a;

/// What the surface leaves open of numbers read on its table:
/// `sqrt( s^2 / S + (x_beam - x)^2 + (x_steps - x)^2 )`, s the standard deviation over the S sub-areas of the map, `x_beam` the number
/// for mirror beams weaker by their own standard error, `x_steps` for heights that come in steps taken as they are. The
/// last two are zero where there is no beam or no step.
///
/// `values` are what `read` gives for `brdf` with `options`, in the same order. A number that a sub-area does not have is left out
/// (NaN).
///
/// # Errors
/// Those of `read`; `Error::Parameter` if a sub-area's density cannot be sampled.
pub fn surface_scatter(brdf: &TableBrdf, values: &[f64], options: &Options, read: &Read) -> Result<Vec<f64>> {
    let table = brdf.table();
    // Twice the integration points would not tell more about a surface whose sub-areas differ by percents.
    let quick = Options { azimuths: options.azimuths.clone(), ..Options::quick() };
    let of = |table: Table, options: &Options| read(&TableBrdf::new(table)?, options);
    // One sub-area's sampler at a time per thread: together they would hold sixteen times the table.
    let repeats: Vec<Vec<f64>> =
        (0..table.subareas()).into_par_iter().map(|k| of(table.of_subarea(k), &quick)).collect::<Result<_>>()?;
    let others = [table.of_weaker_beam(), table.of_raw_steps()];
    let others: Vec<Vec<f64>> = others.into_iter().flatten().map(|table| of(table, options)).collect::<Result<_>>()?;
    let error = |k: usize| {
        let known: Vec<f64> = repeats.iter().map(|r| r[k]).filter(|x| x.is_finite()).collect();
        let differences = others.iter().map(|other| other[k] - values[k]).filter(|d| d.is_finite());
        differences.fold(Estimate::from_repeats(&known).standard_error, f64::hypot)
    };
    Ok((0..values.len()).map(error).collect())
}

/// Gloss of a table, its standard error from the integration joined in quadrature with [`surface_scatter`].
///
/// # Errors
/// `Error::Parameter` if a sub-area's density cannot be sampled.
pub fn surface_gloss(brdf: &TableBrdf, geometry: &[Geometry], options: &Options) -> Result<Vec<Estimate>> {
    let values = geometry.par_iter().map(|g| gloss(brdf, g, options)).collect::<Vec<_>>();
    let read =
        |part: &dyn Brdf, options: &Options| Ok(geometry.iter().map(|g| gloss(part, g, options).value).collect());
    let scatter = surface_scatter(brdf, &values.iter().map(|v| v.value).collect::<Vec<_>>(), options, &read)?;
    Ok(values.into_iter().zip(scatter).map(|(value, error)| value.with_error(error)).collect())
}
