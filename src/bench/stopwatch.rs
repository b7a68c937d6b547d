//! Times of repeated calls.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// Shorter than this a single call tells little: it is repeated.
const SHORTEST: Duration = Duration::from_millis(2);

/// The result of `work` and the seconds of one call, over as many calls as fill two milliseconds.
pub fn timed<T>(work: impl Fn() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = black_box(work());
    let first = start.elapsed();
    if first >= SHORTEST {
        return (result, first.as_secs_f64());
    }
    let calls = (SHORTEST.as_secs_f64() / first.as_secs_f64().max(1e-9)).ceil().min(1e4) as u32;
    let start = Instant::now();
    for _ in 0..calls {
        black_box(work());
    }
    (result, start.elapsed().as_secs_f64() / f64::from(calls))
}

/// Median of the seconds of `repeats` calls after one that warms up.
pub fn median_of<T>(repeats: usize, work: impl Fn() -> T) -> f64 {
    black_box(work());
    let mut seconds: Vec<f64> = (0..repeats.max(1)).map(|_| timed(&work).1).collect();
    seconds.sort_by(f64::total_cmp);
    median(&seconds)
}

/// The middle of sorted values, the mean of the two middle ones if their number is even; 0 of none.
pub fn median(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[1.0, 2.0, 9.0]), 2.0);
        assert_eq!(median(&[1.0, 2.0, 4.0, 9.0]), 3.0);
        let (value, seconds) = timed(|| 7);
        assert!(value == 7 && seconds < 1e-3);
    }
}
