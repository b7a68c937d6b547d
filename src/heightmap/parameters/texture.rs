//! Spatial parameters of ISO 25178-2:2012, 4.4 and 4.6: how far heights remember each other, and in which direction.

use crate::heightmap::spectrum::{Autocorrelation, Spectrum};
use rayon::prelude::*;

/// Where the autocorrelation counts as decayed (default of ISO 25178-3:2012).
pub const DECAY: f64 = 0.2;

/// `Sal = min |t|`, `Str = Sal / max |t|` over the first lags `t` at which the autocorrelation falls to 0.2, one in each
/// direction; `Std` the direction of the lay.
///
/// Source: ISO 25178-2:2012, 4.4.1, 4.4.2, 4.6.1, threshold 0.2. A Gaussian autocorrelation of length `acl` has
/// `Sal = acl sqrt(ln 5)`. Std is given as most programs give it, along the grooves; the peak of the angular spectrum that
/// the standard speaks of lies at right angles to it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Texture {
    /// Autocorrelation length \[m\]; `None` if the heights remember each other over the whole reach in every direction.
    pub sal: Option<f64>,
    /// Texture aspect ratio, 0 to 1; `None` where there is no Sal.
    pub str: Option<f64>,
    /// Str is only an upper bound: in some direction the autocorrelation is above 0.2 as far as the map reaches.
    pub str_is_upper_bound: bool,
    /// Direction of the lay from +x \[rad\], in (-90, 90] deg; means little if Str is above one half.
    pub std: Option<f64>,
}

/// Directions looked into over half a turn: a groove 2000 Sal long is not missed.
const DIRECTIONS: usize = 720;

/// How far one direction goes on.
#[derive(Clone, Copy)]
enum Lag {
    /// To the first crossing \[m\].
    Decayed(f64),
    /// To the end of what is known \[m\].
    Open(f64),
}

impl Texture {
    /// From the autocorrelation and the spectrum of one map.
    pub fn of(autocorrelation: &Autocorrelation, spectrum: &Spectrum) -> Self {
        let lags: Vec<Lag> = (0..DIRECTIONS)
            .into_par_iter()
            .map(|k| decay(autocorrelation, std::f64::consts::PI * k as f64 / DIRECTIONS as f64))
            .collect();
        let mut sal = None;
        let (mut longest, mut longest_open) = (0.0f64, 0.0f64);
        for lag in lags {
            match lag {
                Lag::Decayed(t) => {
                    sal = Some(sal.map_or(t, |s: f64| s.min(t)));
                    longest = longest.max(t);
                }
                Lag::Open(t) => longest_open = longest_open.max(t),
            }
        }
        Texture {
            sal,
            str: sal.map(|s| s / longest.max(longest_open).max(s)),
            str_is_upper_bound: sal.is_some() && longest_open > 0.0,
            std: spectrum.lay(),
        }
    }
}

/// Walks outwards in steps of half a pitch and closes in on the crossing.
fn decay(acf: &Autocorrelation, direction: f64) -> Lag {
    let (sin, cos) = direction.sin_cos();
    let at = |t: f64| acf.at_lag(t * cos, t * sin);
    let step = 0.5 * acf.pitch[0].min(acf.pitch[1]);
    let mut steps = 0u32;
    loop {
        let t = f64::from(steps) * step;
        match at(t) {
            None => return Lag::Open((t - step).max(0.0)),
            Some(value) if value <= DECAY => {
                let (mut low, mut high) = (t - step, t);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if at(middle).is_some_and(|v| v > DECAY) { low = middle } else { high = middle }
                }
                return Lag::Decayed(high);
            }
            Some(_) => steps += 1,
        }
    }
}
