//! What hills hide near the horizon: the factor that a table keeps apart from its cells.

use crate::facets::SlopeStatistics;
use crate::optics::Material;
use crate::scatter::HalfVectorCells;
use crate::scatter::axis::{at_least, at_most, nearest};
use crate::scatter::facing::facing;
use glam::DVec3;

/// Steps of the cosine.
const STEPS: usize = 128;

/// Midpoints along each axis of a cell that the horizon cuts.
const CUT: usize = 8;

/// `G(ci, co) = ci co / (ci co + L(ci) co + ci L(co))`, `L(c) = c Lambda(c)`: the height-correlated masking and shadowing
/// of Smith (1967; Heitz, JCGT 3(2), 2014, equation 99) with `Lambda` of the measured slopes, L straight between 129 cosines.
///
/// At the horizon the density of visible facets falls to zero in proportion to `co`, within a cell of any size, and the
/// horizon lies in other cells for every source. Divided by G it does neither, and straight lines between cells and
/// between nodes hold. What the facets hide otherwise than G says stays in the cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Masking {
    /// `L` at the cosines `k / 128`.
    steps: Vec<f64>,
}

/// Integrals over one cell and one source.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CellWeight {
    /// Of `R(beta) G cb / (ch ci)` where the mirror direction is above the horizon.
    pub reflected: f64,
    /// Of `cb / (ch ci)` there, and wherever the facet faces the source.
    pub seen: f64,
    pub lit: f64,
}

impl Masking {
    /// Nothing hides: G = 1.
    pub fn none() -> Masking {
        Masking { steps: vec![0.0; STEPS + 1] }
    }

    /// That of a map.
    pub fn of(statistics: &SlopeStatistics) -> Masking {
        // L has a limit at the horizon, Lambda has none.
        let at = |k: usize| {
            let cos = (k as f64 / STEPS as f64).clamp(1e-6, 1.0);
            cos * statistics.hidden_excess(cos.acos())
        };
        Masking { steps: (0..=STEPS).map(at).collect() }
    }

    /// From a file; `None` for another number of steps.
    pub fn from_steps(steps: Vec<f64>) -> Option<Masking> {
        (steps.len() == STEPS + 1).then_some(Masking { steps })
    }

    /// `L` at its cosines.
    pub fn steps(&self) -> &[f64] {
        &self.steps
    }

    /// `L(cos_theta)`.
    #[inline(always)]
    pub fn times_cosine(&self, cos_theta: f64) -> f64 {
        let x = at_most(at_least(cos_theta, 0.0), 1.0) * STEPS as f64;
        let (k, whole) = nearest(at_most(at_least(x - 0.5, 0.0), (STEPS - 1) as f64));
        let step = &self.steps[k..k + 2];
        step[0] + (x - whole) * (step[1] - step[0])
    }

    /// `G`, given `L(ci)`.
    #[inline(always)]
    pub fn visible(&self, ci: f64, li: f64, co: f64) -> f64 {
        let both = ci * co;
        both / (both + li * co + ci * self.times_cosine(co))
    }

    /// The weights of a cell: by four Gauss points, or by 64 midpoints where the horizon cuts it.
    pub fn cell_weight(&self, cells: &HalfVectorCells, cell: usize, wi: DVec3, material: &Material) -> CellWeight {
        let li = self.times_cosine(wi.z);
        let mut sum = CellWeight::default();
        let mut add = |p: f64, q: f64, area: f64| {
            let Some(f) = facing(p, q, wi) else { return };
            sum.lit += area * f.weight;
            if f.wo.z > 0.0 {
                sum.seen += area * f.weight;
                let visible = self.visible(wi.z, li, f.wo.z);
                sum.reflected += area * f.weight * visible * material.reflectance(f.cos_beta);
            }
        };
        let above = |(p, q): (f64, f64)| facing(p, q, wi).is_some_and(|f| f.wo.z > 0.0);
        let corners = [0.0, 1.0].map(|b| [0.0, 1.0].map(|a| above(cells.slope_in(cell, a, b))));
        if corners == [[corners[0][0]; 2]; 2] {
            for point in cells.points(cell) {
                add(point.p, point.q, point.area);
            }
        } else {
            let part = |k: usize| (k as f64 + 0.5) / CUT as f64;
            let area = cells.area(cell) / (CUT * CUT) as f64;
            for k in 0..CUT * CUT {
                let (p, q) = cells.slope_in(cell, part(k % CUT), part(k / CUT));
                add(p, q, area);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    #[test]
    fn masking_is_the_measured_one_and_ends_at_zero() {
        let grid = synth::Grid { width: 128, height: 96, pitch: [1e-6, 1.5e-6] };
        let surface = synth::Gaussian { sq: 1e-6, acl: 8e-6, seed: 1, exact: false };
        let map = level::level(&synth::gaussian(grid, surface).unwrap(), Edges::Open).unwrap();
        let statistics = SlopeStatistics::measure(&map).unwrap();
        let (masking, hiding) = (Masking::of(&statistics), statistics.hiding());
        for k in 1..=200 {
            let (ci, co) = (0.3, f64::from(k) / 200.0);
            let li = masking.times_cosine(ci);
            assert!((masking.visible(ci, li, co) - hiding.visible(ci, co)).abs() < 2e-3, "{co}");
        }
        assert_eq!(masking.visible(0.5, masking.times_cosine(0.5), 0.0), 0.0);
        assert!((Masking::none().visible(0.5, 0.0, 0.2) - 1.0).abs() < 1e-15);
        assert_eq!(Masking::from_steps(vec![0.0; 3]), None);
    }
}
