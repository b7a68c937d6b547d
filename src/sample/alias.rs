//! Draws from a list of weights in constant time.

use crate::error::{Error, Result};
use crate::math::statistics::compensated_sum;
use crate::scatter::axis::at_most;

/// Walker's alias table (Electronics Letters 10, 127, 1974): `m` columns of equal mass, each shared by at most two cells.
///
/// `p_k = (own_k + sum over columns j with alias k of (1 - own_j)) / m`, over the `m` cells with weight; a cell without is in
/// no column and cannot be drawn. Filled in one sweep of two fingers, one over the cells below the mean and one over those
/// above (Vose, IEEE Trans. Softw. Eng. 17, 972, 1991, without his stacks): memory is read in order. In f64 throughout; in
/// f32 the rounding of `m p` near one hot cell would stray far above its neighbours' weights.
#[derive(Debug, Clone)]
pub struct AliasTable {
    columns: Vec<Column>,
    cells: usize,
    total: f64,
}

/// A column keeps its own cell for draws below `threshold / 2^32`, else gives the alias.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    pub threshold: u32,
    /// The alias, then the own cell.
    pub cells: [u32; 2],
}

/// Steps of a threshold.
const STEPS: f64 = (1u64 << 32) as f64;

impl AliasTable {
    /// Table for `weights >= 0`; they need not sum to 1.
    ///
    /// # Errors
    /// `Error::Parameter` if a weight is negative, infinite or NaN, if all are zero, or for more than 2^32 - 1 weights.
    pub fn new(weights: &[f64]) -> Result<Self> {
        if weights.len() >= u32::MAX as usize {
            return Err(Error::parameter("too many cells to sample", "coarsen the table"));
        }
        let mut largest = 0.0f64;
        for (k, &w) in weights.iter().enumerate() {
            if !(w >= 0.0 && w.is_finite()) {
                return Err(Error::parameter(
                    format!("weight {k} is {w}"),
                    "weights to sample must be finite and not negative",
                ));
            }
            largest = largest.max(w);
        }
        if largest == 0.0 {
            return Err(Error::parameter("every weight is zero", "there is nothing to sample"));
        }
        // Scaled by the largest first, so that denormal weights keep their ratios and large ones do not overflow.
        let sum = compensated_sum(weights.iter().map(|w| w / largest));
        let drawable = weights.iter().filter(|&&w| w > 0.0).count();
        let scale = drawable as f64 / sum;
        let mut cells = Vec::with_capacity(drawable);
        let mut masses = Vec::with_capacity(drawable);
        for (k, &w) in weights.iter().enumerate() {
            if w > 0.0 {
                cells.push(k as u32);
                masses.push(w / largest * scale);
            }
        }
        Ok(AliasTable { columns: sweep(&cells, &masses), cells: weights.len(), total: sum * largest })
    }

    pub(super) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of weights, those of zero included.
    pub fn len(&self) -> usize {
        self.cells
    }

    /// Never true: an empty list is refused.
    pub fn is_empty(&self) -> bool {
        self.cells == 0
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Index drawn by 64 random bits, and what is left of them, again uniform in `[0, 1)`.
    #[inline]
    pub fn draw(&self, bits: u64) -> (usize, f64) {
        let product = u128::from(bits) * self.columns.len() as u128;
        let rest = product as u64;
        let column = &self.columns[(product >> 64) as usize];
        let own = usize::from((rest >> 32) < u64::from(column.threshold));
        // What is left is rescaled from its part of the column: low-discrepancy points stay spread inside the cell. Worked out
        // without a branch, which would be missed every other time.
        let threshold = f64::from(column.threshold);
        let other = 1.0 - own as f64;
        let place = (rest >> 11) as i64 as f64 * (STEPS / (1u64 << 53) as f64);
        let width = (threshold - other * STEPS).abs();
        (column.cells[own] as usize, at_most((place - other * threshold) / width, 1.0 - f64::EPSILON))
    }

    /// Probability of each cell as the columns hold it: what a pdf must use. Within 2^-32 of `weight / total`.
    pub fn probabilities(&self) -> Vec<f64> {
        // Whole numbers of steps: exact in any order.
        let mut steps = vec![0u64; self.cells];
        for column in &self.columns {
            steps[column.cells[1] as usize] += u64::from(column.threshold);
            steps[column.cells[0] as usize] += (1 << 32) - u64::from(column.threshold);
        }
        let unit = 1.0 / (STEPS * self.columns.len() as f64);
        steps.into_iter().map(|s| s as f64 * unit).collect()
    }
}

/// Fills the columns; `masses` are the weights over their mean, all above zero.
fn sweep(cells: &[u32], masses: &[f64]) -> Vec<Column> {
    let m = masses.len();
    let mut columns: Vec<Column> =
        cells.iter().map(|&cell| Column { threshold: u32::MAX, cells: [cell, cell] }).collect();
    let next = |from: usize, heavy: bool| (from..m).find(|&k| (masses[k] > 1.0) == heavy).unwrap_or(m);
    let (mut light, mut heavy) = (next(0, false), next(0, true));
    if heavy == m {
        return columns;
    }
    // What is left of the heavy cell, and what each addition to it rounded off: it may give to thousands of others.
    let (mut left, mut lost) = (masses[heavy], 0.0);
    let mut take = |left: &mut f64, mass: f64| {
        let given = mass - 1.0;
        let sum = *left + given;
        lost += given - (sum - *left);
        *left = sum;
        sum + lost
    };
    // A cell that can be drawn keeps at least one step, and its alias as well.
    let steps = |mass: f64| ((mass * STEPS + 0.5) as u64).clamp(1, u64::from(u32::MAX)) as u32;
    let mut exact = left;
    loop {
        if exact > 1.0 {
            if light == m {
                break;
            }
            columns[light] = Column { threshold: steps(masses[light]), cells: [cells[heavy], cells[light]] };
            exact = take(&mut left, masses[light]);
            light = next(light + 1, false);
        } else {
            // The heavy cell has become a light one: its column is filled up by the next heavy cell.
            let following = next(heavy + 1, true);
            if following == m {
                break;
            }
            columns[heavy] = Column { threshold: steps(exact.max(0.0)), cells: [cells[following], cells[heavy]] };
            exact = take(&mut left, masses[following]);
            heavy = following;
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    fn bits(rng: &mut CounterRng) -> u64 {
        ((rng.uniform() * STEPS) as u64) << 32 | (rng.uniform() * STEPS) as u64
    }

    fn exact(weights: &[f64]) {
        let table = AliasTable::new(weights).unwrap();
        let sum: f64 = compensated_sum(weights.iter().copied());
        let columns = weights.iter().filter(|&&w| w > 0.0).count() as f64;
        let probabilities = table.probabilities();
        assert_eq!(probabilities.len(), weights.len());
        for (k, p) in probabilities.into_iter().enumerate() {
            // Half a step for the own column and for every column a heavy cell fills up.
            let tolerance = (1.0 + weights[k] / sum * columns) / columns / STEPS;
            assert!((p - weights[k] / sum).abs() <= tolerance + 1e-15, "{k}: {p} {}", weights[k] / sum);
            assert_eq!(p > 0.0, weights[k] > 0.0);
        }
        assert!((table.total() / sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn mass_is_reconstructed() {
        exact(&[0.1, 0.2, 0.3, 0.4]);
        exact(&[0.0, 1.0, 3.0]);
        exact(&[5.0]);
        exact(&[1.0; 7]);
        let mut rng = CounterRng::new(1, 0, 0);
        exact(&(0..10_007).map(|_| rng.uniform().powi(9)).collect::<Vec<_>>());
    }

    /// A near-mirror lobe: one hot cell, a small halo, the rest empty or nearly so.
    #[test]
    fn a_hot_cell_never_lets_an_empty_one_be_drawn() {
        for n in [1_000, 32_400, 129_600, 1_000_000] {
            for background in [0.0, 1e-12] {
                let mut weights = vec![background; n];
                weights[n / 2] = 0.7;
                (1..40).for_each(|k| weights[n / 2 + k] = 0.3 / 39.0);
                weights[3] = 0.0;
                exact(&weights);
                let table = AliasTable::new(&weights).unwrap();
                let mut rng = CounterRng::new(n as u64, 0, 0);
                for _ in 0..100_000 {
                    let (k, left) = table.draw(bits(&mut rng));
                    assert!(weights[k] > 0.0 && (0.0..1.0).contains(&left));
                }
            }
        }
    }

    #[test]
    fn the_remainder_is_uniform() {
        let table = AliasTable::new(&[0.05, 0.6, 0.35]).unwrap();
        let mut bins = [[0.0f64; 10]; 3];
        let n = 300_000u64;
        for j in 0..n {
            let (k, left) = table.draw(u64::MAX / n * j + u64::MAX / n / 2);
            bins[k][(left * 10.0) as usize] += 1.0;
        }
        for (k, p) in [0.05, 0.6, 0.35].into_iter().enumerate() {
            for b in bins[k] {
                assert!((b - n as f64 * p / 10.0).abs() < 10.0, "{bins:?}");
            }
        }
    }

    #[test]
    fn degenerate_weights() {
        for bad in [f64::NAN, f64::INFINITY, -1.0, -f64::INFINITY] {
            assert!(AliasTable::new(&[1.0, bad]).is_err());
        }
        assert!(AliasTable::new(&[0.0, 0.0]).is_err());
        assert!(AliasTable::new(&[0.0, -0.0]).is_err());
        assert!(AliasTable::new(&[]).is_err());
        let tiny = AliasTable::new(&[5e-324, 1.5e-323]).unwrap();
        assert!((tiny.probabilities()[1] - 0.75).abs() < 1e-9);
        let huge = AliasTable::new(&[1e308, 1e308, 0.0]).unwrap();
        assert!((huge.probabilities()[0] - 0.5).abs() < 1e-9);
        let single = AliasTable::new(&[0.0, 7.0, 0.0]).unwrap();
        for bits in [0, 1, u64::MAX / 2, u64::MAX] {
            let (k, left) = single.draw(bits);
            assert!(k == 1 && (0.0..1.0).contains(&left));
        }
    }
}
