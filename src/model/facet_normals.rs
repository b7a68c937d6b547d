//! How facet normals lie, as the Beard-Maxwell models count them: `Xi(theta_h)` \[1/sr\], facet area per steradian of
//! normals.
//!
//! Each law can be drawn from in closed form; the density of the draws need not be `Xi cos_theta_h` to the letter, but is
//! known exactly.

use super::zero_bistatic::ZeroBistatic;
use std::f64::consts::{PI, TAU};

/// A law of facet normals.
#[derive(Debug, Clone, PartialEq)]
pub enum FacetNormals {
    /// `Xi = B / (cos_theta_h (sigma^2 + tan^2 theta_h))`.
    Cauchy { sigma: f64, bias: f64 },
    /// `Xi = B exp(-tan^2 theta_h / (2 sigma^2)) / (2 pi sigma^2 cos^3 theta_h)`.
    Gaussian { sigma: f64, bias: f64 },
    /// `Xi = 4 f_zb(theta_h) cos^2 theta_h / R(0)`, `f_zb` measured with source and detector in one direction.
    Scan { scan: ZeroBistatic, normal_reflectance: f64 },
}

/// `B` with `int Xi cos_theta_h dw_h = 1` for the Cauchy law: `B = a / (2 pi (artanh(sqrt a) / sqrt a - 1))`,
/// `a = 1 - sigma^2`.
pub fn cauchy_bias(sigma: f64) -> f64 {
    let a = 1.0 - sigma * sigma;
    let root = a.abs().sqrt();
    // Series where the difference would cancel.
    let rest = if root < 1e-2 {
        a / 3.0 + a * a / 5.0 + a * a * a / 7.0
    } else if a > 0.0 {
        // artanh(sqrt a) with 1 - a = sigma^2 kept exact.
        ((1.0 + root) / sigma).ln() / root - 1.0
    } else {
        root.atan() / root - 1.0
    };
    if a == 0.0 { 3.0 / TAU } else { a / (TAU * rest) }
}

impl FacetNormals {
    /// `Xi` \[1/sr\] at `cos_theta_h` in `(0, 1]`.
    #[inline]
    pub fn xi(&self, cos_theta_h: f64) -> f64 {
        self.xi_at(cos_theta_h, cos_theta_h.acos())
    }

    /// [`FacetNormals::xi`] where the angle is known beside its cosine.
    #[inline]
    pub fn xi_at(&self, cos_theta_h: f64, theta_h: f64) -> f64 {
        let c2 = cos_theta_h * cos_theta_h;
        match self {
            FacetNormals::Cauchy { sigma, bias } => bias * cos_theta_h / (sigma * sigma * c2 + (1.0 - c2)),
            FacetNormals::Gaussian { sigma, bias } => {
                let v = 2.0 * sigma * sigma;
                bias * (-(1.0 - c2) / (v * c2)).exp() / (PI * v * c2 * cos_theta_h)
            }
            FacetNormals::Scan { scan, normal_reflectance } => 4.0 * scan.at(theta_h) * c2 / normal_reflectance,
        }
    }

    /// About `int Xi cos_theta_h dw_h`, for choosing what to draw.
    pub fn strength(&self) -> f64 {
        match self {
            FacetNormals::Cauchy { sigma, bias } => bias / cauchy_bias(*sigma),
            FacetNormals::Gaussian { bias, .. } => *bias,
            FacetNormals::Scan { scan, normal_reflectance } => 4.0 * scan.integral() / normal_reflectance,
        }
    }

    /// `cos_theta_h` of the draw `u` in `[0, 1)`; azimuth uniform.
    pub fn draw(&self, u: f64) -> f64 {
        match self {
            FacetNormals::Cauchy { sigma, .. } => {
                // c^2 = (1 - sigma^(2 (1 - u))) / a, with its limit at sigma = 1.
                let a = 1.0 - sigma * sigma;
                let v = 1.0 - u;
                if a.abs() < 1e-9 { v.sqrt() } else { (-(v * 2.0 * sigma.ln()).exp_m1() / a).sqrt().min(1.0) }
            }
            FacetNormals::Gaussian { sigma, .. } => 1.0 / (1.0 - 2.0 * sigma * sigma * (-u).ln_1p()).sqrt(),
            FacetNormals::Scan { scan, .. } => scan.draw(u),
        }
    }

    /// Density of the draws per steradian of normals.
    #[inline]
    pub fn density(&self, cos_theta_h: f64) -> f64 {
        let c2 = cos_theta_h * cos_theta_h;
        match self {
            FacetNormals::Cauchy { sigma, .. } => {
                let a = 1.0 - sigma * sigma;
                let share = if a.abs() < 1e-9 { 1.0 } else { -a / (2.0 * sigma.ln()) };
                share * cos_theta_h / (PI * (sigma * sigma * c2 + (1.0 - c2)))
            }
            FacetNormals::Gaussian { sigma, .. } => {
                let v = 2.0 * sigma * sigma;
                (-(1.0 - c2) / (v * c2)).exp() / (PI * v * c2 * cos_theta_h)
            }
            FacetNormals::Scan { scan, .. } => scan.density(cos_theta_h),
        }
    }

    /// Share of the draws with `tan theta_h` up to `t`.
    pub fn distribution(&self, t: f64) -> f64 {
        match self {
            FacetNormals::Cauchy { sigma, .. } => {
                let c2 = 1.0 / (1.0 + t * t);
                let a = 1.0 - sigma * sigma;
                if a.abs() < 1e-9 { 1.0 - c2 } else { 1.0 - (-a * c2).ln_1p() / (2.0 * sigma.ln()) }
            }
            FacetNormals::Gaussian { sigma, .. } => -(-t * t / (2.0 * sigma * sigma)).exp_m1(),
            FacetNormals::Scan { scan, .. } => scan.distribution(1.0 / t.hypot(1.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::gauss_legendre;

    /// TV38 and the other values of the same formula.
    #[test]
    fn normalised_bias() {
        for (sigma, b) in [(0.02, 0.04412), (0.05, 0.0589545309968), (0.1, 0.07846), (0.2, 0.11405)] {
            assert!((cauchy_bias(sigma) - b).abs() < if sigma == 0.05 { 1e-10 } else { 5e-6 }, "{sigma}");
        }
        // Both branches and the series meet at sigma = 1.
        for d in [1e-9, 1e-4, 4.9e-5, 5.1e-5] {
            assert!((cauchy_bias(1.0 + d) - cauchy_bias(1.0 - d)).abs() < 4.0 * d + 1e-12);
        }
        assert!((cauchy_bias(1.0) - 3.0 / TAU).abs() < 1e-15);
    }

    /// Projected area 1 for the normalised Cauchy law, and every density of draws integrates to 1 and to its
    /// distribution.
    #[test]
    fn laws_and_draws_are_normalised() {
        let scan = ZeroBistatic::new(&[(0.0, 9.0), (0.1, 4.0), (0.5, 0.3), (1.4, 0.0)]).unwrap();
        let cauchy = |sigma: f64| FacetNormals::Cauchy { sigma, bias: cauchy_bias(sigma) };
        let laws = [
            cauchy(0.05),
            cauchy(0.4),
            cauchy(1.0),
            cauchy(1.5),
            FacetNormals::Gaussian { sigma: 0.1, bias: 1.0 },
            FacetNormals::Scan { scan, normal_reflectance: 0.04 },
        ];
        let rule = gauss_legendre(24);
        for law in &laws {
            // Over ln tan, where lobes of any width are smooth.
            let (mut projected, mut drawn) = (0.0, 0.0);
            let (low, high, cells) = (-14.0, 14.0, 400);
            for cell in 0..cells {
                for &(x, w) in &rule {
                    let width = (high - low) / f64::from(cells);
                    let l: f64 = low + width * (f64::from(cell) + 0.5 * (x + 1.0));
                    let t = l.exp();
                    let c = 1.0 / t.hypot(1.0);
                    // dw = 2 pi sin dtheta, dtheta = dt c^2.
                    let dw = 0.5 * w * width * TAU * t * t * c * c * c;
                    drawn += dw * law.density(c);
                    projected += dw * law.xi(c) * c;
                }
                let t = (low + (high - low) * f64::from(cell + 1) / f64::from(cells)).exp();
                assert!((law.distribution(t) - drawn).abs() < 2e-3, "{law:?} {t}: {drawn}");
            }
            // The density of a scan's draws has steps, which the rule blurs.
            let steps = matches!(law, FacetNormals::Scan { .. });
            assert!((drawn - 1.0).abs() < if steps { 2e-3 } else { 2e-4 }, "{law:?}: {drawn}");
            if let FacetNormals::Cauchy { .. } = law {
                assert!((projected - 1.0).abs() < 1e-6, "{law:?}: {projected}");
            }
            assert!((projected / law.strength() - 1.0).abs() < 0.02, "{law:?}: {projected} {}", law.strength());
            for u in [0.0, 0.1, 0.5, 0.9, 0.999] {
                let c = law.draw(u);
                assert!(c > 0.0 && c <= 1.0);
                let share = law.distribution((1.0 - c * c).max(0.0).sqrt() / c);
                assert!((share - u).abs() < 1e-6, "{law:?} {u}: {share}");
            }
        }
    }
}
