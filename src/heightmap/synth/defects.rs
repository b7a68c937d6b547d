//! What instruments add: noise, spikes, steps and gaps, each in a known amount.

use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::math::random::CounterRng;

/// Streams of random numbers apart from those that make surfaces (0 and 1).
const NOISE: u32 = 2;
const SPIKES: u32 = 3;
const DROPOUTS: u32 = 4;

/// Defects of a measurement, applied in this order; zero leaves one out.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Defects {
    /// Standard deviation of white, normally distributed height noise \[m\].
    pub noise: f64,
    /// Share of the points that become spikes.
    pub spikes: f64,
    /// Height of a spike above or below its place \[m\].
    pub spike_height: f64,
    /// Step that heights are rounded to \[m\].
    pub quantum: f64,
    /// Share of the points that go missing.
    pub dropouts: f64,
    /// Seed.
    pub seed: u64,
}

/// `h <- round((h + noise +- spike) / quantum) quantum`, and then the dropouts.
///
/// Noise adds `2 noise^2 / d^2` to the slope variance of forward differences along each axis. Spikes and dropouts are
/// exactly `round(share * points)` points at random places; the same seed gives the same points for any number of threads.
///
/// # Errors
/// `Error::Parameter` for a negative or infinite amount, a share above 1, or spikes without a height.
pub fn add_defects(map: &mut RawMap, defects: &Defects) -> Result<()> {
    let d = defects;
    let amounts = [("noise", d.noise), ("spike-height", d.spike_height), ("quantum", d.quantum)];
    if let Some((name, value)) = amounts.into_iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)) {
        return Err(Error::parameter(format!("--{name} {value} m is not an amount"), "give a length of 0 or more"));
    }
    let shares = [("spikes", d.spikes), ("dropouts", d.dropouts)];
    if let Some((name, value)) = shares.into_iter().find(|(_, v)| !(0.0..=1.0).contains(v)) {
        return Err(Error::parameter(format!("--{name} {value} is not a share"), "give a number from 0 to 1"));
    }
    if d.spikes > 0.0 && d.spike_height == 0.0 {
        return Err(Error::parameter("spikes have no height", "give --spike-height, for example 1um"));
    }
    if d.noise > 0.0 {
        for (k, h) in map.heights.iter_mut().enumerate() {
            *h += d.noise * CounterRng::new(d.seed, NOISE, k as u64).normal_pair()[0];
        }
    }
    let points = map.heights.len();
    let mut chosen = vec![false; points];
    for k in some_of(points, d.spikes, d.seed, SPIKES) {
        chosen[k] = true;
    }
    for (k, h) in map.heights.iter_mut().enumerate().filter(|(k, _)| chosen[*k]) {
        // One more number of the point's stream decides the side.
        let mut rng = CounterRng::new(d.seed, SPIKES, k as u64);
        rng.uniform();
        *h += if rng.uniform() < 0.5 { -d.spike_height } else { d.spike_height };
    }
    if d.quantum > 0.0 {
        map.heights.mapv_inplace(|h| (h / d.quantum).round() * d.quantum);
    }
    let mut missing = vec![false; points];
    for k in some_of(points, d.dropouts, d.seed, DROPOUTS) {
        missing[k] = true;
    }
    for (_, h) in map.heights.iter_mut().enumerate().filter(|(k, _)| missing[*k]) {
        *h = f64::NAN;
    }
    Ok(())
}

/// `round(share * points)` different points: those that draw the smallest numbers.
fn some_of(points: usize, share: f64, seed: u64, stream: u32) -> Vec<usize> {
    let wanted = (share * points as f64).round() as usize;
    if wanted == 0 {
        return Vec::new();
    }
    let mut drawn: Vec<(f64, usize)> =
        (0..points).map(|k| (CounterRng::new(seed, stream, k as u64).uniform(), k)).collect();
    // Ties, should there be any, go to the earlier point.
    let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if wanted < points {
        drawn.select_nth_unstable_by(wanted, order);
    }
    drawn[..wanted].iter().map(|d| d.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::synth::{Grid, ramp};

    fn flat() -> RawMap {
        ramp(Grid { width: 160, height: 90, pitch: [1e-6, 2e-6] }, [0.0, 0.0]).unwrap()
    }

    /// Variance of the heights and of forward differences, within four standard errors of either.
    #[test]
    fn noise_is_white() {
        let mut map = flat();
        add_defects(&mut map, &Defects { noise: 2e-9, seed: 3, ..Defects::default() }).unwrap();
        let n = map.heights.len() as f64;
        let mean_square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>() / n / 4e-18;
        let variance = mean_square(&mut map.heights.iter().copied());
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance}");
        let differences = map.heights.outer_iter().flat_map(|row| {
            let row = row.to_vec();
            (0..160).map(move |c| row[(c + 1) % 160] - row[c])
        });
        let doubled = mean_square(&mut differences.collect::<Vec<_>>().into_iter());
        // 2 sigma^2, with a standard error of sqrt(6 / n) of neighbours that share a point.
        assert!((doubled / 2.0 - 1.0).abs() < 4.0 * (3.0 / n).sqrt(), "{doubled}");
    }

    #[test]
    fn spikes_and_dropouts_are_counted_out() {
        let mut map = flat();
        let defects = Defects { spikes: 0.01, spike_height: 1e-6, dropouts: 0.25, seed: 7, ..Defects::default() };
        add_defects(&mut map, &Defects { dropouts: 0.0, ..defects }).unwrap();
        let up = map.heights.iter().filter(|h| **h == 1e-6).count();
        let down = map.heights.iter().filter(|h| **h == -1e-6).count();
        assert!(up + down == 144 && up > 40 && down > 40, "{up} {down}");
        let mut map = flat();
        add_defects(&mut map, &defects).unwrap();
        assert_eq!(map.heights.iter().filter(|h| h.is_nan()).count(), 160 * 90 / 4);
        let mut all = flat();
        add_defects(&mut all, &Defects { dropouts: 1.0, ..defects }).unwrap();
        assert!(all.heights.iter().all(|h| h.is_nan()));
    }

    /// Rounding a wide uniform distribution leaves an error of standard deviation `q / sqrt 12`.
    #[test]
    fn heights_come_in_steps() {
        let grid = Grid { width: 160, height: 90, pitch: [1e-6, 2e-6] };
        let smooth = ramp(grid, [0.01234, 0.0077]).unwrap();
        let mut map = smooth.clone();
        add_defects(&mut map, &Defects { quantum: 5e-9, ..Defects::default() }).unwrap();
        let mut squares = 0.0;
        for (a, b) in map.heights.iter().zip(&smooth.heights) {
            let steps = a / 5e-9;
            assert!((steps - steps.round()).abs() < 1e-6);
            squares += (a - b) * (a - b);
        }
        let rms = (squares / map.heights.len() as f64).sqrt();
        assert!((rms / (5e-9 / 12f64.sqrt()) - 1.0).abs() < 0.05, "{rms}");
    }

    #[test]
    fn nothing_asked_nothing_done_and_nonsense_refused() {
        let mut map = flat();
        add_defects(&mut map, &Defects::default()).unwrap();
        assert!(map.heights.iter().all(|h| *h == 0.0));
        for bad in [
            Defects { noise: -1.0, ..Defects::default() },
            Defects { quantum: f64::NAN, ..Defects::default() },
            Defects { dropouts: 1.5, ..Defects::default() },
            Defects { spikes: 0.1, ..Defects::default() },
        ] {
            assert!(add_defects(&mut map, &bad).is_err());
        }
    }
}
