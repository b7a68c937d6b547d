//! Which of the facets that a path sees are hidden, asked one by one: for where Smith's function is too coarse.

use super::path::Path;
use crate::facets::slopes::{self, Facet};
use crate::facets::visibility::{Fate, HeightField, Ray};
use crate::math::frame::normal_of_slope;
use crate::math::reflect;
use crate::optics::Material;
use glam::DVec3;
use rayon::prelude::*;
use std::cell::Cell;

/// Share of the facets that Smith's function may hide before they are asked.
pub const LARGEST_FOR_SMITH: f64 = 1e-3;

/// About so many facets are looked at, on evenly spaced rows; the share of them that a path sees is asked.
const LOOKED_AT: usize = 1 << 22;

/// `sum of K V / sum of K` over the facets of the map and over `paths`: K the flux of a facet ([`Path::facet`]), V whether the
/// ways from its centroid to the source and to the exit are free; `None` if no facet throws light into a receptor.
///
/// The way in is that to the mean of the source's part which the facet mirrors into the receptor.
pub fn seen_share(field: &HeightField, paths: &[Path], material: &Material) -> Option<f64> {
    let (nx, ny) = slopes::cells(field.map());
    let every = (2 * nx * ny * paths.len() / LOOKED_AT).max(1);
    let rows: Vec<[f64; 2]> = (0..ny)
        .into_par_iter()
        .step_by(every)
        .map(|row| {
            let mut sums = [0.0; 2];
            slopes::visit_row(field.map(), row, |facet| {
                for path in paths {
                    if let Some((flux, free)) = look(field, path, material, &facet) {
                        sums[0] += flux;
                        sums[1] += if free { flux } else { 0.0 };
                    }
                }
            });
            sums
        })
        .collect();
    let [all, free] = rows.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    (all > 0.0).then(|| free / all)
}

/// Flux of one facet and whether nothing is in its way; `None` if it throws no light into the receptor.
fn look(field: &HeightField, path: &Path, material: &Material, facet: &Facet) -> Option<(f64, bool)> {
    let n = normal_of_slope(facet.p, facet.q);
    path.position(n)?;
    let middle = Cell::new(DVec3::ZERO);
    let flux = path.facet(n, |cos_beta, wi, _| {
        middle.set(middle.get() + wi);
        material.reflectance(cos_beta)
    });
    if flux <= 0.0 {
        return None;
    }
    let wi = middle.get().normalize();
    let corners = field.corners(facet.column, facet.row).map(f64::from);
    let (u, v) = if facet.upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
    let third = corners[if facet.upper { 1 } else { 2 }];
    let (column, row) = (facet.column as f64 + u, facet.row as f64 + v);
    let z = (corners[0] + corners[3] + third) / 3.0;
    let own = Some(([facet.column, facet.row], facet.upper));
    let free = |direction: DVec3| {
        direction.z > 0.0 && matches!(field.trace(Ray { column, row, z, direction }, own), Fate::Escaped(_))
    };
    Some((flux, free(wi) && free(reflect(wi, n))))
}
