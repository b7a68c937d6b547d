//! Nonlinear least squares with few unknowns: damped steps of Levenberg and Marquardt.
//!
//! `(J^T J + lambda diag(J^T J)) du = -J^T r`; the damping `lambda` follows the ratio of the gain to the one the
//! linear model promised.
//!
//! Sources: Marquardt, J. SIAM 11(2), 1963; damping: Nielsen, Damping parameter in Marquardt's method, IMM-REP-1999-05.

use crate::math::least_squares::NormalEquations;

/// Residuals `r(u)`, always as many; `None` where the model cannot be built.
pub type Residuals<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a;

/// How a search descends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquares {
    /// Step of the difference quotients in a coordinate; larger for residuals with jumps.
    pub difference: f64,
    /// Steps tried at most.
    pub steps: usize,
    /// Stops when a step gains less than this share of the cost.
    pub gain: f64,
    /// Stops when no coordinate moves by more.
    pub shift: f64,
    /// Stops when the cost is no more than this.
    pub enough: f64,
}

impl Default for LeastSquares {
    fn default() -> Self {
        LeastSquares { difference: 1e-5, steps: 100, gain: 1e-10, shift: 1e-9, enough: 0.0 }
    }
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Coordinates.
    pub at: Vec<f64>,
    pub residuals: Vec<f64>,
    /// `sum r^2`.
    pub cost: f64,
    /// `dr_i / du_j`, row by row.
    pub jacobian: Vec<f64>,
    /// Whether it stopped because nothing was left to gain.
    pub converged: bool,
}

/// Largest change of a coordinate in one step: a logistic coordinate crosses its box in about ten.
const LONGEST: f64 = 3.0;

impl LeastSquares {
    /// Descends from `start`; `None` if the residuals cannot be had there, or are not finite.
    pub fn descend(&self, residuals: &Residuals, start: &[f64]) -> Option<Minimum> {
        let n = start.len();
        let mut at = start.to_vec();
        let mut r = finite(residuals(&at))?;
        let mut cost = sum_of_squares(&r);
        let mut jacobian = self.jacobian(residuals, &at, &r);
        let (mut damping, mut growth) = (1e-3, 2.0);
        let mut converged = cost <= self.enough;
        for _ in 0..self.steps {
            if converged {
                break;
            }
            let Some((step, promised)) = damped_step(&jacobian, &r, n, damping) else {
                // No direction changes anything.
                converged = true;
                break;
            };
            let next: Vec<f64> = at.iter().zip(&step).map(|(u, d)| u + d.clamp(-LONGEST, LONGEST)).collect();
            let moved = step.iter().fold(0.0f64, |m, d| m.max(d.abs()));
            let tried = finite(residuals(&next)).map(|r| (sum_of_squares(&r), r));
            match tried {
                Some((lower, tried)) if lower < cost => {
                    let ratio = (cost - lower) / promised.max(f64::MIN_POSITIVE);
                    converged = cost - lower <= self.gain * cost && ratio < 4.0 || lower <= self.enough;
                    (at, r, cost) = (next, tried, lower);
                    damping *= (1.0 - (2.0 * ratio.min(1.0) - 1.0).powi(3)).max(1.0 / 3.0);
                    growth = 2.0;
                    jacobian = self.jacobian(residuals, &at, &r);
                }
                _ => {
                    damping *= growth;
                    growth *= 2.0;
                    converged = promised <= self.gain * cost;
                }
            }
            converged |= moved <= self.shift;
        }
        Some(Minimum { at, residuals: r, cost, jacobian, converged })
    }

    /// Central differences, one-sided where a side cannot be had, 0 where neither can.
    fn jacobian(&self, residuals: &Residuals, at: &[f64], r: &[f64]) -> Vec<f64> {
        let n = at.len();
        let mut jacobian = vec![0.0; r.len() * n];
        for j in 0..n {
            let shifted = |h: f64| {
                let mut u = at.to_vec();
                u[j] += h;
                finite(residuals(&u))
            };
            let h = self.difference;
            let (up, down) = (shifted(h), shifted(-h));
            let width = h * f64::from(u8::from(up.is_some()) + u8::from(down.is_some()));
            if width > 0.0 {
                let (up, down) = (up.as_deref().unwrap_or(r), down.as_deref().unwrap_or(r));
                for (i, (a, b)) in up.iter().zip(down).enumerate() {
                    jacobian[i * n + j] = (a - b) / width;
                }
            }
        }
        jacobian
    }
}

fn finite(r: Option<Vec<f64>>) -> Option<Vec<f64>> {
    r.filter(|r| r.iter().all(|v| v.is_finite()))
}

/// `sum r^2`.
pub fn sum_of_squares(r: &[f64]) -> f64 {
    r.iter().map(|v| v * v).sum()
}

/// The damped step and the reduction of the cost that the linear model promises for it; coordinates that change
/// nothing stay. `None` if all do.
fn damped_step(jacobian: &[f64], r: &[f64], n: usize, damping: f64) -> Option<(Vec<f64>, f64)> {
    let moving = moving_columns(jacobian, n);
    if moving.is_empty() {
        return None;
    }
    let mut equations = normal_equations(jacobian, n, &moving, r);
    for (k, &j) in moving.iter().enumerate() {
        let square: f64 = jacobian.iter().skip(j).step_by(n).map(|v| v * v).sum();
        equations.add_entry(k, k, damping * square);
    }
    let part = equations.solve()?;
    let mut step = vec![0.0; n];
    moving.iter().zip(&part).for_each(|(&j, &d)| step[j] = -d);
    let change = |row: &[f64]| row.iter().zip(&step).map(|(j, d)| j * d).sum::<f64>();
    let predicted: f64 = jacobian.chunks(n).zip(r).map(|(row, r)| (r + change(row)).powi(2)).sum();
    Some((step, sum_of_squares(r) - predicted))
}

/// Columns of the Jacobian that are not zero.
pub fn moving_columns(jacobian: &[f64], n: usize) -> Vec<usize> {
    (0..n).filter(|&j| jacobian.iter().skip(j).step_by(n).any(|v| *v != 0.0)).collect()
}

/// `J^T J` and `J^T r` of the chosen columns.
pub fn normal_equations(jacobian: &[f64], n: usize, columns: &[usize], r: &[f64]) -> NormalEquations {
    let mut equations = NormalEquations::new(columns.len());
    let mut row = vec![0.0; columns.len()];
    for (full, &r) in jacobian.chunks(n).zip(r) {
        columns.iter().zip(&mut row).for_each(|(&j, v)| *v = full[j]);
        equations.add(&row, r);
    }
    equations
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as least squares; minimum 0 at (1, 1).
    #[test]
    fn finds_the_end_of_a_curved_valley() {
        let valley = |u: &[f64]| Some(vec![10.0 * (u[1] - u[0] * u[0]), 1.0 - u[0]]);
        let m = LeastSquares::default().descend(&valley, &[-1.2, 1.0]).unwrap();
        assert!(m.converged && m.cost < 1e-18, "{m:?}");
        assert!((m.at[0] - 1.0).abs() < 1e-8 && (m.at[1] - 1.0).abs() < 1e-8);
    }

    /// NIST StRD nonlinear regression, Misra1a (lower difficulty, certified values; start 1): `y = b1 (1 - exp(-b2 x))`.
    #[test]
    fn certified_values_of_misra1a() {
        let x = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
        let y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78];
        // Logarithms of both, so that the coordinates are of order one.
        let r = |u: &[f64]| {
            let (b1, b2) = (u[0].exp(), u[1].exp());
            Some(x.iter().zip(y).map(|(x, y)| b1 * (1.0 - (-b2 * x).exp()) - y).collect())
        };
        let m = LeastSquares::default().descend(&r, &[500f64.ln(), 1e-4f64.ln()]).unwrap();
        assert!((m.at[0].exp() / 2.389_421_291_8e2 - 1.0).abs() < 1e-7, "{}", m.at[0].exp());
        assert!((m.at[1].exp() / 5.501_564_318_1e-4 - 1.0).abs() < 1e-7);
        assert!((m.cost / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn walls_and_idle_coordinates_do_no_harm() {
        let r = |u: &[f64]| (u[0] < 2.0).then(|| vec![u[0] - 1.999, 3.0]);
        let m = LeastSquares::default().descend(&r, &[-5.0, 7.0]).unwrap();
        assert!((m.at[0] - 1.999).abs() < 1e-6 && m.at[1] == 7.0 && (m.cost - 9.0).abs() < 1e-9);
        let never = |_: &[f64]| None;
        assert!(LeastSquares::default().descend(&never, &[0.0]).is_none());
        let nan = |_: &[f64]| Some(vec![f64::NAN]);
        assert!(LeastSquares::default().descend(&nan, &[0.0]).is_none());
    }
}
