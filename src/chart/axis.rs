//! Scales and ticks: where a number lies on an axis and which round numbers to print.

/// Linear or logarithmic axis between two values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    pub logarithmic: bool,
    /// Labelled values, with a grid line each.
    pub ticks: Vec<f64>,
    /// Unlabelled values between, with a fainter line.
    pub minor: Vec<f64>,
}

impl Axis {
    /// From 0 to a round number above `highest`, with about `wanted` ticks.
    ///
    /// A `highest` that is not a positive number gives the axis 0 to 1.
    pub fn from_zero(highest: f64, wanted: usize) -> Self {
        let highest = if highest > 0.0 && highest.is_finite() { highest } else { 1.0 };
        let step = round_step(highest / wanted.max(1) as f64);
        let count = (highest / step - 1e-9).ceil().max(1.0);
        let ticks = (0..=count as usize).map(|k| k as f64 * step).collect();
        Axis { low: 0.0, high: count * step, logarithmic: false, ticks, minor: Vec::new() }
    }

    /// Linear axis over `lowest` to `highest`, ending at multiples of a round step outside them, with about `wanted` ticks.
    pub fn linear(lowest: f64, highest: f64, wanted: usize) -> Self {
        let step = round_step((highest - lowest) / wanted.max(1) as f64);
        let (first, last) = ((lowest / step).floor() as i64, (highest / step).ceil() as i64);
        let value = |k: i64| if step < 1.0 { k as f64 / (1.0 / step).round() } else { k as f64 * step };
        let ticks = (first..=last).map(value).collect();
        Axis { low: value(first), high: value(last), logarithmic: false, ticks, minor: Vec::new() }
    }

    /// Logarithmic axis over `lowest` to `highest`, both positive, ending at numbers of the series 1, 2, 5 outside them.
    pub fn logarithmic(lowest: f64, highest: f64) -> Self {
        let series = |mantissas: &[f64]| -> Vec<f64> {
            let (first, last) = (lowest.log10().floor() as i32 - 1, highest.log10().ceil() as i32 + 1);
            // Division keeps negative powers exact: 2 / 10, not 2 * 0.1.
            let power = |m: f64, e: i32| if e < 0 { m / 10f64.powi(-e) } else { m * 10f64.powi(e) };
            (first..=last).flat_map(|e| mantissas.iter().map(move |&m| power(m, e))).collect()
        };
        let one_two_five = series(&[1.0, 2.0, 5.0]);
        // A little air, so that no marker sits on the frame.
        let low = one_two_five.iter().copied().filter(|&v| v <= lowest / 1.05).fold(lowest / 2.0, f64::max);
        let high = one_two_five.iter().copied().filter(|&v| v >= highest * 1.05).fold(highest * 2.5, f64::min);
        // Over many decades only the powers of ten have room for a label.
        let labelled = if high / low > 3e3 { series(&[1.0]) } else { one_two_five };
        let within = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
        let ticks: Vec<f64> = labelled.into_iter().filter(within).collect();
        let minor = series(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        let minor = minor.into_iter().filter(|v| within(v) && !ticks.contains(v)).collect();
        Axis { low, high, logarithmic: true, ticks, minor }
    }

    /// Position of `value` as a share of the axis' length.
    pub fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Labels of the ticks: as many decimals as the smallest step needs, the same for all of a linear axis.
    pub fn labels(&self) -> Vec<String> {
        let decimals = |v: f64| if v > 0.0 { (-v.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
        let step = if self.ticks.len() > 1 { self.ticks[1] - self.ticks[0] } else { self.high };
        let shared = decimals(step * (1.0 + 1e-9));
        let digits = |v: f64| if self.logarithmic { decimals(v * (1.0 + 1e-9)) } else { shared };
        self.ticks.iter().map(|&v| format!("{v:.*}", digits(v))).collect()
    }
}

/// Smallest of 1, 2, 5 times a power of ten that is at least `step`.
fn round_step(step: f64) -> f64 {
    let exponent = step.log10().floor() as i32;
    let power = |m: f64| if exponent < 0 { m / 10f64.powi(-exponent) } else { m * 10f64.powi(exponent) };
    [1.0, 2.0, 5.0].map(power).into_iter().find(|&s| s >= step * (1.0 - 1e-9)).unwrap_or_else(|| power(10.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_axes_end_at_round_numbers() {
        for (highest, end, label) in [
            (98.9, 100.0, "100"),
            (100.0, 100.0, "100"),
            (103.0, 120.0, "120"),
            (0.37, 0.4, "0.4"),
            (1820.0, 2000.0, "2000"),
        ] {
            let axis = Axis::from_zero(highest, 6);
            assert_eq!(axis.high, end);
            assert_eq!(axis.labels().last().unwrap(), label);
            assert_eq!(axis.ticks[0], 0.0);
            assert!(axis.ticks.len() <= 8);
        }
        for odd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Axis::from_zero(odd, 6).high, 1.0);
        }
    }

    #[test]
    fn linear_axes_need_not_start_at_zero() {
        let axis = Axis::linear(200.3, 204.1, 6);
        assert_eq!((axis.low, axis.high), (200.0, 205.0));
        assert_eq!(axis.labels().join(" "), "200 201 202 203 204 205");
        assert_eq!(Axis::linear(0.11, 0.143, 6).labels().join(" "), "0.11 0.12 0.13 0.14 0.15");
    }

    #[test]
    fn logarithmic_axes_enclose_the_data() {
        let axis = Axis::logarithmic(3.0, 805.0);
        assert_eq!((axis.low, axis.high), (2.0, 1000.0));
        assert_eq!(axis.labels(), ["2", "5", "10", "20", "50", "100", "200", "500", "1000"]);
        assert!((axis.share(2.0)).abs() < 1e-12 && (axis.share(1000.0) - 1.0).abs() < 1e-12);
        assert_eq!(Axis::logarithmic(0.02, 0.4).labels(), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]);
        let wide = Axis::logarithmic(0.5, 9000.0);
        assert_eq!(wide.labels(), ["1", "10", "100", "1000", "10000"]);
        assert!(!wide.minor.is_empty());
    }
}
