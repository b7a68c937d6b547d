//! Detectors in the half-vector plane: cells of the slope a facet must have to send `wi` to `wo`.

use crate::facets::SlopeStatistics;
use crate::math::{half_vector, slope_of_half_vector};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Cell width at the core of the lobe in its standard deviations; at half of one the peak would read 2 % low.
const CORE_CELL: f64 = 0.2;
/// The fine cells reach this many standard deviations, then rings grow by the factor below.
const CORE_REACH: f64 = 3.0;
const RING_GROWTH: f64 = 1.2;
const MAX_SECTORS: u32 = 64;
/// Slope of a facet at 89.5 deg; whatever is steeper falls into the last ring.
const STEEPEST: f64 = 115.0;

/// Quadrature points of a cell.
pub const POINTS: usize = 8;
/// Node of the two-point Gauss-Legendre rule on [-1, 1].
const GAUSS_2: f64 = 0.577_350_269_189_625_8;

/// Elliptical rings and sectors over the slope plane, following the lobe of one surface.
///
/// A slope `(p, q)` has coordinates `(rho, chi)`: `rho e^(i chi) = R(-angle) (p - p0, q - q0) / (s1, s2)`.
/// Ring `j` spans `edges[j]..edges[j+1]` in rho and is cut into `sectors[j]` equal sectors, sector 0 centred on chi = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HalfVectorCells {
    /// Slope at the centre `(p0, q0)`.
    pub centre: [f64; 2],
    /// Length of one unit of rho along the two axes, in slope.
    pub scale: [f64; 2],
    /// Direction of the first axis from +x \[rad\].
    pub angle: f64,
    /// Ring edges in rho, rising from 0.
    pub edges: Vec<f64>,
    /// Sectors per ring; 1 in the central disc.
    pub sectors: Vec<u32>,
    /// Index of each ring's sector 0; one more entry than rings, the last is the number of cells.
    first: Vec<usize>,
    /// Cosine and sine of `angle`.
    axis: [f64; 2],
}

/// Interpolation stencil: up to four cells and their weights, which sum to 1.
pub type Stencil = [(usize, f64); 4];

/// A quadrature point of a cell in the slope plane with its share of the cell's area.
#[derive(Debug, Clone, Copy)]
pub struct CellPoint {
    pub p: f64,
    pub q: f64,
    pub area: f64,
}

impl HalfVectorCells {
    /// Cells that follow the measured lobe. `isotropic`: circular and centred on the mean normal.
    pub fn for_lobe(statistics: &SlopeStatistics, isotropic: bool) -> Self {
        let floor = 1e-5;
        let scale = if isotropic {
            [(statistics.sdq / std::f64::consts::SQRT_2).max(floor); 2]
        } else {
            // A lobe thinner than a fiftieth of its length would need more sectors than the rings have.
            let major = statistics.axes[0].max(floor);
            [major, statistics.axes[1].max(major / 50.0)]
        };
        let (centre, angle) = if isotropic { ([0.0; 2], 0.0) } else { (statistics.mean, statistics.axis_angle) };
        let core = scale.map(|s| (s * statistics.core).max(floor));
        Self::new(centre, core, angle)
    }

    /// Cells about `centre` for a lobe of standard deviations `scale` along axes turned by `angle` \[rad\].
    pub fn new(centre: [f64; 2], scale: [f64; 2], angle: f64) -> Self {
        // A central disc of the area of a square cell, then rings.
        let mut edges = vec![0.0, CORE_CELL / std::f64::consts::PI.sqrt()];
        let reach = (STEEPEST + centre[0].hypot(centre[1])) / scale[0].min(scale[1]);
        let mut last = edges[1];
        while last < reach {
            last = if last < CORE_REACH { last + CORE_CELL } else { last * RING_GROWTH };
            edges.push(last);
        }
        let sectors = edges
            .windows(2)
            .map(|e| {
                if e[0] == 0.0 {
                    return 1;
                }
                let round = TAU * 0.5 * (e[0] + e[1]);
                ((round / (e[1] - e[0]).min(CORE_CELL)).round() as u32).clamp(6, MAX_SECTORS)
            })
            .collect();
        Self::from_parts(centre, scale, angle, edges, sectors)
    }

    /// Cells from stored parts; see the field documentation.
    pub fn from_parts(centre: [f64; 2], scale: [f64; 2], angle: f64, edges: Vec<f64>, sectors: Vec<u32>) -> Self {
        let mut first = vec![0];
        for &n in &sectors {
            first.push(first[first.len() - 1] + n as usize);
        }
        let (sin, cos) = angle.sin_cos();
        HalfVectorCells { centre, scale, angle, edges, sectors, first, axis: [cos, sin] }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.first[self.sectors.len()]
    }

    /// Never true: there is always the central disc.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Cell of the slope `(p, q)`; slopes beyond the last ring belong to it.
    #[inline]
    pub fn locate(&self, p: f64, q: f64) -> usize {
        self.cell_at(self.polar(p, q))
    }

    /// Cell at `(rho, chi)`.
    #[inline]
    pub fn cell_at(&self, (rho, chi): (f64, f64)) -> usize {
        let ring = self.ring(rho);
        let n = self.sectors[ring];
        let turn = (chi / TAU * f64::from(n) + 0.5).floor() as i64;
        self.first[ring] + turn.rem_euclid(i64::from(n)) as usize
    }

    /// Cell of the half vector of `wi` and `wo`, both above the surface.
    #[inline]
    pub fn locate_pair(&self, wi: DVec3, wo: DVec3) -> usize {
        let (p, q) = slope_of_half_vector(half_vector(wi, wo));
        self.locate(p, q)
    }

    /// Area of a cell in the slope plane.
    pub fn area(&self, cell: usize) -> f64 {
        let ring = self.ring_of_cell(cell);
        let rho2 = self.edges[ring + 1].powi(2) - self.edges[ring].powi(2);
        std::f64::consts::PI * rho2 * self.scale[0] * self.scale[1] / f64::from(self.sectors[ring])
    }

    /// Slope at `(a, b)` in `[0, 1]^2` of a cell; uniform `(a, b)` give a uniform density over its area.
    #[inline]
    pub fn slope_in(&self, cell: usize, a: f64, b: f64) -> (f64, f64) {
        self.slope_at(self.polar_in(cell, a, b))
    }

    /// `(rho, chi)` at `(a, b)` in `[0, 1]^2` of a cell, as [`HalfVectorCells::slope_in`].
    #[inline]
    pub fn polar_in(&self, cell: usize, a: f64, b: f64) -> (f64, f64) {
        let ring = self.ring_of_cell(cell);
        let (r0, r1) = (self.edges[ring], self.edges[ring + 1]);
        let rho = (r0 * r0 + a * (r1 * r1 - r0 * r0)).sqrt();
        let sector = (cell - self.first[ring]) as f64;
        (rho, TAU * (sector + b - 0.5) / f64::from(self.sectors[ring]))
    }

    /// Quadrature points: two-point Gauss in rho on each side of the ring's centre line, one midpoint in chi on each side of
    /// the sector's. Exact for the piecewise linear interpolation of [`HalfVectorCells::stencil`].
    pub fn points(&self, cell: usize) -> [CellPoint; POINTS] {
        let ring = self.ring_of_cell(cell);
        let (r0, r1) = (self.edges[ring], self.edges[ring + 1]);
        let middle = if ring == 0 { 0.5 * (r0 + r1) } else { self.ring_centre(ring) };
        let sector = (cell - self.first[ring]) as f64;
        let n = f64::from(self.sectors[ring]);
        let unit = self.scale[0] * self.scale[1] * TAU / n / 2.0;
        std::array::from_fn(|k| {
            let (from, to) = if k < 4 { (r0, middle) } else { (middle, r1) };
            let side = if k % 4 < 2 { -GAUSS_2 } else { GAUSS_2 };
            let rho = 0.5 * (from + to) + 0.5 * (to - from) * side;
            let chi = TAU * (sector + if k % 2 == 0 { -0.25 } else { 0.25 }) / n;
            let (p, q) = self.slope_at((rho, chi));
            CellPoint { p, q, area: unit * rho * 0.5 * (to - from) }
        })
    }

    /// Slope at `(rho, chi)`.
    #[inline]
    pub fn slope_at(&self, (rho, chi): (f64, f64)) -> (f64, f64) {
        let (s, c) = chi.sin_cos();
        let (x, y) = (self.scale[0] * rho * c, self.scale[1] * rho * s);
        let [cos, sin] = self.axis;
        (self.centre[0] + cos * x - sin * y, self.centre[1] + sin * x + cos * y)
    }

    /// Cells and weights whose weighted values interpolate at `(p, q)`: linear in rho between ring centres,
    /// linear in chi between sector centres.
    #[inline]
    pub fn stencil(&self, p: f64, q: f64) -> Stencil {
        self.stencil_at(self.polar(p, q))
    }

    /// The stencil at `(rho, chi)`.
    #[inline]
    pub fn stencil_at(&self, (rho, chi): (f64, f64)) -> Stencil {
        let ring = self.ring(rho);
        let last = self.sectors.len() - 1;
        let centre = self.ring_centre(ring);
        let (inner, outer) = if rho < centre { (ring.saturating_sub(1), ring) } else { (ring, (ring + 1).min(last)) };
        let t = if inner == outer {
            0.0
        } else {
            let (a, b) = (self.ring_centre(inner), self.ring_centre(outer));
            ((rho - a) / (b - a)).clamp(0.0, 1.0)
        };
        let [a, b] = self.round_pair(inner, chi);
        let [c, d] = self.round_pair(outer, chi);
        [(a.0, a.1 * (1.0 - t)), (b.0, b.1 * (1.0 - t)), (c.0, c.1 * t), (d.0, d.1 * t)]
    }

    /// The cell that is the image of `cell` when chi changes sign.
    pub fn mirrored(&self, cell: usize) -> usize {
        let ring = self.ring_of_cell(cell);
        let n = self.sectors[ring] as usize;
        self.first[ring] + (n - (cell - self.first[ring])) % n
    }

    /// Ring that a cell belongs to.
    #[inline]
    pub fn ring_of_cell(&self, cell: usize) -> usize {
        self.first.partition_point(|&f| f <= cell) - 1
    }

    /// Cells of a ring.
    pub fn cells_of_ring(&self, ring: usize) -> std::ops::Range<usize> {
        self.first[ring]..self.first[ring + 1]
    }

    /// `(rho, chi)` of a slope.
    #[inline]
    pub fn polar(&self, p: f64, q: f64) -> (f64, f64) {
        let (dp, dq) = (p - self.centre[0], q - self.centre[1]);
        let [cos, sin] = self.axis;
        let x = (cos * dp + sin * dq) / self.scale[0];
        let y = (cos * dq - sin * dp) / self.scale[1];
        // Not `hypot`: slopes neither overflow nor vanish into denormals, and this is the hottest line of a render.
        ((x * x + y * y).sqrt(), y.atan2(x))
    }

    #[inline]
    fn ring(&self, rho: f64) -> usize {
        // Written so that a NaN falls into the last ring instead of out of bounds.
        let beyond = |edge: f64| edge > rho;
        let above = self.edges.partition_point(|&edge| !beyond(edge));
        above.saturating_sub(1).min(self.sectors.len() - 1)
    }

    #[inline]
    pub(super) fn ring_centre(&self, ring: usize) -> f64 {
        if ring == 0 { 0.0 } else { 0.5 * (self.edges[ring] + self.edges[ring + 1]) }
    }

    #[inline]
    fn round_pair(&self, ring: usize, chi: f64) -> [(usize, f64); 2] {
        let n = self.sectors[ring] as usize;
        let first = self.first[ring];
        if n == 1 {
            return [(first, 1.0), (first, 0.0)];
        }
        let turn = chi / TAU * n as f64;
        let low = turn.floor();
        let t = turn - low;
        let k = (low as i64).rem_euclid(n as i64) as usize;
        [(first + k, 1.0 - t), (first + (k + 1) % n, t)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    fn tilted() -> HalfVectorCells {
        HalfVectorCells::new([0.03, -0.01], [0.1, 0.02], 0.5)
    }

    #[test]
    fn every_point_of_a_cell_is_located_in_it() {
        let cells = tilted();
        let mut rng = CounterRng::new(1, 0, 0);
        for cell in 0..cells.len() {
            for _ in 0..4 {
                let (a, b) = (0.001 + 0.998 * rng.uniform(), 0.001 + 0.998 * rng.uniform());
                let (p, q) = cells.slope_in(cell, a, b);
                assert_eq!(cells.locate(p, q), cell);
            }
            assert_eq!(cells.mirrored(cells.mirrored(cell)), cell);
        }
        assert_eq!(cells.locate(1e9, 0.0), cells.locate(1e8, 0.0));
        assert!(cells.locate(f64::NAN, 0.0) < cells.len());
    }

    #[test]
    fn areas_tile_the_ellipse() {
        let cells = tilted();
        for cell in 0..cells.len() {
            let area: f64 = cells.points(cell).iter().map(|x| x.area).sum();
            assert!((area / cells.area(cell) - 1.0).abs() < 1e-12);
        }
        let sum: f64 = (0..cells.len()).map(|c| cells.area(c)).sum();
        let rho = cells.edges[cells.edges.len() - 1];
        assert!((sum / (std::f64::consts::PI * rho * rho * 0.1 * 0.02) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn stencil_weights_sum_to_one_and_reproduce_cell_centres() {
        let cells = tilted();
        let mut rng = CounterRng::new(2, 0, 0);
        for _ in 0..1000 {
            let s = cells.stencil(rng.uniform() - 0.5, rng.uniform() - 0.5);
            assert!((s.iter().map(|x| x.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(s.iter().all(|x| x.1 >= 0.0 && x.0 < cells.len()));
        }
        let s = cells.stencil(0.03, -0.01);
        assert_eq!(s[0].0, 0);
        assert!((s[0].1 - 1.0).abs() < 1e-9);
    }
}
