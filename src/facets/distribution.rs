//! The slope distribution of a map in a few numbers: how steep, how anisotropic, how much hides.

use super::slopes;
use crate::error::{Error, Result};
use crate::heightmap::HeightMap;
use rayon::prelude::*;

/// Natural logarithm of the slope at the lower end of the radial histogram, and bins per unit of it.
const LOG_MIN: f64 = -23.0;
const BINS_PER_E: f64 = 32.0;
const BINS: usize = 900;

/// Moments, principal axes and radial histogram of the facet slopes (all dimensionless).
#[derive(Debug, Clone)]
pub struct SlopeStatistics {
    /// Facets with three measured vertices.
    pub facets: u64,
    /// Facets the grid would have without missing points.
    pub possible_facets: u64,
    /// Mean slopes along x and y.
    pub mean: [f64; 2],
    /// Root-mean-square slopes along x and y about zero.
    pub rms: [f64; 2],
    /// Sdq: root of the mean squared gradient, `sqrt(<p^2 + q^2>)` (ISO 25178-2).
    pub sdq: f64,
    /// Standard deviations along the principal axes about the mean, larger first.
    pub axes: [f64; 2],
    /// Direction of the larger axis from +x \[rad\].
    pub axis_angle: f64,
    /// Largest gradient of any facet.
    pub steepest: f64,
    /// Standard deviation of the core of the lobe in units of `axes`: 1 for a Gaussian, less for a sharp core with long tails.
    pub core: f64,
    /// Facets per bin of the gradient's logarithm.
    gradient_histogram: Vec<u64>,
}

#[derive(Clone, Copy, Default)]
struct Moments {
    n: u64,
    p: f64,
    q: f64,
    pp: f64,
    pq: f64,
    qq: f64,
    steepest2: f64,
}

impl SlopeStatistics {
    /// Two passes over the facets; identical for any number of threads.
    ///
    /// # Errors
    /// `Error::Parameter` if the map has no facet.
    pub fn measure(map: &HeightMap) -> Result<Self> {
        let (nx, ny) = slopes::cells(map);
        let rows: Vec<Moments> = (0..ny)
            .into_par_iter()
            .map(|row| {
                let mut m = Moments::default();
                slopes::visit_row(map, row, |f| {
                    m.n += 1;
                    m.p += f.p;
                    m.q += f.q;
                    m.pp += f.p * f.p;
                    m.pq += f.p * f.q;
                    m.qq += f.q * f.q;
                    m.steepest2 = m.steepest2.max(f.p * f.p + f.q * f.q);
                });
                m
            })
            .collect();
        let mut m = Moments::default();
        for row in rows {
            m = Moments {
                n: m.n + row.n,
                p: m.p + row.p,
                q: m.q + row.q,
                pp: m.pp + row.pp,
                pq: m.pq + row.pq,
                qq: m.qq + row.qq,
                steepest2: m.steepest2.max(row.steepest2),
            };
        }
        if m.n == 0 {
            return Err(Error::parameter("the map has no facet", "every triangle touches a missing point"));
        }
        let n = m.n as f64;
        let mean = [m.p / n, m.q / n];
        let (pp, pq, qq) = (m.pp / n, m.pq / n, m.qq / n);
        let (vp, cov, vq) =
            ((pp - mean[0] * mean[0]).max(0.0), pq - mean[0] * mean[1], (qq - mean[1] * mean[1]).max(0.0));
        let half_trace = (vp + vq) / 2.0;
        let split = ((vp - vq) / 2.0).hypot(cov);
        let axes = [(half_trace + split).sqrt(), (half_trace - split).max(0.0).sqrt()];
        let mut statistics = SlopeStatistics {
            facets: m.n,
            possible_facets: 2 * (nx * ny) as u64,
            mean,
            rms: [pp.sqrt(), qq.sqrt()],
            sdq: (pp + qq).sqrt(),
            axes,
            axis_angle: 0.5 * (2.0 * cov).atan2(vp - vq),
            steepest: m.steepest2.sqrt(),
            core: 1.0,
            gradient_histogram: Vec::new(),
        };
        statistics.gradient_histogram = radial_histogram(map, |p, q| p.hypot(q));
        statistics.core = statistics.core_scale(map);
        Ok(statistics)
    }

    /// Ratio of the smaller to the larger principal slope; 1 for an isotropic or flat map.
    pub fn axis_ratio(&self) -> f64 {
        if self.axes[0] > 0.0 { self.axes[1] / self.axes[0] } else { 1.0 }
    }

    /// Whether one lobe averaged over azimuth stands for the map: axes alike within 15 % and no tilt left
    /// that would show beside the lobe's own width.
    pub fn looks_isotropic(&self) -> bool {
        let tilt = self.mean[0].hypot(self.mean[1]);
        self.axis_ratio() >= 0.85 && tilt <= 0.1 * self.axes[0] + 1e-6
    }

    /// `Lambda(theta) = tan(theta) <max(0, g cos(phi) - cot(theta))>` over facets of gradient `g` and all azimuths:
    /// projected area counted twice, hence hidden, per unit of illuminated area.
    ///
    /// Smith's function (IEEE Trans. Antennas Propag. 15, 668, 1967) with the measured instead of a Gaussian
    /// distribution; exact for a surface whose slopes and heights are independent.
    pub fn hidden_excess(&self, theta: f64) -> f64 {
        let bins = self.gradient_histogram.iter().enumerate();
        hidden_excess(bins.map(|(k, &count)| (bin_value(k), count as f64 / self.facets as f64)), theta)
    }

    /// [`SlopeStatistics::hidden_excess`] tabulated against the cosine, for loops.
    pub fn hiding(&self) -> Hiding {
        Hiding::tabulate(|theta| self.hidden_excess(theta))
    }

    fn core_scale(&self, map: &HeightMap) -> f64 {
        let (sin, cos) = self.axis_angle.sin_cos();
        let scale = self.axes.map(|a| a.max(1e-3 * self.axes[0]).max(1e-12));
        let histogram = radial_histogram(map, |p, q| {
            let (dp, dq) = (p - self.mean[0], q - self.mean[1]);
            ((cos * dp + sin * dq) / scale[0]).hypot((cos * dq - sin * dp) / scale[1])
        });
        // A tenth of a two-dimensional Gaussian lies within 0.459 standard deviations.
        let wanted = self.facets / 10;
        let mut below = 0;
        for (k, &count) in histogram.iter().enumerate() {
            below += count;
            if below > wanted {
                return (bin_value(k) / 0.459).clamp(0.02, 1.0);
            }
        }
        1.0
    }
}

const HIDING_STEPS: usize = 512;

/// Masking and shadowing of one surface.
#[derive(Debug, Clone)]
pub struct Hiding {
    /// Lambda at `cos_theta = (k / steps)^2`: fine steps where it varies, at the horizon.
    excess: Vec<f64>,
}

/// [`SlopeStatistics::hidden_excess`] of a list of gradients, each with its share of the facets.
pub fn hidden_excess(gradients: impl Iterator<Item = (f64, f64)>, theta: f64) -> f64 {
    let (sin, cos) = theta.sin_cos();
    if sin <= 0.0 {
        return 0.0;
    }
    let c = cos / sin;
    let mut sum = 0.0;
    for (g, share) in gradients {
        if share > 0.0 && g > c {
            sum += share * ((g * g - c * c).sqrt() - c * (c / g).acos()) / std::f64::consts::PI;
        }
    }
    sum / c.max(1e-300)
}

impl Hiding {
    /// Tabulates Lambda, a function of theta.
    pub fn tabulate(excess: impl Fn(f64) -> f64) -> Self {
        // At the horizon Lambda is infinite; a cosine that small is never asked for exactly.
        let cos = |k: usize| (k as f64 / HIDING_STEPS as f64).powi(2).max(1e-6);
        Hiding { excess: (0..=HIDING_STEPS).map(|k| excess(cos(k).acos())).collect() }
    }

    /// `Lambda(cos_theta)`.
    #[inline]
    pub fn lambda(&self, cos_theta: f64) -> f64 {
        let x = cos_theta.clamp(0.0, 1.0).sqrt() * HIDING_STEPS as f64;
        let k = (x as usize).min(HIDING_STEPS - 1);
        let t = x - k as f64;
        self.excess[k] + t * (self.excess[k + 1] - self.excess[k])
    }

    /// `G = 1 / (1 + Lambda_i + Lambda_o)`: share of facets lit and seen, height-correlated (Heitz 2014).
    #[inline]
    pub fn visible(&self, cos_i: f64, cos_o: f64) -> f64 {
        1.0 / (1.0 + self.lambda(cos_i) + self.lambda(cos_o))
    }
}

fn bin_value(k: usize) -> f64 {
    (LOG_MIN + (k as f64 + 0.5) / BINS_PER_E).exp()
}

/// Histogram of `ln radius(p, q)` over all facets; exact counts, so the order of threads cannot matter.
fn radial_histogram(map: &HeightMap, radius: impl Fn(f64, f64) -> f64 + Sync) -> Vec<u64> {
    let (_, ny) = slopes::cells(map);
    (0..ny)
        .into_par_iter()
        .fold(
            || vec![0u64; BINS],
            |mut counts, row| {
                slopes::visit_row(map, row, |f| {
                    let bin = (radius(f.p, f.q).ln() - LOG_MIN) * BINS_PER_E;
                    counts[(bin.max(0.0) as usize).min(BINS - 1)] += 1;
                });
                counts
            },
        )
        .reduce(
            || vec![0u64; BINS],
            |mut a, b| {
                a.iter_mut().zip(b).for_each(|(x, y)| *x += y);
                a
            },
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};

    fn gaussian_map(sq: f64) -> HeightMap {
        let grid = synth::Grid { width: 512, height: 512, pitch: [0.5e-6; 2] };
        let raw = synth::gaussian(grid, synth::Gaussian { sq, acl: 6e-6, seed: 5, exact: true }).unwrap();
        level::keep_tilt(&raw, Edges::Periodic)
    }

    /// Gaussian ACF: slope variance 2 sq^2/acl^2 per axis, times the forward-difference factor (TV46 formula).
    #[test]
    fn gaussian_slopes() {
        let s = SlopeStatistics::measure(&gaussian_map(0.6e-6)).unwrap();
        let x2 = (0.5f64 / 6.0).powi(2);
        let expected = 0.02 * (1.0 - (-x2).exp()) / x2;
        for rms in s.rms {
            // The two axes of one map share the fixed spectrum; what is left is the grid's own anisotropy.
            assert!((rms * rms / expected - 1.0).abs() < 0.01, "{} {expected}", rms * rms);
        }
        assert!(s.looks_isotropic() && (s.core - 1.0).abs() < 0.1, "{s:?}");
    }

    /// 1 + Lambda of a Gaussian surface: 1.0125 and 1.3903 at 60 and 80 deg for alpha = .495 (TV45).
    #[test]
    fn hidden_excess_is_smiths_lambda() {
        let factor = |s: &SlopeStatistics| 0.495 / s.sdq;
        let base = SlopeStatistics::measure(&gaussian_map(0.6e-6)).unwrap();
        let s = SlopeStatistics::measure(&gaussian_map(0.6e-6 * factor(&base))).unwrap();
        assert!((s.hidden_excess(60f64.to_radians()) - 0.0125).abs() < 0.002);
        assert!((s.hidden_excess(80f64.to_radians()) - 0.3903).abs() < 0.01);
        assert_eq!(s.hidden_excess(0.0), 0.0);
        let hiding = s.hiding();
        for degrees in [0.0, 30.0, 60.0, 80.0, 88.0f64] {
            let exact = s.hidden_excess(degrees.to_radians());
            assert!((hiding.lambda(degrees.to_radians().cos()) - exact).abs() < 1e-3 * (1.0 + exact), "{degrees}");
        }
    }

    #[test]
    fn a_tilted_mirror_is_not_isotropic_and_a_flat_map_is() {
        let grid = synth::Grid { width: 20, height: 30, pitch: [1e-6, 2e-6] };
        let tilted = level::keep_tilt(&synth::ramp(grid, [0.1, 0.05]).unwrap(), Edges::Open);
        let s = SlopeStatistics::measure(&tilted).unwrap();
        assert!(!s.looks_isotropic() && (s.mean[1] - 0.05).abs() < 1e-6);
        let flat = level::keep_tilt(&synth::ramp(grid, [0.0, 0.0]).unwrap(), Edges::Open);
        let s = SlopeStatistics::measure(&flat).unwrap();
        assert!(s.looks_isotropic() && s.hidden_excess(1.5) == 0.0 && s.core > 0.0);
    }
}
