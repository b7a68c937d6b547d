//! From the slopes of a run to directions, densities and weights.

use super::super::sources::COSINES;
use super::super::table_brdf::TableBrdf;
use super::cells::Places;
use super::sources::SourceLanes;
use super::{Lanes, piece};
use crate::optics::Material;
use crate::optics::fresnel::{conductor_of_square, dielectric_of_square};
use crate::scatter::axis::{at_least, at_most};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use std::f64::consts::PI;

/// Mirror directions of a run.
pub(super) struct Draws<const N: usize> {
    pub x: Lanes<f64, N>,
    pub y: Lanes<f64, N>,
    pub z: Lanes<f64, N>,
    pub pdf: Lanes<f64, N>,
    pub weight: Lanes<f64, N>,
    /// `cos_beta / cos_theta_h`: above 0 if the facet faces the source.
    pub lean: Lanes<f64, N>,
}

impl<const N: usize> Default for Draws<N> {
    #[inline(always)]
    fn default() -> Self {
        let zero = [0.0; N];
        Draws { x: zero, y: zero, z: zero, pdf: zero, weight: zero, lean: zero }
    }
}

impl<const N: usize> Draws<N> {
    /// Mirrors the sources at the slopes of `places`, where the table holds density and density of draws `found`.
    #[simd]
    pub fn reflect<S: Simd>(
        &mut self,
        simd: S,
        brdf: &TableBrdf,
        s: &SourceLanes<N>,
        places: &Places<N>,
        found: &Lanes<[f32; 2], N>,
    ) {
        let (d, table) = (self, &brdf.table);
        let zero = [0.0f64; N];
        let (mut cos2_beta, mut density, mut draws, mut per_draw) = (zero, zero, zero, zero);
        let (mut cosine, mut above) = ([0u32; N], [0.0f32; N]);
        for j in 0..N {
            let (p, q) = table.cells.slope_of([f64::from(places.x[0][j]), f64::from(places.x[1][j])]);
            let lean = s.z[j] - p * s.x[j] - q * s.y[j];
            let steepness = 1.0 + p * p + q * q;
            let inverse = 1.0 / (steepness * lean);
            let scale = 2.0 * lean * lean * inverse;
            let v = [-p * scale - s.x[j], -q * scale - s.y[j]];
            d.x[j] = s.cos[j] * v[0] - s.sin[j] * v[1];
            d.y[j] = s.cos[j] * v[1] + s.sin[j] * v[0];
            d.z[j] = scale - s.z[j];
            (density[j], draws[j]) = (f64::from(found[j][0]), f64::from(found[j][1]));
            per_draw[j] = 0.25 * steepness * steepness * steepness * inverse;
            d.lean[j] = lean;
            cos2_beta[j] = at_most(at_least(0.5 * lean * scale, 0.0), 1.0);
            (cosine[j], above[j]) = piece(at_least(d.z[j], 0.0) as f32 * COSINES as f32 + 0.5);
        }
        let mut masked = [[0.0f32; 2]; N];
        for j in 0..N {
            masked[j] = brdf.source_tables.masking[cosine[j] as usize & (2 * COSINES - 1)];
        }
        let mut reflectance = [1.0; N];
        reflectances(simd, &table.material, &cos2_beta, &mut reflectance);
        let mut below = zero;
        for j in 0..N {
            let z = d.z[j];
            let hidden = f64::from(masked[j][0] + above[j] * masked[j][1]);
            let cosines = (s.z[j] + f64::from(s.masked[j])) * z + s.z[j] * hidden;
            density[j] *= f64::from(s.balance[j]) * reflectance[j] * d.lean[j] * z;
            below[j] = cosines;
        }
        if brdf.glossy {
            for j in 0..N {
                d.weight[j] = density[j] / (below[j] * draws[j]);
                d.pdf[j] = draws[j] * per_draw[j];
            }
        } else {
            for j in 0..N {
                // The floor sends light here as well, and draws; where it does so alone the rest is 0.
                let [_, floor, diffuse, _] = places.blend[j].to_array().map(f64::from);
                d.pdf[j] = draws[j] * per_draw[j] + floor * d.z[j] * (1.0 / PI);
                d.weight[j] = (density[j] / below[j] * per_draw[j] + diffuse * d.z[j]) / d.pdf[j];
            }
        }
    }
}

/// [`Material::reflectance_of_square`] of a run; `reflectance` is 1 before.
#[simd]
pub(super) fn reflectances<S: Simd, const N: usize>(
    _: S,
    material: &Material,
    cos2_beta: &Lanes<f64, N>,
    reflectance: &mut Lanes<f64, N>,
) {
    match *material {
        Material::Mirror => {}
        Material::Dielectric { n } => {
            for j in 0..N {
                reflectance[j] = dielectric_of_square(cos2_beta[j], n);
            }
        }
        Material::Conductor { n, k } => {
            for j in 0..N {
                reflectance[j] = conductor_of_square(cos2_beta[j], n, k);
            }
        }
    }
}
