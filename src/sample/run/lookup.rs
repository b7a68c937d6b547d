//! Lookups of a run: from pairs of directions to the places between the cells, and from what is found there to `f_r` and pdf.

use super::super::grid::piece as piece_f64;
use super::super::sources::COSINES;
use super::super::table_brdf::TableBrdf;
use super::mirror::reflectances;
use super::sources::SourceLanes;
use super::{Lanes, piece};
use crate::scatter::axis::{at_least, at_most};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use glam::{DVec3, Vec4};
use std::f64::consts::PI;

/// Pairs of a run; those below the horizon are taken as above it.
pub(super) struct Lookups<const N: usize> {
    /// The cell at or below, and the shares of the next column and row.
    pub from: Lanes<u32, N>,
    pub shares: [Lanes<f32, N>; 2],
    /// `f_r` and pdf.
    pub value: Lanes<f64, N>,
    pub pdf: Lanes<f64, N>,
    /// Cosines of the direction out and of the half vector's angles, the latter two squared.
    z: Lanes<f64, N>,
    cos2_beta: Lanes<f64, N>,
    steepness: Lanes<f64, N>,
    /// `1 / (wi + wo).z`.
    per_z: Lanes<f64, N>,
}

impl<const N: usize> Default for Lookups<N> {
    #[inline(always)]
    fn default() -> Self {
        let (wide, narrow) = ([0.0; N], [0.0; N]);
        Lookups {
            from: [0; N],
            shares: [narrow; 2],
            value: wide,
            pdf: wide,
            z: wide,
            cos2_beta: wide,
            steepness: wide,
            per_z: wide,
        }
    }
}

impl<const N: usize> Lookups<N> {
    /// Places of the pairs between the cells.
    #[simd]
    pub fn find<S: Simd>(
        &mut self,
        _: S,
        brdf: &TableBrdf,
        s: &SourceLanes<N>,
        wi: &Lanes<DVec3, N>,
        wo: &Lanes<DVec3, N>,
    ) {
        let grid = &brdf.slabs.grid;
        let mut places = [[0.0f64; N]; 2];
        for j in 0..N {
            let z = at_least(wo[j].z, super::HORIZON);
            let sum = [wi[j].x + wo[j].x, wi[j].y + wo[j].y, s.z[j] + z];
            let per_z = 1.0 / sum[2];
            let length2 = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
            self.z[j] = z;
            self.per_z[j] = per_z;
            self.cos2_beta[j] = at_most(0.25 * length2, 1.0);
            self.steepness[j] = length2 * per_z * per_z;
            // In the frame of the cells.
            let p = -per_z * (s.cos[j] * sum[0] + s.sin[j] * sum[1]);
            let q = -per_z * (s.cos[j] * sum[1] - s.sin[j] * sum[0]);
            [places[0][j], places[1][j]] = grid.place([p, q]);
        }
        for axis in 0..2 {
            let stride = if axis == 0 { 1 } else { grid.row as u32 };
            for j in 0..N {
                let u = grid.coordinate(axis, places[axis][j]) + grid.half[axis];
                let (number, beyond) = piece_f64(at_most(at_least(u, 0.5 + 1e-12), 2.0 * grid.half[axis] - 0.5));
                self.from[j] += stride * (number as u32 - 1);
                self.shares[axis][j] = (beyond + 0.5) as f32;
            }
        }
    }

    /// `f_r` and pdf where the table holds density and density of draws `found`.
    #[simd]
    pub fn value<S: Simd>(&mut self, simd: S, brdf: &TableBrdf, s: &SourceLanes<N>, found: &Lanes<[f32; 2], N>) {
        let (mut cosine, mut above) = ([0u32; N], [0.0f32; N]);
        for j in 0..N {
            (cosine[j], above[j]) = piece(self.z[j] as f32 * COSINES as f32 + 0.5);
        }
        let mut masked = [[0.0f32; 2]; N];
        for j in 0..N {
            masked[j] = brdf.source_tables.masking[cosine[j] as usize & (2 * COSINES - 1)];
        }
        let mut reflectance = [1.0f64; N];
        reflectances(simd, &brdf.table.material, &self.cos2_beta, &mut reflectance);
        for j in 0..N {
            let (z, steepness) = (self.z[j], self.steepness[j]);
            let hidden = f64::from(masked[j][0] + above[j] * masked[j][1]);
            let cosines = (s.z[j] + f64::from(s.masked[j])) * z + s.z[j] * hidden;
            let bright = f64::from(s.balance[j]) * reflectance[j] * f64::from(found[j][0]);
            self.value[j] = 0.25 * bright * steepness * steepness / cosines;
            self.pdf[j] = f64::from(found[j][1]) * 0.5 * steepness * self.per_z[j];
        }
        if !brdf.glossy {
            let mut blend = [Vec4::ZERO; N];
            s.blend(simd, brdf, &mut blend);
            for j in 0..N {
                self.pdf[j] += f64::from(blend[j].y) * self.z[j] * (1.0 / PI);
                self.value[j] += f64::from(blend[j].z);
            }
        }
    }
}
