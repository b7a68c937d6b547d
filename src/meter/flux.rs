//! Flux from a source stop through a receptor stop, by way of a surface.
//!
//! `Phi = int_S int_R f_r(wi, wo) cos_theta_i cos_theta_r dwo dwi`, radiance 1 and uniform over the source stop `S`,
//! specimen overfilled. The specular core adds `int_S R cos_theta_i [mirror(wi) in R] dwi`.
//!
//! The integrand may be a spike 0.01 deg wide or flat, so two strategies share it: (a) directions drawn by the surface and counted if
//! they hit the receptor, (b) directions uniform in the receptor. Any two weights that sum to 1 leave the mean alone (Veach 1997,
//! section 9.2); here `w_a = taper pa / (pa + pb)`, the balance heuristic times a taper that falls smoothly to 0 at the receptor's
//! edge. Strategy (a) alone sees that edge as a jump, which is what slows low-discrepancy points down; tapered, the whole
//! integrand is smooth and the error falls nearly as 1/N.

use super::geometry::Geometry;
use crate::math::quadrature::gauss_legendre;
use crate::math::solid_angle::RectangularAperture;
use crate::optics::Brdf;
use glam::DVec3;
use std::f64::consts::PI;

/// Outer part of the receptor's half width over which strategy (a) hands over to (b). The mirror image of the source stop
/// stays within 70 % of every standard receptor, so a narrow lobe never meets the taper.
const TAPER: f64 = 0.25;

/// Nodes per axis for the specular core: its integrand is smooth and a few degrees wide.
const CORE_NODES: usize = 12;

/// Source and receptor in place at one azimuth.
pub struct Path {
    source: RectangularAperture,
    receptor: RectangularAperture,
    geometry: Geometry,
    phi: f64,
}

impl Path {
    /// Source at azimuth `phi` [rad] of the specimen, receptor opposite.
    pub fn new(geometry: &Geometry, phi: f64) -> Self {
        let [source_width, source_height] = geometry.source;
        let [width, height] = geometry.receptor;
        Path {
            source: RectangularAperture::new(geometry.theta_i, phi, source_width, source_height),
            receptor: RectangularAperture::new(geometry.theta_i + geometry.offset, phi + PI, width, height),
            geometry: geometry.clone(),
            phi,
        }
    }

    /// One unbiased estimate of the flux without the specular core [sr^2], for `u` in `[0, 1)^4`.
    pub fn estimate(&self, brdf: &dyn Brdf, u: [f64; 4]) -> f64 {
        let (wi, source_density) = self.source.direction([u[0], u[1]]);
        if wi.z <= 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        if let Some(sample) = brdf.sample(wi, [u[2], u[3]])
            && !sample.specular
        {
            sum += sample.weight * self.share_of_lobe(sample.wo, sample.pdf);
        }
        let (wo, density) = self.receptor.direction([u[2], u[3]]);
        if wo.z > 0.0 {
            let f = brdf.eval(wi, wo);
            if f > 0.0 {
                sum += f * wo.z / density * (1.0 - self.share_of_lobe(wo, brdf.pdf(wi, wo)));
            }
        }
        sum * wi.z / source_density
    }

    /// Weight of strategy (a) at `wo`, which it draws with density `pdf`.
    fn share_of_lobe(&self, wo: DVec3, pdf: f64) -> f64 {
        let Some([x, y]) = self.receptor.position(wo) else {
            return 0.0;
        };
        let inside = (1.0 - x.abs().max(y.abs())) / TAPER;
        let taper = if inside >= 1.0 { 1.0 } else { inside * inside * (3.0 - 2.0 * inside) };
        taper * pdf / (pdf + self.receptor.density(wo))
    }

    /// Flux of the specular core [sr], times the source's solid angle: Gauss-Legendre over exactly those
    /// source directions whose mirror image the receptor accepts.
    ///
    /// In the source's tangent plane the receptor is bounded by straight lines (great circles project to lines), so the accepted part is
    /// `x` in an interval and `|y|` below a line: no jump is left for the rule to step over.
    pub fn core(&self, reflectance: impl Fn(DVec3) -> f64) -> f64 {
        let g = &self.geometry;
        let half = |full: f64| (full / 2.0).tan();
        let (sin, cos) = g.offset.sin_cos();
        // x runs along growing theta, for the mirrored source as for the receptor.
        let receptor_half = g.receptor[0] / 2.0;
        let low = (g.offset - receptor_half).tan().max(-half(g.source[0]));
        let high = (g.offset + receptor_half).tan().min(half(g.source[0]));
        if high <= low {
            return 0.0;
        }
        let rule = gauss_legendre(CORE_NODES);
        let (full_x, full_y) = (2.0 * half(g.source[0]), 2.0 * half(g.source[1]));
        let mut flux = 0.0;
        for &(a, wa) in &rule {
            let x = 0.5 * (low + high + (high - low) * a);
            let reach = (half(g.receptor[1]) * (cos + x * sin)).min(half(g.source[1]));
            for &(b, wb) in &rule {
                let y = reach * b;
                let (wi, density) = self.source.direction([0.5 + x / full_x, 0.5 + y / full_y]);
                // Share of the stop's plane area that this node stands for.
                let share = 0.25 * wa * wb * (high - low) * 2.0 * reach / (full_x * full_y);
                flux += share / density * reflectance(wi) * wi.z.max(0.0);
            }
        }
        flux
    }

    /// Azimuth of the source [rad].
    pub fn phi(&self) -> f64 {
        self.phi
    }
}
