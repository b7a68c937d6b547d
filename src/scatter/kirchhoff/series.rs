//! Beckmann's series for a Gaussian surface: the average of the phase integral over all maps.

/// `<|I|^2>_incoherent / A = pi l^2 sum over m >= 1 of g^m e^-g / (m! m) exp(-v_xy^2 l^2 / (4 m))` \[m^2\], for normally
/// distributed heights of autocorrelation `Sq^2 exp(-r^2 / l^2)`.
///
/// `g = (v_z Sq)^2`, `l` the correlation length \[m\], `v_xy` [1/m]. Summed in logarithms from `m = g - 10 sqrt(g)` to
/// `g + 10 sqrt(g) + 40`. Source: Beckmann and Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces,
/// 1963, section 5.3.
pub fn beckmann_spizzichino(g: f64, correlation_length: f64, v_xy: f64) -> f64 {
    if g <= 0.0 {
        return 0.0;
    }
    let x = (0.5 * v_xy * correlation_length).powi(2);
    let first = (g - 10.0 * g.sqrt()).floor().max(1.0) as u64;
    let last = (g + 10.0 * g.sqrt() + 40.0).ceil() as u64;
    let sum: f64 = (first..=last)
        .map(|m| {
            let m = m as f64;
            (m * g.ln() - g - libm::lgamma(m + 1.0) - m.ln() - x / m).exp()
        })
        .sum();
    std::f64::consts::PI * correlation_length.powi(2) * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// `integral of S d^2 v / (2 pi)^2 = 1 - exp(-g)`: the incoherent share (Parseval).
    #[test]
    fn holds_all_incoherent_light() {
        for g in [0.01, 1.15, 10.4, 295.0] {
            let l = 10e-6;
            let step = 0.01 * (1.0f64 + g).sqrt() / l;
            let sum: f64 = (0..4000)
                .map(|k| {
                    let v = (f64::from(k) + 0.5) * step;
                    beckmann_spizzichino(g, l, v) * v * step / (2.0 * PI)
                })
                .sum();
            assert!((sum - (1.0 - (-g).exp())).abs() < 1e-3 * sum, "{g}: {sum}");
        }
    }

    /// Rough limit: the slope density `exp(-s^2/alpha^2) / (pi alpha^2)`, s = v_xy / v_z, alpha = 2 Sq / l.
    #[test]
    fn very_rough_surfaces_scatter_by_slope() {
        let (sq, l, v_z) = (3e-6, 40e-6, 2.0e7);
        let alpha: f64 = 2.0 * sq / l;
        for s in [0.0, 0.1, 0.2] {
            let series = beckmann_spizzichino((v_z * sq).powi(2), l, s * v_z) * v_z * v_z / (4.0 * PI * PI);
            let facets = (-(s / alpha).powi(2)).exp() / (PI * alpha * alpha);
            assert!((series / facets - 1.0).abs() < 0.01, "{s}: {series} {facets}");
        }
    }
}
