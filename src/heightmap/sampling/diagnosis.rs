//! From slopes at several distances to a verdict.
//!
//! With `b(d) = log2(s(d) / s(2d))`, the local exponent of `s ~ d^-b`:
//!
//! | surface | b at the pitch | b at coarser distances |
//! |---|---|---|
//! | resolved | below 0.07 (5 %) | anything |
//! | Gaussian, undersampled | above 0.07 | larger: up to 1 beyond the autocorrelation length |
//! | exponential or fractal | between | the same over several octaves (0.5 for an exponential) |
//! | smooth with white noise | above 0.07, up to 1 | smaller: the noise fades as 1/d |
//! | nothing but white noise, or far undersampled | about 1 | about 1 |

use super::quantum::Quantum;
use super::scales::SlopeScale;
use super::spikes::Spikes;
use super::warning::{MapAxis, Warning};

/// Change of the rms slope between 2d and d from which it counts as unresolved.
pub const LARGEST_CHANGE: f64 = 0.05;

/// Exponents of neighbouring octaves that differ by less are the same.
const SAME_EXPONENT: f64 = 0.05;

/// Above this exponent neighbours are independent: no trend can be told from noise.
const INDEPENDENT: f64 = 0.85;

/// Spikes that carry less of the squared slope are not worth a warning.
const SPIKE_SHARE: f64 = 0.02;

/// Share of missing points from which slopes are suspect.
const GAPS: f64 = 0.05;

/// Exponent of the slope between a distance and the next, double one.
fn exponent(pair: &[SlopeScale]) -> f64 {
    if pair[1].rms > 0.0 { (pair[0].rms / pair[1].rms).log2() } else { 0.0 }
}

/// The one verdict on the slopes along an axis; `None` if they are resolved, or the map too small to tell.
pub(super) fn of_axis(axis: MapAxis, scales: &[SlopeScale]) -> Option<Warning> {
    let exponents: Vec<f64> = scales.windows(2).map(exponent).collect();
    let (&finest, scale) = (exponents.first()?, scales.first()?);
    let change = finest.exp2() - 1.0;
    if change <= LARGEST_CHANGE {
        return None;
    }
    let distance = scale.distance;
    let next = exponents.get(1).copied().unwrap_or(1.0);
    let noisy = || {
        let (share, sigma) = noise(scales);
        Some(Warning::Noise { axis, distance, share, sigma })
    };
    if finest > INDEPENDENT || finest - next > SAME_EXPONENT {
        return noisy();
    }
    let same = exponents.windows(2).take_while(|b| (b[1] - b[0]).abs() <= SAME_EXPONENT).count();
    // Two equal exponents could be chance where a curve bends; three octaves of one power are a law.
    if same >= 2 && finest >= 0.15 {
        let mean = exponents[..=same].iter().sum::<f64>() / (same + 1) as f64;
        let range = [distance, scales[same + 1].distance];
        return Some(Warning::NoRmsSlope { axis, exponent: mean, range });
    }
    // A slope that settles towards coarser distances was disturbed at the finest; one that does not was cut short.
    if next < finest { noisy() } else { Some(Warning::Unresolved { axis, distance, change }) }
}

/// Share of the squared slope at the pitch, and standard deviation \[m\], of white height noise.
///
/// Squared height differences over 1, 2 and 4 pitches are `2 sigma^2 + a k^2 + b k^4` for a smooth surface with noise;
/// without the third the curvature term is left out.
fn noise(scales: &[SlopeScale]) -> (f64, f64) {
    let squared = |k: usize| scales.get(k).map(|s| (s.rms * s.distance).powi(2));
    let (Some(one), Some(two)) = (squared(0), squared(1)) else { return (0.0, 0.0) };
    let constant = match squared(2) {
        Some(four) => (64.0 * one - 20.0 * two + four) / 45.0,
        None => (4.0 * one - two) / 3.0,
    };
    let constant = constant.clamp(0.0, one);
    (if one > 0.0 { constant / one } else { 0.0 }, (0.5 * constant).sqrt())
}

pub(super) fn of_quantum(quantum: Option<Quantum>) -> Option<Warning> {
    quantum.map(|Quantum { step, distinct, glint_spacing }| Warning::QuantisedHeights { step, distinct, glint_spacing })
}

pub(super) fn of_spikes(spikes: Option<Spikes>) -> Option<Warning> {
    let found = spikes.filter(|s| s.slope_share > SPIKE_SHARE);
    found.map(|Spikes { count, largest, slope_share, .. }| Warning::Spikes { count, largest, slope_share })
}

pub(super) fn of_gaps(fraction: f64) -> Option<Warning> {
    (fraction > GAPS).then_some(Warning::MissingPoints { fraction })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes at 1, 2, 4, .. pitches from squared height differences.
    fn scales(squared_difference: impl Fn(f64) -> f64) -> Vec<SlopeScale> {
        (0..6)
            .map(|k| {
                let d = f64::from(1 << k);
                SlopeScale { distance: d, rms: squared_difference(d).sqrt() / d, pairs: 1000 }
            })
            .collect()
    }

    fn gaussian(acl: f64) -> impl Fn(f64) -> f64 {
        move |d| 2.0 * (1.0 - (-(d / acl).powi(2)).exp())
    }

    #[test]
    fn gaussian_surfaces_are_resolved_from_a_quarter_of_their_length() {
        let verdict = |acl| of_axis(MapAxis::X, &scales(gaussian(acl)));
        assert_eq!(verdict(4.0), None);
        assert_eq!(verdict(40.0), None);
        for acl in [1.2, 1.5, 2.0, 3.0, 3.5] {
            // s(d)^2 / s(2d)^2 = 4 (1 - exp(-x)) / (1 - exp(-4x)) with x = (d / acl)^2.
            let x = f64::powi(1.0 / acl, 2);
            let expected = (4.0 * (1.0 - (-x).exp()) / (1.0 - (-4.0 * x).exp())).sqrt() - 1.0;
            match verdict(acl) {
                Some(Warning::Unresolved { change, .. }) => assert!((change - expected).abs() < 1e-12),
                other => panic!("{acl}: {other:?}"),
            }
        }
    }

    #[test]
    fn noise_is_found_and_measured() {
        for (sigma2, share) in [(0.02, 0.0), (0.002, 0.0), (1.0, 0.0)].map(|(s, _): (f64, f64)| {
            let signal = gaussian(12.0)(1.0);
            (s, 2.0 * s / (2.0 * s + signal))
        }) {
            let found = of_axis(MapAxis::Y, &scales(|d| 2.0 * sigma2 + gaussian(12.0)(d)));
            match found {
                Some(Warning::Noise { share: s, sigma, axis: MapAxis::Y, .. }) => {
                    assert!(
                        (s - share).abs() < 0.01 && (sigma / sigma2.sqrt() - 1.0).abs() < 0.01,
                        "{s} {share} {sigma}"
                    );
                }
                other => panic!("{sigma2}: {other:?}"),
            }
        }
        // White noise alone.
        assert!(
            matches!(of_axis(MapAxis::X, &scales(|_| 2.0)), Some(Warning::Noise { share, .. }) if (share - 1.0).abs() < 1e-9)
        );
    }

    #[test]
    fn surfaces_without_a_slope() {
        for acl in [15.0, 60.0, 1e6] {
            let found = of_axis(MapAxis::X, &scales(|d| 2.0 * (1.0 - (-d / acl).exp())));
            assert!(
                matches!(found, Some(Warning::NoRmsSlope { exponent, .. }) if (exponent - 0.5).abs() < 0.1),
                "{found:?}"
            );
        }
        // Self-affine with Hurst exponent 0.7: s ~ d^-0.3.
        let found = of_axis(MapAxis::X, &scales(|d| d.powf(1.4)));
        assert!(
            matches!(found, Some(Warning::NoRmsSlope { exponent, range, .. })
            if (exponent - 0.3).abs() < 1e-9 && range == [1.0, 32.0]),
            "{found:?}"
        );
    }

    #[test]
    fn nothing_to_say_about_planes_flats_and_crumbs() {
        assert_eq!(of_axis(MapAxis::X, &scales(|d| d * d)), None);
        assert_eq!(of_axis(MapAxis::X, &scales(|_| 0.0)), None);
        assert_eq!(of_axis(MapAxis::X, &scales(gaussian(1.0))[..1]), None);
        assert_eq!(of_axis(MapAxis::X, &[]), None);
    }
}
