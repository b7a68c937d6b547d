//! Metallic paint from three aspecular angles: a flake lobe that falls off exponentially from the mirror direction.
//!
//! `f_r = X(gamma) / pi`, `X(gamma) = A exp(-gamma / b) + C` through `X(15)`, `X(45)`, `X(110 deg)`
//!
//! `gamma` is the angle between `wo` and the mirror direction of `wi`; it is the same for both orders, so the model is
//! reciprocal. `X` is the reflectance factor (1 for a perfect diffuser), as a multi-angle instrument reads it under 45 deg
//! illumination, once per wavelength or tristimulus value.
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `x15` | reflectance factor 15 deg from the mirror direction | | 0 to 100 |
//! | `x45` | the same at 45 deg | | 0 to 100 |
//! | `x110` | the same at 110 deg | | 0 to 100 |
//!
//! b solves `(X15 - X45)/(X45 - X110) = (e^(-15/b) - e^(-45/b))/(e^(-45/b) - e^(-110/b))` by bisection; that needs the left
//! side above 30/65 = 0.4615, a lobe that is steeper near the mirror direction. Flatter, rising or equal data take a monotone
//! cubic through the three points instead, level outside them.
//!
//! Energy: not guaranteed; the albedo follows from the data and its extrapolation to gamma 0. Reciprocal. Under a clear
//! coat: `layered:dielectric:n=1.5,over=metallic:x15=1.2,x45=0.6,x110=0.3`.
//!
//! Sampling: half cosine, half `exp(-gamma / b) sin(gamma)` about the mirror direction; cosine alone for the cubic.
//!
//! Picture: `asperity lobe metallic:x15=1.2,x45=0.6,x110=0.3 -o metallic.svg`
//!
//! Sources: A. B. J. Rodrigues, ASTM Standardization News 23(10), 1995, and ASTM E2194 (the three angles); the exponential
//! through them is ours; monotone cubic: Fritsch and Carlson, SIAM J. Numerical Analysis 17, 238, 1980.

use super::albedo::{AlbedoTable, DRAWS, sampled_average};
use super::lambert::cosine_direction;
use super::parameter::Parameter;
use super::registry::Entry;
use crate::math::frame::tangents;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "metallic",
    summary: "metallic paint from three aspecular angles",
    formula: "f_r = (A exp(-gamma/b) + C)/pi through X at 15, 45, 110 deg from the mirror direction",
    parameters: &[
        Parameter::number("x15", "reflectance factor 15 deg from the mirror direction", 0.0, 100.0).usual(0.6, 2.0),
        Parameter::number("x45", "the same at 45 deg", 0.0, 100.0).usual(0.2, 0.5),
        Parameter::number("x110", "the same at 110 deg", 0.0, 100.0).usual(0.02, 0.15),
    ],
    exceeds_one: true,
    energy: "not guaranteed: what the data say",
    source: "ASTM E2194 angles; exponential through three points",
    example: "metallic:x15=1.2,x45=0.6,x110=0.3",
    build: |v| {
        let [x15, x45, x110] = ["x15", "x45", "x110"].map(|key| v.required(key));
        Ok(Box::new(Metallic::new([x15?, x45?, x110?])))
    },
    ..Entry::PLAIN
};

/// The three angles \[rad\].
const GAMMA: [f64; 3] = [15.0 * PI / 180.0, 45.0 * PI / 180.0, 110.0 * PI / 180.0];

/// Reflectance factor as a function of the aspecular angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Falloff {
    /// `A exp(-gamma / b) + C`, b in radians.
    Exponential { a: f64, b: f64, c: f64 },
    /// Values and slopes at the three angles.
    Cubic { x: [f64; 3], slope: [f64; 3] },
}

impl Falloff {
    /// Through `x` at 15, 45 and 110 deg.
    pub fn through(x: [f64; 3]) -> Self {
        let [g15, g45, g110] = GAMMA;
        let (near, far) = (x[0] - x[1], x[1] - x[2]);
        let drop = |b: f64| {
            let e = |g: f64| (-g / b).exp();
            (e(g15) - e(g45)) / (e(g45) - e(g110))
        };
        // From 1 deg, a lobe no instrument at 15 deg would see, to a straight line.
        let (mut low, mut high) = (1f64.to_radians(), 1e4);
        let ratio = near / far;
        if near > 0.0 && far > 0.0 && ratio > drop(high) && ratio < drop(low) {
            for _ in 0..200 {
                let b = (low * high).sqrt();
                if drop(b) > ratio { low = b } else { high = b }
            }
            let b = (low * high).sqrt();
            let a = near / ((-g15 / b).exp() - (-g45 / b).exp());
            let c = x[2] - a * (-g110 / b).exp();
            // A floor below zero would turn f_r negative beyond 110 deg.
            if a * (-PI / b).exp() + c >= 0.0 {
                return Falloff::Exponential { a, b, c };
            }
        }
        let steep = [-near / (g45 - g15), -far / (g110 - g45)];
        // The middle slope is the harmonic mean of its neighbours, 0 at an extremum; the ends are level.
        let middle = if steep[0] * steep[1] > 0.0 { 2.0 * steep[0] * steep[1] / (steep[0] + steep[1]) } else { 0.0 };
        Falloff::Cubic { x, slope: [0.0, middle, 0.0] }
    }

    /// Reflectance factor at `gamma` \[rad\].
    pub fn at(&self, gamma: f64) -> f64 {
        match *self {
            Falloff::Exponential { a, b, c } => a * (-gamma / b).exp() + c,
            Falloff::Cubic { x, slope } => {
                let k = usize::from(gamma > GAMMA[1]);
                let width = GAMMA[k + 1] - GAMMA[k];
                let t = ((gamma - GAMMA[k]) / width).clamp(0.0, 1.0);
                let r = 1.0 - t;
                x[k] * r * r * (1.0 + 2.0 * t)
                    + x[k + 1] * t * t * (3.0 - 2.0 * t)
                    + width * t * r * (slope[k] * r - slope[k + 1] * t)
            }
        }
    }
}

/// Flake lobe of a metallic paint.
#[derive(Debug, Clone)]
pub struct Metallic {
    falloff: Falloff,
    albedo: OnceLock<AlbedoTable>,
}

impl Metallic {
    /// Through the reflectance factors at 15, 45 and 110 deg.
    pub fn new(x: [f64; 3]) -> Self {
        Metallic { falloff: Falloff::through(x), albedo: OnceLock::new() }
    }

    /// Aspecular angle; `atan2` resolves small ones.
    fn gamma(wi: DVec3, wo: DVec3) -> f64 {
        let r = DVec3::new(-wi.x, -wi.y, wi.z);
        r.cross(wo).length().atan2(r.dot(wo))
    }

    /// `int_0^g exp(-t / b) sin t dt`.
    fn mass(b: f64, g: f64) -> f64 {
        let (s, c) = g.sin_cos();
        (1.0 - (-g / b).exp() * (c + s / b)) / (1.0 + 1.0 / (b * b))
    }

    /// The angle below which the share `u` of the lobe lies.
    fn quantile(b: f64, u: f64) -> f64 {
        let wanted = u * Self::mass(b, PI);
        let (mut low, mut high) = (0.0, PI);
        let mut g = (2.0 * wanted).sqrt().min(PI);
        for _ in 0..60 {
            let excess = Self::mass(b, g) - wanted;
            if excess > 0.0 {
                high = g;
            } else {
                low = g;
            }
            let newton = g - excess / ((-g / b).exp() * g.sin());
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let done = (next - g).abs() < 1e-10;
            g = next;
            if done {
                break;
            }
        }
        g
    }
}

impl Brdf for Metallic {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 { 0.0 } else { self.falloff.at(Self::gamma(wi, wo)) * FRAC_1_PI }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let wo = match self.falloff {
            Falloff::Exponential { b, .. } if u[0] < 0.5 => {
                let (sg, cg) = Self::quantile(b, 2.0 * u[0]).sin_cos();
                let r = DVec3::new(-wi.x, -wi.y, wi.z);
                let (t, q) = tangents(r);
                let (s, c) = (TAU * u[1]).sin_cos();
                (sg * c * t + sg * s * q + cg * r).normalize()
            }
            Falloff::Exponential { .. } => cosine_direction([2.0 * u[0] - 1.0, u[1]]),
            Falloff::Cubic { .. } => cosine_direction(u),
        };
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        match self.falloff {
            Falloff::Exponential { b, .. } => {
                let lobe = (-Self::gamma(wi, wo) / b).exp() / (TAU * Self::mass(b, PI));
                0.5 * (lobe + wo.z * FRAC_1_PI)
            }
            Falloff::Cubic { .. } => wo.z * FRAC_1_PI,
        }
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.albedo.get_or_init(|| AlbedoTable::new(1, |wi| sampled_average(self, wi, DRAWS))).at(theta_i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// TV53.
    #[test]
    fn exponential_through_three_angles() {
        let falloff = Falloff::through([60.0, 20.0, 8.0]);
        let Falloff::Exponential { a, b, c } = falloff else { panic!("{falloff:?}") };
        assert!(
            (a - 107.51287).abs() < 1e-4 && (b.to_degrees() - 20.962977).abs() < 1e-5 && (c - 7.434325).abs() < 1e-4
        );
        assert!((falloff.at(25f64.to_radians()) - 40.05779).abs() < 1e-4);
        assert!((falloff.at(75f64.to_radians()) - 10.43811).abs() < 1e-4);
    }

    #[test]
    fn flat_and_rising_data_take_the_cubic() {
        for x in [[1.0, 0.9, 0.1], [0.5, 0.5, 0.5], [0.1, 0.4, 0.9], [0.1, 0.9, 0.2], [0.0, 0.0, 0.0]] {
            let falloff = Falloff::through(x);
            assert!(matches!(falloff, Falloff::Cubic { .. }), "{x:?}: {falloff:?}");
            for (g, want) in GAMMA.iter().zip(x) {
                assert!((falloff.at(*g) - want).abs() < 1e-12);
            }
            let (low, high) = (x.iter().copied().fold(9.0, f64::min), x.iter().copied().fold(0.0, f64::max));
            for k in 0..=180 {
                let v = falloff.at(f64::from(k).to_radians());
                assert!(v >= low - 1e-12 && v <= high + 1e-12);
            }
        }
    }
}
