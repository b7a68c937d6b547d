//! The radial histogram of an isotropic surface, spread over the half-vector cells.

use super::axis::{Axis, AxisLanes, whole};
use super::cells::HalfVectorCells;
use std::f64::consts::FRAC_PI_4;

/// Rings per cell of an axis.
const PER_CELL: f64 = 3.0;

/// A smaller share of a cell is rounding.
const SLIVER: f64 = 1e-9;

/// Rings about the mean normal, and which share of each lies in which cell.
///
/// `P_k = sum over rings r of n_r |cell k and ring r| / (|ring r| |cell k|)`: all azimuths of the source at once, for
/// the work of a one-dimensional histogram. The areas are exact and those in the cells sum to that of the ring, so no facet is lost;
/// what is left of the truth is that a density is even across a ring, a third of a cell wide.
#[derive(Debug, Clone)]
pub struct Rings {
    axis: Axis,
    per_width: f64,
    rings: usize,
    /// Cells of the quadrant on each side.
    reach: usize,
    /// Where the rings of each cell of the first quadrant begin among `shares`, and where the last ones end.
    first: Vec<u32>,
    /// Rings of the cells, each with the share of the cell that lies in it.
    shares: Vec<(u32, f64)>,
    /// Area of each ring within the cells.
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
        // Edges of the cells of the quadrant, of which the first ones are only half in it, and radii between rings.
        let edges: Vec<f64> = (0..=reach).map(|k| if k == 0 { 0.0 } else { axis.place(k as f64 - 0.5) }).collect();
        let radii: Vec<f64> = (0..=rings).map(|k| axis.place(k as f64 / PER_CELL)).collect();
        let discs = Discs::new(&edges, &radii);
        let ring_of = |x: f64, y: f64| ((axis.coordinate(x.hypot(y)) * PER_CELL) as usize).min(rings - 1);
        for j in 0..reach {
            for i in 0..reach {
                let whole = (edges[i + 1] - edges[i]) * (edges[j + 1] - edges[j]);
                // The central row and column are their own mirror images.
                let images = f64::from(if i == 0 { 1 } else { 2 } * if j == 0 { 1 } else { 2 });
                let area = images * all.cell_area(cells, i, j);
                let mut inner = 0.0;
                for ring in ring_of(edges[i], edges[j])..=ring_of(edges[i + 1], edges[j + 1]) {
                    let outer = discs.share(ring + 1, i, j) / whole;
                    let share = outer - inner;
                    if share > SLIVER {
                        all.shares.push((ring as u32, share));
                        all.area[ring] += share * area;
                        inner = outer;
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
        // A ring outside all cells, if there is one, lends its facets to the next ring inside.
        let mut per_area = vec![0.0; self.rings];
        let mut waiting = 0.0;
        for ring in (0..self.rings).rev() {
            waiting += counts[ring];
            if self.area[ring] > 0.0 {
                per_area[ring] = waiting / (self.area[ring] * total);
                waiting = 0.0;
            }
        }
        let mut density = vec![0.0; cells.len()];
        let (row, half) = (cells.row_length(), self.reach);
        for (cell, ends) in self.first.windows(2).enumerate() {
            let (i, j) = (cell % self.reach, cell / self.reach);
            let shares = &self.shares[ends[0] as usize..ends[1] as usize];
            let value: f64 = shares.iter().map(|&(ring, share)| share * per_area[ring as usize]).sum();
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

/// Discs about the origin, and how much of them lies in the rectangles of a grid.
struct Discs<'a> {
    edges: &'a [f64],
    radii: &'a [f64],
    /// Area of a quarter of each disc within each edge, on one axis: disc by disc.
    within: Vec<f64>,
}

impl<'a> Discs<'a> {
    fn new(edges: &'a [f64], radii: &'a [f64]) -> Self {
        let within = |radius: f64, edge: f64| {
            if edge >= radius {
                return FRAC_PI_4 * radius * radius;
            }
            0.5 * (edge * (radius * radius - edge * edge).sqrt() + radius * radius * (edge / radius).asin())
        };
        let within = radii.iter().flat_map(|&r| edges.iter().map(move |&e| within(r, e))).collect();
        Discs { edges, radii, within }
    }

    /// Area of a disc within the rectangle from the origin to the crossing of edges `i` and `j`.
    ///
    /// `x y` if the crossing lies in the disc; otherwise what lies within either edge, less the quarter of the disc that is counted
    /// twice.
    fn corner(&self, disc: usize, i: usize, j: usize) -> f64 {
        let (x, y, r) = (self.edges[i], self.edges[j], self.radii[disc]);
        if x * x + y * y <= r * r {
            return x * y;
        }
        let within = &self.within[disc * self.edges.len()..];
        within[i] + within[j] - FRAC_PI_4 * r * r
    }

    /// Area of a disc within a rectangle of the grid.
    fn share(&self, disc: usize, i: usize, j: usize) -> f64 {
        let corner = |i, j| self.corner(disc, i, j);
        corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    /// Every cell is shared out wholly, and what the cells have of a ring is the ring.
    #[test]
    fn shares_are_those_of_circles() {
        for tolerance in [0.05, 0.01, 1e-3] {
            let cells = HalfVectorCells::new([0.0; 2], [0.07; 2], 0.0, tolerance);
            let rings = Rings::new(&cells);
            for ends in rings.first.windows(2) {
                let sum: f64 = rings.shares[ends[0] as usize..ends[1] as usize].iter().map(|(_, share)| share).sum();
                assert!((sum - 1.0).abs() < 1e-8, "{sum}");
            }
            let radius = |k: usize| cells.width[0] * rings.axis.place(k as f64 / PER_CELL);
            let far = cells.width[0] * rings.axis.place(f64::from(rings.axis.half) - 0.5);
            let mut checked = 0;
            for ring in (0..rings.len()).take_while(|ring| radius(ring + 1) <= far) {
                let area = std::f64::consts::PI * (radius(ring + 1).powi(2) - radius(ring).powi(2));
                assert!((rings.area[ring] / area - 1.0).abs() < 1e-6, "{ring}: {} {area}", rings.area[ring]);
                checked += 1;
            }
            assert!(checked > 60, "{checked}");
        }
    }

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
