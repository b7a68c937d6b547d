//! Beckmann microfacets: Gaussian slopes, the geometric limit of a Gaussian random surface.
//!
//! `f_r = R(beta) D G / (4 cos_theta_i cos_theta_r)`, `D = exp(-tan^2 theta_h / alpha^2) / (pi alpha^2 cos^4 theta_h)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `alpha` | sqrt 2 times the rms slope along an axis; 2 Sq / correlation length of a Gaussian surface | | 0 to 2 |
//! | `alpha_x`, `alpha_y` | the same along x and y, instead of `alpha` | | 0 to 2 |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//! | `shadowing` | the factor G; `correlated` by default | | see [`super::microfacet`] |
//!
//! `Lambda(v) = (exp(-v^2) / (v sqrt pi) - erfc v) / 2`, `v = cot theta / alpha(phi)`; `G = 1 / (1 + Lambda_i +
//! Lambda_o)`.
//!
//! Energy: single scatter, albedo at most R; what would scatter twice is lost (0.1 % at alpha 0.3 and
//! normal incidence, 8 % at 60 deg). Reciprocal. Alpha below 1e-4 is a specular core.
//!
//! Sampling: visible normals, pdf `G1 D / (4 cos_theta_i)`, weight `R (1 + Lambda_i) G <= R`. The slope across the
//! plane of incidence is Gaussian; the one along it has an elementary distribution function, inverted by Newton's
//! method (Heitz and d'Eon, Importance sampling microfacet-based BSDFs using the distribution of visible normals,
//! EGSR 2014).
//!
//! Picture: `asperity lobe beckmann:alpha=0.1,n=1.5 ggx:alpha=0.1,n=1.5 -o beckmann_ggx.svg`
//!
//! Sources: Beckmann and Spizzichino 1963; Walter et al., EGSR 2007, equations 25-28; Heitz 2014.

use super::microfacet::{Microfacet, SHADOWING, Shadowing, Shape};
use super::parameter::Parameter;
use super::registry::Entry;
use super::smooth::{EXTINCTION, INDEX};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_2_SQRT_PI, PI};
use std::sync::LazyLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "beckmann",
    summary: "rough interface with Gaussian slopes",
    formula: "f_r = R D G / (4 cos_theta_i cos_theta_r), D = exp(-tan^2/alpha^2) / (pi alpha^2 cos^4)",
    parameters: ROUGH_INTERFACE,
    words: &[SHADOWING],
    interface: true,
    exceeds_one: true,
    energy: "albedo <= R, multiple scattering is lost; with shadowing=none it exceeds 1 at grazing",
    source: "Beckmann 1963; Walter et al. 2007; Heitz 2014",
    example: "beckmann:alpha=0.02,n=1.5",
    build: |v| {
        let shadowing = Shadowing::named(v.word("shadowing"));
        Ok(Box::new(Beckmann::new(v.alpha()?, v.material()?).with_shadowing(shadowing)))
    },
    ..Entry::PLAIN
};

/// Parameters of both microfacet models.
pub const ROUGH_INTERFACE: &[Parameter] = &[
    Parameter::number("alpha", "roughness, sqrt 2 x rms slope along an axis", 0.0, 2.0).decades(0.005, 0.7),
    Parameter::number("alpha_x", "roughness along x", 0.0, 2.0).decades(0.005, 0.7).instead_of("alpha"),
    Parameter::number("alpha_y", "roughness along y", 0.0, 2.0).decades(0.005, 0.7).instead_of("alpha"),
    INDEX,
    EXTINCTION,
];

/// Rough interface with Gaussian slopes.
pub type Beckmann = Microfacet<GaussianSlopes>;

/// `P(e) = exp(-e) / pi`.
#[derive(Debug, Clone, Copy, Default)]
pub struct GaussianSlopes;

impl Shape for GaussianSlopes {
    fn slope_density(e: f64) -> f64 {
        (-e).exp() * FRAC_1_PI
    }

    fn distribution(e: f64) -> f64 {
        -(-e).exp_m1()
    }

    fn quantile(c: f64) -> f64 {
        -(-c).ln_1p()
    }

    fn lambda(z2: f64, s2: f64) -> f64 {
        let v2 = z2 / s2;
        // Beyond v = 6 Lambda is below 1e-17; at v = 0 it is infinite and G rightly 0.
        if v2 >= REACH * REACH {
            0.0
        } else if v2 > 0.0 {
            let v = v2.sqrt();
            0.5 * (-v2).exp() * (0.5 * FRAC_2_SQRT_PI * v * (s2 / z2) - scaled_erfc(v))
        } else {
            f64::INFINITY
        }
    }

    fn share_below(v: f64) -> f64 {
        1.0 - 0.5 * libm::erfc(v)
    }

    fn sample_normal(alpha: [f64; 2], wi: DVec3, u: [f64; 2]) -> DVec3 {
        // On the unit scale the surface looks the same from all azimuths: slopes are drawn in the plane of incidence
        // and turned back.
        let stretched = DVec3::new(alpha[0] * wi.x, alpha[1] * wi.y, wi.z);
        let across = (stretched.x * stretched.x + stretched.y * stretched.y).sqrt();
        let (c, s) = if across > 0.0 { (stretched.x / across, stretched.y / across) } else { (1.0, 0.0) };
        let x = visible_slope(across / wi.z, u[0]);
        let y = gaussian_quantile(u[1]);
        DVec3::new(-alpha[0] * (x * c - y * s), -alpha[1] * (x * s + y * c), 1.0).normalize()
    }
}

/// Where [`scaled_erfc`] ends: slopes beyond this many widths occur once in 1e16 draws.
const REACH: f64 = 6.0;

/// Nodes of [`scaled_erfc`] per unit.
const NODES_PER_UNIT: f64 = 32.0;

/// Taylor's coefficients of `y = exp(v^2) erfc(v)` about the nodes 0 to 6, from `y' = 2 v y - 2 / sqrt pi`.
static SCALED_ERFC: LazyLock<Vec<[f64; 7]>> = LazyLock::new(|| {
    (0..=(REACH * NODES_PER_UNIT) as usize)
        .map(|k| {
            let v = k as f64 / NODES_PER_UNIT;
            let y0 = (v * v).exp() * libm::erfc(v);
            let mut y = [y0, 2.0 * v * y0 - FRAC_2_SQRT_PI, 0.0, 0.0, 0.0, 0.0, 0.0];
            for n in 2..7 {
                // The n-th derivative over n!.
                y[n] = 2.0 * (v * y[n - 1] + y[n - 2]) / n as f64;
            }
            y
        })
        .collect()
});

/// `exp(v^2) erfc(v)` for `v` in `[0, 6]`, so that Lambda needs one exponential and no erfc: Taylor's series of order 6
/// about the nearest node, right to 1e-14.
#[inline]
fn scaled_erfc(v: f64) -> f64 {
    let k = (v * NODES_PER_UNIT + 0.5) as usize;
    let d = v - k as f64 / NODES_PER_UNIT;
    let y = SCALED_ERFC[k];
    // In pairs, so that the products do not wait for each other.
    let d2 = d * d;
    (y[0] + d * y[1]) + d2 * ((y[2] + d * y[3]) + d2 * ((y[4] + d * y[5]) + d2 * y[6]))
}

/// Slope along the plane of incidence with density proportional to `(1 - x t) exp(-x^2)` where positive, `t = tan
/// theta` on the unit scale: the root of `F(x) = u F(1/t)`, `F(x) = (1 + erf x) / 2 + t exp(-x^2) / (2 sqrt pi)`.
///
/// The start is the answer for a view from above, moved by a step of Halley's method.
#[inline]
fn visible_slope(t: f64, u: f64) -> f64 {
    let wanted = if t * REACH > 1.0 { u * share_seen(1.0 / t, t)[0] } else { u };
    let start = gaussian_quantile(wanted.min(1.0));
    let (fall, half) = (1.0 - start * t, 0.5 * t);
    let step = -2.0 * half * fall / (2.0 * fall * fall + half * (t + 2.0 * start * fall));
    if t <= SERIES_TAN && start.abs() <= SERIES_START {
        by_series(t, start, step)
    } else {
        by_newton(t, wanted, start + step)
    }
}

/// Up to here [`by_series`] is right to 1e-6 of the distribution.
const SERIES_TAN: f64 = 0.2;
const SERIES_START: f64 = 2.0;

/// Newton's step at `start + d` on `(F(x) - F_0(start)) sqrt pi / exp(-start^2) = E(d) + t E'(d) / 2`, where `F_0` is F of a
/// view from above: `E' = exp(-2 start d - d^2)` by its power series, which needs no exponential.
#[inline]
fn by_series(t: f64, start: f64, d: f64) -> f64 {
    // (n + 1) c(n + 1) = -2 start c(n) - 2 c(n - 1).
    let mut c = [1.0, -2.0 * start, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for n in 1..7 {
        c[n + 1] = -2.0 * (start * c[n] + c[n - 1]) * INVERSE[n + 1];
    }
    let e = |n: usize| c[n] * INVERSE[n + 1];
    let d2 = d * d;
    let d4 = d2 * d2;
    let gauss = (c[0] + c[1] * d) + d2 * (c[2] + c[3] * d) + d4 * ((c[4] + c[5] * d) + d2 * (c[6] + c[7] * d));
    let sum = (e(0) + e(1) * d) + d2 * (e(2) + e(3) * d) + d4 * ((e(4) + e(5) * d) + d2 * (e(6) + e(7) * d));
    start + d - (d * sum + 0.5 * t * gauss) / ((1.0 - (start + d) * t) * gauss)
}

/// `1 / n`.
const INVERSE: [f64; 9] = [0.0, 1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 1.0 / 6.0, 1.0 / 7.0, 1.0 / 8.0];

/// Newton's method between bounds, for steep views.
#[inline(never)]
fn by_newton(t: f64, wanted: f64, start: f64) -> f64 {
    let (mut low, mut high) = (-REACH, REACH.min(1.0 / t));
    let mut x = start.clamp(low, high);
    for _ in 0..60 {
        let [share, gauss] = share_seen(x, t);
        let excess = share - wanted;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - excess / ((1.0 - x * t) * gauss * FRAC_1_SQRT_PI);
        // Newton's step while it stays between the bounds, else their middle; a step over a vanishing slope fails the
        // test.
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        x = next;
        // Convergence is quadratic: the next step would be the square of this one.
        if step < 1e-4 {
            break;
        }
    }
    x
}

const FRAC_1_SQRT_PI: f64 = 0.5 * FRAC_2_SQRT_PI;

/// `F(x)` of [`visible_slope`], and `exp(-x^2)`, for `|x|` up to [`REACH`].
#[inline]
fn share_seen(x: f64, t: f64) -> [f64; 2] {
    let gauss = (-x * x).exp();
    let below = 0.5 * gauss * scaled_erfc(x.abs());
    let below = if x < 0.0 { below } else { 1.0 - below };
    [below + 0.5 * FRAC_1_SQRT_PI * t * gauss, gauss]
}

/// `x` with `erf x = 2 u - 1`, the rarer tail right within 1e-5 of itself; about 5 at the ends.
///
/// Polynomial in `ln(1 - erf^2 x)` where 99.7 % of the draws lie (Giles, Approximating the erfinv function, GPU
/// Computing Gems 2, 2011, single precision); [`inverse_erf`] beyond.
#[inline]
fn gaussian_quantile(u: f64) -> f64 {
    let y = 2.0 * u - 1.0;
    let w = -(4.0 * u * (1.0 - u)).ln() - 2.5;
    // An infinity or what rounding makes of it fails this comparison.
    if !(w < 2.5) {
        return inverse_erf(y);
    }
    let w2 = w * w;
    let w4 = w2 * w2;
    let low = (1.501_409_41 + 0.246_640_727 * w) + w2 * (-0.004_177_681_64 - 0.001_253_725_03 * w);
    let high = (0.000_218_580_87 - 4.391_506_54e-6 * w) + w2 * (-3.523_387_7e-6 + 3.432_739_39e-7 * w);
    y * (low + w4 * (high + w4 * 2.810_226_36e-8))
}

/// `x` with `erf x = y` within 0.004, by an elementary approximation (Winitzki 2008).
fn rough_inverse_erf(y: f64) -> f64 {
    const A: f64 = 0.147;
    let y = y.clamp(-1.0 + 1e-12, 1.0 - 1e-12);
    let l = (1.0 - y * y).ln();
    let b = 2.0 / (PI * A) + 0.5 * l;
    ((b * b - l / A).sqrt() - b).max(0.0).sqrt().copysign(y)
}

/// `x` with `erf x = y` with the rarer tail right within 1e-5 of itself, by one step of Halley's method; about 5 at
/// the ends.
#[inline(never)]
fn inverse_erf(y: f64) -> f64 {
    let y = y.clamp(-1.0 + 1e-12, 1.0 - 1e-12);
    let x = rough_inverse_erf(y);
    // erf x - y, by erfc where the difference to 1 is what counts.
    let excess = if y.abs() < 0.5 { libm::erf(x) - y } else { (1.0 - y.abs() - libm::erfc(x.abs())) * y.signum() };
    let e = excess * 0.5 * PI.sqrt() * (x * x).exp();
    x - e / (1.0 + x * e)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_of_erf() {
        for y in [-0.9999999, -0.99, -0.5, -1e-9, 0.0, 1e-5, 0.3, 0.499, 0.501, 0.9, 0.999999] {
            assert!((libm::erf(inverse_erf(y)) - y).abs() < 1e-5 * (1.0 - y.abs()), "{y}");
        }
        assert!(inverse_erf(-1.0).is_finite() && inverse_erf(1.0).is_finite());
    }

    #[test]
    fn erfc_without_its_exponential() {
        for k in 0..5999 {
            let v = f64::from(k) * 0.001 + 0.0003;
            let want = (v * v).exp() * libm::erfc(v);
            assert!((scaled_erfc(v) - want).abs() < 2e-14, "{v}: {} {want}", scaled_erfc(v));
        }
    }

    #[test]
    fn quantiles_of_a_gaussian() {
        for k in 1..100_000 {
            let u = f64::from(k) * 1e-5;
            // The rarer tail.
            let (x, tail) = (gaussian_quantile(u), u.min(1.0 - u));
            assert!(
                (0.5 * libm::erfc(x.abs()) / tail - 1.0).abs() < 1e-5 && (x > 0.0) == (u > 0.5) || x.abs() < 1e-9,
                "{u}"
            );
        }
    }

    #[test]
    fn visible_slopes_follow_their_distribution() {
        for t in [0.0, 0.01, 0.1, 0.16, 0.17, 0.2, 0.21, 0.5, 1.0, 3.0, 100.0] {
            let f = |x: f64| 0.5 * PI.sqrt() * (1.0 + libm::erf(x)) + 0.5 * t * (-x * x).exp();
            let whole = f(if t > 1.0 / 6.0 { 1.0 / t } else { 6.0 });
            for u in [0.0, 1e-7, 0.9999999].into_iter().chain((1..1000).map(|k| f64::from(k) * 1e-3)) {
                let x = visible_slope(t, u);
                let limit = if t <= SERIES_TAN { 1e-6 } else { 1e-7 };
                assert!((f(x) / whole - u).abs() < limit, "t {t} u {u}: {x}");
                assert!(x * t <= 1.0 + 1e-9);
            }
        }
    }
}
