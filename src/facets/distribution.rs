//! The slope distribution of a map in a few numbers: how steep, how anisotropic, how much hides.

use super::radial::RadialHistogram;
use super::slopes;
use crate::error::{Error, Result};
use crate::heightmap::HeightMap;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rayon::prelude::*;

/// Rows per task.
const ROWS: usize = 32;

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
    gradients: RadialHistogram,
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
    /// Three passes over the facets; identical for any number of threads.
    ///
    /// # Errors
    /// `Error::Parameter` if the map has no facet.
    pub fn measure(map: &HeightMap) -> Result<Self> {
        let (nx, ny) = slopes::cells(map);
        let starts: Vec<usize> = (0..ny).step_by(ROWS).collect();
        let rows: Vec<Moments> = starts
            .into_par_iter()
            .map(|start| {
                let level = Level::new();
                let mut m = Moments::default();
                slopes::visit_lanes(map, start..(start + ROWS).min(ny), |p, q| {
                    dispatch!(level, simd => add_moments(simd, p, q, &mut m));
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
            // Rounded up: it serves as a bound.
            steepest: m.steepest2.sqrt() * (1.0 + 1e-6),
            core: 1.0,
            gradients: RadialHistogram::measure(map, [0.0; 2], [[1.0, 0.0], [0.0, 1.0]]),
        };
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
        let all: u64 = self.gradients.bins().map(|bin| bin.1).sum();
        hidden_excess(self.gradients.bins().map(|(g, count)| (g, count as f64 / all as f64)), theta)
    }

    /// Share of the facets whose gradient is larger, to the width of a histogram bin (3 % in the gradient).
    pub fn share_steeper(&self, gradient: f64) -> f64 {
        let above: u64 = self.gradients.bins().filter(|bin| bin.0 > gradient).map(|bin| bin.1).sum();
        above as f64 / self.facets as f64
    }

    /// [`SlopeStatistics::hidden_excess`] tabulated against the cosine, for loops.
    pub fn hiding(&self) -> Hiding {
        Hiding::tabulate(|theta| self.hidden_excess(theta))
    }

    fn core_scale(&self, map: &HeightMap) -> f64 {
        let (sin, cos) = self.axis_angle.sin_cos();
        let scale = self.axes.map(|a| a.max(1e-3 * self.axes[0]).max(1e-12));
        let rows = [[cos / scale[0], sin / scale[0]], [-sin / scale[1], cos / scale[1]]];
        // A tenth of a two-dimensional Gaussian lies within 0.459 standard deviations.
        let wanted = self.facets / 10;
        let mut below = 0;
        for (radius, count) in RadialHistogram::measure(map, self.mean, rows).bins() {
            below += count;
            if below > wanted {
                return (radius / 0.459).clamp(0.02, 1.0);
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

/// Sums over lanes, which are added to `m` at the end.
#[simd]
fn add_moments<S: Simd>(_: S, p: &[f32], q: &[f32], m: &mut Moments) {
    const LANES: usize = 8;
    let mut sums = [[0.0f64; LANES]; 6];
    let mut steepest = [0.0f32; LANES];
    let mut add = |p: &[f32], q: &[f32], lanes: usize| {
        for k in 0..lanes {
            let there = !(p[k] + q[k]).is_nan();
            let (p, q) = if there { (p[k], q[k]) } else { (0.0, 0.0) };
            let square = p * p + q * q;
            steepest[k] = if square > steepest[k] { square } else { steepest[k] };
            let (p, q) = (f64::from(p), f64::from(q));
            sums[0][k] += if there { 1.0 } else { 0.0 };
            sums[1][k] += p;
            sums[2][k] += q;
            sums[3][k] += p * p;
            sums[4][k] += p * q;
            sums[5][k] += q * q;
        }
    };
    let (some, rest) = p.as_chunks::<LANES>();
    let (others, other_rest) = q.as_chunks::<LANES>();
    for (p, q) in some.iter().zip(others) {
        add(p, q, LANES);
    }
    add(rest, other_rest, rest.len());
    let total = sums.map(|lanes| lanes.iter().sum::<f64>());
    *m = Moments {
        n: m.n + total[0] as u64,
        p: m.p + total[1],
        q: m.q + total[2],
        pp: m.pp + total[3],
        pq: m.pq + total[4],
        qq: m.qq + total[5],
        steepest2: m.steepest2.max(f64::from(steepest.iter().copied().fold(0.0, f32::max))),
    };
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
