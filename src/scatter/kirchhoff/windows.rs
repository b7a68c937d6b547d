//! Over which parts of the map, and with which weights, the phase integral is taken.

use crate::heightmap::spectrum::Autocorrelation;
use crate::heightmap::{Edges, HeightMap};
use rayon::prelude::*;

/// Most windows along each axis.
const MOST: usize = 4;

/// A window is at least so many correlation lengths wide, so that it widens no lobe by more than a hundredth: the power of a
/// Hann window of width L has the standard deviation `0.58 lambda / L` in direction cosines, the narrowest lobe of a
/// surface of correlation length l (here where the autocorrelation is 0.2) `sqrt(2) 1.27 lambda / (2 pi l)`.
const CORRELATION_LENGTHS: f64 = 15.0;

/// Windows with a smaller share of measured points than this say more about their gaps than about the surface.
const FEWEST_MEASURED: f64 = 0.05;

/// A rectangle of points and their weights `taper_y[row] taper_x[column]`; missing points weigh nothing.
#[derive(Debug, Clone)]
pub struct Window {
    /// First column and row.
    pub origin: [usize; 2],
    /// Weights along the columns and along the rows.
    pub taper: [Vec<f32>; 2],
    /// `sum of W^2` over the measured points.
    pub weight: f64,
}

impl Window {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.taper[0].len(), self.taper[1].len()]
    }

    fn new(map: &HeightMap, origin: [usize; 2], taper: [Vec<f32>; 2]) -> Window {
        let rows: Vec<f64> = (0..taper[1].len())
            .into_par_iter()
            .map(|r| {
                let heights = map.heights.row(origin[1] + r);
                let across: f64 = taper[0]
                    .iter()
                    .enumerate()
                    .filter(|&(c, _)| !heights[origin[0] + c].is_nan())
                    .map(|(_, &w)| f64::from(w) * f64::from(w))
                    .sum();
                across * f64::from(taper[1][r]).powi(2)
            })
            .collect();
        Window { origin, taper, weight: rows.iter().sum() }
    }
}

/// The windows of one map. Powers are averaged over them, not amplitudes.
#[derive(Debug, Clone)]
pub struct Windows {
    pub list: Vec<Window>,
    /// Whether the whole periodic map is one window without weights.
    pub periodic: bool,
    /// Width of a window along x and y \[m\].
    pub width: [f64; 2],
}

impl Windows {
    /// The whole map without weights if it is periodic. Otherwise K x K Hann windows of `2 / (K + 1)` of each side, half
    /// overlapping (Welch 1967): K as large as the correlation length allows, up to 4.
    ///
    /// One Hann window uses the middle of a map only: the speckle noise of its lobe is that of a map 3.8 times smaller.
    /// Overlapping windows use all of it again. They blur the lobe instead: see [`Windows::resolution`].
    pub fn choose(map: &HeightMap) -> Windows {
        let size = [map.width(), map.height()];
        let pitch = [map.pitch_x, map.pitch_y];
        let across = if map.edges == Edges::Periodic { 1 } else { Self::across(map, size, pitch) };
        let wide =
            [0, 1].map(|k| if map.edges == Edges::Periodic { size[k] } else { fast(2 * size[k] / (across + 1)) });
        let taper: [Vec<f32>; 2] =
            wide.map(|n| (0..n).map(|i| if map.edges == Edges::Periodic { 1.0 } else { hann(i, n) }).collect());
        let origin = |k: usize, part: usize| match across {
            1 => (size[k] - wide[k]) / 2,
            _ => part * (size[k] - wide[k]) / (across - 1),
        };
        let all: Vec<Window> = (0..across * across)
            .map(|n| Window::new(map, [origin(0, n % across), origin(1, n / across)], taper.clone()))
            .collect();
        let full: f64 = taper.iter().map(|t| t.iter().map(|w| f64::from(w * w)).sum::<f64>()).product();
        let enough = all.iter().any(|w| w.weight > FEWEST_MEASURED * full);
        let mut list: Vec<Window> =
            all.into_iter().filter(|w| w.weight > if enough { FEWEST_MEASURED * full } else { 0.0 }).collect();
        if list.is_empty() {
            // The few measured points lie on the rim that a faster transform leaves out.
            list.push(Window::new(map, [0, 0], size.map(|n| vec![1.0; n])));
        }
        let wide = list[0].size();
        Windows { list, periodic: map.edges == Edges::Periodic, width: [0, 1].map(|k| wide[k] as f64 * pitch[k]) }
    }

    fn across(map: &HeightMap, size: [usize; 2], pitch: [f64; 2]) -> usize {
        let acf = Autocorrelation::measure(map).radial();
        let Some(&(length, _)) = acf.iter().find(|(_, value)| *value < 0.2) else { return 1 };
        let side = (size[0] as f64 * pitch[0]).min(size[1] as f64 * pitch[1]);
        let points = size[0].min(size[1]);
        (1..=MOST)
            .rev()
            .find(|k| {
                let share = 2.0 / (k + 1) as f64;
                share * side >= CORRELATION_LENGTHS * length && share * points as f64 >= 32.0
            })
            .unwrap_or(1)
    }

    /// Full width at half maximum of one direction's power along x and y, in direction cosines: `1.44 lambda / L` for a Hann
    /// window of width L, `0.89 lambda / L` for a periodic map. Finer structure of the lobe is not resolved; divide by
    /// cos_theta for the angle in the plane of incidence.
    pub fn resolution(&self, wavelength: f64) -> [f64; 2] {
        let factor = if self.periodic { 0.886 } else { 1.44 };
        self.width.map(|w| factor * wavelength / w)
    }
}

/// `sin^2(pi (i + 1/2) / n)`: no weight is zero, so even the smallest map has a window.
fn hann(i: usize, n: usize) -> f32 {
    (std::f64::consts::PI * (i as f64 + 0.5) / n as f64).sin().powi(2) as f32
}

/// The largest length up to `n` with no prime factor above 5 if that costs little, else `n`.
fn fast(n: usize) -> usize {
    let smooth = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n > 1 && n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    (n - n / 20..=n).rev().find(|&m| smooth(m)).unwrap_or(n).max(1)
}
