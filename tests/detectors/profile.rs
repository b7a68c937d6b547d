//! What Smith's formula approximates, without it: visibility on a Gaussian profile of autocorrelation `exp(-x^2/l^2)`.
//!
//! In the plane of incidence only the profile along it hides a facet from source and exit, and its slope across does not
//! matter. A profile with slope `p` at the origin is `h(x) + (p - h'(0)) x exp(-x^2/l^2)` with a free profile h (conditional mean
//! of a Gaussian process), so every point of one long profile stands for a facet of any slope.

use asperity::math::random::CounterRng;
use std::f64::consts::TAU;

/// Samples per correlation length.
const PER_LENGTH: usize = 16;
/// Points that are asked, half a correlation length apart.
const POINTS: usize = 60_000;
const APART: usize = PER_LENGTH / 2;
/// Samples to either side after which nothing hides any more: 12 correlation lengths.
const REACH: usize = 12 * PER_LENGTH;

/// A profile of unit variance and unit correlation length.
pub struct Profile {
    heights: Vec<f64>,
    highest: f64,
    /// `x exp(-x^2)`.
    bend: Vec<f64>,
}

impl Profile {
    /// White noise through `exp(-2 x^2)`, whose square in the frequency plane is the spectrum of `exp(-x^2)`.
    pub fn new(seed: u64) -> Self {
        let x = |j: usize| j as f64 / PER_LENGTH as f64;
        let half = 3 * PER_LENGTH;
        let kernel: Vec<f64> = (0..=2 * half).map(|j| (-2.0 * (x(j) - x(half)).powi(2)).exp()).collect();
        let norm = kernel.iter().map(|w| w * w).sum::<f64>().sqrt();
        let n = POINTS * APART + 2 * REACH;
        let mut rng = CounterRng::new(seed, 0, 0);
        let mut normal = || (-2.0 * (1.0 - rng.uniform()).ln()).sqrt() * (TAU * rng.uniform()).cos();
        let noise: Vec<f64> = (0..n + kernel.len()).map(|_| normal()).collect();
        let heights: Vec<f64> =
            (0..n).map(|i| kernel.iter().zip(&noise[i..]).map(|(w, noise)| w * noise).sum::<f64>() / norm).collect();
        let highest = heights.iter().copied().fold(0.0, f64::max) + 3.0;
        Profile { heights, highest, bend: (0..=REACH).map(|j| x(j) * (-x(j) * x(j)).exp()).collect() }
    }

    /// Share of the facets of slope `p` that see the source on the side of +x at `theta_i` and the exit on the side of -x at
    /// `theta_r`, for a surface of roughness `alpha = 2 Sq / l`.
    pub fn visible(&self, alpha: f64, theta_i: f64, theta_r: f64) -> f64 {
        // Slopes and cotangents in units of Sq / l.
        let unit = 0.5 * alpha;
        let p = -(theta_i.sin() - theta_r.sin()) / (theta_i.cos() + theta_r.cos()) / unit;
        let climb = [theta_i, theta_r].map(|t| 1.0 / (t.tan() * unit * PER_LENGTH as f64));
        let d = 1.0 / PER_LENGTH as f64;
        let h = &self.heights;
        let free = |i: usize| {
            // Five points: the slope of the profile to d^4.
            let slope = (h[i - 2] - 8.0 * h[i - 1] + 8.0 * h[i + 1] - h[i + 2]) / (12.0 * d);
            let turn = p - slope;
            [1.0, -1.0].into_iter().zip(climb).all(|(side, climb)| {
                for j in 1..=REACH {
                    let ray = h[i] + climb * j as f64;
                    if ray > self.highest {
                        break;
                    }
                    let there = if side > 0.0 { h[i + j] } else { h[i - j] };
                    if there + side * turn * self.bend[j] > ray {
                        return false;
                    }
                }
                true
            })
        };
        (0..POINTS).filter(|k| free(REACH + k * APART)).count() as f64 / POINTS as f64
    }
}

/// Masking alone, where Smith's function is known to be good: light from above, alpha 0.3.
#[test]
fn smith_is_a_little_dark() {
    let profile = Profile::new(1);
    for (theta_i, theta_r, smith) in [(45.0f64, 60.0f64, 0.99964), (45.0, 75.0, 0.96250), (60.0, 75.0, 0.96216)] {
        let visible = profile.visible(0.3, theta_i.to_radians(), theta_r.to_radians());
        println!("{theta_i} to {theta_r} deg: {visible:.5} see both, Smith {smith:.5}");
        // Neighbouring heights are alike, so a facet that is lit is seen more often than Smith supposes: by up to 2 % here.
        assert!(visible > smith && visible < smith + 0.025, "{visible} {smith}");
    }
}
