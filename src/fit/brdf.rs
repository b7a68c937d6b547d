//! A model through a list of `f_r`: parameters, their errors, and how good it is.
//!
//! Minimises `sum r^2` over the box of the free parameters with, for data `f`, model `m` and error `s`,
//! `r = (m - f) / s` (linear) or `r = f ln(m / f) / s` (logarithmic).
//!
//! The covariance is `(J^T J)^-1` at the minimum (Press et al., Numerical Recipes, section 15.6). If the errors of the data are
//! known, it is enlarged by `chi2 / dof` when that exceeds 1; if not, `chi2 / dof` is the variance of the data.

use super::family::{Family, Free};
use super::levenberg::{Minimum, moving_columns, normal_equations};
use super::observations::{Observation, Observations};
use super::search::{Search, multi_start};
use super::warning::Warning;
use crate::error::{Error, Result};
use crate::math::Estimate;
use rayon::prelude::*;

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residual {
    /// Differences: the bright lobe rules.
    Linear,
    /// Logarithms: every decade counts alike.
    Logarithmic,
}

/// What each value counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// `1 / s^2`, from the error bars.
    Errors,
    /// The projected solid angle it stands for: differences of energy.
    SolidAngle,
    /// Each the same.
    Equal,
}

/// How to fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub residual: Residual,
    pub weights: Weights,
    /// Error of the model itself as a share of `f_r`, added to the error bars: no value counts as better known.
    pub error_floor: f64,
    pub search: Search,
}

impl Options {
    /// Differences weighed by the error bars if there are any, else logarithms of equal weight.
    pub fn suited_to(data: &Observations) -> Self {
        let (residual, weights) = if data.has_errors() {
            (Residual::Linear, Weights::Errors)
        } else {
            (Residual::Logarithmic, Weights::Equal)
        };
        Options { residual, weights, error_floor: 0.0, search: Search::default() }
    }
}

/// One parameter found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FittedParameter {
    pub name: String,
    pub value: f64,
    /// `None` at the end of the range, or where the data say nothing.
    pub standard_error: Option<f64>,
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    pub parameters: Vec<FittedParameter>,
    pub chi2: f64,
    /// Values minus free parameters.
    pub dof: usize,
    /// Root mean square of `ln(m / f)` over values above a millionth of the largest.
    pub rms_log_error: f64,
    pub warnings: Vec<Warning>,
}

impl Fitted {
    /// The values, in the order of the family.
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// `chi2 / dof`.
    pub fn chi2_per_dof(&self) -> f64 {
        self.chi2 / self.dof.max(1) as f64
    }
}

/// Values below this share of the largest count as darkness.
const DARK: f64 = 1e-6;

/// Correlations beyond this are told.
const CORRELATED: f64 = 0.98;

/// Fits the family to the data.
///
/// # Errors
/// `Error::Parameter` if there are fewer values than parameters, or the model can be built nowhere in the box.
pub fn fit(family: &Family, data: &Observations, options: &Options) -> Result<Fitted> {
    let n = family.free().len();
    if data.list.len() <= n {
        return Err(Error::parameter(
            format!("{} values do not determine {n} parameters", data.list.len()),
            "give more values, or give some parameters a value",
        ));
    }
    let problem = Problem::new(family, data, options);
    let dark = problem.dark;
    let residuals = |u: &[f64]| problem.residuals(u);
    let minima = multi_start(family.free(), &residuals, &options.search);
    let best = minima.first().ok_or_else(|| {
        Error::parameter(
            "the model gives no numbers anywhere in the range of its free parameters",
            "give some of them a value",
        )
    })?;
    let values = family.values(&best.at);
    let model = family.model(&values)?;
    let dof = data.list.len() - n;
    let logs: Vec<f64> = data
        .list
        .iter()
        .filter(|o| o.f_r.value > dark)
        .map(|o| (model.eval(o.wi, o.wo).max(dark) / o.f_r.value).ln().powi(2))
        .collect();
    let rms_log_error = (logs.iter().sum::<f64>() / logs.len().max(1) as f64).sqrt();
    let spread = best.cost / dof as f64;
    let variance = if options.weights == Weights::Errors { spread.max(1.0) } else { spread };
    let mut warnings = warnings_of(family, data, options, &minima, spread);
    let errors = uncertainty(family.free(), best, variance, &mut warnings).errors;
    let parameters = (family.free().iter().zip(values).zip(errors))
        .map(|((free, value), standard_error)| FittedParameter { name: free.name.clone(), value, standard_error })
        .collect();
    Ok(Fitted { parameters, chi2: best.cost, dof, rms_log_error, warnings })
}

/// Standard errors from independent repeats of the data, such as the sub-areas of one map, whose errors are the same in
/// all directions: the scatter of the parameters over the repeats. `None` where `found` has none.
///
/// Each repeat descends from what was found; those that cannot are left out.
pub fn errors_from_repeats(
    family: &Family,
    found: &Fitted,
    repeats: &[Observations],
    options: &Options,
) -> Vec<Option<f64>> {
    let start: Vec<f64> = family.free().iter().zip(&found.parameters).map(|(f, p)| f.coordinate(p.value)).collect();
    let values: Vec<Vec<f64>> = repeats
        .par_iter()
        .filter_map(|data| {
            let problem = Problem::new(family, data, options);
            let minimum = options.search.descent.descend(&|u: &[f64]| problem.residuals(u), &start)?;
            Some(family.values(&minimum.at))
        })
        .collect();
    (found.parameters.iter().enumerate())
        .map(|(j, p)| {
            let list: Vec<f64> = values.iter().map(|v| v[j]).collect();
            p.standard_error.filter(|_| list.len() > 1).map(|_| Estimate::from_repeats(&list).standard_error)
        })
        .collect()
}

/// The residuals of one list of data.
struct Problem<'a> {
    family: &'a Family<'a>,
    data: &'a Observations,
    residual: Residual,
    /// Value and root of the weight of each observation.
    rows: Vec<(f64, f64)>,
    /// Values below this count as darkness [1/sr].
    dark: f64,
}

impl<'a> Problem<'a> {
    fn new(family: &'a Family<'a>, data: &'a Observations, options: &Options) -> Self {
        let peak = data.list.iter().fold(0.0f64, |m, o| m.max(o.f_r.value));
        let dark = DARK * peak;
        let total: f64 = data.list.iter().map(|o| o.solid_angle).sum();
        let row = |o: &Observation| {
            let f = o.f_r.value;
            let scale = match (options.weights, options.residual) {
                (Weights::Errors, _) => 1.0 / o.f_r.standard_error.hypot(options.error_floor * f).max(dark),
                (Weights::SolidAngle, Residual::Linear) => (o.solid_angle / total).sqrt() / peak,
                (Weights::SolidAngle, Residual::Logarithmic) => (o.solid_angle / total).sqrt() / f.max(dark),
                (Weights::Equal, Residual::Linear) => 1.0 / peak,
                (Weights::Equal, Residual::Logarithmic) => 1.0 / f.max(dark),
            };
            (f, scale)
        };
        let rows = data.list.iter().map(row).collect();
        Problem { family, data, residual: options.residual, rows, dark }
    }

    /// Weighted residuals at the coordinates `u`; `None` where the model cannot be built.
    fn residuals(&self, u: &[f64]) -> Option<Vec<f64>> {
        let model = self.family.model(&self.family.values(u)).ok()?;
        let dark = self.dark;
        let residual = |(o, (f, scale)): (&Observation, &(f64, f64))| {
            let m = model.eval(o.wi, o.wo);
            match self.residual {
                Residual::Linear => (m - f) * scale,
                Residual::Logarithmic => f.max(dark) * (m.max(dark) / f.max(dark)).ln() * scale,
            }
        };
        Some(self.data.list.iter().zip(&self.rows).map(residual).collect())
    }
}

/// What is known about the values of the free parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Uncertainty {
    /// `sqrt(C_jj)`; `None` for a parameter at its end or not determined.
    pub errors: Vec<Option<f64>>,
    /// `C_jl`; 0 where there is no error.
    pub covariance: Vec<Vec<f64>>,
}

/// Covariance of the values; says which parameters are at an end, trade places or are not determined.
pub(super) fn uncertainty(free: &[Free], best: &Minimum, variance: f64, warnings: &mut Vec<Warning>) -> Uncertainty {
    let n = free.len();
    let mut known = Uncertainty { errors: vec![None; n], covariance: vec![vec![0.0; n]; n] };
    for (f, &u) in free.iter().zip(&best.at) {
        if f.is_at_end(u) {
            warnings.push(Warning::AtEnd { name: f.name.clone(), value: f.value(u) });
        }
    }
    let columns: Vec<usize> =
        moving_columns(&best.jacobian, n).into_iter().filter(|&j| !free[j].is_at_end(best.at[j])).collect();
    if columns.is_empty() {
        return known;
    }
    let equations = normal_equations(&best.jacobian, n, &columns, &vec![0.0; best.residuals.len()]);
    let inverse_column = |k: usize| {
        let mut e = equations.clone();
        e.add_right(k, 1.0);
        e.solve()
    };
    let Some(covariance) = (0..columns.len()).map(inverse_column).collect::<Option<Vec<_>>>() else {
        warnings.push(Warning::Undetermined);
        return known;
    };
    let slope = |j: usize| free[j].derivative(best.at[j]);
    for (k, &j) in columns.iter().enumerate() {
        known.errors[j] = Some((variance * covariance[k][k]).sqrt() * slope(j));
        for (l, &i) in columns.iter().enumerate() {
            known.covariance[j][i] = variance * covariance[k][l] * slope(j) * slope(i);
        }
        for (l, &i) in columns.iter().enumerate().take(k) {
            let correlation = covariance[k][l] / (covariance[k][k] * covariance[l][l]).sqrt();
            if correlation.abs() > CORRELATED {
                let (first, second) = (free[i].name.clone(), free[j].name.clone());
                warnings.push(Warning::Correlated { first, second, correlation });
            }
        }
    }
    known
}

fn warnings_of(
    family: &Family,
    data: &Observations,
    options: &Options,
    minima: &[Minimum],
    chi2_per_dof: f64,
) -> Vec<Warning> {
    let best = &minima[0];
    let mut warnings = Vec::new();
    if data.core > 0.0 {
        warnings.push(Warning::SpecularCore { reflectance: data.core });
    }
    if options.weights == Weights::Errors && chi2_per_dof > 4.0 {
        warnings.push(Warning::PoorFit { chi2_per_dof });
    }
    if !best.converged {
        warnings.push(Warning::NotConverged);
    }
    // A minimum of nearly the same cost whose parameters are elsewhere in the box.
    let elsewhere = |m: &&Minimum| {
        let share = |u: f64| 1.0 / (1.0 + (-u).exp());
        m.converged
            && m.cost < 1.05 * best.cost
            && m.at.iter().zip(&best.at).any(|(a, b)| (share(*a) - share(*b)).abs() > 0.05)
    };
    if best.cost > 1e-9 * data.list.len() as f64
        && let Some(m) = minima.iter().skip(1).find(elsewhere)
    {
        let other = family.free().iter().map(|f| f.name.clone()).zip(family.values(&m.at)).collect();
        warnings.push(Warning::Ambiguous { other, cost_ratio: m.cost / best.cost });
    }
    warnings
}
