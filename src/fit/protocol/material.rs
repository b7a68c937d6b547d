//! The NEF-BM material as the goniometer sees it: polarised first surface and depolarised volume.

use super::scans::{Bistatic, Polarisation, Specular};
use crate::error::Result;
use crate::math::{direction, half_vector};
use crate::model::Definition;
use crate::model::beard_maxwell::{BeardMaxwell, Shadowing, Volume};
use crate::model::facet_normals::FacetNormals;
use crate::optics;
use crate::optics::fresnel::polarised;
use glam::DVec3;
use std::f64::consts::PI;

/// A material under measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub n: f64,
    pub k: f64,
    pub normals: FacetNormals,
    pub shadowing: Shadowing,
    pub volume: Volume,
}

impl Material {
    /// First surface [1/sr] with `reflectance` of `cos_beta`.
    fn first_surface(&self, wi: DVec3, wo: DVec3, reflectance: impl Fn(f64) -> f64) -> f64 {
        let wh = half_vector(wi, wo);
        let (ch, cb) = (wh.z.min(1.0), wi.dot(wh).min(1.0));
        reflectance(cb) * self.normals.xi(ch) * self.shadowing.at(ch.acos(), cb.acos()) / (4.0 * wi.z * wo.z)
    }

    fn mean_reflectance(&self, cos_beta: f64) -> f64 {
        let [s, p] = polarised(cos_beta, self.n, self.k);
        0.5 * (s + p)
    }

    /// First surface and half the volume [1/sr], source and detector both at `theta`.
    pub fn zero_bistatic(&self, theta: f64) -> [f64; 2] {
        let w = direction(theta, 0.0);
        [self.first_surface(w, w, |c| self.mean_reflectance(c)), 0.5 * self.volume.at(w.z, w.z)]
    }

    /// Co-polarised `f_r` [1/sr] of a specular scan.
    pub fn specular(&self, row: &Specular) -> f64 {
        let (wi, wo) = (direction(row.theta_i, 0.0), direction(row.theta_r, PI));
        let side = usize::from(row.polarisation == Polarisation::P);
        self.first_surface(wi, wo, |c| polarised(c, self.n, self.k)[side]) + 0.5 * self.volume.at(wi.z, wo.z)
    }

    /// First surface and half the volume [1/sr] of a fixed-bistatic scan.
    pub fn bistatic(&self, row: &Bistatic) -> [f64; 2] {
        let [wi, wo] = bistatic_directions(row);
        [self.first_surface(wi, wo, |c| self.mean_reflectance(c)), 0.5 * self.volume.at(wi.z, wo.z)]
    }
}

impl Material {
    /// Gives the parameter of that name a value, SI; the scan of a law that is one stays.
    pub fn set(&mut self, name: &str, value: f64) {
        match (name, &mut self.normals) {
            ("n", _) => self.n = value,
            ("k", _) => self.k = value,
            ("tau", _) => self.shadowing.tau = value,
            ("omega", _) => self.shadowing.omega = value,
            ("rho_D", _) => self.volume.lambertian = value,
            ("rho_V", _) => self.volume.directional = value,
            ("sigma", FacetNormals::Cauchy { sigma, .. } | FacetNormals::Gaussian { sigma, .. }) => *sigma = value,
            ("bias", FacetNormals::Cauchy { bias, .. } | FacetNormals::Gaussian { bias, .. }) => *bias = value,
            _ => {}
        }
        // A scan counts facets by the reflectance at normal incidence.
        let normal = polarised(1.0, self.n, self.k)[0];
        if let FacetNormals::Scan { normal_reflectance, .. } = &mut self.normals {
            *normal_reflectance = normal;
        }
    }

    /// `s f_r`: first surface and volume in one proportion.
    pub fn scaled(&self, s: f64) -> Result<Self> {
        let mut material = self.clone();
        match &mut material.normals {
            FacetNormals::Cauchy { bias, .. } | FacetNormals::Gaussian { bias, .. } => *bias *= s,
            FacetNormals::Scan { scan, .. } => *scan = scan.scaled(s)?,
        }
        material.volume = Volume { lambertian: s * self.volume.lambertian, directional: s * self.volume.directional };
        Ok(material)
    }

    /// Directional-hemispherical reflectance at `theta_i` \[rad\], unpolarised.
    pub fn albedo(&self, theta_i: f64) -> f64 {
        let interface = if self.k > 0.0 {
            optics::Material::Conductor { n: self.n, k: self.k }
        } else {
            optics::Material::Dielectric { n: self.n }
        };
        BeardMaxwell::new(self.normals.clone(), interface, self.shadowing, self.volume).integrated(theta_i)
    }

    /// The `nef-bm` model.
    ///
    /// # Errors
    /// `Error::Parameter` naming a parameter outside the range of the model.
    pub fn definition(&self) -> Result<Definition> {
        let mut definition = Definition::parse(&match &self.normals {
            FacetNormals::Cauchy { .. } => "nef-bm".to_owned(),
            FacetNormals::Gaussian { .. } => "nef-bm:distribution=gaussian".to_owned(),
            FacetNormals::Scan { scan, .. } => {
                let item = |p: &(f64, f64)| format!("{:.4}:{:.6e}", p.0.to_degrees(), p.1);
                let items: Vec<String> = scan.points().iter().map(item).collect();
                format!("nef-bm:scan={}", items.join(";"))
            }
        })?;
        if let FacetNormals::Cauchy { sigma, bias } | FacetNormals::Gaussian { sigma, bias } = self.normals {
            definition.set("sigma", sigma)?;
            definition.set("bias", bias)?;
        }
        definition.set("n", self.n)?;
        if self.k > 0.0 {
            definition.set("k", self.k)?;
        }
        definition.set("tau", self.shadowing.tau)?;
        definition.set("omega", self.shadowing.omega)?;
        definition.set("rho_D", self.volume.lambertian)?;
        definition.set("rho_V", self.volume.directional)?;
        Ok(definition)
    }
}

/// Source and detector of a fixed-bistatic scan.
pub fn bistatic_directions(row: &Bistatic) -> [DVec3; 2] {
    [direction(row.theta_h + row.beta, 0.0), direction(row.theta_h - row.beta, 0.0)]
}
