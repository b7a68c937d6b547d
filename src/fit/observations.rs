//! What a model is fitted to: `f_r` with its error at directions that follow the lobe and cover the floor.

use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::math::{Estimate, direction, frame};
use crate::optics::Brdf;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::fmt::Write;
use std::path::Path;

/// One value of the BRDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    pub wi: DVec3,
    pub wo: DVec3,
    /// `f_r` [1/sr].
    pub f_r: Estimate,
    /// Projected solid angle it stands for \[sr\], up to a common factor.
    pub solid_angle: f64,
}

/// A list of values.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    pub list: Vec<Observation>,
    /// Largest reflectance of the specular core at the incident directions, which is not in the list.
    pub core: f64,
}

/// Where a source is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Incident polar angles \[rad\].
    pub theta_i: Vec<f64>,
    /// Incident azimuths \[rad\]; one for an isotropic source.
    pub phi_i: Vec<f64>,
    /// Detector directions per incident direction.
    pub directions: usize,
}

impl Default for Design {
    fn default() -> Self {
        let theta_i = [5.0, 20.0, 35.0, 50.0, 60.0, 70.0, 80.0].map(f64::to_radians).to_vec();
        Design { theta_i, phi_i: vec![0.0], directions: 160 }
    }
}

/// Share of the directions that cover the hemisphere rather than follow the lobe.
const FLOOR: f64 = 0.35;

/// Generators of a rank-1 lattice in two dimensions: powers of the plastic number (Roberts 2018).
const LATTICE: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

impl Observations {
    /// Looks at `source` where `design` says; `estimate(wi, wo)` is its `f_r` with error.
    ///
    /// Detector directions are two lattices: one put through the sampler of the source, so that it follows the lobe however
    /// narrow, one cosine-weighted. The solid angle of each is `cos_theta_r / (N p)`, `p` the density of both together.
    ///
    /// # Errors
    /// `Error::Parameter` if an angle is not in front of the surface, or the source has nothing but a specular core.
    pub fn of(source: &dyn Brdf, estimate: &dyn Fn(DVec3, DVec3) -> Estimate, design: &Design) -> Result<Self> {
        if let Some(t) = design.theta_i.iter().find(|t| !(**t >= 0.0 && t.to_degrees() < 89.9)) {
            return Err(Error::parameter(
                format!("incident angle {} deg", t.to_degrees()),
                "give angles from 0 to below 89.9 deg",
            ));
        }
        let n = design.directions.max(8);
        let floor = ((n as f64 * FLOOR) as usize).max(1);
        let mut list = Vec::new();
        let mut core = 0.0f64;
        for (&theta, &phi) in design.theta_i.iter().flat_map(|t| design.phi_i.iter().map(move |p| (t, p))) {
            let wi = direction(theta, phi);
            core = core.max(source.specular_core(wi));
            for k in 0..n {
                let u = LATTICE.map(|a| (0.5 + a * (k + 1) as f64).fract());
                let wo = if k < floor {
                    // Not quite to the horizon, where 1 / cos_theta_r rules.
                    Some(direction((0.995 * u[0].sqrt()).asin(), std::f64::consts::TAU * u[1]))
                } else {
                    source.sample(wi, u).filter(|draw| !draw.specular && draw.wo.z > 0.02).map(|draw| draw.wo)
                };
                let Some(wo) = wo else { continue };
                let f_r = estimate(wi, wo);
                let share = floor as f64 / n as f64;
                let density = share * wo.z * FRAC_1_PI + (1.0 - share) * source.pdf(wi, wo);
                let solid_angle = wo.z / (n as f64 * density);
                if f_r.value.is_finite() && f_r.standard_error.is_finite() {
                    list.push(Observation { wi, wo, f_r, solid_angle });
                }
            }
        }
        if list.iter().all(|o| o.f_r.value <= 0.0) {
            return Err(Error::parameter(
                "the source has no lobe to fit: it is black, or a mirror and nothing else",
                "take a source that scatters",
            ));
        }
        Ok(Observations { list, core })
    }

    /// Reads `theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg,f_r_per_sr` and, if there is one, `standard_error` (1/sr).
    ///
    /// # Errors
    /// `Error::Io` or `Error::Content` naming the line and the column at fault.
    pub fn read(path: &Path) -> Result<Self> {
        let columns = Columns::read(path)?;
        let polar = |name: &str| columns.numbers_within(name, 0.0, 89.9);
        let (ti, tr) = (polar("theta_i_deg")?, polar("theta_r_deg")?);
        let (pi, pr) = (columns.numbers("phi_i_deg")?, columns.numbers("phi_r_deg")?);
        let f = columns.numbers_within("f_r_per_sr", 0.0, f64::MAX)?;
        let errors = columns.optional_numbers("standard_error")?.unwrap_or_else(|| vec![0.0; f.len()]);
        if let Some(row) = errors.iter().position(|e| *e < 0.0) {
            return Err(columns.row_fault(
                row,
                "the standard error is negative",
                "give it in 1/sr, 0 if it is unknown",
            ));
        }
        if f.iter().all(|f| *f == 0.0) {
            return Err(Error::content(path, "every f_r is 0", "give a list that scatters"));
        }
        let at = |t: f64, p: f64| direction(t.to_radians(), p.to_radians());
        let list = (0..f.len())
            .map(|k| {
                let (wi, wo) = (at(ti[k], pi[k]), at(tr[k], pr[k]));
                let f_r = Estimate { value: f[k], standard_error: errors[k] };
                Observation { wi, wo, f_r, solid_angle: wo.z }
            })
            .collect();
        Ok(Observations { list, core: 0.0 })
    }

    /// Whether most values come with an error.
    pub fn has_errors(&self) -> bool {
        2 * self.list.iter().filter(|o| o.f_r.standard_error > 0.0).count() > self.list.len()
    }

    /// The list with the values of a model and their logarithmic ratio, as CSV.
    pub fn residual_csv(&self, model: &dyn Brdf) -> String {
        let mut text =
            "theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg,theta_h_deg,f_r_per_sr,standard_error,model_f_r_per_sr,\
                        ln_model_over_data\n"
                .to_owned();
        for o in &self.list {
            let deg = |w: DVec3| (frame::theta(w).to_degrees(), frame::phi(w).to_degrees());
            let ((ti, pi), (tr, pr)) = (deg(o.wi), deg(o.wo));
            let th = frame::theta(crate::math::half_vector(o.wi, o.wo)).to_degrees();
            let m = model.eval(o.wi, o.wo);
            let ratio =
                if m > 0.0 && o.f_r.value > 0.0 { format!("{:.6}", (m / o.f_r.value).ln()) } else { String::new() };
            let (f, e) = (o.f_r.value, o.f_r.standard_error);
            let _ = writeln!(text, "{ti:.4},{pi:.4},{tr:.4},{pr:.4},{th:.4},{f:.6e},{e:.3e},{m:.6e},{ratio}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;

    /// The solid angles are a quadrature: with them the list sums to the albedo.
    #[test]
    fn solid_angles_integrate_the_source() {
        for text in ["lambert:rho=0.6", "ward:rho_s=0.3,alpha=0.01,rho_d=0.2", "ggx:alpha=0.2,material=mirror"] {
            let source = model::parse(text, 550e-9).unwrap();
            let estimate = |wi: DVec3, wo: DVec3| Estimate::exact(source.eval(wi, wo));
            let design = Design { theta_i: vec![0.6], directions: 4000, ..Design::default() };
            let o = Observations::of(source.as_ref(), &estimate, &design).unwrap();
            let sum: f64 = o.list.iter().map(|o| o.solid_angle * o.f_r.value).sum();
            let albedo = source.albedo(0.6);
            assert!((sum / albedo - 1.0).abs() < 0.03, "{text}: {sum} {albedo}");
        }
        let mirror = model::parse("mirror", 550e-9).unwrap();
        assert!(Observations::of(mirror.as_ref(), &|_, _| Estimate::exact(0.0), &Design::default()).is_err());
    }
}
