//! What a model can be told: numbers with unit, range and default; words out of a list.

use crate::math::quantity;

/// What the number of a [`Parameter`] measures. Values are SI inside the library; text carries the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A pure number.
    None,
    /// Metres inside, written `0.2um`.
    Length,
    /// Radians inside, written `20deg` or `0.35rad`.
    Angle,
    /// 1/sr inside and in text.
    PerSteradian,
}

impl Unit {
    /// Name of the unit text is printed in; empty for a pure number.
    pub fn name(self) -> &'static str {
        match self {
            Unit::None => "",
            Unit::Length => "um",
            Unit::Angle => "deg",
            Unit::PerSteradian => "1/sr",
        }
    }

    /// Printed units per SI unit.
    fn scale(self) -> f64 {
        match self {
            Unit::None | Unit::PerSteradian => 1.0,
            Unit::Length => 1e6,
            Unit::Angle => 180.0 / std::f64::consts::PI,
        }
    }

    /// Reads a value as text has it, to SI.
    ///
    /// # Errors
    /// What is wrong, to be put behind `key=value`.
    pub fn read(self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        match self {
            Unit::None | Unit::PerSteradian => text.parse().map_err(|_| "is not a number".to_owned()),
            Unit::Length => quantity::length(text).map_err(|e| format!("is not a length: {e}")),
            // 0.3 could be either: degrees in our text, radians in many papers.
            Unit::Angle => match text.parse::<f64>() {
                Ok(0.0) => Ok(0.0),
                Ok(_) => Err("needs its unit: write deg or rad behind it".to_owned()),
                Err(_) => quantity::angle(text).map_err(|e| format!("is not an angle: {e}")),
            },
        }
    }

    /// Writes an SI value so that [`Unit::read`] finds it again within 1e-12 of itself.
    pub fn write(self, value: f64) -> String {
        match self {
            Unit::None | Unit::PerSteradian => format!("{value}"),
            Unit::Length => format!("{}um", twelve_digits(value * self.scale())),
            Unit::Angle => format!("{}deg", twelve_digits(value * self.scale())),
        }
    }
}

/// The number without the noise that a change of unit leaves in its last digits.
fn twelve_digits(value: f64) -> f64 {
    format!("{value:.12e}").parse().unwrap_or(value)
}

/// How values spread over a range: what a fit steps along, and what random trials are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Equal ratios are equal steps; the lower usual value is above 0.
    Logarithmic,
}

/// What it means that a parameter is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Absent {
    /// An error.
    Refused,
    /// It has this value.
    Is(f64),
    /// It is said another way: by this parameter.
    Said(&'static str),
    /// The model is simpler without it (a second lobe, an absorption).
    Fine,
}

/// One parameter of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Key in `key=value`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    pub unit: Unit,
    /// Smallest allowed value, SI.
    pub min: f64,
    /// Largest allowed value, SI.
    pub max: f64,
    /// Where real materials lie: where a fit starts and random trials are drawn, SI.
    pub usual: [f64; 2],
    pub scale: Scale,
    /// What happens if the key is left out.
    pub absent: Absent,
}

impl Parameter {
    /// A pure number in `[min, max]`, linear, that must be given.
    pub const fn number(name: &'static str, meaning: &'static str, min: f64, max: f64) -> Self {
        let usual = [min, max];
        Parameter { name, meaning, unit: Unit::None, min, max, usual, scale: Scale::Linear, absent: Absent::Refused }
    }

    /// The same with a unit; its numbers are SI.
    pub const fn unit(self, unit: Unit) -> Self {
        Parameter { unit, ..self }
    }

    /// The same with usual values spread evenly.
    pub const fn usual(self, low: f64, high: f64) -> Self {
        Parameter { usual: [low, high], ..self }
    }

    /// The same with usual values spread by equal ratios.
    pub const fn decades(self, low: f64, high: f64) -> Self {
        Parameter { usual: [low, high], scale: Scale::Logarithmic, ..self }
    }

    /// The same with a default.
    pub const fn or(self, default: f64) -> Self {
        Parameter { absent: Absent::Is(default), ..self }
    }

    /// The same as another way to say `name`.
    pub const fn instead_of(self, name: &'static str) -> Self {
        Parameter { absent: Absent::Said(name), ..self }
    }

    /// The same, and the model is simpler without it.
    pub const fn optional(self) -> Self {
        Parameter { absent: Absent::Fine, ..self }
    }

    /// Value if the key is left out.
    pub fn default(&self) -> Option<f64> {
        match self.absent {
            Absent::Is(value) => Some(value),
            _ => None,
        }
    }

    /// Whether `value` is allowed; a NaN or an infinity never is.
    pub fn allows(&self, value: f64) -> bool {
        value >= self.min && value <= self.max && value.is_finite()
    }

    /// `0 to 1`, `0 um to 10 um`, or `any` for an unbounded side, as printed to the user.
    pub fn range(&self) -> String {
        let print = |v: f64| {
            let number = twelve_digits(v * self.unit.scale());
            if self.unit.name().is_empty() { format!("{number}") } else { format!("{number} {}", self.unit.name()) }
        };
        match (self.min.is_finite(), self.max.is_finite()) {
            (true, true) => format!("{} to {}", print(self.min), print(self.max)),
            (true, false) => format!("{} or more", print(self.min)),
            (false, true) => format!("{} or less", print(self.max)),
            (false, false) => "any".to_owned(),
        }
    }

    /// The value a share `u` in `[0, 1]` of the way through the usual range.
    pub fn usual_at(&self, u: f64) -> f64 {
        let [low, high] = self.usual;
        match self.scale {
            Scale::Linear => low + u * (high - low),
            Scale::Logarithmic => low * (high / low).powf(u),
        }
    }
}

/// A word a model can be told: one out of a list, or free text such as the name of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// Key in `key=value`.
    pub name: &'static str,
    /// What it chooses.
    pub meaning: &'static str,
    /// The words, the default first; empty for free text.
    pub options: &'static [&'static str],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_and_written() {
        assert!((Unit::Length.read("0.2um").unwrap() - 2e-7).abs() < 1e-20);
        assert!((Unit::Angle.read("20deg").unwrap() - 20f64.to_radians()).abs() < 1e-15);
        assert!((Unit::Angle.read("0.25rad").unwrap() - 0.25).abs() < 1e-15);
        assert_eq!(Unit::Length.write(2e-7), "0.2um");
        assert_eq!(Unit::Angle.write(20f64.to_radians()), "20deg");
        for (unit, value) in [(Unit::Length, 1.234567e-7), (Unit::Angle, 0.7), (Unit::None, 1.0 / 3.0)] {
            let again = unit.read(&unit.write(value)).unwrap();
            assert!((again / value - 1.0).abs() < 1e-12);
        }
        for (unit, text) in [(Unit::Length, "0.2"), (Unit::Angle, "20"), (Unit::Angle, "20um"), (Unit::None, "1um")] {
            assert!(unit.read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ranges_speak_the_unit_of_the_text() {
        let p = Parameter::number("tau", "correlation length", 1e-8, 1e-3).unit(Unit::Length);
        assert_eq!(p.range(), "0.01 um to 1000 um");
        assert!(!p.allows(f64::NAN) && !p.allows(0.0) && p.allows(1e-3));
        let q = p.decades(1e-6, 1e-4);
        assert!((q.usual_at(0.5) - 1e-5).abs() < 1e-18);
    }
}
