//! Climbs the ladder of every method within a budget of time.

use super::method::{Family, Method};
use super::stopwatch::{median, timed};
use crate::math::Estimate;
use serde::Serialize;
use std::time::{Duration, Instant};

/// How much to spend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Time for all methods together.
    pub budget: Duration,
    /// Runs per effort.
    pub repeats: usize,
    pub seed: u64,
}

/// One method at one effort.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rung {
    pub family: String,
    pub method: String,
    /// What effort counts.
    pub effort_of: String,
    pub effort: f64,
    pub repeats: usize,
    /// Shortest, median and longest time of the repeats.
    pub seconds: [f64; 3],
    /// Root of the mean squared distance from the reference over the repeats, with its standard error: the scatter of repeats
    /// and the error of the reference.
    pub error: f64,
    pub error_se: f64,
    pub unit: String,
    /// Whether the program takes this effort by itself.
    pub default: bool,
}

/// Every method of every family, from its cheapest effort up to what its share of the time allows.
///
/// Methods with small appetite go first, and what they leave is shared among the rest. How far up a ladder a run comes depends
/// on the machine; the errors at an effort do not. `progress` is told the share of the budget that is spent.
pub fn run(families: &[Family], plan: &Plan, progress: &dyn Fn(f64)) -> Vec<Rung> {
    let start = Instant::now();
    let mut order: Vec<(usize, usize)> =
        families.iter().enumerate().flat_map(|(f, family)| (0..family.methods.len()).map(move |m| (f, m))).collect();
    order.sort_by(|a, b| {
        let appetite = |&(f, m): &(usize, usize)| families[f].methods[m].appetite;
        appetite(a).total_cmp(&appetite(b))
    });
    let mut waiting: f64 = order.iter().map(|&(f, m)| families[f].methods[m].appetite).sum();
    let mut found = Vec::new();
    for &(f, m) in &order {
        let method = &families[f].methods[m];
        let left = plan.budget.saturating_sub(start.elapsed()).as_secs_f64();
        let share = left * method.appetite / waiting;
        waiting -= method.appetite;
        found.push(((f, m), climb(&families[f], method, plan, share)));
        progress((start.elapsed().as_secs_f64() / plan.budget.as_secs_f64().max(1e-9)).min(1.0));
    }
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().flat_map(|(_, rungs)| rungs).collect()
}

/// The lowest rung always, more while the next is expected to fit into `seconds`.
fn climb(family: &Family, method: &Method, plan: &Plan, seconds: f64) -> Vec<Rung> {
    let start = Instant::now();
    let mut rungs: Vec<Rung> = Vec::new();
    for &effort in &method.ladder {
        if let Some(last) = rungs.last() {
            // Growth goes on as it was; nothing is known after the first.
            let before = rungs.iter().rev().nth(1);
            let growth = before.map_or(3.0, |b| (last.seconds[1] / b.seconds[1].max(1e-9)).clamp(1.5, 12.0));
            let next = 1.2 * growth * last.seconds[1] * last.repeats as f64;
            if start.elapsed().as_secs_f64() + next > seconds {
                break;
            }
        }
        rungs.push(measure(family, method, effort, plan));
    }
    rungs
}

fn measure(family: &Family, method: &Method, effort: f64, plan: &Plan) -> Rung {
    // Without chance only the time varies.
    let repeats = if method.random { plan.repeats.max(2) } else { plan.repeats.clamp(2, 3) };
    let (mut seconds, mut distances) = (Vec::new(), Vec::new());
    for k in 0..repeats {
        let seed = plan.seed + if method.random { 1 + k as u64 } else { 0 };
        let (answer, whole) = timed(|| (method.work)(effort, seed));
        seconds.push(answer.time.map_or(whole, |t| t.as_secs_f64()));
        distances.push(family.distance.between(&answer.values, &family.reference.values));
    }
    seconds.sort_by(f64::total_cmp);
    let error = root_mean_square(&distances, family.reference.noise);
    Rung {
        family: family.id.clone(),
        method: method.name.to_owned(),
        effort_of: method.effort.to_owned(),
        effort,
        repeats,
        seconds: [seconds[0], median(&seconds), seconds[seconds.len() - 1]],
        error: error.value,
        error_se: error.standard_error,
        unit: family.distance.unit().to_owned(),
        default: method.default.is_some_and(|d| (d / effort - 1.0).abs() < 0.2),
    }
}

/// `sqrt(<d^2>)` and its standard error by the rule of propagation, with the error of the reference in quadrature.
fn root_mean_square(distances: &[f64], noise: f64) -> Estimate {
    let squares: Vec<f64> = distances.iter().map(|d| d * d).collect();
    let mean = Estimate::from_repeats(&squares);
    let value = mean.value.max(0.0).sqrt();
    let standard_error = if value > 0.0 { 0.5 * mean.standard_error / value } else { 0.0 };
    Estimate { value, standard_error }.with_error(noise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::method::{Distance, Reference};
    use crate::math::random::CounterRng;

    /// Means of N uniform numbers: the error at effort N is sqrt(1 / 12 N), and the rung that must run does even without time.
    #[test]
    fn a_known_error_is_found_and_the_budget_kept() {
        let mean = |n: f64, seed: u64| {
            let mut rng = CounterRng::new(seed, 0, 0);
            vec![(0..n as u64).map(|_| rng.uniform()).sum::<f64>() / n].into()
        };
        let family = || Family {
            id: "mean".into(),
            title: "Mean of uniform numbers".into(),
            error: "error",
            distance: Distance::Relative,
            reference: Reference { text: "1/2".into(), values: vec![0.5], noise: 0.0 },
            methods: vec![Method::new("draws", "draws", [100.0, 400.0, 1600.0], mean).random().taken_at(400.0)],
        };
        let plan = Plan { budget: Duration::from_secs(60), repeats: 400, seed: 3 };
        let rungs = run(&[family()], &plan, &|_| ());
        assert_eq!(rungs.len(), 3);
        for r in &rungs {
            let expected = (1.0 / 12.0 / r.effort).sqrt() / 0.5;
            assert!((r.error / expected - 1.0).abs() < 0.15, "{} {} {expected}", r.effort, r.error);
            assert!(r.error_se < 0.06 * r.error && r.seconds[0] <= r.seconds[1] && r.seconds[1] <= r.seconds[2]);
        }
        assert_eq!(rungs.iter().map(|r| r.default).collect::<Vec<_>>(), [false, true, false]);
        let none = run(&[family()], &Plan { budget: Duration::ZERO, ..plan }, &|_| ());
        assert_eq!(none.len(), 1);
        assert_eq!(none[0].error, rungs[0].error);
    }
}
