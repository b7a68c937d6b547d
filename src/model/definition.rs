//! A model with its parameters: read from `name:key=value,...`, set number by number, built at a wavelength.

use super::bounded::Bounded;
use super::parameter::{Absent, Parameter, Unit, Word};
use super::registry::{Entry, entry};
use crate::error::{Error, Result};
use crate::optics::{Brdf, Material};

/// A model and what it has been told; numbers are checked as they come, the whole when it is built.
///
/// ```
/// use asperity::model::Definition;
///
/// let mut ward = Definition::parse("ward:rho_s=0.1")?;
/// let free: Vec<&str> = ward.free().iter().map(|p| p.name).collect();
/// assert_eq!(free, ["alpha", "rho_d"]);
/// ward.set("alpha", 0.05)?;
/// assert_eq!(ward.to_string(), "ward:rho_s=0.1,alpha=0.05");
/// let brdf = ward.build(550e-9)?;
/// # Ok::<(), asperity::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    entry: &'static Entry,
    values: Vec<(&'static str, f64)>,
    words: Vec<(&'static str, String)>,
    material: Option<String>,
    wavelength: Option<f64>,
    bounded: bool,
}

/// Key that every spectral model understands.
const WAVELENGTH: Parameter =
    Parameter::number("wavelength", "wavelength of the light", 1e-7, 2e-5).unit(Unit::Length).optional();

impl Definition {
    /// A model that has been told nothing.
    pub fn new(entry: &'static Entry) -> Self {
        let (values, words) = (Vec::new(), Vec::new());
        Definition { entry, values, words, material: None, wavelength: None, bounded: false }
    }

    /// Reads `name` or `name:key=value,...`. What is missing may be [`Definition::set`] later.
    ///
    /// # Errors
    /// `Error::Parameter` naming the model, the parameter, its range, and an example that works.
    pub fn parse(text: &str) -> Result<Self> {
        let mut definition = Definition::new(entry(text)?);
        let pairs = text.split_once(':').map_or("", |(_, rest)| rest);
        for pair in pairs.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) =
                pair.split_once('=').ok_or_else(|| definition.error(format!("`{pair}` is not key=value")))?;
            definition.read(key.trim(), value.trim())?;
        }
        Ok(definition)
    }

    fn read(&mut self, key: &str, value: &str) -> Result<()> {
        let twice = |there: bool| if there { Err(self.error(format!("`{key}` is given twice"))) } else { Ok(()) };
        let number = |unit: Unit| unit.read(value).map_err(|e| self.error(format!("`{key}={value}` {e}")));
        if let Some(parameter) = self.entry.parameters.iter().find(|p| p.name == key) {
            twice(self.get(key).is_some())?;
            let value = number(parameter.unit)?;
            return self.set(key, value);
        }
        if let Some(word) = self.entry.words.iter().find(|w| w.name == key) {
            twice(self.words.iter().any(|(name, _)| *name == key))?;
            if !(word.options.is_empty() || word.options.contains(&value)) {
                return Err(self.error(format!("`{key}={value}` is not one of {}", word.options.join(", "))));
            }
            self.words.push((word.name, value.to_owned()));
            return Ok(());
        }
        match key {
            "material" if self.entry.interface => {
                twice(self.material.is_some())?;
                // Names that depend on the wavelength are known over the visible range.
                Material::parse(value, 550e-9)?;
                self.material = Some(value.to_owned());
            }
            "wavelength" if self.entry.is_spectral() => {
                twice(self.wavelength.is_some())?;
                let value = number(Unit::Length)?;
                self.check(&WAVELENGTH, value)?;
                self.wavelength = Some(value);
            }
            "bounded" => match value {
                "true" => self.bounded = true,
                "false" => self.bounded = false,
                _ => return Err(self.error(format!("`bounded={value}` is neither true nor false"))),
            },
            _ => {
                let keys = self.entry.keys();
                return Err(self.error(format!("there is no parameter `{key}` (it has: {keys})")));
            }
        }
        Ok(())
    }

    /// The model.
    pub fn entry(&self) -> &'static Entry {
        self.entry
    }

    /// Value of `name`, SI, if it has been given.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(n, _)| *n == name).map(|&(_, value)| value)
    }

    /// The word of `key`, else the first of its options; `None` for free text that was not given.
    pub fn word(&self, key: &str) -> Option<&str> {
        let given = self.words.iter().find(|(name, _)| *name == key).map(|(_, word)| word.as_str());
        let first = |w: &Word| w.options.first().copied();
        given.or_else(|| self.entry.words.iter().find(|w| w.name == key).and_then(first))
    }

    /// Gives `name` the value, SI.
    ///
    /// # Errors
    /// `Error::Parameter` if there is no such parameter or the value is outside its range.
    pub fn set(&mut self, name: &str, value: f64) -> Result<()> {
        let found = self.entry.parameters.iter().find(|p| p.name == name);
        let parameter = found.ok_or_else(|| self.error(format!("there is no parameter `{name}`")))?;
        self.check(parameter, value)?;
        match self.values.iter_mut().find(|(n, _)| *n == name) {
            Some(slot) => slot.1 = value,
            None => self.values.push((parameter.name, value)),
        }
        Ok(())
    }

    /// Whether `f_r(wi, wo) = f_r(wo, wi)`.
    pub fn is_reciprocal(&self) -> bool {
        let form = self.words.iter().find(|(name, _)| *name == "form").map(|(_, word)| word.as_str());
        self.entry.not_reciprocal.is_none_or(|form_without| form != Some(form_without))
    }

    /// Scales the model down where it would reflect more than it receives (see [`Bounded`]).
    pub fn set_bounded(&mut self, bounded: bool) {
        self.bounded = bounded;
    }

    /// Parameters that still have to be given or have only their default: what a fit may vary. Other ways to say the
    /// same and optional parts are not among them.
    pub fn free(&self) -> Vec<&'static Parameter> {
        let given = |p: &Parameter| self.get(p.name).is_some();
        let replaced = |name: &str| {
            self.entry.parameters.iter().any(|p| given(p) && matches!(p.absent, Absent::Said(n) if n == name))
        };
        let interface_known = self.material.is_some();
        self.entry
            .parameters
            .iter()
            .filter(|p| matches!(p.absent, Absent::Refused | Absent::Is(_)))
            .filter(|p| !(given(p) || replaced(p.name) || interface_known && p.name == "n"))
            .collect()
    }

    /// The BRDF; `wavelength` \[m\] counts unless the definition has its own.
    ///
    /// # Errors
    /// `Error::Parameter` for a parameter that is missing, or several that contradict each other.
    pub fn build(&self, wavelength: f64) -> Result<Box<dyn Brdf>> {
        let values = Values { definition: self, wavelength: self.wavelength.unwrap_or(wavelength) };
        if self.entry.is_spectral() {
            self.check(&WAVELENGTH, values.wavelength)?;
        }
        let brdf = (self.entry.build)(&values)?;
        Ok(if self.bounded { Box::new(Bounded::new(brdf)) } else { brdf })
    }

    fn check(&self, parameter: &Parameter, value: f64) -> Result<()> {
        if parameter.allows(value) {
            return Ok(());
        }
        let (key, text) = (parameter.name, parameter.unit.write(value));
        Err(self.error(format!("`{key}={text}` is outside its range, {}", parameter.range())))
    }

    fn error(&self, what: impl std::fmt::Display) -> Error {
        self.entry.error(what)
    }
}

/// The text that [`Definition::parse`] reads.
impl std::fmt::Display for Definition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut pairs = Vec::new();
        for &(name, value) in &self.values {
            let unit = self.entry.parameters.iter().find(|p| p.name == name).map_or(Unit::None, |p| p.unit);
            pairs.push(format!("{name}={}", unit.write(value)));
        }
        pairs.extend(self.words.iter().map(|(name, word)| format!("{name}={word}")));
        pairs.extend(self.material.iter().map(|name| format!("material={name}")));
        pairs.extend(self.wavelength.map(|l| format!("wavelength={}", Unit::Length.write(l))));
        pairs.extend(self.bounded.then(|| "bounded=true".to_owned()));
        let colon = if pairs.is_empty() { "" } else { ":" };
        write!(f, "{}{colon}{}", self.entry.name, pairs.join(","))
    }
}

/// A definition at one wavelength, as the constructor of a model reads it.
#[derive(Debug)]
pub struct Values<'a> {
    definition: &'a Definition,
    /// Wavelength of the light \[m\].
    pub wavelength: f64,
}

impl Values<'_> {
    /// Value of `key` if it was given.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.definition.get(key)
    }

    /// Value of `key`, else its default.
    ///
    /// # Errors
    /// `Error::Parameter` if there is neither.
    pub fn required(&self, key: &str) -> Result<f64> {
        let default = || self.definition.entry.parameters.iter().find(|p| p.name == key).and_then(Parameter::default);
        self.get(key).or_else(default).ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    /// The word of `key`, else the first of its options; `None` for free text that was not given.
    pub fn word(&self, key: &str) -> Option<&str> {
        self.definition.word(key)
    }

    /// One value for both axes, or one each: either `both`, or `x` and `y`.
    ///
    /// # Errors
    /// `Error::Parameter` if neither or both ways are used.
    pub fn axes(&self, both: &str, x: &str, y: &str) -> Result<[f64; 2]> {
        match (self.get(both), self.get(x), self.get(y)) {
            (Some(a), None, None) => Ok([a, a]),
            (None, Some(x), Some(y)) => Ok([x, y]),
            _ => Err(self.error(format!("give either `{both}`, or both `{x}` and `{y}`"))),
        }
    }

    /// Roughness along x and y: either `alpha`, or both `alpha_x` and `alpha_y`.
    ///
    /// # Errors
    /// As [`Values::axes`].
    pub fn alpha(&self) -> Result<[f64; 2]> {
        self.axes("alpha", "alpha_x", "alpha_y")
    }

    /// `[rho_d, rho_s]` of a lobe over a diffuse floor.
    ///
    /// # Errors
    /// `Error::Parameter` if `rho_s` is missing or the two reflect more than all light.
    pub fn floor_and_lobe(&self) -> Result<[f64; 2]> {
        let (rho_d, rho_s) = (self.required("rho_d")?, self.required("rho_s")?);
        // A hair above 1 is the rounding of two numbers that a fit has put on the limit.
        if rho_d + rho_s > 1.0 + 1e-9 {
            return Err(self.error(format!("rho_d + rho_s = {} is more than 1", rho_d + rho_s)));
        }
        Ok([rho_d, rho_s])
    }

    /// The interface: `n`, `n` with `k`, or `material=NAME`.
    ///
    /// # Errors
    /// `Error::Parameter` if neither or both ways are used, or a clear material has n below 1.
    pub fn material(&self) -> Result<Material> {
        match (&self.definition.material, self.get("n"), self.get("k").filter(|&k| k > 0.0)) {
            (Some(name), None, None) => Material::parse(name, self.wavelength),
            (None, Some(n), Some(k)) => Ok(Material::Conductor { n, k }),
            (None, Some(n), None) if n >= 1.0 => Ok(Material::Dielectric { n }),
            (None, Some(n), None) => Err(self.error(format!("n={n} without k is below 1, the index of air"))),
            _ => Err(self.error("give the interface as `n`, as `n` and `k`, or as `material`")),
        }
    }

    /// An error of this model, with its example as advice.
    pub fn error(&self, what: impl std::fmt::Display) -> Error {
        self.definition.error(what)
    }
}
