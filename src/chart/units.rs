//! Units that make numbers readable.

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub name: &'static str,
    /// Metres.
    pub size: f64,
}

const UNITS: [Unit; 5] = [
    Unit { name: "pm", size: 1e-12 },
    Unit { name: "nm", size: 1e-9 },
    Unit { name: "\u{b5}m", size: 1e-6 },
    Unit { name: "mm", size: 1e-3 },
    Unit { name: "m", size: 1.0 },
];

impl Unit {
    /// The largest unit of which `length` \[m\] holds at least `fewest`; picometres below all of them.
    pub fn with(length: f64, fewest: f64) -> Unit {
        let fitting = UNITS.iter().rev().find(|u| length.abs() >= fewest * u.size * (1.0 - 1e-9));
        *fitting.unwrap_or(&UNITS[0])
    }
}

/// A length \[m\] with three or four digits and its unit.
pub fn length(metres: f64) -> String {
    if metres == 0.0 {
        return "0 nm".to_owned();
    }
    let unit = Unit::with(metres, 1.0);
    format!("{} {}", digits(metres / unit.size), unit.name)
}

/// Four significant digits, as a decimal number where it is not too long.
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    match magnitude {
        -4..=5 => format!("{value:.*}", (3 - magnitude).clamp(0, 7) as usize),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_for_people() {
        for (metres, text) in [
            (77.193e-9, "77.19 nm"),
            (-1.5e-6, "-1.500 \u{b5}m"),
            (0.0, "0 nm"),
            (3.3e-13, "0.3300 pm"),
            (0.0502, "50.20 mm"),
        ] {
            assert_eq!(length(metres), text);
        }
        assert_eq!(digits(8.9e-5), "8.900e-5");
        assert_eq!(digits(0.062_14), "0.06214");
        assert_eq!(Unit::with(0.9e-6, 0.5).name, "\u{b5}m");
    }
}
