//! The interpolation between cells seen as a mixture: every cell spreads its value under a hat.

use super::cells::HalfVectorCells;
use std::f64::consts::TAU;

/// Pieces of a ring's hat in rho, each with a closed inverse.
const PIECES: usize = 5;

/// `T(rho, chi) = sum over cells of T_k hat_k(rho, chi)`, the weights of [`HalfVectorCells::stencil`]: a tent in rho from the
/// centre of the ring below to that of the ring above, times a tent in chi from the sector before to the one behind;
/// constant in chi in the central disc, and in rho beyond the centre of the last ring.
///
/// Drawing a cell by its share of `sum of T_k integral hat_k` and a place under its hat draws from the interpolated density
/// itself: a cell with `T_k = 0` is never drawn, and no place with `T = 0` either.
#[derive(Debug, Clone)]
pub struct Hats {
    rings: Vec<Ring>,
    /// `1 / integral of hat_k dp dq`, per cell.
    inverse_integral: Vec<f64>,
}

#[derive(Debug, Clone)]
struct Ring {
    /// Where the tent begins, peaks and ends in rho; in the last ring it stays at its peak to `end`.
    begin: f64,
    peak: f64,
    end: f64,
    /// Upper end of each piece's share of the hat's mass.
    cumulative: [f64; PIECES],
    first: usize,
    sectors: f64,
}

impl Hats {
    /// The hats of `cells`.
    pub fn new(cells: &HalfVectorCells) -> Hats {
        let count = cells.sectors.len();
        let mut inverse_integral = Vec::with_capacity(cells.len());
        let rings = (0..count)
            .map(|r| {
                let last = r + 1 == count;
                let peak = cells.ring_centre(r);
                let begin = if r == 0 { peak } else { cells.ring_centre(r - 1) };
                let end = if last { cells.edges[count] } else { cells.ring_centre(r + 1) };
                let (up, down) = (peak - begin, if last { 0.0 } else { end - peak });
                // With rho = a + h x: x rho = a x + h x^2 going up, (1 - x) rho = a (1 - x) + h x (1 - x) coming down.
                let plateau = if last { 0.5 * (end * end - peak * peak) } else { 0.0 };
                let masses = [up * begin / 2.0, up * up / 3.0, down * peak / 2.0, down * down / 6.0, plateau];
                let total: f64 = masses.iter().sum();
                let mut sum = 0.0;
                let cumulative = masses.map(|m| {
                    sum += m;
                    sum / total
                });
                let sectors = f64::from(cells.sectors[r]);
                let integral = total * cells.scale[0] * cells.scale[1] * TAU / sectors;
                let range = cells.cells_of_ring(r);
                inverse_integral.resize(range.end, 1.0 / integral);
                Ring { begin, peak, end, cumulative, first: range.start, sectors }
            })
            .collect();
        Hats { rings, inverse_integral }
    }

    /// `1 / integral of hat_k dp dq` over the slope plane.
    #[inline]
    pub fn inverse_integral(&self, cell: usize) -> f64 {
        self.inverse_integral[cell]
    }

    /// `(rho, chi)` with density `hat_k` over the slope plane, for uniform `(a, b)` in `[0, 1)^2`.
    #[inline]
    pub fn polar_in(&self, cell: usize, a: f64, b: f64) -> (f64, f64) {
        let ring = &self.rings[self.rings.partition_point(|r| r.first <= cell) - 1];
        let piece = ring.cumulative.iter().position(|&c| a < c).unwrap_or(PIECES - 1);
        let below = if piece == 0 { 0.0 } else { ring.cumulative[piece - 1] };
        let v = ((a - below) / (ring.cumulative[piece] - below)).clamp(0.0, 1.0);
        let (up, down) = (ring.peak - ring.begin, ring.end - ring.peak);
        let rho = match piece {
            0 => ring.begin + up * v.sqrt(),
            1 => ring.begin + up * v.cbrt(),
            2 => ring.peak + down * (1.0 - (1.0 - v).sqrt()),
            // x of 3 x^2 - 2 x^3 = v.
            3 => ring.peak + down * (0.5 - ((1.0 - 2.0 * v).asin() / 3.0).sin()),
            _ => (ring.peak * ring.peak + v * (ring.end * ring.end - ring.peak * ring.peak)).sqrt(),
        };
        let turn = if ring.sectors == 1.0 {
            b - 0.5
        } else {
            let tent = if b < 0.5 { (2.0 * b).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * b).sqrt() };
            ((cell - ring.first) as f64 + tent) / ring.sectors
        };
        (rho, TAU * turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use crate::math::statistics::chi_square_test;

    fn cells() -> HalfVectorCells {
        HalfVectorCells::from_parts([0.1, -0.2], [0.3, 0.1], 0.4, vec![0.0, 0.5, 1.1, 1.6, 2.9], vec![1, 6, 9, 7])
    }

    /// Weight of `cell` in the interpolation at a place.
    fn hat(cells: &HalfVectorCells, cell: usize, polar: (f64, f64)) -> f64 {
        cells.stencil_at(polar).iter().filter(|s| s.0 == cell).map(|s| s.1).sum()
    }

    #[test]
    fn hats_tile_the_plane_and_integrate_to_what_they_say() {
        let cells = cells();
        let hats = Hats::new(&cells);
        let sum: f64 = (0..cells.len()).map(|k| 1.0 / hats.inverse_integral(k)).sum();
        let area: f64 = (0..cells.len()).map(|k| cells.area(k)).sum();
        assert!((sum / area - 1.0).abs() < 1e-12);
        // Midpoints in (rho, chi) on a grid that meets the kinks of every ring to 1e-3.
        let (rings, turns) = (2900, 6 * 9 * 7 * 2);
        let mut integrals = vec![0.0; cells.len()];
        for i in 0..rings {
            let rho = 2.9 * (f64::from(i) + 0.5) / f64::from(rings);
            for j in 0..turns {
                let chi = TAU * (f64::from(j) + 0.5) / f64::from(turns);
                for (k, w) in cells.stencil_at((rho, chi)) {
                    integrals[k] += w * rho * 2.9 * TAU / f64::from(rings * turns) * 0.03;
                }
            }
        }
        for (k, integral) in integrals.iter().enumerate() {
            assert!((integral * hats.inverse_integral(k) - 1.0).abs() < 2e-3, "{k}: {integral}");
        }
    }

    /// Places drawn under a hat against the hat, in cells small enough to see its slopes.
    #[test]
    fn places_follow_the_hat() {
        let cells = cells();
        let hats = Hats::new(&cells);
        let (rings, turns) = (58, 36);
        for cell in [0, 3, 10, 22] {
            let mut rng = CounterRng::new(3, 0, cell as u64);
            let mut counts = vec![0.0; rings * turns];
            let draws = 300_000;
            for _ in 0..draws {
                let (rho, chi) = hats.polar_in(cell, rng.uniform(), rng.uniform());
                assert!(hat(&cells, cell, (rho, chi)) > 0.0, "{cell}: {rho} {chi}");
                let i = (rho / 2.9 * rings as f64) as usize;
                let j = ((chi / TAU).rem_euclid(1.0) * turns as f64) as usize;
                counts[i.min(rings - 1) * turns + j.min(turns - 1)] += 1.0;
            }
            let fine = 16;
            let expected: Vec<f64> = (0..rings * turns)
                .map(|bin| {
                    let mut sum = 0.0;
                    for k in 0..fine * fine {
                        let part = |x: usize| (x as f64 + 0.5) / fine as f64;
                        let rho = 2.9 * ((bin / turns) as f64 + part(k / fine)) / rings as f64;
                        let chi = TAU * ((bin % turns) as f64 + part(k % fine)) / turns as f64;
                        sum += hat(&cells, cell, (rho, chi)) * rho;
                    }
                    let step = 2.9 * TAU / (rings * turns * fine * fine) as f64;
                    sum * step * 0.03 * hats.inverse_integral(cell) * f64::from(draws)
                })
                .collect();
            let (chi2, dof, p) = chi_square_test(&counts, &expected, 10.0);
            assert!(p > 1e-4 && dof > 20.0, "{cell}: {chi2} {dof}");
        }
    }
}
