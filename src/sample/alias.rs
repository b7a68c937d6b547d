//! Draws from a list of weights in constant time.

use crate::error::{Error, Result};
use crate::math::statistics::compensated_sum;

/// Walker's alias table (Electronics Letters 10, 127, 1974), built by Vose's two stacks (IEEE Trans. Softw. Eng. 17, 972, 1991).
///
/// `p_k = (threshold_k + sum over j with alias_j = k of (1 - threshold_j)) / n`. Built in f64: in f32 the rounding of
/// `n p` near one hot cell makes empty cells drawable.
#[derive(Debug, Clone)]
pub struct AliasTable {
    entries: Vec<Entry>,
    probabilities: Vec<f64>,
    total: f64,
}

/// One column: keep its own index below `threshold`, else go to `alias`.
#[derive(Debug, Clone, Copy)]
struct Entry {
    threshold: f64,
    alias: u32,
}

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
        // Scaled by the largest first, so that denormal weights keep their ratios.
        let sum = compensated_sum(weights.iter().map(|w| w / largest));
        let probabilities: Vec<f64> = weights.iter().map(|w| w / largest / sum).collect();
        Ok(AliasTable { entries: vose(&probabilities), probabilities, total: sum * largest })
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Never true: an empty list is refused.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Probability of drawing `k`.
    #[inline]
    pub fn probability(&self, k: usize) -> f64 {
        self.probabilities[k]
    }

    /// Index drawn by `u` in `[0, 1)` and what is left of `u`, again uniform in `[0, 1)`.
    #[inline]
    pub fn draw(&self, u: f64) -> (usize, f64) {
        let n = self.entries.len();
        let x = u * n as f64;
        let column = (x as usize).min(n - 1);
        let rest = x - column as f64;
        let Entry { threshold, alias } = self.entries[column];
        // The remainder of the remainder: rescaling keeps low-discrepancy points spread inside the cell.
        let (index, left) = if rest < threshold {
            (column, rest / threshold)
        } else {
            (alias as usize, (rest - threshold) / (1.0 - threshold))
        };
        (index, left.clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// The probabilities as the columns hold them, for tests: must equal [`AliasTable::probability`].
    pub fn reconstruct(&self) -> Vec<f64> {
        let n = self.entries.len() as f64;
        let mut parts: Vec<Vec<f64>> = self.entries.iter().map(|e| vec![e.threshold / n]).collect();
        for e in &self.entries {
            parts[e.alias as usize].push((1.0 - e.threshold) / n);
        }
        parts.into_iter().map(compensated_sum).collect()
    }
}

fn vose(probabilities: &[f64]) -> Vec<Entry> {
    let n = probabilities.len();
    let mut scaled: Vec<f64> = probabilities.iter().map(|p| p * n as f64).collect();
    let mut entries: Vec<Entry> = (0..n).map(|k| Entry { threshold: 1.0, alias: k as u32 }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&k| scaled[k] < 1.0);
    // A hot cell gives to thousands of empty ones: what each subtraction rounds off is kept beside it.
    let mut lost = 0.0;
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        entries[s] = Entry { threshold: scaled[s], alias: l as u32 };
        let given = scaled[s] - 1.0;
        let left = scaled[l] + given;
        lost += given - (left - scaled[l]);
        scaled[l] = left;
        if left + lost < 1.0 {
            scaled[l] = (left + lost).max(0.0);
            lost = 0.0;
            large.pop();
            small.push(l);
        }
    }
    // Rounding can strand columns on either stack. One with weight keeps its own index; one without must not be
    // drawable, so it points to the heaviest.
    let heaviest = (0..n).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b])).unwrap_or(0);
    for k in small {
        if probabilities[k] == 0.0 {
            entries[k] = Entry { threshold: 0.0, alias: heaviest as u32 };
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;

    fn exact(weights: &[f64]) {
        let table = AliasTable::new(weights).unwrap();
        let sum: f64 = compensated_sum(weights.iter().copied());
        for (k, p) in table.reconstruct().into_iter().enumerate() {
            assert!((p - weights[k] / sum).abs() < 1e-12, "{k}: {p}");
            assert!((table.probability(k) - weights[k] / sum).abs() < 1e-15);
        }
        assert!((table.total() / sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn mass_is_reconstructed() {
        exact(&[0.1, 0.2, 0.3, 0.4]);
        exact(&[0.0, 1.0, 3.0]);
        exact(&[5.0]);
        let mut rng = CounterRng::new(1, 0, 0);
        exact(&(0..10_007).map(|_| rng.uniform().powi(9)).collect::<Vec<_>>());
    }

    /// A near-mirror lobe: one hot cell, a small halo, the rest empty, where an f32 table draws empty cells.
    #[test]
    fn a_hot_cell_never_lets_an_empty_one_be_drawn() {
        for n in [1_000, 32_400, 129_600, 1_000_000] {
            let mut weights = vec![0.0; n];
            weights[n / 2] = 0.7;
            (1..40).for_each(|k| weights[n / 2 + k] = 0.3 / 39.0);
            exact(&weights);
            let table = AliasTable::new(&weights).unwrap();
            for (k, e) in table.entries.iter().enumerate() {
                assert!(e.threshold == 0.0 || weights[k] > 0.0);
                assert!(e.threshold >= 1.0 || weights[e.alias as usize] > 0.0);
            }
            let mut rng = CounterRng::new(n as u64, 0, 0);
            for _ in 0..200_000 {
                let (k, left) = table.draw(rng.uniform());
                assert!(weights[k] > 0.0 && (0.0..1.0).contains(&left));
            }
        }
    }

    #[test]
    fn the_remainder_is_uniform() {
        let table = AliasTable::new(&[0.05, 0.6, 0.35]).unwrap();
        let mut bins = [[0.0f64; 10]; 3];
        let n = 300_000;
        for j in 0..n {
            let (k, left) = table.draw((f64::from(j) + 0.5) / f64::from(n));
            bins[k][(left * 10.0) as usize] += 1.0;
        }
        for (k, p) in [0.05, 0.6, 0.35].into_iter().enumerate() {
            for b in bins[k] {
                assert!((b - f64::from(n) * p / 10.0).abs() < 10.0, "{bins:?}");
            }
        }
    }

    #[test]
    fn degenerate_weights() {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(AliasTable::new(&[1.0, bad]).is_err());
        }
        assert!(AliasTable::new(&[0.0, 0.0]).is_err());
        assert!(AliasTable::new(&[]).is_err());
        let tiny = AliasTable::new(&[5e-324, 1.5e-323]).unwrap();
        assert!((tiny.probability(1) - 0.75).abs() < 1e-12);
        assert_eq!(tiny.draw(1.0).0, 1);
    }
}
