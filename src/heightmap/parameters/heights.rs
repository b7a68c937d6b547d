//! Amplitude parameters of ISO 25178-2:2012, 4.2: the distribution of heights without regard to where they are.

use super::lanes::{LANES, add, each, runs};
use crate::heightmap::HeightMap;
use ndarray::ArrayView1;
use rayon::prelude::*;
use std::borrow::Cow;

/// `Sa = <|h|>`, `Sq = sqrt <h^2>`, `Ssk = <h^3> / Sq^3`, `Sku = <h^4> / Sq^4`, `Sp = max h`, `Sv = -min h`,
/// `Sz = Sp + Sv`, with `h` \[m\] from the mean of the measured points.
///
/// Source: ISO 25178-2:2012, 4.2. Every measured point counts once; missing points do not count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Heights {
    /// Measured points.
    pub points: u64,
    /// Mean height \[m\]: about 0 in a levelled map.
    pub mean: f64,
    /// Arithmetical mean height \[m\].
    pub sa: f64,
    /// Root-mean-square height \[m\].
    pub sq: f64,
    /// Skewness; 0 for a flat map.
    pub ssk: f64,
    /// Kurtosis, 3 for a Gaussian surface; 0 for a flat map.
    pub sku: f64,
    /// Height of the highest peak above the mean \[m\].
    pub sp: f64,
    /// Depth of the deepest pit below the mean \[m\], positive.
    pub sv: f64,
}

impl Heights {
    /// Two readings of the map (the mean is needed before the moments about it), no copy of it.
    ///
    /// All numbers are 0 if no point is measured. The same numbers for any number of threads.
    pub fn measure(map: &HeightMap) -> Self {
        let rows = map.height();
        let first: Vec<[f64; 2]> =
            (0..rows).into_par_iter().map(|r| count_and_sum(&contiguous(map.heights.row(r)))).collect();
        let n: f64 = first.iter().map(|s| s[0]).sum();
        if n == 0.0 {
            return Heights::default();
        }
        let mean = first.iter().map(|s| s[1]).sum::<f64>() / n;
        let second: Vec<([f64; 4], [f32; 2])> = (0..rows)
            .into_par_iter()
            .map(|r| {
                let row = contiguous(map.heights.row(r));
                (moments(&row, mean), extremes(&row))
            })
            .collect();
        let mut sums = [0.0; 4];
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (moments, [l, h]) in second {
            sums.iter_mut().zip(moments).for_each(|(sum, m)| *sum += m);
            (low, high) = (low.min(l), high.max(h));
        }
        let [absolute, squares, cubes, fourths] = sums.map(|s| s / n);
        let sq = squares.sqrt();
        let over = |moment: f64, power: i32| if sq > 0.0 { moment / sq.powi(power) } else { 0.0 };
        Heights {
            points: n as u64,
            mean,
            sa: absolute,
            sq,
            ssk: over(cubes, 3),
            sku: over(fourths, 4),
            sp: f64::from(high) - mean,
            sv: mean - f64::from(low),
        }
    }

    /// `Sz = Sp + Sv` \[m\]: from the deepest pit to the highest peak (ISO 25178-2:2012, 4.2.6).
    pub fn sz(&self) -> f64 {
        self.sp + self.sv
    }
}

/// `Sq = sqrt(<h^2>)` \[m\], over the measured points about their mean.
pub fn sq(map: &HeightMap) -> f64 {
    Heights::measure(map).sq
}

/// A row as a slice; a copy only if the array is laid out in another order.
pub(super) fn contiguous(row: ArrayView1<'_, f32>) -> Cow<'_, [f32]> {
    row.to_slice().map_or_else(|| Cow::Owned(row.to_vec()), Cow::Borrowed)
}

/// Number and sum of the measured heights of a row.
fn count_and_sum(row: &[f32]) -> [f64; 2] {
    let mut sum = [0.0; LANES];
    // A zero added to the last run changes no sum.
    runs([row], 0.0, |[h]| add(&mut sum, &each(|k| f64::from(h[k]))));
    let plain: f64 = sum.iter().sum();
    if !plain.is_nan() {
        return [row.len() as f64, plain];
    }
    let measured = row.iter().filter(|h| !h.is_nan());
    measured.fold([0.0, 0.0], |[count, sum], &h| [count + 1.0, sum + f64::from(h)])
}

/// Sums of `|h|`, `h^2`, `h^3` and `h^4` about `mean`; a missing point adds nothing.
fn moments(row: &[f32], mean: f64) -> [f64; 4] {
    let mut sums = [[0.0; LANES]; 4];
    runs([row], f32::NAN, |[h]| {
        let h = each(|k| {
            let h = f64::from(h[k]) - mean;
            if h.is_nan() { 0.0 } else { h }
        });
        let squared = each(|k| h[k] * h[k]);
        add(&mut sums[0], &each(|k| h[k].abs()));
        add(&mut sums[1], &squared);
        add(&mut sums[2], &each(|k| squared[k] * h[k]));
        add(&mut sums[3], &each(|k| squared[k] * squared[k]));
    });
    sums.map(|lane| lane.iter().sum())
}

/// Lowest and highest measured height of a row.
fn extremes(row: &[f32]) -> [f32; 2] {
    let mut low = [f32::INFINITY; LANES];
    let mut high = [f32::NEG_INFINITY; LANES];
    // Comparisons pass over NaN as `f32::min` does, and are vector instructions.
    runs([row], f32::NAN, |[h]| {
        for k in 0..LANES {
            low[k] = if h[k] < low[k] { h[k] } else { low[k] };
            high[k] = if h[k] > high[k] { h[k] } else { high[k] };
        }
    });
    [low.into_iter().fold(f32::INFINITY, f32::min), high.into_iter().fold(f32::NEG_INFINITY, f32::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::Edges;
    use std::f64::consts::{PI, SQRT_2, TAU};

    fn map(heights: ndarray::Array2<f32>) -> HeightMap {
        HeightMap { heights, pitch_x: 1.0, pitch_y: 1.0, edges: Edges::Open, removed_slopes: [0.0; 2] }
    }

    /// `Sq = A / sqrt 2`, `Sa = 2 A / pi`, `Ssk = 0`, `Sku = 3/2` of a sinusoid over whole periods.
    #[test]
    fn sinusoid_with_a_gap() {
        // 4096 samples a period: the mean of |sin| at samples falls short of 2 / pi by the share pi^2 / (3 N^2) = 2e-7.
        let mut heights =
            ndarray::Array2::from_shape_fn((8, 4096), |(_, c)| (3.0 + 2.0 * (TAU * c as f64 / 4096.0).sin()) as f32);
        heights.row_mut(3).fill(f32::NAN);
        let h = Heights::measure(&map(heights));
        assert_eq!(h.points, 7 * 4096);
        for (found, expected) in [
            (h.sq, 2.0 / SQRT_2),
            (h.sa, 4.0 / PI),
            (h.sku, 1.5),
            (h.sp, 2.0),
            (h.sv, 2.0),
            (h.sz(), 4.0),
            (h.mean, 3.0),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
        assert!(h.ssk.abs() < 1e-6);
    }

    /// Heights 0 with probability 3/4 and 4 with probability 1/4: all moments in closed form, any width.
    #[test]
    fn two_levels_and_a_width_that_is_no_multiple_of_eight() {
        let h =
            Heights::measure(&map(ndarray::Array2::from_shape_fn((4, 13), |(r, _)| if r == 2 { 4.0 } else { 0.0 })));
        assert_eq!((h.mean, h.sa, h.sq, h.sp, h.sv), (1.0, 1.5, 3f64.sqrt(), 3.0, 1.0));
        assert!((h.ssk - 2.0 / 3f64.sqrt()).abs() < 1e-14 && (h.sku - 7.0 / 3.0).abs() < 1e-14, "{h:?}");
    }

    #[test]
    fn flat_and_empty_maps_have_no_moments() {
        let flat = Heights::measure(&map(ndarray::Array2::from_elem((3, 9), 5.0)));
        assert_eq!((flat.sq, flat.ssk, flat.sku, flat.sz(), flat.mean), (0.0, 0.0, 0.0, 0.0, 5.0));
        assert_eq!(Heights::measure(&map(ndarray::Array2::from_elem((3, 9), f32::NAN))), Heights::default());
    }
}
