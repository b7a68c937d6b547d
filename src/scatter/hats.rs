//! The interpolation between cells seen as a mixture: every cell spreads its value under a hat.

use super::axis::{Axis, at_most};
use super::cells::HalfVectorCells;

/// `T(u, v) = sum over cells of T_k hat_k(u, v)`, the weights of [`HalfVectorCells::stencil`]: a tent in each grid coordinate
/// from the centre of the cell before to that of the cell behind.
///
/// Drawing a cell by its share of `sum of T_k integral hat_k dp dq` and a place under its hat draws from the interpolated
/// density itself: a cell with `T_k = 0` is never drawn, and no place with `T = 0` either.
#[derive(Debug, Clone)]
pub struct Hats {
    across: Vec<Tent>,
    along: Vec<Tent>,
    /// Area of the unit of both integrals: a core cell.
    core_area: f64,
}

/// The tent of one axis: half a neighbour's cell up to 1/2, the own cell up to 1 and down, half a neighbour's down.
///
/// The width of a cell is constant within it, so the squared distance from the foot of the tent is piecewise linear in the
/// share of the mass below.
#[derive(Debug, Clone, Copy)]
struct Tent {
    /// Grid coordinate of the peak.
    peak: f64,
    /// Mass of the tent in core cells, and the share of it on the left.
    mass: f64,
    left: f64,
    sides: [Side; 2],
}

/// One side, from its foot, in two pieces: up to what squared distance, from what share of the tent's mass, and with what
/// rise per share each begins. Looked up, not branched to: which piece a draw meets cannot be predicted.
#[derive(Debug, Clone, Copy)]
struct Side {
    square: [f64; 2],
    from: [f64; 2],
    rise: [f64; 2],
    sign: f64,
}

impl Tent {
    fn new(axis: &Axis, k: usize) -> Tent {
        let width = |k: usize| if k < axis.len() { axis.width(k) } else { 0.0 };
        let own = width(k);
        let neighbours = [if k > 0 { width(k - 1) } else { 0.0 }, width(k + 1)];
        let mass = 0.75 * own + (neighbours[0] + neighbours[1]) / 8.0;
        let side = |neighbour: f64, sign: f64| {
            let (outer, inner) = (neighbour / 8.0 / mass, 0.375 * own / mass);
            let rise = [0.25 / outer.max(f64::MIN_POSITIVE), 0.75 / inner];
            Side { square: [0.0, 0.25], from: [0.0, outer], rise, sign }
        };
        let left = (neighbours[0] / 8.0 + 0.375 * own) / mass;
        let sides = [side(neighbours[0], -1.0), side(neighbours[1], 1.0)];
        Tent { peak: k as f64 - f64::from(axis.half), mass, left, sides }
    }

    /// Grid coordinate with a density in slope that follows the tent, for a uniform `a` in `[0, 1)`.
    #[inline(always)]
    fn place(&self, a: f64) -> f64 {
        let right = usize::from(a >= self.left);
        let side = &self.sides[right];
        // From the left end or from the right.
        let share = (right as f64 - a).abs();
        let piece = usize::from(share >= side.from[1]);
        let square = side.square[piece] + (share - side.from[piece]) * side.rise[piece];
        self.peak + side.sign * (1.0 - at_most(square, 1.0).sqrt())
    }
}

impl Hats {
    /// The hats of `cells`.
    pub fn new(cells: &HalfVectorCells) -> Hats {
        let tents = |axis: &Axis| (0..axis.len()).map(|k| Tent::new(axis, k)).collect();
        Hats { across: tents(&cells.axes[0]), along: tents(&cells.axes[1]), core_area: cells.width[0] * cells.width[1] }
    }

    /// `integral of hat_k dp dq` over the slope plane.
    #[inline(always)]
    pub fn integral(&self, [column, row]: [usize; 2]) -> f64 {
        self.across[column].mass * self.along[row].mass * self.core_area
    }

    /// Grid coordinates with density `hat_k` over the slope plane, for uniform `(a, b)` in `[0, 1)^2`.
    #[inline(always)]
    pub fn place(&self, [column, row]: [usize; 2], a: f64, b: f64) -> [f64; 2] {
        [self.across[column].place(a), self.along[row].place(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use crate::math::statistics::chi_square_test;

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
                let at = hats.place([column, row], rng.uniform(), rng.uniform());
                assert!(hat(&cells, cell, at) > 0.0, "{cell}: {at:?}");
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
