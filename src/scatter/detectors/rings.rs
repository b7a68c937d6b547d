//! Rings in theta cut into equal sectors in phi: what most goniometers and window standards count in.

use super::{Bounds, Detectors};
use crate::math::{frame, solid_angle};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Ring `j` spans `edges[j]..edges[j+1]` in theta and is cut into `sectors[j]` sectors, sector 0 centred on phi = 0.
/// Detectors are numbered ring after ring from the pole.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings {
    /// \[rad\], from 0 to pi/2.
    edges: Vec<f64>,
    sectors: Vec<usize>,
    /// Index of each ring's sector 0; the last entry is the number of detectors.
    first: Vec<usize>,
}

impl Rings {
    /// Rings from their inner edges and sector counts; the last ring ends at the horizon.
    pub(super) fn new(inner_edges: Vec<f64>, sectors: Vec<usize>) -> Self {
        debug_assert_eq!(inner_edges.len(), sectors.len());
        let mut edges = inner_edges;
        edges.push(FRAC_PI_2);
        let mut first = vec![0];
        for &n in &sectors {
            first.push(first[first.len() - 1] + n);
        }
        Rings { edges, sectors, first }
    }

    fn ring_of(&self, index: usize) -> usize {
        self.first.partition_point(|&f| f <= index) - 1
    }
}

impl Detectors for Rings {
    fn len(&self) -> usize {
        self.first[self.sectors.len()]
    }

    fn index(&self, _wi: DVec3, wo: DVec3) -> usize {
        let theta = frame::theta(wo);
        let ring = self.edges[1..self.sectors.len()].partition_point(|&edge| edge <= theta);
        let n = self.sectors[ring];
        // Half-open sectors; what rounds up to a full turn is sector 0.
        self.first[ring] + (frame::phi(wo) / TAU * n as f64 + 0.5).floor() as usize % n
    }

    fn projected_solid_angle(&self, index: usize, _wi: DVec3) -> f64 {
        let Bounds { theta, phi } = self.bounds(index);
        solid_angle::projected_bin(theta[0], theta[1], phi[0], phi[1])
    }

    fn bounds(&self, index: usize) -> Bounds {
        let ring = self.ring_of(index);
        let width = TAU / self.sectors[ring] as f64;
        let centre = (index - self.first[ring]) as f64;
        // A ring of one sector is a whole turn.
        let phi = if self.sectors[ring] == 1 { [0.0, TAU] } else { [(centre - 0.5) * width, (centre + 0.5) * width] };
        Bounds { theta: [self.edges[ring], self.edges[ring + 1]], phi }
    }
}
