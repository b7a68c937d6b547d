//! The sum of He and Torrance, `Sigma(g, q) = sum_{m>=1} g^m e^-g / (m! m) exp(-q / m)`, from mirror to very rough.
//!
//! The terms peak at `m*`, where `ln(g / m) + q / m^2 = 0`, with the width `(1/m + 2 q / m^3)^-1/2`. Up to `m*` of about
//! 50 all terms within 8 widths are added, by a recurrence. Beyond, the terms are a smooth bell and every `h`-th one is
//! taken, h up to 0.8 widths: the trapezoid rule of a bell is exact to `exp(-2 pi^2 (width / h)^2)`, 4e-14. So the cost
//! does not grow with roughness (200 terms, the habit of older programs, are too few beyond g 150).

use std::f64::consts::TAU;

/// Widths of the bell on either side.
const REACH: f64 = 8.0;

/// `Sigma(g, q)` for `g >= 0`, `q >= 0`.
pub fn sigma(g: f64, q: f64) -> f64 {
    if !(g > 0.0) || !q.is_finite() {
        return 0.0;
    }
    let peak = peak(g, q);
    let width = 1.0 / (1.0 / peak + 2.0 * q / peak.powi(3)).sqrt();
    let first = (peak - REACH * width - 2.0).floor().max(1.0);
    // The tail above falls off slower than a bell while m is small.
    let last = (peak + REACH * width + 15.0).ceil();
    if first > 1.0 && width > 2.5 {
        let stride = (0.8 * width).floor();
        let mut sum = 0.0;
        let mut m = first;
        while m <= last {
            sum += (log_poisson(g, m) - m.ln() - q / m).exp();
            m += stride;
        }
        return stride * sum;
    }
    let mut weight = log_poisson(g, first).exp();
    let (mut m, mut sum) = (first, 0.0);
    while m <= last {
        let reciprocal = 1.0 / m;
        sum += weight * reciprocal * (-q * reciprocal).exp();
        m += 1.0;
        weight *= g / m;
    }
    sum
}

/// Where the terms are largest, at least 1.
fn peak(g: f64, q: f64) -> f64 {
    // x = ln(g / m) + q / m^2 falls with m; Newton in ln m from the larger of both scales.
    let mut m = g.max(q.cbrt()).max(1.0);
    for _ in 0..30 {
        let curve = q / (m * m);
        let step = ((g / m).ln() + curve) / (1.0 + 2.0 * curve);
        m = (m * step.clamp(-1.5, 1.5).exp()).max(1.0);
        if step.abs() < 0.02 || (m == 1.0 && step < 0.0) {
            break;
        }
    }
    m
}

/// `ln(g^m e^-g / m!)` for whole `m >= 1`.
pub fn log_poisson(g: f64, m: f64) -> f64 {
    if m < 12.0 {
        let factorial: f64 = (2..=m as u32).map(f64::from).product();
        return m * g.ln() - g - factorial.ln();
    }
    // Stirling, with the large parts taken together: m ln(g/m) + m - g loses no digits near g = m.
    let x = (g - m) / m;
    let large = if x.abs() < 0.1 { m * (x.ln_1p() - x) } else { m * (g / m).ln() + m - g };
    let m2 = m * m;
    large - 0.5 * (TAU * m).ln() - (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * m2)) / m2) / m2) / m
}

/// Draws `m` from the Poisson distribution of mean `g` with the uniform number `u`, and returns what is left of `u`, again
/// uniform in `[0, 1)`.
pub fn draw(g: f64, u: f64) -> (f64, f64) {
    // The sum starts where less than 1e-16 lies below.
    let mut m = (g - 8.5 * g.sqrt() - 4.0).floor().max(0.0);
    let mut weight = if m == 0.0 { (-g).exp() } else { log_poisson(g, m).exp() };
    let last = g + 12.0 * g.sqrt() + 40.0;
    let mut below = 0.0;
    while u >= below + weight && m < last {
        below += weight;
        m += 1.0;
        weight *= g / m;
    }
    (m, ((u - below) / weight).clamp(0.0, 1.0 - f64::EPSILON))
}

/// The limit of [`sigma`] for large g: `exp(-q / g) / g`.
#[cfg(test)]
fn rough_limit(g: f64, q: f64) -> f64 {
    (-q / g).exp() / g
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All terms, in logarithms; the logarithm of the weight is summed with its rounding error carried along (Kahan), or
    /// 20 thousand terms would cost seven digits.
    fn slow(g: f64, q: f64) -> f64 {
        let last = (g + 20.0 * g.sqrt() + 100.0 + 40.0 * q.cbrt()) as u32;
        let (mut log_weight, mut carried, mut sum) = (-g, 0.0, 0.0);
        for m in 1..=last {
            let m = f64::from(m);
            let step = (g / m).ln() - carried;
            let next = log_weight + step;
            carried = (next - log_weight) - step;
            log_weight = next;
            sum += (log_weight - m.ln() - q / m).exp();
        }
        sum
    }

    #[test]
    fn fast_sum_against_all_terms() {
        for g in [1e-6f64, 0.01, 0.5, 1.0, 3.0, 8.0, 17.0214, 40.0, 60.0, 77.0, 150.0, 400.0, 3000.0, 20_000.0] {
            for q in [0.0, 0.1, 1.0, 10.0, g, 5.0 * g, 20.0 * g, 10.0 * g * g.sqrt()] {
                let (fast, slow) = (sigma(g, q), slow(g, q));
                assert!((fast - slow).abs() <= 1e-10 * slow + 1e-200, "g {g} q {q}: {fast} {slow}");
            }
        }
        assert_eq!((sigma(0.0, 1.0), sigma(1.0, f64::INFINITY)), (0.0, 0.0));
        for q in [0.0, 1e5, 3e5] {
            assert!((sigma(1e5, q) / rough_limit(1e5, q) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn poisson_weights_and_draws() {
        for g in [0.3, 5.0, 80.0, 2500.0] {
            // The quantiles of the mean and the variance.
            let n = 20_000;
            let draws: Vec<f64> = (0..n).map(|k| draw(g, (f64::from(k) + 0.5) / f64::from(n)).0).collect();
            let mean = draws.iter().sum::<f64>() / f64::from(n);
            let variance = draws.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / f64::from(n);
            assert!((mean / g - 1.0).abs() < 1e-3 && (variance / g - 1.0).abs() < 5e-3, "{g}: {mean} {variance}");
            for u in [0.0, 1e-17, 0.5, 1.0 - 1e-16] {
                let (m, rest) = draw(g, u);
                assert!(m.is_finite() && (0.0..1.0).contains(&rest));
            }
        }
        let stirling = log_poisson(20.0, 15.0);
        let exact = 15.0 * 20f64.ln() - 20.0 - (1..=15).map(|k| f64::from(k).ln()).sum::<f64>();
        assert!((stirling - exact).abs() < 1e-12 && (log_poisson(1.0, 1.0) + 1.0).abs() < 1e-15);
    }
}
