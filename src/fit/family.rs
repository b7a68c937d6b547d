//! A model with some of its parameters free, and the coordinates in which they are searched.

use crate::error::{Error, Result};
use crate::model::{Definition, Parameter, Scale};
use crate::optics::Brdf;

/// A parameter that may move inside a box.
///
/// `v = low + (high - low) / (1 + exp(-u))` for any real coordinate `u`, or the same of `ln v`: the search knows no
/// walls, and the value never leaves `[low, high]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Free {
    pub name: String,
    pub low: f64,
    pub high: f64,
    pub scale: Scale,
    /// Where a search starts looking.
    pub likely: [f64; 2],
}

/// Coordinates beyond this are at the end of the box to ten digits, and the search stops telling them apart.
const FARTHEST: f64 = 23.0;

impl Free {
    /// A parameter in `[low, high]`.
    ///
    /// # Errors
    /// `Error::Parameter` if the box is empty or not finite, or a logarithmic one is not positive.
    pub fn new(name: &str, low: f64, high: f64, scale: Scale) -> Result<Self> {
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(Error::parameter(
                format!("`{name}` cannot be free between {low} and {high}"),
                "give two finite bounds, the lower first",
            ));
        }
        if scale == Scale::Logarithmic && low <= 0.0 {
            return Err(Error::parameter(
                format!("`{name}` cannot be searched by ratios from {low}"),
                "give a lower bound above 0",
            ));
        }
        Ok(Free { name: name.to_owned(), low, high, scale, likely: [low, high] })
    }

    /// The box of a parameter of the library: its usual values and as much again on either side, fifty times as wide if
    /// it is spread by ratios, within what is allowed.
    fn of(p: &Parameter) -> Result<Self> {
        let [a, b] = p.usual;
        let (low, high) = match p.scale {
            Scale::Linear => (a - (b - a), b + (b - a)),
            Scale::Logarithmic => (a / 50.0, b * 50.0),
        };
        Ok(Free { likely: p.usual, ..Free::new(p.name, low.max(p.min), high.min(p.max), p.scale)? })
    }

    /// Value at `share` of the likely range, 0 to 1.
    pub fn likely_at(&self, share: f64) -> f64 {
        let [a, b] = self.likely;
        match self.scale {
            Scale::Linear => a + share * (b - a),
            Scale::Logarithmic => a * (b / a).powf(share),
        }
    }

    fn ends(&self) -> [f64; 2] {
        match self.scale {
            Scale::Linear => [self.low, self.high],
            Scale::Logarithmic => [self.low.ln(), self.high.ln()],
        }
    }

    /// Value at the coordinate `u`.
    pub fn value(&self, u: f64) -> f64 {
        self.at_share(1.0 / (1.0 + (-u.clamp(-FARTHEST, FARTHEST)).exp()))
    }

    /// Value at `share` of the box, 0 to 1.
    pub fn at_share(&self, share: f64) -> f64 {
        let [a, b] = self.ends();
        let x = a + (b - a) * share;
        let v = if self.scale == Scale::Logarithmic { x.exp() } else { x };
        v.clamp(self.low, self.high)
    }

    /// Coordinate of a value; values outside the box count as its ends.
    pub fn coordinate(&self, value: f64) -> f64 {
        let [a, b] = self.ends();
        let x = value.clamp(self.low, self.high);
        let x = if self.scale == Scale::Logarithmic { x.ln() } else { x };
        ((x - a) / (b - x)).ln().clamp(-FARTHEST, FARTHEST)
    }

    /// `dv / du` at the coordinate `u`.
    pub fn derivative(&self, u: f64) -> f64 {
        let [a, b] = self.ends();
        let share = 1.0 / (1.0 + (-u.clamp(-FARTHEST, FARTHEST)).exp());
        let slope = (b - a) * share * (1.0 - share);
        if self.scale == Scale::Logarithmic { slope * self.value(u) } else { slope }
    }

    /// Whether the coordinate `u` lies within a millionth of an end of the box.
    pub fn is_at_end(&self, u: f64) -> bool {
        u.abs() > 1e6f64.ln()
    }
}

type Build<'a> = dyn Fn(&[f64]) -> Result<Box<dyn Brdf>> + Send + Sync + 'a;

/// A model as a function of its free parameters.
pub struct Family<'a> {
    free: Vec<Free>,
    build: Box<Build<'a>>,
}

impl<'a> Family<'a> {
    /// `build` makes the model from one value per free parameter, in their order; it may refuse a combination.
    pub fn new(free: Vec<Free>, build: impl Fn(&[f64]) -> Result<Box<dyn Brdf>> + Send + Sync + 'a) -> Self {
        Family { free, build: Box::new(build) }
    }

    /// The parameters of `definition` that have no value yet (see [`Definition::free`]) and those named in `also`, at
    /// `wavelength` \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` if a name in `also` is not a parameter, or nothing is free.
    pub fn of_model(definition: &Definition, also: &[String], wavelength: f64) -> Result<Family<'static>> {
        let entry = definition.entry();
        // A parameter that is free counts as given when its other spellings are looked for.
        let mut told = definition.clone();
        let mut chosen = Vec::new();
        for name in also {
            let parameter = entry.parameters.iter().find(|p| p.name == name).ok_or_else(|| {
                entry.error(format!("there is no parameter `{name}` to free (it has: {})", entry.keys()))
            })?;
            told.set(parameter.name, parameter.usual_at(0.5))?;
            chosen.push(parameter);
        }
        chosen.extend(told.free());
        // In the order of the model's own list, each once.
        let free: Vec<&Parameter> =
            entry.parameters.iter().filter(|p| chosen.iter().any(|c| c.name == p.name)).collect();
        if free.is_empty() {
            return Err(entry.error("every parameter has a value, so there is nothing to find: leave one out"));
        }
        let names: Vec<&'static str> = free.iter().map(|p| p.name).collect();
        let boxes = free.iter().map(|p| Free::of(p)).collect::<Result<_>>()?;
        let definition = definition.clone();
        Ok(Family::new(boxes, move |values| {
            let mut set = definition.clone();
            names.iter().zip(values).try_for_each(|(name, &v)| set.set(name, v))?;
            set.build(wavelength)
        }))
    }

    /// The free parameters.
    pub fn free(&self) -> &[Free] {
        &self.free
    }

    /// Values at the coordinates `u`.
    pub fn values(&self, u: &[f64]) -> Vec<f64> {
        self.free.iter().zip(u).map(|(f, &u)| f.value(u)).collect()
    }

    /// The model at the given values.
    ///
    /// # Errors
    /// What the model says about a combination it cannot be.
    pub fn model(&self, values: &[f64]) -> Result<Box<dyn Brdf>> {
        (self.build)(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_of_a_model_frees_what_has_no_value() {
        let names = |text: &str, also: &[&str]| -> Vec<String> {
            let also: Vec<String> = also.iter().map(|s| (*s).to_owned()).collect();
            let family = Family::of_model(&Definition::parse(text).unwrap(), &also, 550e-9).unwrap();
            family.free().iter().map(|f| f.name.clone()).collect()
        };
        assert_eq!(names("ward", &[]), ["rho_s", "alpha", "rho_d"]);
        assert_eq!(names("ward:rho_d=0", &["alpha_y", "alpha_x"]), ["rho_s", "alpha_x", "alpha_y"]);
        assert_eq!(names("ward:rho_s=0.1,alpha=0.1", &["alpha"]), ["alpha", "rho_d"]);
        let full = Definition::parse("lambert:rho=0.5").unwrap();
        assert!(Family::of_model(&full, &[], 550e-9).is_err());
        assert!(Family::of_model(&full, &["gloss".to_owned()], 550e-9).is_err());
        let family = Family::of_model(&Definition::parse("lambert").unwrap(), &[], 550e-9).unwrap();
        assert_eq!(family.model(&[0.3]).unwrap().albedo(0.2), 0.3);
    }

    #[test]
    fn coordinates_and_values_are_inverse_and_stay_in_the_box() {
        let boxes =
            [Free::new("a", -2.0, 5.0, Scale::Linear).unwrap(), Free::new("b", 1e-4, 2.0, Scale::Logarithmic).unwrap()];
        for free in &boxes {
            for share in [1e-6, 0.1, 0.5, 0.999] {
                let v = free.at_share(share);
                let u = free.coordinate(v);
                assert!((free.value(u) - v).abs() < 1e-12 * v.abs().max(1.0));
                let h = 1e-3;
                let slope = (free.value(u + h) - free.value(u - h)) / (2.0 * h);
                assert!((slope / free.derivative(u) - 1.0).abs() < 1e-6);
            }
            for u in [-1e300, -30.0, 30.0, 1e300] {
                let v = free.value(u);
                assert!(v >= free.low && v <= free.high && free.is_at_end(u));
            }
            assert!(free.coordinate(free.low).is_finite() && free.coordinate(1e9).is_finite());
        }
        assert!(Free::new("c", 0.0, 1.0, Scale::Logarithmic).is_err());
        assert!(Free::new("c", 1.0, 1.0, Scale::Linear).is_err());
        assert!(Free::new("c", 0.0, f64::INFINITY, Scale::Linear).is_err());
    }
}
