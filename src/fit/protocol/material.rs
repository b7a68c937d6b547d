//! The NEF-BM material as the goniometer sees it: polarised first surface and depolarised volume.

use super::scans::{Bistatic, Polarisation, Specular};
use crate::math::{direction, half_vector};
use crate::model::beard_maxwell::{Shadowing, Volume};
use crate::model::facet_normals::FacetNormals;
use crate::optics::fresnel::polarised;
use glam::DVec3;
use std::f64::consts::PI;

/// A material under measurement.
#[derive(Debug, Clone)]
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

/// Source and detector of a fixed-bistatic scan.
pub fn bistatic_directions(row: &Bistatic) -> [DVec3; 2] {
    [direction(row.theta_h + row.beta, 0.0), direction(row.theta_h - row.beta, 0.0)]
}
