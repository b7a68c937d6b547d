//! Many starts, so that the answer does not depend on a guess.

use super::family::Free;
use super::levenberg::{LeastSquares, Minimum, Residuals, sum_of_squares};
use crate::math::random::CounterRng;
use rayon::prelude::*;

/// How widely a minimum is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Random points of the likely values at which the cost is looked up.
    pub scouts: usize,
    /// The best of them, from which the search descends.
    pub starts: usize,
    pub seed: u64,
    pub descent: LeastSquares,
}

impl Default for Search {
    fn default() -> Self {
        Search { scouts: 96, starts: 6, seed: 1, descent: LeastSquares::default() }
    }
}

/// Random stream of the starts.
const STREAM: u32 = 0x7174;

/// Minima of `residuals` over the box of the free parameters, lowest cost first; `residuals` takes coordinates.
///
/// Scouts are uniform in the scale of each parameter over its likely values. The result does not depend on the number of threads. Empty if the
/// residuals can be had nowhere.
pub fn multi_start(free: &[Free], residuals: &Residuals, search: &Search) -> Vec<Minimum> {
    let scout = |k: usize| -> Option<(f64, Vec<f64>)> {
        let mut rng = CounterRng::new(search.seed, STREAM, k as u64);
        // The first scout stands in the middle.
        let share = |u: f64| if k == 0 { 0.5 } else { 0.02 + 0.96 * u };
        let at: Vec<f64> = free.iter().map(|f| f.coordinate(f.likely_at(share(rng.uniform())))).collect();
        let cost = sum_of_squares(&residuals(&at)?);
        cost.is_finite().then_some((cost, at))
    };
    let mut scouts: Vec<(f64, Vec<f64>)> = (0..search.scouts.max(1)).into_par_iter().filter_map(scout).collect();
    scouts.sort_by(|a, b| a.0.total_cmp(&b.0));
    scouts.truncate(search.starts.max(1));
    let mut minima: Vec<Minimum> =
        scouts.par_iter().filter_map(|(_, start)| search.descent.descend(residuals, start)).collect();
    minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    minima
}

#[cfg(test)]
mod tests {
    use super::super::family::Free;
    use super::*;
    use crate::model::Scale;

    /// A wave with many dips: from the middle of the box the nearest is the wrong one.
    #[test]
    fn finds_the_deepest_of_many_dips() {
        let free = vec![Free::new("x", -10.0, 10.0, Scale::Linear).unwrap()];
        let r = |u: &[f64]| {
            let x = free[0].value(u[0]);
            Some(vec![0.1 * (x - 6.0), 1.0 + (3.0 * x).cos()])
        };
        // Near 6, cos(3x) = -1 at x = 5.236 + ...: the deepest dip is at 3x = 5 pi, x = 5.236, or 7 pi, x = 7.330.
        let minima = multi_start(&free, &r, &Search::default());
        let x = free[0].value(minima[0].at[0]);
        assert!((x - 5.236).abs() < 0.3, "{x}");
        assert!(minima.windows(2).all(|m| m[0].cost <= m[1].cost));
        assert_eq!(minima, multi_start(&free, &r, &Search::default()));
    }
}
