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
        let across = stretched.x.hypot(stretched.y);
        let (c, s) = if across > 0.0 { (stretched.x / across, stretched.y / across) } else { (1.0, 0.0) };
        let x = visible_slope(across / wi.z, u[0]);
        let y = inverse_erf(2.0 * u[1] - 1.0);
        DVec3::new(-alpha[0] * (x * c - y * s), -alpha[1] * (x * s + y * c), 1.0).normalize()
    }
}

/// Where [`scaled_erfc`] ends.
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
/// theta` on the unit scale: the root of `F(x) = u F(1/t)`, `F(x) = sqrt pi (1 + erf x) / 2 + t exp(-x^2) / 2`.
fn visible_slope(t: f64, u: f64) -> f64 {
    let half_root_pi = 0.5 * PI.sqrt();
    let distribution = |x: f64, gauss: f64| half_root_pi * (1.0 + libm::erf(x)) + 0.5 * t * gauss;
    let limit = if t * SLOPE_LIMIT > 1.0 { 1.0 / t } else { SLOPE_LIMIT };
    let wanted = u * distribution(limit, (-limit * limit).exp());
    let (mut low, mut high) = (-SLOPE_LIMIT, limit);
    // The answer for a view from above.
    let mut x = rough_inverse_erf(2.0 * u - 1.0).clamp(low, high);
    for _ in 0..60 {
        let gauss = (-x * x).exp();
        let excess = distribution(x, gauss) - wanted;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - excess / ((1.0 - x * t) * gauss);
        // Newton's step while it stays between the bounds, else their middle; a step over a vanishing slope fails the
        // test.
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        x = next;
        // Convergence is quadratic: the next step would be the square of this one.
        if step < 1e-5 {
            break;
        }
    }
    x
}

/// Slopes beyond this many widths occur once in 1e16 draws.
const SLOPE_LIMIT: f64 = 6.0;

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
    fn visible_slopes_follow_their_distribution() {
        for t in [0.0, 0.01, 0.5, 1.0, 3.0, 100.0] {
            let f = |x: f64| 0.5 * PI.sqrt() * (1.0 + libm::erf(x)) + 0.5 * t * (-x * x).exp();
            for u in [0.0, 1e-7, 0.1, 0.5, 0.9, 0.9999999] {
                let x = visible_slope(t, u);
                let whole = f(if t > 1.0 / 6.0 { 1.0 / t } else { 6.0 });
                assert!((f(x) / whole - u).abs() < 1e-7, "t {t} u {u}: {x}");
                assert!(x * t <= 1.0 + 1e-9);
            }
        }
    }
}
