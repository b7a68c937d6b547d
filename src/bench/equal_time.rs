//! How much less the facet sum errs than naive rays that are given the same time.

use super::families::scattering::{FACETS, RAYS};
use super::method::Family;
use super::runner::Rung;
use serde::Serialize;

/// One angle of incidence: all facets once, against rays for as long as that takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EqualTime {
    pub family: String,
    /// Median time of the sum over all facets.
    pub seconds: f64,
    pub facets: f64,
    /// Distance of the facet sum from the reference; that of the reference itself is in it.
    pub facets_error: f64,
    pub reference_error: f64,
    /// Rays that fit into the time, and their error: between the rungs, or beyond the last by its slope of -1/2.
    pub rays: f64,
    pub rays_error: f64,
    /// `rays_error / facets_error`.
    pub ratio: f64,
    /// The facet sum is as near to the reference as the reference to the truth, so the ratio is a lower bound.
    pub at_least: bool,
}

impl std::fmt::Display for EqualTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "in the {:.2} ms of all facets, rays at random places err {}{} times as much ({:.3} % against {}{:.4} %)",
            1e3 * self.seconds,
            if self.at_least { "at least " } else { "" },
            round(self.ratio),
            100.0 * self.rays_error,
            if self.at_least { "at most " } else { "" },
            100.0 * self.facets_error
        )
    }
}

/// Two digits are known.
fn round(ratio: f64) -> String {
    let step = 10f64.powf(ratio.max(1.0).log10().floor() - 1.0).max(0.1);
    format!("{:.*}", usize::from(step < 1.0), (ratio / step).round() * step)
}

/// The comparison in one family; `None` where the time did not suffice for all facets, or in a family of other methods.
pub fn equal_time(family: &Family, rungs: &[Rung]) -> Option<EqualTime> {
    let facets = family.methods.iter().find(|m| m.name == FACETS)?;
    compare(&family.id, *facets.ladder.last()?, family.reference.noise, rungs)
}

/// The same, given the number of all facets and the error of the reference.
fn compare(family: &str, facets: f64, reference_error: f64, rungs: &[Rung]) -> Option<EqualTime> {
    let of = |method: &str| rungs.iter().filter(|r| r.family == family && r.method == method).collect::<Vec<_>>();
    let all = *of(FACETS).last().filter(|r| r.effort == facets)?;
    let rays = of(RAYS);
    let seconds = all.seconds[1];
    let (rays_error, count) = at_time(&rays, seconds)?;
    Some(EqualTime {
        family: family.to_owned(),
        seconds,
        facets: all.effort,
        facets_error: all.error.max(f64::MIN_POSITIVE),
        reference_error,
        rays: count,
        rays_error,
        ratio: rays_error / all.error.max(f64::MIN_POSITIVE),
        at_least: all.error <= 2.0 * reference_error,
    })
}

/// Error and effort after so long: straight in the logarithms between two rungs, by the law of independent samples beyond.
fn at_time(rungs: &[&Rung], seconds: f64) -> Option<(f64, f64)> {
    let (first, last) = (rungs.first()?, rungs.last()?);
    let law = |from: &Rung| {
        let more = seconds / from.seconds[1];
        (from.error / more.sqrt(), from.effort * more)
    };
    if seconds <= first.seconds[1] {
        return Some(law(first));
    }
    if seconds >= last.seconds[1] {
        return Some(law(last));
    }
    let pair = rungs.windows(2).find(|pair| (pair[0].seconds[1]..=pair[1].seconds[1]).contains(&seconds))?;
    let [a, b] = [pair[0], pair[1]];
    let share = (seconds / a.seconds[1]).ln() / (b.seconds[1] / a.seconds[1]).ln().max(f64::MIN_POSITIVE);
    let between = |a: f64, b: f64| a * (b / a).powf(share);
    Some((between(a.error, b.error), between(a.effort, b.effort)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rung(method: &str, effort: f64, seconds: f64, error: f64) -> Rung {
        Rung {
            family: "scatter_45".into(),
            method: method.into(),
            effort_of: "rays".into(),
            effort,
            repeats: 3,
            seconds: [seconds; 3],
            error,
            error_se: 0.0,
            unit: "share".into(),
            default: false,
        }
    }

    /// Rays of 1 us with the error 1 / sqrt(N) against facets that take 10 ms: 1 % against 0.01 %.
    #[test]
    fn errors_at_equal_time_by_hand() {
        let mut rungs: Vec<Rung> = [1e3, 1e4, 1e6].map(|n: f64| rung(RAYS, n, 1e-6 * n, 1.0 / n.sqrt())).to_vec();
        for (facets, seconds, error) in [(1e3, 1e-4, 0.1), (1e5, 1e-2, 1e-4)] {
            rungs.push(rung(FACETS, facets, seconds, error));
        }
        let found = compare("scatter_45", 1e5, 1e-5, &rungs).unwrap();
        assert!((found.ratio - 100.0).abs() < 1e-9 && (found.rays - 1e4).abs() < 1e-6 && !found.at_least);
        assert!(compare("scatter_45", 1e5, 1e-4, &rungs).unwrap().at_least);
        // Between two rungs and beyond the last.
        for (seconds, expected) in [(0.1, 1e5f64), (100.0, 1e8), (1e-5, 10.0)] {
            rungs.last_mut().unwrap().seconds = [seconds; 3];
            let found = compare("scatter_45", 1e5, 1e-5, &rungs).unwrap();
            assert!(
                (found.rays / expected - 1.0).abs() < 1e-9 && (found.rays_error * expected.sqrt() - 1.0).abs() < 1e-9
            );
        }
        assert_eq!(compare("sampling", 1e5, 0.0, &rungs), None);
        // Not all facets were reached.
        assert_eq!(compare("scatter_45", 2e5, 1e-5, &rungs), None);
        assert_eq!((round(994.3), round(12.34), round(1.26)), ("990".into(), "12".into(), "1.3".into()));
    }
}
