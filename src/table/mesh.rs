//! Quadrature of the interpolated density over the slope plane.

use super::masking::Masking;
use crate::optics::Material;
use crate::scatter::HalfVectorCells;
use crate::scatter::cells::Stencil;
use glam::DVec3;

/// Two-point Gauss-Legendre on each half of a cell: between centres and edges the interpolation is bilinear, so the rule
/// is exact for it times a weight quadratic in the slopes.
const OFFSETS: [f64; 4] =
    [0.105_662_432_702_593_5, 0.394_337_567_297_406_5, 0.605_662_432_702_593_5, 0.894_337_567_297_406_5];
/// One point on each half.
const FEW_OFFSETS: [f64; 2] = [0.25, 0.75];

/// Quadrature points of all cells under a hat that holds something.
pub(crate) struct Mesh<'a> {
    masking: &'a Masking,
    points: Vec<Point>,
}

struct Point {
    p: f64,
    q: f64,
    area: f64,
    stencil: Stencil,
}

impl<'a> Mesh<'a> {
    /// The points where a density that is zero outside `filled` cells may be above zero.
    pub fn new(cells: &HalfVectorCells, filled: &[bool], masking: &'a Masking) -> Mesh<'a> {
        Mesh::at(&OFFSETS, cells, filled, masking)
    }

    /// The same of a quarter of the points: where the weights of draws follow it, which need not be exact.
    pub fn coarse(cells: &HalfVectorCells, filled: &[bool], masking: &'a Masking) -> Mesh<'a> {
        Mesh::at(&FEW_OFFSETS, cells, filled, masking)
    }

    fn at(offsets: &[f64], cells: &HalfVectorCells, filled: &[bool], masking: &'a Masking) -> Mesh<'a> {
        let side = offsets.len();
        let row = cells.row_length();
        let near = |k: usize| {
            let rows = [k.checked_sub(row), Some(k), Some(k + row)];
            rows.into_iter().flatten().any(|middle| {
                let from = middle.saturating_sub(1);
                filled.iter().skip(from).take(middle + 2 - from).any(|&f| f)
            })
        };
        let points = (0..cells.len())
            .filter(|&k| near(k))
            .flat_map(|k| {
                let area = cells.area(k) / (side * side) as f64;
                (0..side * side).map(move |j| {
                    let (p, q) = cells.slope_in(k, offsets[j % side], offsets[j / side]);
                    Point { p, q, area, stencil: cells.stencil(p, q) }
                })
            })
            .collect();
        Mesh { masking, points }
    }

    /// `T` at every point.
    pub fn values(&self, density: &[f64]) -> Vec<f64> {
        self.points.iter().map(|x| x.stencil.iter().map(|&(k, w)| density[k] * w).sum()).collect()
    }

    /// `integral of R(beta) G T cb / (ch ci) dp dq` over facets that face `wi` and mirror it above the horizon.
    pub fn energy(&self, values: &[f64], wi: DVec3, material: &Material) -> f64 {
        let mut sum = 0.0;
        for (x, t) in self.points.iter().zip(values) {
            let (lean, steepness) = lean(x.p, x.q, wi);
            if *t > 0.0 && lean > 0.0 && 2.0 * lean > wi.z * steepness {
                sum += t * self.weight(x, lean, steepness, wi) * material.reflectance(lean / steepness.sqrt());
            }
        }
        sum / wi.z
    }

    /// The energy of every cell's hat: the same for a density of 1 in that cell alone.
    pub fn hat_energies(&self, cells: usize, wi: DVec3, material: &Material) -> Vec<f64> {
        let mut energies = vec![0.0; cells];
        for x in &self.points {
            let (lean, steepness) = lean(x.p, x.q, wi);
            if lean > 0.0 && 2.0 * lean > wi.z * steepness {
                let reflectance = material.reflectance(lean / steepness.sqrt());
                let energy = self.weight(x, lean, steepness, wi) * reflectance / wi.z;
                x.stencil.iter().for_each(|&(k, w)| energies[k] += w * energy);
            }
        }
        energies
    }

    /// As [`Mesh::energy`] for mirror facets and a density between two: `(1 - u) a + u b`.
    pub fn mirror_energy(&self, a: &[f64], b: &[f64], u: f64, wi: DVec3) -> f64 {
        let mut sum = 0.0;
        for ((x, a), b) in self.points.iter().zip(a).zip(b) {
            let (lean, steepness) = lean(x.p, x.q, wi);
            let lit = lean > 0.0 && 2.0 * lean > wi.z * steepness;
            sum += if lit { (a + u * (b - a)) * self.weight(x, lean, steepness, wi) } else { 0.0 };
        }
        sum / wi.z
    }

    /// `G cb / ch` times the area of the point.
    #[inline]
    fn weight(&self, x: &Point, lean: f64, steepness: f64, wi: DVec3) -> f64 {
        let cos = 2.0 * lean / steepness - wi.z;
        self.masking.visible(wi.z, self.masking.times_cosine(wi.z), cos) * x.area * lean
    }
}

/// `cb / ch` of a facet and `1 / ch^2`.
#[inline]
fn lean(p: f64, q: f64, wi: DVec3) -> (f64, f64) {
    (wi.z - p * wi.x - q * wi.y, 1.0 + p * p + q * q)
}
