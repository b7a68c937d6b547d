//! Removal of form: what the part was meant to be, taken away so that roughness remains.

use super::{Edges, HeightMap, RawMap, level, polynomial, sphere};
use crate::error::{Error, Result};
use ndarray::Array2;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

/// The nominal form to remove (F-operator of ISO 25178-2, 2021).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Only the mean height: tilt and form are meant.
    None,
    /// The least-squares plane.
    #[default]
    Plane,
    /// The least-squares polynomial of this total degree, 0 to [`polynomial::HIGHEST_DEGREE`].
    Polynomial(u8),
    /// The least-squares sphere.
    Sphere,
}

/// What was removed, in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Removed {
    /// The form that was asked for.
    pub form: Form,
    /// Slopes `(dh/dx, dh/dy)` of the least-squares plane of the map as measured; 0 for [`Form::None`].
    pub slopes: [f64; 2],
    /// Highest minus lowest point of what was removed, over the measured points \[m\].
    #[serde(rename = "span_m")]
    pub span: f64,
    /// Terms of a polynomial in Legendre's basis.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<polynomial::Term>,
    /// A sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<sphere::Sphere>,
}

impl fmt::Display for Removed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p, q] = self.slopes;
        match self.form {
            Form::None => write!(f, "removed the mean only"),
            Form::Plane => write!(f, "removed plane (slopes {p:.3e}, {q:.3e})"),
            Form::Polynomial(degree) => write!(
                f,
                "removed polynomial of degree {degree} ({:.4} um high, slopes {p:.3e}, {q:.3e})",
                self.span * 1e6
            ),
            Form::Sphere => {
                write!(f, "removed sphere (")?;
                match self.sphere {
                    Some(s) => write!(f, "{s}, ")?,
                    None => write!(f, "flat, ")?,
                }
                write!(f, "{:.4} um high, slopes {p:.3e}, {q:.3e})", self.span * 1e6)
            }
        }
    }
}

/// `h <- h - form(x, y)`, the form fitted by least squares of the vertical residuals over the measured points.
///
/// Fitted and subtracted in f64, stored as f32. Slopes of the plane part go to `removed_slopes` for every form but
/// [`Form::None`].
///
/// # Errors
/// `Error::Parameter` if the measured points do not determine the form, the degree is too high, or the fitted sphere is
/// smaller than the map.
pub fn remove(raw: &RawMap, form: Form, edges: Edges) -> Result<(HeightMap, Removed)> {
    let bare = |slopes, span| Removed { form, slopes, span, terms: Vec::new(), sphere: None };
    match form {
        Form::None => Ok((level::keep_tilt(raw, edges), bare([0.0; 2], 0.0))),
        Form::Plane => {
            let map = level::level(raw, edges)?;
            let [p, q] = map.removed_slopes;
            let span = (p * raw.pitch_x).abs() * (map.width() - 1) as f64
                + (q * raw.pitch_y).abs() * (map.height() - 1) as f64;
            let removed = bare(map.removed_slopes, span);
            Ok((map, removed))
        }
        Form::Polynomial(degree) => {
            let found = polynomial::fit(raw, degree)?;
            let (map, removed) = subtract(raw, edges, bare, |r, out| found.heights_of_row(r, out))?;
            Ok((map, Removed { terms: found.terms(), ..removed }))
        }
        Form::Sphere => {
            let found = sphere::fit(raw)?;
            let (map, removed) = subtract(raw, edges, bare, |r, out| found.heights_of_row(r, out))?;
            Ok((map, Removed { sphere: found.sphere(), ..removed }))
        }
    }
}

/// Subtracts a form given row by row; a measured point where the form is not finite is an error.
fn subtract(
    raw: &RawMap,
    edges: Edges,
    bare: impl Fn([f64; 2], f64) -> Removed,
    form_of_row: impl Fn(usize, &mut [f64]) + Sync,
) -> Result<(HeightMap, Removed)> {
    let slopes = level::fit_plane(raw.heights.view(), [raw.pitch_x, raw.pitch_y])?.slopes;
    let (rows, columns) = raw.heights.dim();
    let mut out = Array2::<f32>::zeros((rows, columns));
    let mut limits = vec![(f64::INFINITY, f64::NEG_INFINITY, 0usize); rows];
    if let Some(all) = out.as_slice_mut() {
        all.par_chunks_mut(columns).zip(&mut limits).enumerate().for_each_init(
            || vec![0.0; columns],
            |form, (r, (to, (low, high, beyond)))| {
                form_of_row(r, form);
                for ((to, h), form) in to.iter_mut().zip(raw.heights.row(r)).zip(form.iter()) {
                    *to = if h.is_finite() { (h - form) as f32 } else { f32::NAN };
                    if h.is_finite() {
                        *low = low.min(*form);
                        *high = high.max(*form);
                        *beyond += usize::from(!form.is_finite());
                    }
                }
            },
        );
    }
    let beyond: usize = limits.iter().map(|l| l.2).sum();
    if beyond > 0 {
        return Err(Error::parameter(
            format!("{beyond} measured points lie beyond the edge of the fitted sphere"),
            "crop to the cap with --region, or remove a polynomial with --form poly:4",
        ));
    }
    let low = limits.iter().map(|l| l.0).fold(f64::INFINITY, f64::min);
    let high = limits.iter().map(|l| l.1).fold(f64::NEG_INFINITY, f64::max);
    let map = HeightMap { heights: out, pitch_x: raw.pitch_x, pitch_y: raw.pitch_y, edges, removed_slopes: slopes };
    Ok((map, bare(slopes, high - low)))
}
