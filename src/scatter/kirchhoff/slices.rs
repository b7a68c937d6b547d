//! At which `v_z` the spectrum of a map is taken, and how the values between are joined.

/// Step in `ln v_z`; four slices meet in a cubic.
const STEP: f64 = 0.2;

/// Equal steps of `ln v_z`.
#[derive(Debug, Clone, Copy)]
pub struct Slices {
    /// `ln v_z` of the first, `v_z` in 1/m.
    first: f64,
    step: f64,
    count: usize,
}

impl Slices {
    /// At least four slices that span `v_z` [1/m] from `lowest` to `highest`.
    pub fn spanning(lowest: f64, highest: f64) -> Self {
        let (first, last) = (lowest.ln(), highest.ln());
        let count = (((last - first) / STEP).ceil() as usize + 1).max(4);
        Slices { first, step: (last - first) / (count - 1) as f64, count }
    }

    /// Number of slices.
    pub fn count(&self) -> usize {
        self.count
    }

    /// `v_z` of a slice [1/m].
    pub fn v_z(&self, slice: usize) -> f64 {
        (self.first + slice as f64 * self.step).exp()
    }

    /// The slice nearest to `v_z`.
    pub fn nearest(&self, v_z: f64) -> usize {
        ((v_z.ln() - self.first) / self.step).round().clamp(0.0, (self.count - 1) as f64) as usize
    }

    /// First of four slices and their weights (cubic of Lagrange); beyond the ends the end's value holds.
    pub fn weights(&self, v_z: f64) -> (usize, [f64; 4]) {
        let x = ((v_z.ln() - self.first) / self.step).clamp(0.0, (self.count - 1) as f64);
        let i = (x as usize).clamp(1, self.count - 3);
        let t = x - i as f64;
        let w = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        (i - 1, w)
    }

    /// Least and largest `v_z` at which a slice has weight.
    pub fn support(&self, slice: usize) -> [f64; 2] {
        let low = if slice < 4 { 0.0 } else { self.v_z(slice - 2) };
        [low, if slice + 4 < self.count { self.v_z(slice + 2) } else { f64::INFINITY }]
    }

    /// Weight of one slice at `v_z`; zero where it is not among the four.
    pub fn weight(&self, slice: usize, v_z: f64) -> f64 {
        let (first, w) = self.weights(v_z);
        slice.checked_sub(first).and_then(|k| w.get(k)).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_v_z_are_joined() {
        let slices = Slices::spanning(2e6, 2.3e7);
        for power in [-2i32, 0, 1, 2] {
            for k in 0..100 {
                let v_z = 2e6 * (1.0 + 0.105 * f64::from(k));
                let outside = |s: &usize| v_z < slices.support(*s)[0] || v_z > slices.support(*s)[1];
                assert!((0..slices.count()).filter(outside).all(|s| slices.weight(s, v_z).abs() < 1e-12));
                let joined: f64 = (0..slices.count()).map(|s| slices.weight(s, v_z) * slices.v_z(s).powi(power)).sum();
                assert!((joined / v_z.powi(power) - 1.0).abs() < 2e-3, "{power} {v_z}: {joined}");
            }
        }
        assert_eq!(slices.nearest(2e6), 0);
        assert_eq!(slices.nearest(1e9), slices.count() - 1);
    }
}
