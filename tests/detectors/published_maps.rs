//! The maps behind `heightfield_bounces.csv`, made again.
//!
//! The table does not say how its surfaces were made, but it names the rms slope of each to six digits, and that is enough
//! to tell: numpy's `default_rng(1)` fills six arrays of 1024 x 1024 with normal numbers one after the other, each is
//! smoothed periodically to the autocorrelation `exp(-r^2 / 16^2)`, stretched to its nominal rms height, and the light comes
//! from the positive end of the first axis. All six slopes then agree in every printed digit.

use asperity::heightmap::{Edges, HeightMap, RawMap, level};
use ndarray::Array2;

const SIDE: usize = 1024;
/// Correlation length in pitches.
const LENGTH: f64 = 16.0;

/// Normal numbers of numpy's `default_rng(1)`: PCG64 (O'Neill 2014, XSL-RR 128/64) and a ziggurat of 256 layers (Marsaglia
/// and Tsang 2000).
pub struct NumpyNormals {
    state: u128,
    abscissa: [f64; 257],
    density: [f64; 257],
}

/// Where the base of the ziggurat ends, and the area of a layer.
const BASE: f64 = 3.654_152_885_361_009;
const AREA: f64 = 0.004_928_673_233_974_655;
/// A layer is cut in so many steps.
const STEPS: u64 = 1 << 52;

impl NumpyNormals {
    /// As `numpy.random.default_rng(1)` starts.
    pub fn new() -> Self {
        let mut abscissa = [0.0; 257];
        let mut density = [1.0; 257];
        // From the base up; the lowest layer holds the tail, as if it were so much wider.
        abscissa[256] = AREA / (-0.5 * BASE * BASE).exp();
        abscissa[255] = BASE;
        for k in (1..256).rev() {
            let x = abscissa[k];
            density[k] = (-0.5 * x * x).exp();
            abscissa[k - 1] = if k > 1 { (-2.0 * (AREA / x + density[k]).ln()).sqrt() } else { 0.0 };
        }
        NumpyNormals { state: 0x9c5b_484b_fedb_756c_2a6e_7d6f_320f_bc7e, abscissa, density }
    }

    fn bits(&mut self) -> u64 {
        const MULTIPLIER: u128 = 0x2360_ed05_1fc6_5da4_4385_df64_9fcc_f645;
        const STREAM: u128 = 0x922a_f2da_2645_f895_a198_57b9_5740_937b;
        self.state = self.state.wrapping_mul(MULTIPLIER).wrapping_add(STREAM);
        ((self.state >> 64) as u64 ^ self.state as u64).rotate_right((self.state >> 122) as u32)
    }

    fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next one.
    pub fn draw(&mut self) -> f64 {
        loop {
            let bits = self.bits();
            let layer = (bits & 255) as usize;
            let sign = if bits >> 8 & 1 == 1 { -1.0 } else { 1.0 };
            let step = bits >> 9 & (STEPS - 1);
            // The outer edge of the layer, and that of the one above.
            let (outer, inner) = match layer {
                0 => (self.abscissa[256], BASE),
                k => (self.abscissa[k], self.abscissa[k - 1]),
            };
            let x = step as f64 * (outer / STEPS as f64);
            if step < (inner / outer * STEPS as f64) as u64 {
                return sign * x;
            }
            if layer == 0 {
                loop {
                    let beyond = -(-self.uniform()).ln_1p() / BASE;
                    let height = -(-self.uniform()).ln_1p();
                    if height + height > beyond * beyond {
                        return if step >> 8 & 1 == 1 { -(BASE + beyond) } else { BASE + beyond };
                    }
                }
            }
            let [low, high] = [self.density[layer], self.density[layer - 1]];
            if (high - low) * self.uniform() + low < (-0.5 * x * x).exp() {
                return sign * x;
            }
        }
    }
}

/// The next map: of unit pitch, periodic, with the nominal rms slope per axis.
pub fn next_map(normals: &mut NumpyNormals, slope: f64) -> HeightMap {
    let noise: Vec<f64> = (0..SIDE * SIDE).map(|_| normals.draw()).collect();
    // Twice along the rows with a turn in between and after: rows and columns change places and change back.
    let mut heights = turned(&smoothed(&turned(&smoothed(&noise))));
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let sq = (heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / heights.len() as f64).sqrt();
    let factor = slope * LENGTH / 2f64.sqrt() / sq;
    heights.iter_mut().for_each(|h| *h = (*h - mean) * factor);
    // Their first axis is our x; y grows from the last row up.
    let heights = Array2::from_shape_fn((SIDE, SIDE), |(row, column)| heights[column * SIDE + (SIDE - 1 - row)]);
    let raw = RawMap { heights, pitch_x: 1.0, pitch_y: 1.0, format: "synthetic", notes: Vec::new() };
    level::keep_tilt(&raw, Edges::Periodic)
}

/// Every row with a periodic Gaussian that has half the wanted autocorrelation's width squared.
fn smoothed(rows: &[f64]) -> Vec<f64> {
    let reach = (4.0 * LENGTH) as usize;
    let kernel: Vec<f64> = (0..=reach).map(|k| (-2.0 * (k as f64 / LENGTH).powi(2)).exp()).collect();
    rows.chunks(SIDE)
        .flat_map(|row| {
            let around: Vec<f64> = (0..SIDE + 2 * reach).map(|k| row[(k + SIDE - reach) % SIDE]).collect();
            let mut sums: Vec<f64> = row.iter().map(|h| h * kernel[0]).collect();
            for (k, weight) in kernel.iter().enumerate().skip(1) {
                let [left, right] = [reach - k, reach + k].map(|from| &around[from..from + SIDE]);
                sums.iter_mut().zip(left).zip(right).for_each(|((sum, l), r)| *sum += weight * (l + r));
            }
            sums
        })
        .collect()
}

fn turned(rows: &[f64]) -> Vec<f64> {
    (0..SIDE * SIDE).map(|k| rows[k % SIDE * SIDE + k / SIDE]).collect()
}

/// As numpy 1.26 and 2 print them.
#[test]
fn normal_numbers_are_those_of_numpy() {
    let mut normals = NumpyNormals::new();
    let known = [0.34558419, 0.82161814, 0.33043708, -1.30315723, 0.90535587, 0.44637457];
    for value in known {
        let drawn = normals.draw();
        assert!((drawn - value).abs() < 5e-9, "{drawn} instead of {value}");
    }
}
