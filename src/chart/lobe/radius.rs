//! How far from the foot a value of `f_r` is drawn.

/// The user's choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RadiusScale {
    /// Linear, unless lobes of one page differ too much in height, or one is too narrow to be seen.
    Auto,
    /// Proportional to `f_r`.
    Linear,
    /// Proportional to the decades above a floor, `decades` below the highest.
    Logarithmic { decades: f64 },
}

/// Radius as a share of the panel's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radius {
    /// The value at the rim [1/sr].
    pub top: f64,
    /// Decades from rim to foot, `None` if linear.
    pub decades: Option<f64>,
}

/// Peaks of lobes further apart than this would hide the lower one.
const APART: f64 = 10.0;
/// A slice whose peak is this much above its median is a spike.
const SPIKE: f64 = 1e3;
/// Decades shown if the choice is left to us.
const DECADES: f64 = 5.0;

impl Radius {
    /// A scale on which all slices fit.
    pub fn new(scale: RadiusScale, cuts: &[Vec<(f64, f64)>]) -> Self {
        let peak = |cut: &Vec<(f64, f64)>| cut.iter().fold(0.0f64, |m, p| m.max(p.1));
        let peaks: Vec<f64> = cuts.iter().map(peak).filter(|p| *p > 0.0 && p.is_finite()).collect();
        let highest = peaks.iter().copied().fold(0.0, f64::max);
        if highest <= 0.0 {
            return Radius { top: 1.0, decades: None };
        }
        let lowest = peaks.iter().copied().fold(f64::INFINITY, f64::min);
        let spiky = cuts.iter().any(|cut| {
            // Over the even steps only: the crowd near the mirror direction is not the median.
            let mut values: Vec<f64> = cut.iter().map(|p| p.1).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 4).is_some_and(|m| peak(cut) > SPIKE * m)
        });
        let decades = match scale {
            RadiusScale::Linear => None,
            RadiusScale::Logarithmic { decades } => Some(decades.clamp(1.0, 12.0)),
            RadiusScale::Auto => (highest > APART * lowest || spiky).then_some(DECADES),
        };
        match decades {
            // Whole decades, so that circles are powers of ten.
            Some(d) => Radius { top: 10f64.powf(highest.log10().ceil()), decades: Some(d) },
            None => Radius { top: highest, decades: None },
        }
    }

    /// Share of the panel's radius, 0 to 1.
    pub fn share(&self, f: f64) -> f64 {
        let share = match self.decades {
            None => f / self.top,
            Some(d) if f > 0.0 => 1.0 + (f / self.top).log10() / d,
            Some(_) => 0.0,
        };
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Values of the circles, with their labels.
    pub fn circles(&self) -> Vec<(f64, String)> {
        match self.decades {
            None => {
                let step = round_step(self.top / 4.0);
                let n = (self.top / step + 1e-9) as usize;
                (1..=n).map(|k| k as f64 * step).map(|v| (v, digits(v))).collect()
            }
            Some(d) => {
                let exponent = self.top.log10().round() as i32;
                (0..d.floor() as i32).map(|k| 10f64.powi(exponent - k)).map(|v| (v, power(v))).collect()
            }
        }
    }
}

/// Three digits, or a power of ten where those would be long.
pub fn digits(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    let exponent = v.abs().log10().floor() as i32;
    if (-3..4).contains(&exponent) {
        let decimals = (2 - exponent).max(0) as usize;
        let text = format!("{v:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{v:.2e}")
    }
}

fn power(v: f64) -> String {
    let e = v.log10().round() as i32;
    if (-3..4).contains(&e) { digits(v) } else { format!("1e{e}") }
}

/// The nearest of 1, 2, 5 times a power of ten at or below `step`.
fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [5.0, 2.0, 1.0].iter().map(|m| m * power).find(|s| *s <= step * (1.0 + 1e-9)).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_fit_all_lobes() {
        let flat = vec![(0.0, 0.3), (0.1, 0.3), (0.2, 0.3), (0.3, 0.3)];
        let spike = vec![(0.0, 0.0), (0.1, 1e-9), (0.2, 700.0), (0.3, 0.0)];
        let linear = Radius::new(RadiusScale::Auto, std::slice::from_ref(&flat));
        assert_eq!((linear.decades, linear.share(0.3), linear.share(0.15)), (None, 1.0, 0.5));
        let log = Radius::new(RadiusScale::Auto, &[flat, spike]);
        assert_eq!((log.top, log.decades), (1000.0, Some(5.0)));
        assert!((log.share(10.0) - 0.6).abs() < 1e-12 && log.share(0.0) == 0.0 && log.share(1e-9) == 0.0);
        assert_eq!(log.circles().iter().map(|c| c.1.as_str()).collect::<Vec<_>>(), ["1000", "100", "10", "1", "0.1"]);
        let nothing = Radius::new(RadiusScale::Auto, &[vec![(0.0, 0.0)]]);
        assert_eq!(nothing.share(0.0), 0.0);
    }

    #[test]
    fn numbers_are_short() {
        for (v, text) in
            [(0.31749, "0.317"), (12.0, "12"), (0.5, "0.5"), (1234.0, "1234"), (1.5e6, "1.50e6"), (0.0, "0")]
        {
            assert_eq!(digits(v), text);
        }
    }
}
