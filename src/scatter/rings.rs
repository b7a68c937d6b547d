//! The radial histogram of an isotropic surface, spread over the half-vector cells.

use super::axis::{Axis, AxisLanes, whole};
use super::cells::HalfVectorCells;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;

/// Rings per cell of an axis, and points along each side of a cell that decide which rings it shares.
const PER_CELL: f64 = 3.0;
const SIDE: usize = 6;

/// Rings about the mean normal, and which share of each lies in which cell.
///
/// `P_k = sum over rings r of n_r |cell k and ring r| / (|ring r| |cell k|)`: all azimuths of the source at once, for
/// the work of a one-dimensional histogram. Both areas are counted by the same points, so no facet is lost.
#[derive(Debug, Clone)]
pub struct Rings {
    axis: Axis,
    per_width: f64,
    rings: usize,
    /// Cells of the quadrant on each side.
    reach: usize,
    /// Where the rings of each cell of the first quadrant begin among `shares`, and where the last ones end.
    first: Vec<u32>,
    /// Rings of the cells, each with the number of points it has there.
    shares: Vec<(u32, f64)>,
    /// Points of each ring, weighted by the area they stand for.
    area: Vec<f64>,
}

/// [`Rings`] in f32, made of operations that work on lanes side by side.
#[derive(Debug, Clone, Copy)]
pub struct RingLanes {
    axis: AxisLanes,
    per_width: f32,
    last: u32,
}

impl RingLanes {
    /// Ring of a slope.
    #[inline(always)]
    pub fn ring(&self, p: f32, q: f32) -> u32 {
        let ring = whole(self.axis.coordinate((p * p + q * q).sqrt() * self.per_width) * PER_CELL as f32);
        if ring < self.last { ring } else { self.last }
    }
}

impl Rings {
    /// Rings for square cells centred on the mean normal.
    pub fn new(cells: &HalfVectorCells) -> Rings {
        let axis = cells.axes[0];
        let reach = axis.half as usize;
        // The corner of the plane is farther than its sides.
        let far = axis.coordinate(1.5 * axis.place(f64::from(axis.half)));
        let rings = (far * PER_CELL).ceil() as usize + 1;
        let per_width = 1.0 / cells.width[0];
        let mut all =
            Rings { axis, per_width, rings, reach, first: vec![0], shares: Vec::new(), area: vec![0.0; rings] };
        let places: Vec<f32> = (0..reach * SIDE)
            .map(|k| axis.place(((k % SIDE) as f64 + 0.5) / SIDE as f64 + (k / SIDE) as f64 - 0.5))
            .map(|x| (cells.width[0] * x) as f32)
            .collect();
        let (level, lanes) = (Level::new(), all.lanes());
        // Rings of the points of one row of cells, line by line.
        let mut of_point = vec![0; SIDE * places.len()];
        let mut points = vec![0u32; rings];
        for j in 0..reach {
            for (line, q) in of_point.chunks_mut(places.len()).zip(&places[j * SIDE..]) {
                dispatch!(level, simd => rings_of(simd, lanes, &places, *q, line));
            }
            for i in 0..reach {
                let mut range = [u32::MAX, 0];
                for line in of_point.chunks(places.len()) {
                    for &ring in &line[i * SIDE..(i + 1) * SIDE] {
                        points[ring as usize] += 1;
                        range = [range[0].min(ring), range[1].max(ring)];
                    }
                }
                // The central row and column are their own mirror images.
                let images = f64::from(if i == 0 { 1 } else { 2 } * if j == 0 { 1 } else { 2 });
                let area = images * all.cell_area(cells, i, j) / (SIDE * SIDE) as f64;
                for ring in range[0]..=range[1] {
                    let n = f64::from(std::mem::take(&mut points[ring as usize]));
                    if n > 0.0 {
                        all.shares.push((ring, n));
                        all.area[ring as usize] += n * area;
                    }
                }
                all.first.push(all.shares.len() as u32);
            }
        }
        all
    }

    /// Number of rings.
    pub fn len(&self) -> usize {
        self.rings
    }

    /// Never true.
    pub fn is_empty(&self) -> bool {
        self.rings == 0
    }

    /// Ring of a slope.
    #[inline]
    pub fn ring(&self, p: f64, q: f64) -> usize {
        let radius = (p * p + q * q).sqrt() * self.per_width;
        ((self.axis.coordinate(radius) * PER_CELL) as usize).min(self.rings - 1)
    }

    /// What [`Rings::ring`] needs, for lanes.
    pub fn lanes(&self) -> RingLanes {
        RingLanes { axis: self.axis.lanes(), per_width: self.per_width as f32, last: self.rings as u32 - 1 }
    }

    /// Density per unit slope area and cell of facets counted by ring; `total` counts those elsewhere as well.
    pub fn spread(&self, cells: &HalfVectorCells, counts: &[f64], total: f64) -> Vec<f64> {
        // A ring without a point, if there is one, lends its facets to the next ring inside.
        let mut per_area = vec![0.0; self.rings];
        let mut waiting = 0.0;
        for ring in (0..self.rings).rev() {
            waiting += counts[ring];
            if self.area[ring] > 0.0 {
                per_area[ring] = waiting / (self.area[ring] * total * (SIDE * SIDE) as f64);
                waiting = 0.0;
            }
        }
        let mut density = vec![0.0; cells.len()];
        let (row, half) = (cells.row_length(), self.reach);
        for (cell, ends) in self.first.windows(2).enumerate() {
            let (i, j) = (cell % self.reach, cell / self.reach);
            let shares = &self.shares[ends[0] as usize..ends[1] as usize];
            let value: f64 = shares.iter().map(|&(ring, n)| n * per_area[ring as usize]).sum();
            for column in [half - i, half + i] {
                for line in [half - j, half + j] {
                    density[line * row + column] = value;
                }
            }
        }
        density
    }

    fn cell_area(&self, cells: &HalfVectorCells, i: usize, j: usize) -> f64 {
        cells.area((self.reach + j) * cells.row_length() + self.reach + i)
    }
}

/// Rings of the slopes `(p, q)` for all `p`.
#[simd]
fn rings_of<S: Simd>(_: S, lanes: RingLanes, p: &[f32], q: f32, rings: &mut [u32]) {
    let n = rings.len();
    let p = &p[..n];
    for k in 0..n {
        rings[k] = lanes.ring(p[k], q);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    /// A Gaussian of a million slopes: every facet is kept, and the density is that of the formula.
    #[test]
    fn spread_keeps_every_facet_and_follows_the_density() {
        let s = 0.1;
        let cells = HalfVectorCells::new([0.0; 2], [s; 2], 0.0, 0.01);
        let rings = Rings::new(&cells);
        let mut rng = CounterRng::new(5, 0, 0);
        let mut counts = vec![0.0; rings.len()];
        let n = 1_000_000;
        for _ in 0..n {
            let [p, q] = rng.normal_pair();
            counts[rings.ring(s * p, s * q)] += 1.0;
        }
        let density = rings.spread(&cells, &counts, f64::from(n));
        let sum: f64 = density.iter().enumerate().map(|(k, d)| d * cells.area(k)).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let mut difference = 0.0;
        for (k, d) in density.iter().enumerate() {
            let exact: f64 = cells
                .points(k)
                .iter()
                .map(|x| x.area * (-(x.p * x.p + x.q * x.q) / (2.0 * s * s)).exp() / (std::f64::consts::TAU * s * s))
                .sum();
            difference += (d * cells.area(k) - exact).abs();
        }
        // Most of it by the width of a ring, the rest by counting.
        assert!(difference < 0.01, "{difference}");
        assert!(rings.ring(f64::NAN, 0.0) < rings.len() && rings.ring(1e300, 1e300) < rings.len());
    }
}
