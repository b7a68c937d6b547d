//! Importance sampling of a rectangle: per axis a density that is linear between knots, learnt from the integrand.
//!
//! The density of a point is the product of both axes. Source: the separable grid of G. P. Lepage, J. Computational
//! Physics 27, 192 (1978) (VEGAS); linear instead of constant between knots, so that the weights have no steps for
//! low-discrepancy points to stumble over.

/// Evenly spaced knots per axis, and knots at quantiles of the surface's own draws.
const EVEN: usize = 24;
const QUANTILES: usize = 24;

/// Smallest density of a knot relative to the mean: nothing in the rectangle is ever out of reach.
const FLOOR: f64 = 0.05;

/// Density over an interval, linear between knots.
#[derive(Debug, Clone)]
struct Axis {
    knots: Vec<f64>,
    /// Density at each knot.
    density: Vec<f64>,
    /// Probability below each knot.
    below: Vec<f64>,
    /// What training saw near each knot.
    seen: Vec<f64>,
}

impl Axis {
    fn new([low, high]: [f64; 2], draws: &mut [f64]) -> Self {
        draws.sort_by(f64::total_cmp);
        let mut knots: Vec<f64> = (0..=EVEN).map(|k| low + (high - low) * k as f64 / EVEN as f64).collect();
        if let Some(last) = draws.len().checked_sub(1) {
            knots.extend((0..=QUANTILES).map(|k| draws[k * last / QUANTILES]));
        }
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        let mut axis = Axis { density: vec![1.0; knots.len()], below: Vec::new(), seen: vec![0.0; knots.len()], knots };
        axis.normalise();
        axis
    }

    /// Half the distance between the neighbours of knot `k`: what its hat function integrates to.
    fn hat(&self, k: usize) -> f64 {
        let last = self.knots.len() - 1;
        0.5 * (self.knots[(k + 1).min(last)] - self.knots[k.saturating_sub(1)])
    }

    fn learn(&mut self, x: f64, value: f64) {
        let k = self.cell(x);
        let t = (x - self.knots[k]) / (self.knots[k + 1] - self.knots[k]);
        self.seen[k] += value * (1.0 - t);
        self.seen[k + 1] += value * t;
    }

    fn adapt(&mut self) {
        let total: f64 = self.seen.iter().sum();
        let mean = total / (self.knots[self.knots.len() - 1] - self.knots[0]);
        if mean > 0.0 && mean.is_finite() {
            self.density = (0..self.seen.len()).map(|k| self.seen[k] / self.hat(k) + FLOOR * mean).collect();
            self.normalise();
        }
    }

    fn normalise(&mut self) {
        let mut sum = 0.0;
        self.below = vec![0.0];
        for (x, p) in self.knots.windows(2).zip(self.density.windows(2)) {
            sum += 0.5 * (x[1] - x[0]) * (p[0] + p[1]);
            self.below.push(sum);
        }
        self.below.iter_mut().for_each(|b| *b /= sum);
        self.density.iter_mut().for_each(|p| *p /= sum);
    }

    fn cell(&self, x: f64) -> usize {
        self.knots.partition_point(|&k| k <= x).clamp(1, self.knots.len() - 1) - 1
    }

    /// Point at `u` in `[0, 1)` and its density.
    fn point(&self, u: f64) -> (f64, f64) {
        let k = self.below.partition_point(|&b| b <= u).clamp(1, self.knots.len() - 1) - 1;
        let (p, q) = (self.density[k], self.density[k + 1]);
        let width = self.knots[k + 1] - self.knots[k];
        // p t + (q - p) t^2 / 2 = c, the root in [0, 1] in the form that survives q = p.
        let c = (u - self.below[k]).max(0.0) / width;
        let root = (p * p + 2.0 * (q - p) * c).max(0.0).sqrt();
        let t = (2.0 * c / (p + root)).clamp(0.0, 1.0);
        (self.knots[k] + t * width, p + t * (q - p))
    }

    /// Density at `x`; 0 outside.
    fn density(&self, x: f64) -> f64 {
        if x < self.knots[0] || x > self.knots[self.knots.len() - 1] {
            return 0.0;
        }
        let k = self.cell(x);
        let t = (x - self.knots[k]) / (self.knots[k + 1] - self.knots[k]);
        self.density[k] + t * (self.density[k + 1] - self.density[k])
    }
}

/// Product of two learnt axes.
#[derive(Debug, Clone)]
pub struct Grid {
    axes: [Axis; 2],
}

impl Grid {
    /// Uniform density over the rectangle `bounds` (low, high per axis), ready to learn detail where `draws` lie.
    pub fn new(bounds: [[f64; 2]; 2], draws: &[[f64; 2]]) -> Self {
        let axis = |a: usize| Axis::new(bounds[a], &mut draws.iter().map(|d| d[a]).collect::<Vec<_>>());
        Grid { axes: [axis(0), axis(1)] }
    }

    /// Point at `u` in `[0, 1)^2` and its density.
    pub fn point(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let ((x, px), (y, py)) = (self.axes[0].point(u[0]), self.axes[1].point(u[1]));
        ([x, y], px * py)
    }

    /// Density at `p`; 0 outside the rectangle.
    pub fn density(&self, p: [f64; 2]) -> f64 {
        self.axes[0].density(p[0]) * self.axes[1].density(p[1])
    }

    /// Remembers that the integrand over the density of training points was `value` at `p`.
    pub fn learn(&mut self, p: [f64; 2], value: f64) {
        for (axis, x) in self.axes.iter_mut().zip(p) {
            axis.learn(x, value);
        }
    }

    /// Makes the density follow what was learnt.
    pub fn adapt(&mut self) {
        self.axes.iter_mut().for_each(Axis::adapt);
    }
}
