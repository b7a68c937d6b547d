//! Methods climb their ladders of effort within a time budget; time and error are measured at every rung.

use crate::error::Result;
use crate::math::Estimate;
use std::time::{Duration, Instant};

/// What a method gives at one effort.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Numbers to be compared with those of a reference.
    pub values: Vec<f64>,
    /// Size of what was made, in the unit of the contest, if it makes something.
    pub size: Option<f64>,
}

impl From<Vec<f64>> for Outcome {
    fn from(values: Vec<f64>) -> Self {
        Outcome { values, size: None }
    }
}

/// What a method does at an effort, with a seed.
pub type Run<'a> = Box<dyn Fn(f64, u64) -> Result<Outcome> + 'a>;

/// One way to do it.
pub struct Method<'a> {
    pub name: String,
    /// Efforts in order of rising cost, in the unit of the contest.
    pub ladder: Vec<f64>,
    /// The effort that the program takes if it is not told otherwise.
    pub chosen: Option<f64>,
    /// Whether the seed matters.
    pub random: bool,
    /// Which reference of the contest it is measured against.
    pub reference: usize,
    pub run: Run<'a>,
}

/// What is taken for the truth.
pub struct Reference {
    pub name: String,
    pub values: Vec<f64>,
    /// Distance that the reference itself is expected to keep from the truth; 0 for a closed form.
    pub noise: f64,
}

/// Several ways to the same numbers.
pub struct Contest<'a> {
    /// Name for flags and files.
    pub key: &'static str,
    pub title: String,
    /// What the error is, with its unit.
    pub error: &'static str,
    /// What the effort counts.
    pub effort: &'static str,
    /// What the size counts, if methods make something.
    pub size: Option<&'static str>,
    pub references: Vec<Reference>,
    pub methods: Vec<Method<'a>>,
    /// Distance of values from those of a reference.
    pub distance: fn(&[f64], &[f64]) -> f64,
}

/// A measured rung.
#[derive(Debug, Clone)]
pub struct Point {
    pub contest: &'static str,
    pub method: String,
    pub effort: f64,
    /// Fastest, median and slowest repeat \[s\].
    pub seconds: [f64; 3],
    /// Root-mean-square distance over the repeats, with its standard error.
    pub error: Estimate,
    pub size: Option<f64>,
    pub repeats: usize,
    pub reference: String,
    pub reference_noise: f64,
    pub chosen: bool,
}

/// Repeats of a random and of a deterministic method, where time allows.
const REPEATS: [usize; 2] = [7, 3];

/// Root mean square of distances with its standard error.
pub struct Aggregate(pub Estimate);

impl Aggregate {
    /// `rms = sqrt(mean d^2)`, its standard error by the delta method; one repeat, or equal ones, have no scatter.
    pub fn of(distances: &[f64]) -> Self {
        let squares: Vec<f64> = distances.iter().map(|d| d * d).collect();
        if squares.len() < 2 {
            return Aggregate(Estimate::exact(squares.first().map_or(0.0, |s| s.sqrt())));
        }
        let mean = Estimate::from_repeats(&squares);
        let rms = mean.value.sqrt();
        let standard_error = if rms > 0.0 { 0.5 * mean.standard_error / rms } else { 0.0 };
        Aggregate(Estimate { value: rms, standard_error })
    }
}

/// Runs every method of a contest up its ladder until its share of `budget` is spent. Errors depend on `seed` alone, times on
/// the machine.
///
/// # Errors
/// Those of the methods.
pub fn race(contest: &Contest, budget: Duration, seed: u64, progress: &dyn Fn(f64)) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    let start = Instant::now();
    for (k, method) in contest.methods.iter().enumerate() {
        // What the others left over may be used up.
        let share = budget.saturating_sub(start.elapsed()) / (contest.methods.len() - k) as u32;
        climb(contest, method, share, seed, &mut points)?;
        progress((k + 1) as f64 / contest.methods.len() as f64);
    }
    Ok(points)
}

fn climb(contest: &Contest, method: &Method, share: Duration, seed: u64, points: &mut Vec<Point>) -> Result<()> {
    let reference = &contest.references[method.reference];
    let start = Instant::now();
    let left = || share.saturating_sub(start.elapsed()).as_secs_f64();
    let mut last: Option<(f64, f64)> = None;
    for &effort in &method.ladder {
        // Cost is taken to grow as the effort, downwards for tolerances; caches and overheads only make that too careful.
        let expected = last.map_or(0.0, |(before, seconds): (f64, f64)| {
            seconds * if effort > before { effort / before } else { before / effort }
        });
        if last.is_some() && expected > left() {
            break;
        }
        let mut times = Vec::new();
        let mut distances = Vec::new();
        let mut size = None;
        for repeat in 0..REPEATS[usize::from(!method.random)] {
            if repeat > 0 && times.last().is_some_and(|t| *t > 0.5 * left()) {
                break;
            }
            let begun = Instant::now();
            let outcome = (method.run)(effort, seed + repeat as u64)?;
            times.push(begun.elapsed().as_secs_f64());
            distances.push((contest.distance)(&outcome.values, &reference.values));
            size = outcome.size;
        }
        times.sort_by(f64::total_cmp);
        let seconds = [times[0], times[times.len() / 2], times[times.len() - 1]];
        last = Some((effort, seconds[1]));
        points.push(Point {
            contest: contest.key,
            method: method.name.clone(),
            effort,
            seconds,
            error: Aggregate::of(&distances).0,
            size,
            repeats: times.len(),
            reference: reference.name.clone(),
            reference_noise: reference.noise,
            chosen: method.chosen == Some(effort),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mean of n uniform numbers misses 1/2 by sqrt(1 / (12 n)), and the ladder stops where time is up.
    #[test]
    fn errors_of_means_fall_as_the_root_of_their_number() {
        let run = |effort: f64, seed: u64| {
            let mut rng = crate::math::random::CounterRng::new(seed, 0, effort as u64);
            let mean = (0..effort as u64).map(|_| rng.uniform()).sum::<f64>() / effort;
            Ok(vec![mean].into())
        };
        let slow = |effort: f64, _: u64| {
            std::thread::sleep(Duration::from_millis(effort as u64));
            Ok(vec![0.75].into())
        };
        let contest = Contest {
            key: "means",
            title: String::new(),
            error: "",
            effort: "numbers",
            size: None,
            references: vec![Reference { name: "1/2".into(), values: vec![0.5], noise: 0.0 }],
            methods: vec![
                Method {
                    name: "mean".into(),
                    ladder: vec![1e2, 1e4],
                    chosen: Some(1e4),
                    random: true,
                    reference: 0,
                    run: Box::new(run),
                },
                Method {
                    name: "slow".into(),
                    ladder: vec![1.0, 1e5],
                    chosen: None,
                    random: false,
                    reference: 0,
                    run: Box::new(slow),
                },
            ],
            distance: |a, b| (a[0] - b[0]).abs(),
        };
        let points = race(&contest, Duration::from_secs(2), 3, &|_| ()).unwrap();
        assert_eq!(points.len(), 3);
        for p in &points[..2] {
            let expected = (1.0 / (12.0 * p.effort)).sqrt();
            assert!((p.error.value - expected).abs() < 4.0 * p.error.standard_error, "{p:?}");
        }
        assert!(points[1].chosen && !points[0].chosen && points[0].repeats == 7);
        assert_eq!(points[2].error, Estimate::exact(0.25));
    }
}
