//! Detectors in the half-vector plane: cells of the slope a facet must have to send `wi` to `wo`.

use super::axis::{Axis, AxisLanes, at_least, at_most, nearest};
use crate::facets::SlopeStatistics;
use crate::math::{half_vector, slope_of_half_vector};
use glam::DVec3;

/// Share of the energy that may go astray unless asked otherwise.
pub const TOLERANCE: f64 = 0.01;

/// Slope of a facet at 87 deg; whatever is steeper falls into the last cell.
const STEEPEST: f64 = 20.0;

/// Smallest standard deviation that cells follow: well above that of the specular core, far below any lobe's.
const FINEST: f64 = 1e-5;

/// Cells of a lobe as wide as the core of a Gaussian is straight end here, in standard deviations.
const CORE_REACH: f64 = 2.0;

/// Nodes of the two-point Gauss-Legendre rule on [0, 1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Quadrature points of a cell.
pub const POINTS: usize = 4;

/// A grid over the slope plane, following the lobe of one surface: fine and even in the core, coarse in the tails.
///
/// A slope `(p, q)` has `x = R(-angle) (p - p0, q - q0) / (w1, w2)`, `w` the width of a core cell, and grid coordinates
/// `u_k = Axis_k(x_k)`; cell `(j, i)` is the square of side 1 about `u = (i - half_1, j - half_2)`, stored as number
/// `j (2 half_1 + 1) + i`. The cells cover the plane to a slope of 20; what is steeper belongs to the outermost
/// ones. The border all round holds nothing, so that interpolation ends at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfVectorCells {
    /// Slope at the centre `(p0, q0)`.
    pub centre: [f64; 2],
    /// Width of a core cell along the two axes, in slope.
    pub width: [f64; 2],
    /// Direction of the first axis from +x \[rad\].
    pub angle: f64,
    pub axes: [Axis; 2],
    /// Rows of the map from a slope to `x`: factors of p and q, and the constant.
    to_x: [[f64; 3]; 2],
    /// The other way: factors of x1 and x2.
    to_slope: [[f64; 2]; 2],
}

/// [`HalfVectorCells`] in f32, made of operations that work on lanes side by side.
#[derive(Debug, Clone, Copy)]
pub struct CellLanes {
    centre: [f32; 2],
    to_x: [[f32; 2]; 2],
    axes: [AxisLanes; 2],
    row_length: u32,
}

impl CellLanes {
    /// Cell of the slope `(p, q)`.
    #[inline(always)]
    pub fn locate(&self, p: f32, q: f32) -> u32 {
        let (p, q) = (p - self.centre[0], q - self.centre[1]);
        let [a, b] = self.to_x;
        self.axes[1].cell(b[0] * p + b[1] * q) * self.row_length + self.axes[0].cell(a[0] * p + a[1] * q)
    }
}

/// Interpolation stencil: four cells and their weights, which sum to 1.
pub type Stencil = [(usize, f64); 4];

/// A quadrature point in the slope plane with the area it stands for.
#[derive(Debug, Clone, Copy)]
pub struct CellPoint {
    pub p: f64,
    pub q: f64,
    pub area: f64,
}

impl HalfVectorCells {
    /// Cells that follow the measured lobe, fine enough that interpolation misses less than about `tolerance` of the energy
    /// (mean absolute difference) of a Gaussian lobe. `isotropic`: square and centred on the mean normal.
    pub fn for_lobe(statistics: &SlopeStatistics, isotropic: bool, tolerance: f64) -> Self {
        Self::for_core(statistics, statistics.core, isotropic, tolerance)
    }

    /// As [`HalfVectorCells::for_lobe`], the core of the lobe being so many principal slopes wide.
    pub fn for_core(statistics: &SlopeStatistics, core: f64, isotropic: bool, tolerance: f64) -> Self {
        let scale = if isotropic { [statistics.sdq / std::f64::consts::SQRT_2; 2] } else { statistics.axes };
        let (centre, angle) = if isotropic { ([0.0; 2], 0.0) } else { (statistics.mean, statistics.axis_angle) };
        Self::new(centre, scale.map(|s| (s * core).max(FINEST)), angle, tolerance)
    }

    /// Cells about `centre` for a lobe of standard deviations `scale` along axes turned by `angle` \[rad\].
    pub fn new(centre: [f64; 2], scale: [f64; 2], angle: f64, tolerance: f64) -> Self {
        // Straight lines between points h apart miss h^2 / 12 of a unit Gaussian's second derivative. Wider than half a
        // standard deviation the peak would read low, finer than a sixteenth no map has the facets to fill.
        let cell = (2.5 * tolerance.max(0.0).sqrt()).clamp(0.0625, 0.5);
        let core = (CORE_REACH / cell).ceil() as u32;
        let per_octave = if cell > 0.2 {
            4
        } else if cell > 0.1 {
            8
        } else {
            16
        };
        let width = scale.map(|s| s * cell);
        let reach = STEEPEST + centre[0].hypot(centre[1]);
        let axes = width.map(|w| Axis::reaching(reach / w, core, per_octave));
        Self::from_parts(centre, width, angle, axes)
    }

    /// Cells from stored parts; see the field documentation.
    pub fn from_parts(centre: [f64; 2], width: [f64; 2], angle: f64, axes: [Axis; 2]) -> Self {
        let (sin, cos) = angle.sin_cos();
        let row = |a: f64, b: f64, w: f64| [a / w, b / w, -(a * centre[0] + b * centre[1]) / w];
        HalfVectorCells {
            centre,
            width,
            angle,
            axes,
            to_x: [row(cos, sin, width[0]), row(-sin, cos, width[1])],
            to_slope: [[cos * width[0], -sin * width[1]], [sin * width[0], cos * width[1]]],
        }
    }

    /// Number of cells, border included.
    pub fn len(&self) -> usize {
        self.axes[0].len() * self.axes[1].len()
    }

    /// Never true.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Cells in a row of the grid: the step from a cell to its neighbour along the second axis.
    #[inline]
    pub fn row_length(&self) -> usize {
        self.axes[0].len()
    }

    /// Cell of the slope `(p, q)`; slopes beyond the grid belong to its outermost cells.
    #[inline]
    pub fn locate(&self, p: f64, q: f64) -> usize {
        let [u, v] = self.coordinates(p, q);
        self.axes[1].cell(v) * self.row_length() + self.axes[0].cell(u)
    }

    /// What [`HalfVectorCells::locate`] needs, for lanes.
    pub fn lanes(&self) -> CellLanes {
        let factors = |row: [f64; 3]| [row[0] as f32, row[1] as f32];
        CellLanes {
            centre: self.centre.map(|x| x as f32),
            to_x: self.to_x.map(factors),
            axes: self.axes.each_ref().map(Axis::lanes),
            row_length: self.row_length() as u32,
        }
    }

    /// Cell of the half vector of `wi` and `wo`, both above the surface.
    #[inline]
    pub fn locate_pair(&self, wi: DVec3, wo: DVec3) -> usize {
        let (p, q) = slope_of_half_vector(half_vector(wi, wo));
        self.locate(p, q)
    }

    /// Grid coordinates of a slope.
    #[inline]
    pub fn coordinates(&self, p: f64, q: f64) -> [f64; 2] {
        let [a, b] = &self.to_x;
        [self.axes[0].coordinate(a[0] * p + a[1] * q + a[2]), self.axes[1].coordinate(b[0] * p + b[1] * q + b[2])]
    }

    /// Slope at grid coordinates.
    #[inline]
    pub fn slope_at(&self, [u, v]: [f64; 2]) -> (f64, f64) {
        self.slope_of([self.axes[0].place(u), self.axes[1].place(v)])
    }

    /// Slope at a place along the axes, in core cells.
    #[inline]
    pub fn slope_of(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let [a, b] = &self.to_slope;
        (self.centre[0] + a[0] * x + a[1] * y, self.centre[1] + b[0] * x + b[1] * y)
    }

    /// Column and row of a cell.
    #[inline]
    pub fn column_and_row(&self, cell: usize) -> [usize; 2] {
        [cell % self.row_length(), cell / self.row_length()]
    }

    /// Whether a cell belongs to the border, which holds nothing.
    pub fn is_border(&self, cell: usize) -> bool {
        let [i, j] = self.column_and_row(cell);
        i == 0 || j == 0 || i + 1 == self.axes[0].len() || j + 1 == self.axes[1].len()
    }

    /// Area of a cell in the slope plane.
    pub fn area(&self, cell: usize) -> f64 {
        let [i, j] = self.column_and_row(cell);
        self.axes[0].width(i) * self.axes[1].width(j) * self.width[0] * self.width[1]
    }

    /// Slope at `(a, b)` in `[0, 1]^2` of a cell; uniform `(a, b)` give a uniform density over its area.
    #[inline]
    pub fn slope_in(&self, cell: usize, a: f64, b: f64) -> (f64, f64) {
        self.slope_at(self.coordinates_in(cell, a, b))
    }

    /// Two by two Gauss points: exact for a constant density times a weight cubic in p and q.
    pub fn points(&self, cell: usize) -> [CellPoint; POINTS] {
        let area = self.area(cell) / POINTS as f64;
        std::array::from_fn(|k| {
            let (p, q) = self.slope_in(cell, GAUSS[k % 2], GAUSS[k / 2]);
            CellPoint { p, q, area }
        })
    }

    /// Cells and weights whose weighted values interpolate at `(p, q)`: linear in both grid coordinates between the centres of
    /// the cells, zero beyond the centres of the border.
    #[inline]
    pub fn stencil(&self, p: f64, q: f64) -> Stencil {
        self.stencil_at(self.coordinates(p, q))
    }

    /// The stencil at grid coordinates.
    #[inline]
    pub fn stencil_at(&self, [u, v]: [f64; 2]) -> Stencil {
        let (i, s) = between(u, f64::from(self.axes[0].half));
        let (j, t) = between(v, f64::from(self.axes[1].half));
        let row = self.row_length();
        let k = j * row + i;
        [(k, (1.0 - s) * (1.0 - t)), (k + 1, s * (1.0 - t)), (k + row, (1.0 - s) * t), (k + row + 1, s * t)]
    }

    /// The cell that is the image of `cell` in the first axis.
    pub fn mirrored(&self, cell: usize) -> usize {
        let [i, j] = self.column_and_row(cell);
        (self.axes[1].len() - 1 - j) * self.row_length() + i
    }

    fn coordinates_in(&self, cell: usize, a: f64, b: f64) -> [f64; 2] {
        let [i, j] = self.column_and_row(cell);
        // A cell is a straight piece of its axes: places in u and in slope go in step.
        let at = |k: usize, axis: &Axis, t: f64| k as f64 - f64::from(axis.half) - 0.5 + t;
        [at(i, &self.axes[0], a), at(j, &self.axes[1], b)]
    }
}

/// The cell at or below a grid coordinate, counted from 0, and the share of the next one.
#[inline]
pub fn between(u: f64, half: f64) -> (usize, f64) {
    // At the very end the pair is the last one, with all weight on the border.
    let from_zero = at_most(at_least(u + half, 0.0), 2.0 * half);
    let (below, whole) = nearest(at_most(at_least(from_zero - 0.5, 0.0), 2.0 * half - 1.0));
    (below, from_zero - whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    fn tilted() -> HalfVectorCells {
        HalfVectorCells::new([0.03, -0.01], [0.1, 0.02], 0.5, 0.04)
    }

    #[test]
    fn every_point_of_a_cell_is_located_in_it() {
        let cells = tilted();
        let mut rng = CounterRng::new(1, 0, 0);
        for cell in 0..cells.len() {
            assert_eq!(cells.mirrored(cells.mirrored(cell)), cell);
            if cells.is_border(cell) {
                continue;
            }
            for _ in 0..4 {
                let (a, b) = (0.001 + 0.998 * rng.uniform(), 0.001 + 0.998 * rng.uniform());
                let (p, q) = cells.slope_in(cell, a, b);
                assert_eq!(cells.locate(p, q), cell);
            }
        }
        assert_eq!(cells.locate(1e9, 0.0), cells.locate(1e8, 0.0));
        assert!(cells.locate(f64::NAN, 0.0) < cells.len());
    }

    #[test]
    fn areas_tile_the_plane() {
        let cells = tilted();
        let mut sum = 0.0;
        for cell in (0..cells.len()).filter(|&k| !cells.is_border(k)) {
            let area: f64 = cells.points(cell).iter().map(|x| x.area).sum();
            assert!((area / cells.area(cell) - 1.0).abs() < 1e-12);
            sum += area;
        }
        let [x, y] = cells.axes.map(|axis| 2.0 * axis.place(f64::from(axis.half) - 0.5));
        assert!((sum / (x * cells.width[0] * y * cells.width[1]) - 1.0).abs() < 1e-12);
        assert!(x * cells.width[0] > 40.0 && y * cells.width[1] > 40.0);
    }

    /// A core cell is at most half a standard deviation wide, whatever the tolerance.
    #[test]
    fn core_cells_follow_the_lobe() {
        for tolerance in [1e-6, 1e-3, 0.01, 0.5] {
            let cells = HalfVectorCells::new([0.0; 2], [0.004, 0.001], 0.0, tolerance);
            assert!(cells.width[0] <= 0.002 && cells.width[1] <= 0.0005, "{:?}", cells.width);
        }
    }

    #[test]
    fn stencils_reproduce_centres_and_straight_lines_within_an_octave() {
        let cells = tilted();
        let mut rng = CounterRng::new(2, 0, 0);
        for _ in 0..1000 {
            let s = cells.stencil(40.0 * rng.uniform() - 20.0, 4.0 * rng.uniform() - 2.0);
            assert!((s.iter().map(|x| x.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(s.iter().all(|x| x.1 >= 0.0 && x.0 < cells.len()));
        }
        for cell in (0..cells.len()).filter(|&k| !cells.is_border(k)) {
            let (p, q) = cells.slope_in(cell, 0.5, 0.5);
            let own: f64 = cells.stencil(p, q).iter().filter(|s| s.0 == cell).map(|s| s.1).sum();
            assert!((own - 1.0).abs() < 1e-9, "{cell}: {own}");
        }
        // In the core the interpolation of a plane is the plane.
        let plane = |p: f64, q: f64| 2.0 + 3.0 * p - 5.0 * q;
        for _ in 0..100 {
            let (p, q) = (0.03 + 0.05 * (rng.uniform() - 0.5), -0.01 + 0.02 * (rng.uniform() - 0.5));
            let value: f64 = cells
                .stencil(p, q)
                .iter()
                .map(|&(k, w)| {
                    let (p, q) = cells.slope_in(k, 0.5, 0.5);
                    w * plane(p, q)
                })
                .sum();
            assert!((value - plane(p, q)).abs() < 1e-12);
        }
        assert!(cells.stencil(1e9, f64::INFINITY).iter().all(|&(k, w)| w == 0.0 || cells.is_border(k)));
    }
}
