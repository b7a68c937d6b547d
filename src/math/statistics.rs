//! Estimates with their errors, and the chi-square test of the sampler audit.

use serde::{Deserialize, Serialize};

/// A number that was estimated, with one standard error in the same unit. A bare `f64` is exact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Default)]
pub struct Estimate {
    pub value: f64,
    pub standard_error: f64,
}

impl Estimate {
    /// A value known exactly.
    pub const fn exact(value: f64) -> Self {
        Estimate { value, standard_error: 0.0 }
    }

    /// Mean of independent repeats and its standard error `s / sqrt(n)`; error 0 for fewer than two repeats.
    pub fn from_repeats(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n.max(1.0);
        let squares: f64 = values.iter().map(|v| (v - value).powi(2)).sum();
        let standard_error = if values.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
        Estimate { value, standard_error }
    }

    /// The same value with another, independent error added in quadrature.
    pub fn with_error(self, other: f64) -> Self {
        Estimate { standard_error: self.standard_error.hypot(other), ..self }
    }
}

/// Sum with compensation (Neumaier 1974): the error does not grow with the number of terms.
pub fn compensated_sum(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0f64, 0.0f64);
    for v in values {
        let t = sum + v;
        lost += if sum.abs() >= v.abs() { (sum - t) + v } else { (v - t) + sum };
        sum = t;
    }
    sum + lost
}

/// `P(X^2 > chi2)` for `dof` degrees of freedom by the cube-root normal approximation
/// (Wilson and Hilferty 1931): relative error below 10 % for p > 1e-5 and dof >= 10.
pub fn chi_square_p_value(chi2: f64, dof: f64) -> f64 {
    let v = 2.0 / (9.0 * dof);
    let z = ((chi2 / dof).cbrt() - (1.0 - v)) / v.sqrt();
    0.5 * libm::erfc(z / std::f64::consts::SQRT_2)
}

/// Pearson chi-square of counts against expectations that sum to the same total. Cells expecting
/// fewer than `pool_below` are pooled into one. Returns `(chi2, degrees of freedom, p)`.
pub fn chi_square_test(counts: &[f64], expected: &[f64], pool_below: f64) -> (f64, f64, f64) {
    let (mut chi2, mut cells) = (0.0, 0.0);
    let (mut pooled_count, mut pooled_expected) = (0.0, 0.0);
    for (&c, &e) in counts.iter().zip(expected) {
        if e < pool_below {
            pooled_count += c;
            pooled_expected += e;
        } else {
            chi2 += (c - e).powi(2) / e;
            cells += 1.0;
        }
    }
    if pooled_expected >= pool_below.min(5.0) {
        chi2 += (pooled_count - pooled_expected).powi(2) / pooled_expected;
        cells += 1.0;
    } else if pooled_count > 10.0 * pooled_expected.max(1.0) {
        // Far more draws than expected where almost none belong: no approximation needed to refuse that.
        return (f64::INFINITY, cells, 0.0);
    }
    let dof = f64::max(cells - 1.0, 1.0);
    (chi2, dof, chi_square_p_value(chi2, dof))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_square_tail_matches_tables() {
        // Abramowitz and Stegun, table 26.8: upper 1 % and 0.1 % points.
        for (chi2, dof, p) in [(23.2093, 10.0, 0.01), (135.807, 100.0, 0.01), (149.449, 100.0, 0.001)] {
            assert!((chi_square_p_value(chi2, dof) / p - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn repeats_give_the_error_of_the_mean() {
        let e = Estimate::from_repeats(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(e.value, 2.5);
        assert!((e.standard_error - (5.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn compensation_keeps_small_terms() {
        assert_eq!(compensated_sum([1e16, 1.0, -1e16]), 1.0);
    }
}
