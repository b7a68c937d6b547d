//! Spikes: isolated points that the instrument made up.

use super::{Edges, RawMap, level, warning::MOST_SPIKES};
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;

/// When a point is a spike.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Despike {
    /// Distance from the local median, in median absolute deviations; 6 MAD are four standard deviations of a normal
    /// distribution.
    pub threshold: f64,
    /// Side of the square window in samples, odd.
    pub window: usize,
}

impl Default for Despike {
    fn default() -> Self {
        Despike { threshold: 6.0, window: 3 }
    }
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spikes {
    /// Points marked as missing.
    pub points: usize,
    /// Their share of the measured points.
    pub fraction: f64,
    /// The rule.
    pub rule: Despike,
}

impl std::fmt::Display for Spikes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} spikes beyond {} MAD ({:.4} %) marked as missing",
            self.points,
            self.rule.threshold,
            100.0 * self.fraction
        )
    }
}

/// Fewest measured points of a window, with its centre, from which a point is judged.
const FEWEST: usize = 4;

/// `|h - m| > t max(MAD, M)`: `m` and `MAD` are the median and the median absolute deviation of the window around a point,
/// `M` is the median of `|h - m|` over the map. Such points become missing.
///
/// After Hampel's identifier (1974), on heights above the least-squares plane. `M` keeps a quiet window, where a few
/// equal heights make MAD vanish, from condemning ordinary roughness; of a map of which more than half is locally flat it
/// is the median over the rest, or zero if that is less than 1 % of the points; and it is never below the step of an
/// instrument that quantises its heights. Windows end at the border. Grooves one sample wide look like spikes to a median.
///
/// # Errors
/// `Error::Parameter` for a threshold that is not above zero, a window that is not odd or not within 3 to 15, or fewer
/// points than make a plane.
pub fn despike(raw: &mut RawMap, rule: Despike) -> Result<Spikes> {
    let Despike { threshold, window } = rule;
    if !(threshold > 0.0 && threshold.is_finite() && (3..=15).contains(&window) && window % 2 == 1) {
        return Err(Error::parameter(
            format!("spikes beyond {threshold} MAD in a window of {window} points cannot be looked for"),
            "choose a threshold above zero, such as 6, and an odd window from 3 to 15",
        ));
    }
    let flat = level::level(raw, Edges::Open)?.heights;
    let (rows, columns) = flat.dim();
    let Some(flat) = flat.as_slice() else { return Ok(Spikes { points: 0, fraction: 0.0, rule }) };
    let window_of = |r: usize, c: usize, into: &mut Vec<f32>| {
        let half = window / 2;
        into.clear();
        for row in flat[r.saturating_sub(half) * columns..(r + half + 1).min(rows) * columns].chunks(columns) {
            into.extend(row[c.saturating_sub(half)..(c + half + 1).min(columns)].iter().filter(|h| !h.is_nan()));
        }
    };
    let mut deviations = vec![f32::NAN; flat.len()];
    deviations.par_chunks_mut(columns).enumerate().for_each_init(Vec::new, |values, (r, row)| {
        if window == 3 && r > 0 && r + 1 < rows {
            let at = |r: usize| &flat[r * columns..(r + 1) * columns];
            deviations_of_three([at(r - 1), at(r), at(r + 1)], row);
        }
        for (c, deviation) in row.iter_mut().enumerate() {
            let h = flat[r * columns + c];
            if deviation.is_nan() && !h.is_nan() {
                window_of(r, c, values);
                if values.len() >= FEWEST {
                    *deviation = (h - median(values)).abs();
                }
            }
        }
    });
    let limit = threshold * f64::from(typical(&deviations)).max(quantum(raw));
    // Few points are beyond the map's own limit; only those need their window's MAD.
    let spikes: Vec<usize> = deviations
        .par_iter()
        .enumerate()
        .filter(|(_, d)| f64::from(**d) > limit)
        .filter(|(k, d)| {
            let mut values = Vec::new();
            window_of(k / columns, k % columns, &mut values);
            let middle = median(&mut values);
            values.iter_mut().for_each(|v| *v = (*v - middle).abs());
            f64::from(**d) > threshold * f64::from(median(&mut values))
        })
        .map(|(k, _)| k)
        .collect();
    let measured = flat.iter().filter(|h| !h.is_nan()).count();
    for k in &spikes {
        raw.heights[[k / columns, k % columns]] = f64::NAN;
    }
    Ok(Spikes { points: spikes.len(), fraction: spikes.len() as f64 / measured as f64, rule })
}

/// Median of a few values, which are sorted; the mean of the middle two of an even number.
fn median(values: &mut [f32]) -> f32 {
    values.sort_unstable_by(f32::total_cmp);
    let n = values.len();
    if n % 2 == 1 { values[n / 2] } else { 0.5 * (values[n / 2 - 1] + values[n / 2]) }
}

/// `|h - median|` for the inner points of the middle row of three; NaN where a point of the window is missing.
///
/// The middle of nine is the middle of the largest of the lows, the middle of the middles and the smallest of the highs
/// of three sorted triples (Paeth 1990). Without branches the compiler works on several points at once.
fn deviations_of_three([a, b, c]: [&[f32]; 3], out: &mut [f32]) {
    let (less, more) = (|x: f32, y: f32| if x < y { x } else { y }, |x: f32, y: f32| if x < y { y } else { x });
    let middle = |x: f32, y: f32, z: f32| more(less(x, y), less(more(x, y), z));
    let sorted = |x, y, z| [less(less(x, y), z), middle(x, y, z), more(more(x, y), z)];
    for k in 1..out.len().max(1) - 1 {
        let s = [sorted(a[k - 1], b[k - 1], c[k - 1]), sorted(a[k], b[k], c[k]), sorted(a[k + 1], b[k + 1], c[k + 1])];
        let median = middle(
            more(more(s[0][0], s[1][0]), s[2][0]),
            middle(s[0][1], s[1][1], s[2][1]),
            less(less(s[0][2], s[1][2]), s[2][2]),
        );
        // Comparisons lose a NaN, a sum keeps it.
        let sum = a[k - 1] + a[k] + a[k + 1] + b[k - 1] + b[k] + b[k + 1] + c[k - 1] + c[k] + c[k + 1];
        out[k] = if sum.is_nan() { f32::NAN } else { (b[k] - median).abs() };
    }
}

/// `M` of [`despike`].
fn typical(deviations: &[f32]) -> f32 {
    let all = lower_median(deviations, 0.0).unwrap_or((0.0, 0));
    if all.0 > 0.0 {
        return all.0;
    }
    // The smallest number above zero as the bound leaves out the zeros only.
    let rest = lower_median(deviations, f32::from_bits(1)).unwrap_or((0.0, 0));
    if rest.1 as f64 > MOST_SPIKES * all.1 as f64 { rest.0 } else { 0.0 }
}

/// Step of quantised heights: the smallest difference between neighbours in a row, if more than 1 % of them differ by just
/// that; else 0.
fn quantum(raw: &RawMap) -> f64 {
    let differences = |r: usize| {
        let row = raw.heights.row(r);
        (1..row.len()).map(move |c| (row[c] - row[c - 1]).abs()).filter(|d| *d > 0.0 && d.is_finite())
    };
    let rows = raw.heights.nrows();
    let smallest = |r: usize| differences(r).fold(f64::INFINITY, f64::min);
    let step = (0..rows).into_par_iter().map(smallest).reduce(|| f64::INFINITY, f64::min);
    let steps: usize = (0..rows).into_par_iter().map(|r| differences(r).filter(|d| *d < 1.5 * step).count()).sum();
    if steps as f64 > MOST_SPIKES * raw.heights.len() as f64 { step } else { 0.0 }
}

/// Lower median of the values that are `least` or more, and their number; `None` if there are none.
///
/// Positive floats sort like their bit patterns: two counts of 16 bits each find the median without a copy.
fn lower_median(values: &[f32], least: f32) -> Option<(f32, usize)> {
    let bits = || values.iter().filter(|v| **v >= least).map(|v| v.to_bits());
    let n = bits().count();
    let mut rank = n.checked_sub(1)? / 2;
    let mut found = 0u32;
    for (shift, prefix) in [(16, false), (0, true)] {
        let mut counts = vec![0usize; 1 << 16];
        bits().filter(|b| !prefix || b >> 16 == found >> 16).for_each(|b| counts[(b >> shift & 0xffff) as usize] += 1);
        let digit = counts.iter().position(|count| {
            let here = rank < *count;
            if !here {
                rank -= count;
            }
            here
        })?;
        found |= (digit as u32) << shift;
    }
    Some((f32::from_bits(found), n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use ndarray::Array2;

    fn raw(heights: Array2<f64>) -> RawMap {
        RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] }
    }

    fn noise(rows: usize, columns: usize) -> Array2<f64> {
        Array2::from_shape_fn((rows, columns), |(r, c)| {
            1e-9 * CounterRng::new(5, 0, (r * columns + c) as u64).normal_pair()[0]
        })
    }

    #[test]
    fn finds_the_planted_spikes_on_a_tilted_noisy_map_and_next_to_nothing_else() {
        let mut map = raw(noise(200, 300));
        map.heights.indexed_iter_mut().for_each(|((r, c), h)| *h += 0.05 + 1e-8 * (3 * c + 5 * r) as f64);
        let planted = [(0, 0), (50, 70), (50, 71), (120, 299), (199, 20), (77, 150)];
        for (k, (r, c)) in planted.iter().enumerate() {
            map.heights[[*r, *c]] += if k % 2 == 0 { 3e-8 } else { -5e-8 };
        }
        map.heights[[77, 151]] = f64::NAN;
        let found = despike(&mut map, Despike::default()).unwrap();
        assert!(planted.iter().all(|p| map.heights[*p].is_nan()));
        // 60000 normal points: beyond 6 MAD both of the window and of the map about one in ten thousand.
        assert!(found.points >= 6 && found.points < 6 + 30, "{found}");
        assert_eq!(map.heights.iter().filter(|h| h.is_nan()).count(), found.points + 1);
    }

    #[test]
    fn grooves_and_quantised_steps_are_not_spikes() {
        let mut sinusoid = raw(Array2::from_shape_fn((64, 64), |(_, c)| 1e-6 * (c as f64 * 0.4).sin()));
        assert_eq!(despike(&mut sinusoid, Despike::default()).unwrap().points, 0);
        // Most windows are exactly flat; single points one quantum off are how such an instrument sees noise.
        let step = |r: usize, c: usize| if (r * 31 + c * 17).is_multiple_of(23) { 1e-9 } else { 0.0 };
        let mut quantised = raw(Array2::from_shape_fn((64, 64), |(r, c)| step(r, c)));
        assert_eq!(despike(&mut quantised, Despike::default()).unwrap().points, 0);
        quantised.heights[[30, 30]] = 2e-8;
        assert_eq!(despike(&mut quantised, Despike::default()).unwrap().points, 1);
        let mut flat = raw(Array2::zeros((32, 32)));
        assert_eq!(despike(&mut flat, Despike::default()).unwrap().points, 0);
        flat.heights[[4, 4]] = 1e-9;
        assert_eq!(despike(&mut flat, Despike::default()).unwrap().points, 1);
        assert!(flat.heights[[4, 4]].is_nan());
    }

    #[test]
    fn the_fast_median_of_nine_is_the_sorted_one() {
        let value = |k: u64| (CounterRng::new(1, 0, k).uniform() * 20.0).floor() as f32;
        for n in [1, 2, 3, 40] {
            let mut rows: [Vec<f32>; 3] = std::array::from_fn(|r| (0..n).map(|k| value(1000 * r as u64 + k)).collect());
            if n == 40 {
                rows[2][20] = f32::NAN;
            }
            let mut found = vec![f32::NAN; n as usize];
            deviations_of_three([&rows[0], &rows[1], &rows[2]], &mut found);
            for k in 1..(n as usize).max(1) - 1 {
                let mut window: Vec<f32> = rows.iter().flat_map(|r| r[k - 1..=k + 1].to_vec()).collect();
                let expected = (rows[1][k] - median(&mut window)).abs();
                assert!(found[k] == expected || ((19..=21).contains(&k) && n == 40 && found[k].is_nan()));
            }
        }
    }

    #[test]
    fn the_median_over_the_map_is_the_sorted_one() {
        let mut values: Vec<f32> = (0..1001).map(|k| ((k * 7919) % 1009) as f32 * 1e-9).collect();
        let found = lower_median(&values, 0.0).unwrap();
        values.sort_by(f32::total_cmp);
        assert_eq!(found, (values[500], 1001));
        values.push(f32::NAN);
        assert_eq!(lower_median(&values, 0.0).unwrap(), found);
        assert_eq!(lower_median(&values, values[1]).unwrap(), (values[500], 1000));
        assert!(lower_median(&[f32::NAN], 0.0).is_none());
        assert_eq!(typical(&[0.0, 0.0, 3.0, 0.0, 2.0]), 2.0);
        assert_eq!(typical(&[0.0, 0.0]), 0.0);
        assert_eq!(typical(&[&[3.0][..], &[0.0; 200]].concat()), 0.0);
    }

    #[test]
    fn refuses_rules_that_make_no_sense() {
        for (threshold, window) in [(0.0, 3), (-1.0, 3), (f64::NAN, 3), (6.0, 4), (6.0, 1), (6.0, 17)] {
            assert!(despike(&mut raw(noise(10, 10)), Despike { threshold, window }).is_err());
        }
    }
}
