//! Metallic paint as a multi-angle instrument reads it: tristimulus values at three angles from the mirror direction.
//!
//! `f_r = sum_k s_k X_k(gamma) / pi`, `s_k` the linear sRGB of tristimulus value k of the perfect diffuser, `X_k` its
//! reflectance factor through 15, 45 and 110 deg ([`Metallic`]).

use super::spectral::{Spectral, tristimulus_shares};
use crate::error::{Error, Result};
use crate::math::direction;
use crate::model::CosineTable;
use crate::model::metallic::Metallic;
use crate::optics::colour::{Illuminant, white};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::sync::Arc;

/// X, Y, Z at 15, 45 and 110 deg from the mirror direction under D65 and the CIE 1931 observer, Y = 100 for the perfect
/// diffuser (ASTM E2194, ASTM E308).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetallicPaint {
    pub xyz: [[f64; 3]; 3],
}

impl MetallicPaint {
    /// # Errors
    /// `Error::Parameter` if a value is negative, above 10 000, or not a number.
    pub fn new(xyz: [[f64; 3]; 3]) -> Result<Self> {
        if let Some(bad) = xyz.iter().flatten().find(|v| !(0.0..=1e4).contains(*v)) {
            return Err(Error::parameter(
                format!("{bad} is no tristimulus value of a paint"),
                "give X, Y, Z from 0 up, with Y = 100 for the perfect diffuser",
            ));
        }
        Ok(MetallicPaint { xyz })
    }

    /// Reflectance factor of the tristimulus value `k` relative to that of the perfect diffuser, at the three angles.
    pub fn factors(&self, k: usize) -> [f64; 3] {
        let white = white(Illuminant::D65)[k];
        self.xyz.map(|angle| angle[k] / (100.0 * white))
    }

    /// The flakes alone.
    pub fn bare(&self) -> Spectral {
        let part = |(k, share)| -> (Box<dyn Brdf>, DVec3) { (Box::new(Metallic::new(self.factors(k))), share) };
        Spectral::sum(vec![tristimulus_shares().into_iter().enumerate().map(part).collect()])
    }

    /// The flakes under a first surface, by the rule of [`crate::model::Layered`], with the colourless coat counted once.
    pub fn coated(&self, coat: Box<dyn Brdf>) -> Spectral {
        let reflectance = CosineTable::new(|theta| coat.albedo(theta));
        let first = Arc::new(FirstSurface { reflectance, brdf: coat });
        let under = |(k, share)| -> (Box<dyn Brdf>, DVec3) {
            (Box::new(Under { first: first.clone(), base: Metallic::new(self.factors(k)) }), share)
        };
        let base = tristimulus_shares().into_iter().enumerate().map(under).collect();
        Spectral::sum(vec![vec![(Box::new(Coat(first.clone())), DVec3::ONE)], base])
    }
}

/// A coat with its albedo by the cosine.
struct FirstSurface {
    brdf: Box<dyn Brdf>,
    reflectance: CosineTable,
}

impl FirstSurface {
    /// `1 - R`
    fn transmitted(&self, w: DVec3) -> f64 {
        (1.0 - self.reflectance.at(w.z)).clamp(0.0, 1.0)
    }
}

/// A first surface that is shared.
struct Coat(Arc<FirstSurface>);

impl Brdf for Coat {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.brdf.eval(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        self.0.brdf.sample(wi, u)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.brdf.pdf(wi, wo)
    }

    fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        self.0.brdf.eval_and_pdf(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.0.brdf.albedo(theta_i)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.0.brdf.specular_core(wi)
    }
}

/// Flakes seen through a first surface: `(1 - R_i)(1 - R_o) f_base`.
struct Under {
    first: Arc<FirstSurface>,
    base: Metallic,
}

impl Brdf for Under {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let base = self.base.eval(wi, wo);
        if base > 0.0 { base * self.first.transmitted(wi) * self.first.transmitted(wo) } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let draw = self.base.sample(wi, u)?;
        let weight = draw.weight * self.first.transmitted(wi) * self.first.transmitted(draw.wo);
        Some(BrdfSample { weight, ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.base.pdf(wi, wo)
    }

    /// At most: without the way back through the coat.
    fn albedo(&self, theta_i: f64) -> f64 {
        self.first.transmitted(direction(theta_i, 0.0)) * self.base.albedo(theta_i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::model::{Layered, parse};
    use crate::render::spectral::to_linear_srgb;

    const RED: MetallicPaint = MetallicPaint { xyz: [[68.30, 52.97, 19.87], [17.50, 12.26, 3.72], [5.14, 3.59, 1.27]] };

    /// What the paint sends to a multi-angle instrument is what the instrument read.
    #[test]
    fn the_instrument_reads_what_went_in() {
        let paint = RED.bare();
        let wi = direction(45f64.to_radians(), 0.0);
        for (angle, xyz) in [15.0f64, 45.0, 110.0].into_iter().zip(RED.xyz) {
            // In the plane of incidence, from the mirror direction towards the source.
            let turned = (45.0 - angle).to_radians();
            let wo = DVec3::new(-turned.sin(), 0.0, turned.cos());
            // The perfect diffuser is exactly white, whatever the rounding of the matrix.
            let diffuser = to_linear_srgb(DVec3::from(white(Illuminant::D65)));
            let expected = to_linear_srgb(DVec3::from(xyz) / 100.0) / diffuser;
            let read = paint.eval_and_pdf(wi, wo).0 * std::f64::consts::PI;
            assert!(
                (read - expected).abs().max_element() < 1e-4 * expected.max_element(),
                "{angle}: {read} {expected}"
            );
        }
        assert!(MetallicPaint::new([[1.0, -1.0, 1.0]; 3]).is_err() && MetallicPaint::new([[f64::NAN; 3]; 3]).is_err());
    }

    /// Coat and base in parts add up to the layered model of each tristimulus value.
    #[test]
    fn a_coated_paint_is_the_layered_model() {
        let coat = || parse("beckmann:alpha=0.1,n=1.5", 550e-9).unwrap();
        let paint = RED.coated(coat());
        let wholes = [0, 1, 2].map(|k| Layered::new(coat(), Box::new(Metallic::new(RED.factors(k)))));
        for (ti, to, phi) in [(0.2, 0.3, 3.0), (1.0, 0.9, 2.5), (0.7, 0.1, 0.4)] {
            let (wi, wo) = (direction(ti, 0.0), direction(to, phi));
            let expected: DVec3 = tristimulus_shares().into_iter().zip(&wholes).map(|(s, w)| s * w.eval(wi, wo)).sum();
            let found = paint.eval_and_pdf(wi, wo).0;
            assert!((found - expected).abs().max_element() < 1e-9 * expected.max_element(), "{found} {expected}");
        }
    }

    const COATS: [&str; 5] = [
        "dielectric:n=1.5",
        "beckmann:alpha=0.05,n=1.5",
        "ggx:alpha=0.3,n=1.5",
        "he-torrance:sigma=0.1um,tau=5um,n=1.5",
        "dielectric:n=2.4",
    ];

    /// As many draws of a lattice.
    fn draws(count: u32) -> impl Iterator<Item = [f64; 2]> {
        (0..count).map(|k| [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|a| (0.5 + a * f64::from(k)).fract()))
    }

    /// A matt base of one reflectance.
    fn matt(rho: f64) -> MetallicPaint {
        let white = white(Illuminant::D65);
        MetallicPaint { xyz: [white.map(|w| 100.0 * rho * w); 3] }
    }

    /// A white furnace in closed form: `R + (1 - R) rho (1 - F)`, `F` what a smooth surface reflects of diffuse light
    /// from outside (Walsh, Dept. Sci. Ind. Res. Illum. Res. Tech. Paper 2, 1926): 0.0918 at n = 1.5.
    #[test]
    fn a_mirror_coat_on_matt_paint_in_a_white_furnace() {
        let paint = matt(0.5).coated(parse("dielectric:n=1.5", 550e-9).unwrap());
        let mirror = parse("dielectric:n=1.5", 550e-9).unwrap();
        let n = 1.5f64;
        let (n2, n4) = (n * n, n.powi(4));
        let diffuse = 0.5
            + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
            + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
            - 2.0 * n.powi(3) * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
            + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln();
        assert!((diffuse - 0.0918).abs() < 1e-4);
        for theta in [0.0, 0.6, 1.2, 1.45] {
            let wi = direction(theta, 0.3);
            let count = 1 << 15;
            let sum: DVec3 = draws(count).map(|u| paint.sample(wi, u).map_or(DVec3::ZERO, |d| d.weight)).sum();
            let r = mirror.albedo(theta);
            let expected = r + (1.0 - r) * 0.5 * (1.0 - diffuse);
            let found = sum / f64::from(count);
            assert!((found - expected).abs().max_element() < 1e-3, "{theta}: {found} {expected}");
        }
    }

    /// A black base takes no draws: the same weights as those of the coat alone.
    #[test]
    fn a_black_base_adds_no_noise() {
        for text in COATS {
            let coat = parse(text, 550e-9).unwrap();
            let paint = matt(0.0).coated(parse(text, 550e-9).unwrap());
            for theta in [0.1, 0.8, 1.4] {
                let wi = direction(theta, 0.3);
                let spread = |weights: Vec<f64>| {
                    let n = weights.len() as f64;
                    let mean = weights.iter().sum::<f64>() / n;
                    (mean, weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / n)
                };
                let bare = spread(draws(1 << 13).map(|u| coat.sample(wi, u).map_or(0.0, |d| d.weight)).collect());
                let over = spread(draws(1 << 13).map(|u| paint.sample(wi, u).map_or(0.0, |d| d.weight.y)).collect());
                assert!((over.0 - bare.0).abs() < 1e-3 * bare.0, "{text} {theta}: {over:?} {bare:?}");
                assert!(over.1 < 1.05 * bare.1 + 1e-12, "{text} {theta}: {over:?} {bare:?}");
            }
        }
    }

    /// Neither the mirror beam, drawn by its energy, nor the flakes weigh much more than both send out.
    #[test]
    fn weights_are_bounded_and_densities_are_those_of_the_draws() {
        let tint = RED.xyz.map(|angle| angle.map(|v| v / 1.2));
        for text in COATS {
            let coat = parse(text, 550e-9).unwrap();
            let paint = MetallicPaint { xyz: tint }.coated(parse(text, 550e-9).unwrap());
            for theta in [0.1, 0.8, 1.4] {
                let wi = direction(theta, 0.0);
                let core = coat.specular_core(wi);
                let (mut specular, mut rest, mut inverse, n) = (0.0, 0.0, 0.0, 1 << 14);
                for draw in draws(n).filter_map(|u| paint.sample(wi, u)) {
                    assert!(draw.weight.abs().max_element() < 3.0, "{text} {theta}: {}", draw.weight);
                    if draw.specular {
                        specular += 1.0;
                        // Its weight times its probability is the core.
                        inverse = core / draw.weight.y;
                    } else {
                        rest += 1.0;
                        let (f_r, pdf) = paint.eval_and_pdf(wi, draw.wo);
                        assert!((pdf / draw.pdf - 1.0).abs() < 1e-12);
                        assert!((f_r * draw.wo.z - draw.weight * pdf).abs().max_element() < 1e-9 * pdf);
                    }
                }
                let n = f64::from(n);
                assert!((specular / n - inverse).abs() < 5e-3, "{text} {theta}: {} {inverse}", specular / n);
                // The density of the rest over the hemisphere, at directions even over it.
                let (mut mass, m) = (0.0, 1 << 18);
                for u in draws(m) {
                    let (s, c) = (std::f64::consts::TAU * u[1]).sin_cos();
                    let r = (1.0 - u[0] * u[0]).sqrt();
                    mass += paint.eval_and_pdf(wi, DVec3::new(r * c, r * s, u[0])).1 * std::f64::consts::TAU;
                }
                let mass = mass / f64::from(m);
                assert!((mass - rest / n).abs() < 0.02, "{text} {theta}: {mass} {}", rest / n);
            }
        }
    }
}
