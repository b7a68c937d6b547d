//! The interpolation between cells seen as a mixture: every cell spreads its value under a hat.

use crate::scatter::HalfVectorCells;
use crate::scatter::axis::Axis;

/// `T(u, v) = sum over cells of T_k hat_k(u, v)`, the weights of [`HalfVectorCells::stencil`]: a tent in each grid coordinate
/// from the centre of the cell before to that of the cell behind.
///
/// Drawing a cell by its share of `sum of T_k integral hat_k dp dq` and a place under its hat draws from the interpolated
/// density itself: a cell with `T_k = 0` is never drawn, and no place with `T = 0` either. The draw knows its place
/// between the cells as well, so that nothing needs to be looked for.
#[derive(Debug, Clone)]
pub(super) struct Hats {
    /// Of the columns, and of the rows.
    pub tents: [Vec<Tent>; 2],
    /// Mass of every tent in core cells.
    masses: [Vec<f64>; 2],
    /// Area of the unit of both integrals: a core cell.
    core_area: f64,
}

/// The tent of one axis: half a neighbour's cell up to 1/2, the own cell up to 1 and down, half a neighbour's down.
///
/// The width of a cell is constant within it, so the squared distance from the foot of the tent is piecewise linear in the
/// share of the mass below. Looked up, not branched to: which piece a draw meets cannot be predicted.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(32))]
pub(super) struct Tent {
    /// Left side near its foot and near the peak, right side the same.
    pub pieces: [Piece; 4],
    /// Share of the mass on the left.
    pub left: f32,
    /// Share of the mass near the foot, of both sides.
    pub outer: [f32; 2],
}

/// One piece: `height^2 = square + rise (share - from)` for the share of mass between it and the foot, and
/// `x = place + slope height` in core cells.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Piece {
    pub place: f64,
    pub slope: f32,
    pub from: f32,
    pub square: f32,
    pub rise: f32,
}

/// Where along one axis a draw fell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// Place in core cells.
    pub x: f64,
    /// 1 beyond the peak of the tent, 0 before it.
    pub beyond: usize,
    /// Share of the upper of the two cells it lies between.
    pub upper: f32,
}

/// Heights are at least its root: a place under the very edge would have no density.
pub(super) const LEAST_SQUARE: f32 = 1e-12;

impl Tent {
    fn new(axis: &Axis, k: usize) -> (Tent, f64) {
        let width = |k: usize| if k < axis.len() { axis.width(k) } else { 0.0 };
        let own = width(k);
        let neighbours = [if k > 0 { width(k - 1) } else { 0.0 }, width(k + 1)];
        let mass = 0.75 * own + (neighbours[0] + neighbours[1]) / 8.0;
        let peak = axis.place(k as f64 - f64::from(axis.half));
        let mut tent = Tent { left: ((neighbours[0] / 8.0 + 0.375 * own) / mass) as f32, ..Tent::default() };
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let neighbour = neighbours[side];
            let (outer, inner) = (neighbour / 8.0 / mass, 0.375 * own / mass);
            tent.outer[side] = outer as f32;
            tent.pieces[2 * side] = Piece {
                place: peak + sign * 0.5 * (own + neighbour),
                slope: (-sign * neighbour) as f32,
                from: 0.0,
                square: 0.0,
                rise: (0.25 / outer.max(1e-30)) as f32,
            };
            tent.pieces[2 * side + 1] = Piece {
                place: peak + sign * own,
                slope: (-sign * own) as f32,
                from: outer as f32,
                square: 0.25,
                rise: (0.75 / inner) as f32,
            };
        }
        (tent, mass)
    }

    /// A place whose density in slope follows the tent, for a uniform `a` in `[0, 1]`.
    #[inline(always)]
    pub fn place(&self, a: f32) -> Spot {
        let beyond = not_below(a, self.left);
        let one = f32::from_bits(beyond & 1f32.to_bits());
        let share = (one - a).abs();
        let beyond = (beyond & 1) as usize;
        let inner = (not_below(share, self.outer[beyond]) & 1) as usize;
        let piece = &self.pieces[(2 * beyond + inner) & 3];
        let square = piece.square + (share - piece.from) * piece.rise;
        let square = if square > LEAST_SQUARE { square } else { LEAST_SQUARE };
        let height = (if square < 1.0 { square } else { 1.0 }).sqrt();
        Spot { x: piece.place + f64::from(piece.slope * height), beyond, upper: (one - height).abs() }
    }
}

/// All ones if `a >= b`, from the sign of the difference: of a comparison LLVM makes a branch, missed every other time.
#[inline(always)]
fn not_below(a: f32, b: f32) -> u32 {
    !(((a - b).to_bits() as i32) >> 31) as u32
}

impl Hats {
    /// The hats of `cells`.
    pub fn new(cells: &HalfVectorCells) -> Hats {
        let both = cells.axes.each_ref().map(|axis| (0..axis.len()).map(|k| Tent::new(axis, k)).collect::<Vec<_>>());
        Hats {
            tents: both.each_ref().map(|axis| axis.iter().map(|t| t.0).collect()),
            masses: both.map(|axis| axis.into_iter().map(|t| t.1).collect()),
            core_area: cells.width[0] * cells.width[1],
        }
    }

    /// `integral of hat_k dp dq` over the slope plane.
    pub fn integral(&self, [column, row]: [usize; 2]) -> f64 {
        self.masses[0][column] * self.masses[1][row] * self.core_area
    }

    /// A place with density `hat_k` over the slope plane, for uniform `(a, b)`.
    #[inline(always)]
    pub fn place(&self, [column, row]: [u16; 2], a: f32, b: f32) -> [Spot; 2] {
        [self.tents[0][usize::from(column)].place(a), self.tents[1][usize::from(row)].place(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use crate::math::statistics::chi_square_test;
    use crate::scatter::cells::between;

    /// Few cells: central, one octave of two, then wider ones.
    fn cells() -> HalfVectorCells {
        let axis = |half| Axis { core: 1, per_octave: 2, half };
        HalfVectorCells::from_parts([0.1, -0.2], [0.3, 0.1], 0.4, [axis(7), axis(6)])
    }

    /// Weight of `cell` in the interpolation at grid coordinates.
    fn hat(cells: &HalfVectorCells, cell: usize, at: [f64; 2]) -> f64 {
        cells.stencil_at(at).iter().filter(|s| s.0 == cell).map(|s| s.1).sum()
    }

    /// Midpoints within the half cells, where hats are bilinear: exact.
    #[test]
    fn hats_integrate_to_what_they_say() {
        let cells = cells();
        let hats = Hats::new(&cells);
        let mut integrals = vec![0.0; cells.len()];
        for cell in 0..cells.len() {
            for (a, b) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
                let (p, q) = cells.slope_in(cell, a, b);
                for (k, w) in cells.stencil(p, q) {
                    integrals[k] += w * cells.area(cell) / 4.0;
                }
            }
        }
        for k in (0..cells.len()).filter(|&k| !cells.is_border(k)) {
            let said = hats.integral(cells.column_and_row(k));
            assert!((integrals[k] / said - 1.0).abs() < 1e-12, "{k}: {} {said}", integrals[k]);
        }
    }

    /// Places drawn under a hat against the hat, in bins small enough to see its slopes.
    #[test]
    fn places_follow_the_hat() {
        let cells = cells();
        let hats = Hats::new(&cells);
        let bins = 40;
        // In the core, at the step from one width to the next, and next to the border.
        for (column, row) in [(7, 6), (7 + 3, 6 - 4), (1, 11), (7 - 4, 6)] {
            let cell = row * cells.row_length() + column;
            let from = [column as f64 - 7.0 - 1.0, row as f64 - 6.0 - 1.0];
            let mut rng = CounterRng::new(3, 0, cell as u64);
            let mut counts = vec![0.0; bins * bins];
            let draws = 400_000;
            for _ in 0..draws {
                let u = [0, 1].map(|_| rng.uniform() as f32);
                let spots = hats.place([column as u16, row as u16], u[0], u[1]);
                let at = [0, 1].map(|k| cells.axes[k].coordinate(spots[k].x));
                assert!(hat(&cells, cell, at) > 0.0, "{cell}: {at:?}");
                // The place between the cells is what a search would find.
                for (k, own) in [column, row].into_iter().enumerate() {
                    let (lower, upper) = between(at[k], f64::from(cells.axes[k].half));
                    let said = (own + spots[k].beyond - 1) as f64 + f64::from(spots[k].upper);
                    assert!((lower as f64 + upper - said).abs() < 1e-5, "{cell}: {at:?} {spots:?}");
                }
                let [i, j] = [0, 1].map(|k| ((at[k] - from[k]) / 2.0 * bins as f64) as usize);
                counts[j.min(bins - 1) * bins + i.min(bins - 1)] += 1.0;
            }
            // Within a bin the hat is bilinear and the width of the cell constant: its middle stands for it.
            let integral = hats.integral([column, row]);
            let expected: Vec<f64> = (0..bins * bins)
                .map(|bin| {
                    let at = [0, 1].map(|k| {
                        let step = if k == 0 { bin % bins } else { bin / bins };
                        from[k] + (step as f64 + 0.5) * 2.0 / bins as f64
                    });
                    let widths: f64 = (0..2)
                        .map(|k| {
                            let axis = &cells.axes[k];
                            let h = 1.0 / bins as f64;
                            (axis.place(at[k] + h) - axis.place(at[k] - h)) * cells.width[k]
                        })
                        .product();
                    hat(&cells, cell, at) * widths / integral * f64::from(draws)
                })
                .collect();
            let (chi2, dof, p) = chi_square_test(&counts, &expected, 10.0);
            assert!(p > 1e-4 && dof > 20.0, "{cell}: {chi2} {dof}");
        }
    }
}
