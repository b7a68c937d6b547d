//! What a fit cannot promise, in full sentences with advice.

use serde::Serialize;

/// A doubt about a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Warning {
    /// Part of the source is a mirror, which no residual sees.
    SpecularCore { reflectance: f64 },
    /// Residuals far above the error bars.
    PoorFit { chi2_per_dof: f64 },
    /// A parameter went to the end of its range.
    AtEnd { name: String, value: f64 },
    /// Two parameters trade places.
    Correlated { first: String, second: String, correlation: f64 },
    /// The data leave parameters open.
    Undetermined,
    /// Another set of parameters is nearly as good.
    Ambiguous { other: Vec<(String, f64)>, cost_ratio: f64 },
    /// The search stopped before it was done.
    NotConverged,
    /// Scans and hemispherical reflectance of the same wavelength disagree.
    HemisphericalMismatch { wavelength: f64, scale: f64, standard_error: f64 },
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Warning::SpecularCore { reflectance } => write!(
                f,
                "the source has a specular core of reflectance {reflectance:.4}, which is left out of the fit: the model \
                 describes the rest only"
            ),
            Warning::PoorFit { chi2_per_dof } => write!(
                f,
                "the model does not describe the data within their errors (chi2/dof {chi2_per_dof:.2}); the standard \
                 errors are enlarged by its root, look at the residuals or take another model"
            ),
            Warning::AtEnd { name, value } => write!(
                f,
                "`{name}` went to {value:.4}, the end of its range, and has no standard error: give it a value, or take a \
                 model without it"
            ),
            Warning::Correlated { first, second, correlation } => write!(
                f,
                "`{first}` and `{second}` can trade places (correlation {correlation:.3}): give one of them a value if it \
                 is known"
            ),
            Warning::Undetermined => write!(
                f,
                "the data do not determine all parameters, so no standard errors can be given: give some of them a value"
            ),
            Warning::Ambiguous { other, cost_ratio } => {
                let other: Vec<String> = other.iter().map(|(name, v)| format!("{name}={v:.5}")).collect();
                write!(
                    f,
                    "another set of parameters is nearly as good ({}; cost {cost_ratio:.3} of the best): measure at more \
                     angles or give a parameter a value",
                    other.join(",")
                )
            }
            Warning::NotConverged => {
                write!(f, "the search stopped before it converged: try another seed or free fewer parameters")
            }
            Warning::HemisphericalMismatch { wavelength, scale, standard_error } => write!(
                f,
                "at {:.0} nm, where the scans were taken, the hemispherical reflectance is {scale:.3} +- \
                 {standard_error:.3} times that of the scanned material, and not 1: check the calibration of both, for \
                 every band is scaled to the hemispherical one",
                wavelength * 1e9
            ),
        }
    }
}
