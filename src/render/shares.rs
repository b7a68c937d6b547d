//! How often each part of a sum of BRDFs is drawn from: as often as its energy asks at this incident angle.
//!
//! `p_k(theta_i) = c_k E_k(theta_i) / sum_j c_j E_j(theta_i)`, `E_k` the directional-hemispherical reflectance, core included,
//! `c_k` how much of white the part stands for.

use crate::optics::Brdf;

/// Steps between grazing and the normal.
const STEPS: usize = 256;

/// Probabilities that add up to 1, by the cosine of the incident angle: linear in its root, in which reflectances are smooth.
pub(super) struct Shares {
    parts: usize,
    /// One row of all parts per step.
    rows: Vec<f64>,
}

impl Shares {
    /// Of parts that each stand for so much of white. A part that reflects nothing is never drawn from; where nothing
    /// reflects, all are equal.
    pub(super) fn new(parts: &[(&dyn Brdf, f64)]) -> Self {
        let mut rows = Vec::with_capacity((STEPS + 1) * parts.len());
        for step in 0..=STEPS {
            let theta_i = (step as f64 / STEPS as f64).powi(2).acos();
            // The larger of nothing and of what is no number is nothing.
            let energies = parts.iter().map(|(brdf, white)| (white * brdf.albedo(theta_i)).max(0.0));
            let first = rows.len();
            rows.extend(energies);
            let total: f64 = rows[first..].iter().sum();
            let even = 1.0 / parts.len() as f64;
            rows[first..].iter_mut().for_each(|e| *e = if total > 0.0 { *e / total } else { even });
        }
        Shares { parts: parts.len(), rows }
    }

    /// The probability of each part.
    #[inline]
    pub(super) fn at(&self, cos_theta: f64) -> impl Iterator<Item = f64> {
        let x = cos_theta.clamp(0.0, 1.0).sqrt() * STEPS as f64;
        let step = (x as usize).min(STEPS - 1);
        let t = x - step as f64;
        let (low, high) = self.rows[step * self.parts..(step + 2) * self.parts].split_at(self.parts);
        low.iter().zip(high).map(move |(a, b)| a + t * (b - a))
    }

    /// The part that `u` in `[0, 1)` falls to, and `u` stretched over its share.
    #[inline]
    pub(super) fn choose(&self, cos_theta: f64, u: f64) -> (usize, f64) {
        let (mut from, mut chosen) = (0.0, (0, u));
        for (k, share) in self.at(cos_theta).enumerate().filter(|(_, share)| *share > 0.0) {
            chosen = (k, ((u - from) / share).clamp(0.0, 1.0 - f64::EPSILON));
            from += share;
            if u < from {
                break;
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;

    #[test]
    fn drawn_as_often_as_energy_asks_and_black_never() {
        let parts =
            ["dielectric:n=1.5", "lambert:rho=0", "lambert:rho=0.3"].map(|text| model::parse(text, 550e-9).unwrap());
        let shares = Shares::new(&[(&*parts[0], 1.0), (&*parts[1], 1.0), (&*parts[2], 0.5)]);
        for theta in [0.0f64, 0.4, 1.2, 1.5] {
            let mirror = parts[0].albedo(theta);
            let expected = [mirror / (mirror + 0.15), 0.0, 0.15 / (mirror + 0.15)];
            for (share, expected) in shares.at(theta.cos()).zip(expected) {
                assert!((share - expected).abs() < 1e-4, "{theta}: {share} {expected}");
            }
            let n = 10_000;
            let mut drawn = [0u32; 3];
            for i in 0..n {
                let (k, rest) = shares.choose(theta.cos(), (f64::from(i) + 0.5) / f64::from(n));
                assert!((0.0..1.0).contains(&rest));
                drawn[k] += 1;
            }
            for (drawn, expected) in drawn.into_iter().zip(expected) {
                assert!((f64::from(drawn) / f64::from(n) - expected).abs() < 3e-4);
            }
        }
    }

    #[test]
    fn where_nothing_reflects_all_are_equal() {
        let black = model::parse("lambert:rho=0", 550e-9).unwrap();
        let shares = Shares::new(&[(&*black, 1.0), (&*black, 1.0)]);
        assert_eq!(shares.at(0.3).collect::<Vec<_>>(), [0.5, 0.5]);
        assert_eq!(shares.choose(0.3, 1.0 - f64::EPSILON).0, 1);
    }
}
