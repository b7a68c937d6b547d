//! Do the heights come in steps?

use crate::heightmap::HeightMap;
use crate::math::random::CounterRng;

/// The step of the heights, where it is coarse enough to be seen in the slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantum {
    /// Step \[m\].
    pub step: f64,
    /// Distinct differences between neighbours, but for one in five hundred on either side.
    pub distinct: usize,
    /// Angle between the two glints of facets one step apart in slope \[rad\]: `2 atan(step / pitch)`.
    pub glint_spacing: f64,
}

impl Quantum {
    /// The steps of a map's heights, if there are few.
    pub fn of(map: &HeightMap) -> Option<Quantum> {
        find(map)
    }

    /// `h + (u - 1/2) step`, u uniform in `[0, 1)`, another one for every point: the heights spread evenly within their
    /// steps, as a reading that was rounded to them may have been.
    pub fn spread(&self, map: &HeightMap, seed: u64) -> HeightMap {
        let mut spread = map.clone();
        for ((row, column), h) in spread.heights.indexed_iter_mut() {
            let item = (row as u64) << 32 | column as u64;
            *h += ((CounterRng::four(seed, SPREAD, item)[0] - 0.5) * self.step) as f32;
        }
        spread
    }
}

/// Stream of the random numbers that spread heights.
const SPREAD: u32 = 0x5752_4541;

/// More distinct differences than this are as good as a continuum: the step is below a twentieth of their spread.
const MOST_DISTINCT: usize = 150;

/// Differences looked at along each axis.
const WANTED: usize = 100_000;

/// Looks for regular steps in the differences of neighbours along x, then along y. A tilt that was taken off shifts all
/// differences alike and does not hide the steps; a filter does, and rightly so.
pub(super) fn find(map: &HeightMap) -> Option<Quantum> {
    let (rows, columns) = map.heights.dim();
    let stride = (rows * columns / WANTED).max(1).min((rows / 2).max(1));
    let range = map.heights.iter().filter(|h| !h.is_nan()).fold(0.0f32, |a, h| a.max(h.abs()));
    // f32 rounds either height by half a digit, and the difference is of two.
    let rounding = 4.0 * f64::from(range) * f64::from(f32::EPSILON);
    let along_x = (0..rows).step_by(stride).flat_map(|r| (1..columns).map(move |c| [[r, c - 1], [r, c]]));
    let along_y = (1..rows).step_by(stride).flat_map(|r| (0..columns).map(move |c| [[r, c], [r - 1, c]]));
    let difference = |[from, to]: [[usize; 2]; 2]| f64::from(map.heights[to]) - f64::from(map.heights[from]);
    let x = steps(along_x.map(difference), rounding, map.pitch_x);
    x.or_else(|| steps(along_y.map(difference), rounding, map.pitch_y))
}

fn steps(differences: impl Iterator<Item = f64>, rounding: f64, pitch: f64) -> Option<Quantum> {
    let mut all: Vec<f64> = differences.filter(|d| !d.is_nan()).collect();
    if all.len() < 200 {
        return None;
    }
    all.sort_by(f64::total_cmp);
    let tail = all.len() / 500;
    let core = &all[tail..all.len() - tail];
    let gap = |w: &[f64]| w[1] - w[0];
    // Where differences are most frequent every step is taken, so the widest gap there is one step. (If half of all
    // neighbours are level there is no gap; then most gaps anywhere are.)
    let widest = |part: &[f64]| part.windows(2).map(gap).fold(0.0, f64::max);
    let (inner, outer) = (widest(&core[core.len() / 4..core.len() - core.len() / 4]), widest(core));
    let coarse = if inner > rounding { inner } else { 0.3 * outer };
    // Smaller gaps are the rounding of whoever converted the file.
    let mut between: Vec<f64> = core.windows(2).map(gap).filter(|g| *g > rounding.max(0.3 * coarse)).collect();
    between.sort_by(f64::total_cmp);
    let distinct = between.len() + 1;
    if !(3..=MOST_DISTINCT).contains(&distinct) || core.len() < 20 * distinct {
        return None;
    }
    let step = between[between.len() / 2];
    // A saw of two slopes also has few differences; steps are told by being multiples of one of them.
    let regular = |g: &&f64| {
        let ratio = *g / step;
        (ratio - ratio.round()).abs() < 0.1
    };
    let even = between.iter().filter(regular).count() as f64 >= 0.9 * between.len() as f64;
    // From end to end, so that what the conversion did to single gaps averages out.
    let steps: f64 = between.iter().map(|g| (g / step).round()).sum();
    let step = (core[core.len() - 1] - core[0]) / steps;
    even.then(|| Quantum { step, distinct, glint_spacing: 2.0 * (step / pitch).atan() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    /// A Gaussian surface of 300 nm rounded to multiples of `step`, levelled and not.
    fn rounded(step: f64) -> [HeightMap; 2] {
        let grid = synth::Grid { width: 300, height: 200, pitch: [0.5e-6, 1e-6] };
        let mut raw = synth::gaussian(grid, synth::Gaussian { sq: 3e-7, acl: 8e-6, seed: 1, exact: true }).unwrap();
        raw.heights.indexed_iter_mut().for_each(|((_, c), h)| *h += 1e-8 * c as f64 + 1e-3);
        if step > 0.0 {
            raw.heights.mapv_inplace(|h| (h / step).round() * step);
        }
        [level::level(&raw, Edges::Open).unwrap(), level::keep_tilt(&raw, Edges::Open)]
    }

    #[test]
    fn coarse_steps_are_found_whatever_the_tilt() {
        for map in rounded(5e-9) {
            let q = find(&map).unwrap();
            assert!((q.step / 5e-9 - 1.0).abs() < 1e-3 && q.distinct > 20, "{q:?}");
            assert!((q.glint_spacing - 2.0 * (0.01f64).atan()).abs() < 1e-4);
        }
        for step in [0.0, 1e-11] {
            assert!(rounded(step).iter().all(|map| find(map).is_none()), "{step}");
        }
    }

    /// The variance of `(u - 1/2) step` is `step^2 / 12`, and neighbours know nothing of each other.
    #[test]
    fn spread_heights_stay_within_half_a_step_and_have_none_left() {
        let [map, _] = rounded(5e-9);
        let q = Quantum::of(&map).unwrap();
        let spread = q.spread(&map, 3);
        let moved: Vec<f64> = spread.heights.iter().zip(&map.heights).map(|(a, b)| f64::from(a - b)).collect();
        let n = moved.len() as f64;
        let variance = moved.iter().map(|m| m * m).sum::<f64>() / n;
        let beside = moved.windows(2).map(|m| m[0] * m[1]).sum::<f64>() / n;
        assert!(moved.iter().all(|m| m.abs() < 0.501 * q.step));
        assert!((variance / (q.step * q.step / 12.0) - 1.0).abs() < 0.02, "{variance}");
        assert!((beside / variance).abs() < 4.0 / n.sqrt(), "{beside}");
        assert_eq!(find(&spread), None);
        assert_eq!(q.spread(&map, 3).heights, spread.heights);
    }

    #[test]
    fn saws_ramps_and_mirrors_are_not_quantised() {
        let of = |height: &dyn Fn(usize, usize) -> f64| {
            let heights = ndarray::Array2::from_shape_fn((64, 64), |(r, c)| height(r, c) as f32);
            find(&HeightMap { heights, pitch_x: 1.0, pitch_y: 1.0, edges: Edges::Open, removed_slopes: [0.0; 2] })
        };
        assert_eq!(of(&|_, _| 0.0), None);
        assert_eq!(of(&|r, c| 0.1 * c as f64 - 0.3 * r as f64), None);
        assert_eq!(of(&|_, c| if c % 16 < 8 { (c % 16) as f64 } else { 16.0 - (c % 16) as f64 }), None);
    }
}
