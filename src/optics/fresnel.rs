//! Fresnel reflectance of a smooth interface seen from air, unpolarised light.

/// `R = (r_s^2 + r_p^2) / 2` of a dielectric of index `n` at `cos_theta`.
///
/// `cos_theta` outside `[0, 1]` is clamped; R is 1 at grazing. As [`dielectric_of_square`].
#[inline]
pub fn dielectric(cos_theta: f64, n: f64) -> f64 {
    let c = cos_theta.clamp(0.0, 1.0);
    dielectric_of_square(c * c, n)
}

/// The same from `c2 = cos^2_theta` in `[0, 1]`, which needs one root and one division:
/// `R = (n^2 - 1)^2 (P^2 + k^2 S^2) / (2 S^2 P^2)`, `S = (c + n ct)^2`, `P = n^2 (n c + ct)^2`, `k = c2 (n^2 + 1) - 1`, `ct` the
/// cosine inside.
///
/// That is `r_s = (c - n ct) / (c + n ct)` and `r_p = (n c - ct) / (n c + ct)` (Born and Wolf, Principles of Optics, section
/// 1.5.2), each times its own denominator above and below: the numerators are then free of `ct` and of cancellation.
#[inline(always)]
pub fn dielectric_of_square(c2: f64, n: f64) -> f64 {
    let step = n * n - 1.0;
    // The square of n ct.
    let inside = step + c2;
    if inside <= 0.0 {
        return 1.0;
    }
    let cross = 2.0 * (c2 * inside).sqrt();
    let s = c2 + inside + cross;
    let p = n * n * (n * n * c2 + cross) + inside;
    let (k, above) = (c2 * (n * n + 1.0) - 1.0, step * step);
    let (ks, sp) = (k * s, s * p);
    0.5 * above * (p * p + ks * ks) / (sp * sp)
}

/// `R` of a conductor of index `n + i k`: `e = (n + ik)^2`, `g = sqrt(e - sin^2)`,
/// `r_s = (c - g) / (c + g)`, `r_p = (e c - g) / (e c + g) = r_s (c g - sin^2) / (c g + sin^2)`.
///
/// Free of divisions by `c`, so it holds at grazing. Source: Born and Wolf, section 14.2. As [`conductor_of_square`].
#[inline]
pub fn conductor(cos_theta: f64, n: f64, k: f64) -> f64 {
    let c = cos_theta.clamp(0.0, 1.0);
    conductor_of_square(c * c, n, k)
}

/// The same from `c2 = cos^2_theta` in `[0, 1]`, which needs two roots and one division:
/// `R = (A - B) C / ((A + B) (C + B sin^2))`, `A = c2 + |g|^2`, `B = 2 c Re g`, `C = c2 |g|^2 + sin^4`.
#[inline(always)]
pub fn conductor_of_square(c2: f64, n: f64, k: f64) -> f64 {
    let sin2 = 1.0 - c2;
    let (re, im) = (n * n - k * k - sin2, 2.0 * n * k);
    // Squares of indices are far from overflow, and a root is cheaper than hypot.
    let modulus = (re * re + im * im).sqrt();
    let a = c2 + modulus;
    let b = (2.0 * c2 * (modulus + re).max(0.0)).sqrt();
    let c = c2 * modulus + sin2 * sin2;
    let below = (a + b) * (c + b * sin2);
    if below == 0.0 { 1.0 } else { (a - b) * c / below }
}

/// `[Re g, (Im g)^2]` of `g = sqrt((n + ik)^2 - sin^2)`.
#[inline]
fn root(n: f64, k: f64, sin2: f64) -> [f64; 2] {
    let (re, im) = (n * n - k * k - sin2, 2.0 * n * k);
    let modulus = (re * re + im * im).sqrt();
    [((modulus + re).max(0.0) / 2.0).sqrt(), (modulus - re).max(0.0) / 2.0]
}

/// `[R_s, R_p]` of an interface of index `n + i k`, `k = 0` for a clear one; formulas of [`conductor`].
#[inline]
pub fn polarised(cos_theta: f64, n: f64, k: f64) -> [f64; 2] {
    let c = cos_theta.clamp(0.0, 1.0);
    let sin2 = 1.0 - c * c;
    let (er, ei) = (n * n - k * k, 2.0 * n * k);
    let [gr, gi2] = root(n, k, sin2);
    let gi = gi2.sqrt();
    let ratio = |ar: f64, ai: f64| {
        // |a - g|^2 / |a + g|^2
        let denominator = (ar + gr).powi(2) + (ai + gi).powi(2);
        if denominator == 0.0 { 1.0 } else { ((ar - gr).powi(2) + (ai - gi).powi(2)) / denominator }
    };
    [ratio(c, 0.0), ratio(er * c, ei * c)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cos_deg(d: f64) -> f64 {
        d.to_radians().cos()
    }

    /// TV01-TV05.
    #[test]
    fn dielectric_vectors() {
        let cases = [
            (0.0, 0.04),
            (20.0, 0.0402662286665),
            (60.0, 0.0891867128022),
            (85.0, 0.612799645265),
            (1.5f64.atan().to_degrees(), 0.0739644970414),
        ];
        for (angle, r) in cases {
            assert!((dielectric(cos_deg(angle), 1.5) - r).abs() < 1e-10);
        }
        assert_eq!(dielectric(0.0, 1.5), 1.0);
        assert_eq!(dielectric(-0.1, 1.5), 1.0);
    }

    /// TV06: aluminium at 550 nm.
    #[test]
    fn conductor_vectors() {
        for (angle, r) in [(0.0, 0.91536850356), (60.0, 0.900334880565), (80.0, 0.859759505185)] {
            assert!((conductor(cos_deg(angle), 1.0152, 6.6273) - r).abs() < 1e-9);
        }
        assert!((conductor(0.0, 1.0, 6.6) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for angle in [0.0, 20.0, 56.0, 85.0, 89.9] {
            let c = cos_deg(angle);
            assert!((conductor(c, 1.5, 0.0) - dielectric(c, 1.5)).abs() < 1e-14);
        }
    }

    /// Two forms of r_p, one of them without squares of the index. Where `g` is all but imaginary its real part keeps
    /// twelve digits.
    #[test]
    fn a_conductor_is_the_mean_of_its_polarised_parts() {
        for (n, k) in [(1.0152, 6.6273), (0.05, 3.3), (2.9, 3.1), (1.5, 1e-6), (0.01, 0.01), (9.0, 40.0), (1.0, 0.0)] {
            for angle in 0..=180 {
                let c = cos_deg(0.5 * f64::from(angle));
                let [s, p] = polarised(c, n, k);
                let found = conductor(c, n, k);
                assert!((found - 0.5 * (s + p)).abs() < 1e-12, "{n} {k} {angle}: {found} {s} {p}");
            }
        }
        assert_eq!(conductor(0.0, 1.0, 0.0), 1.0);
    }

    /// TV02-TV05 and TV08: both polarisations, and the standard glass.
    #[test]
    fn polarised_vectors() {
        let brewster = 56.309932474;
        for (angle, s, p) in [
            (20.0, 0.0470809333588, 0.0334515239742),
            (60.0, 0.176571488083, 0.00180193752159),
            (85.0, 0.732345478711, 0.493253811819),
            (brewster, 0.147928994083, 0.0),
        ] {
            let [got_s, got_p] = polarised(cos_deg(angle), 1.5, 0.0);
            assert!((got_s - s).abs() < 1e-10 && (got_p - p).abs() < 1e-10, "{angle}: {got_s} {got_p}");
        }
        for (angle, r) in [(20.0, 0.04907810), (60.0, 0.10005603), (85.0, 0.61914821)] {
            assert!((dielectric(cos_deg(angle), 1.567) - r).abs() < 1e-8);
        }
    }

    /// At Brewster's angle R_p vanishes and R_s is twice the mean.
    #[test]
    fn polarised_parts() {
        let c = 1.0 / (1.0f64 + 1.5 * 1.5).sqrt();
        let [s, p] = polarised(c, 1.5, 0.0);
        assert!(p.abs() < 1e-15 && (s - 2.0 * 0.0739644970414).abs() < 1e-10);
        let [s, p] = polarised(1.0, 1.0152, 6.6273);
        assert!((s - p).abs() < 1e-14);
    }

    /// TV07: cosine-weighted hemispherical mean.
    #[test]
    fn mean_reflectance() {
        let sum: f64 = crate::math::quadrature::gauss_legendre(64)
            .iter()
            .map(|(x, w)| {
                let mu = (x + 1.0) / 2.0;
                w / 2.0 * 2.0 * mu * dielectric(mu, 1.5)
            })
            .sum();
        assert!((sum - 0.0917779593424).abs() < 1e-8);
    }
}
