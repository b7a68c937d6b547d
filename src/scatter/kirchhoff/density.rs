//! The lobe of a wave over the half-vector cells, and what it sends where.

use super::Wave;
use super::slices::Slices;
use crate::facets::distribution::Hiding;
use crate::math::{half_vector, slope_of_half_vector};
use crate::optics::Material;
use crate::scatter::cells::HalfVectorCells;
use crate::scatter::facing::{Facing, facing};
use crate::scatter::tally::Tally;
use glam::DVec3;

/// `T(slope; v_z)` of the module's formula, without the mirror beam, at equal steps of `ln v_z`.
///
/// Stored as shape (integral 1) times incoherent share; both vary slowly, so a cubic through four slices joins them.
#[derive(Debug, Clone)]
pub struct WaveDensity {
    wave: Wave,
    slices: Slices,
    shapes: Vec<Vec<f64>>,
    /// `(1 - |m|^2) / v_z^2`: level for smooth surfaces, a power for rough ones.
    incoherent: Vec<f64>,
    /// Shapes of independent parts of the speckle at the middle slice: their scatter is the standard error.
    pub replicates: Vec<Vec<f64>>,
}

impl WaveDensity {
    pub(super) fn new(wave: Wave, slices: Slices) -> Self {
        WaveDensity { wave, slices, shapes: Vec::new(), incoherent: Vec::new(), replicates: Vec::new() }
    }

    pub(super) fn push(&mut self, shape: Vec<f64>, incoherent: f64) {
        let v_z = self.slices.v_z(self.shapes.len());
        self.shapes.push(shape);
        self.incoherent.push(incoherent / (v_z * v_z));
    }

    /// Number of slices in `v_z`.
    pub fn slices(&self) -> usize {
        self.shapes.len()
    }

    /// `T` of a cell at `v_z` [1/m].
    pub fn at(&self, cell: usize, v_z: f64) -> f64 {
        self.joined(&[(cell, 1.0)], v_z)
    }

    /// `T` joined over cells.
    fn joined(&self, cells: &[(usize, f64)], v_z: f64) -> f64 {
        let (first, w) = self.slices.weights(v_z);
        let shape: f64 = (0..4)
            .map(|k| w[k] * cells.iter().map(|&(cell, share)| share * self.shapes[first + k][cell]).sum::<f64>())
            .sum();
        if shape <= 0.0 { 0.0 } else { shape * self.incoherent(first, &w, v_z) }
    }

    /// Share of the light outside the mirror beam, joined over the slices from `first` on with weights `w`.
    fn incoherent(&self, first: usize, w: &[f64; 4], v_z: f64) -> f64 {
        let per_square: f64 = (0..4).map(|k| w[k] * self.incoherent[first + k]).sum();
        (per_square * v_z * v_z).clamp(0.0, 1.0)
    }

    /// `E_k = w integral over the cell of G R(beta) T cb / (ch ci) dp dq`, mirror beam `G R(theta_i) mirror` apart;
    /// `w = (1 - mirror) / (share of T outside the beam)`, both at the `v_z` of the mirror direction.
    ///
    /// `G` is Smith's masking-shadowing of the measured slopes, for both: the phase integral lights every point of the map.
    /// What `G` hides, and what the formula sends below the horizon, would meet the surface again: it is `lost`. Scalar
    /// A weak mirror beam stands out from the speckle at some `v_z` and not at others: the lobe as a whole holds what the beam
    /// does not have at the `v_z` of the mirror direction, whatever the slices around took out. Scalar
    /// Kirchhoff does not conserve energy: near grazing a lobe wider than its angle to the surface gets up to twice the
    /// incoherent light there is. More than the mirror beam has left is scaled down to it.
    pub fn tally(
        &self,
        cells: &HalfVectorCells,
        wi: DVec3,
        mirror: f64,
        material: &Material,
        hiding: &Hiding,
    ) -> Tally {
        let mut tally = Tally::new(cells.len());
        let k = self.wave.wave_number();
        let source = self.wave.source_points(wi);
        let mut escaping = 0.0;
        let specular = 2.0 * k * wi.z;
        let (first, w) = self.slices.weights(specular);
        let joined = self.incoherent(first, &w, specular);
        let whole = if joined > 0.0 { (1.0 - mirror).max(0.0) / joined } else { 1.0 };
        for cell in 0..cells.len() {
            if source.len() == 1 && self.shapes.iter().all(|s| s[cell] == 0.0) {
                continue;
            }
            for point in cells.points(cell) {
                let Some(f) = facing(point.p, point.q, wi).filter(|f| f.wo.z > 0.0) else { continue };
                let t = if source.len() == 1 {
                    self.at(cell, k * (wi.z + f.wo.z))
                } else {
                    source.iter().map(|&(from, share)| share * self.seen_from(cells, from, &f)).sum()
                };
                let seen = whole * t * point.area * f.weight * hiding.visible(wi.z, f.wo.z);
                let reflected = seen * material.reflectance(f.cos_beta);
                escaping += seen;
                tally.energy[cell] += reflected;
                tally.absorbed += seen - reflected;
            }
        }
        let beam = mirror * hiding.visible(wi.z, wi.z);
        let reflectance = material.reflectance(wi.z);
        let excess = (escaping / (1.0 - beam).max(f64::MIN_POSITIVE)).max(1.0);
        tally.energy.iter_mut().for_each(|e| *e /= excess);
        tally.core = beam * reflectance;
        tally.absorbed = tally.absorbed / excess + beam * (1.0 - reflectance);
        tally.incident = 1.0;
        tally.lost = (1.0 - beam - escaping / excess).max(0.0);
        tally.bounces[0] = tally.energy.iter().sum::<f64>() + tally.core;
        tally.shadowed = hiding.lambda(wi.z);
        tally
    }

    /// `T` for light from another point of the source into the same direction.
    fn seen_from(&self, cells: &HalfVectorCells, wi: DVec3, f: &Facing) -> f64 {
        let (p, q) = slope_of_half_vector(half_vector(wi, f.wo));
        self.joined(&cells.stencil(p, q), self.wave.wave_number() * (wi.z + f.wo.z))
    }
}
