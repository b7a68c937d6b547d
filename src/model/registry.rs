//! From `name:key=value,...` to a model: names, parameters and ranges are data, so the parser, the error
//! messages and the printed list of models cannot drift apart.

use super::MODELS;
use crate::error::{Error, Result};
use crate::optics::{Brdf, Material};

/// One parameter of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Key in `key=value`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// Unit as printed; empty for a pure number.
    pub unit: &'static str,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Value if the key is left out; `None` if the model decides (required, or one of several ways to say it).
    pub default: Option<f64>,
}

impl Parameter {
    /// A pure number in `[min, max]` without a default.
    pub const fn number(name: &'static str, meaning: &'static str, min: f64, max: f64) -> Self {
        Parameter { name, meaning, unit: "", min, max, default: None }
    }

    /// The same parameter with a default.
    pub const fn or(self, default: f64) -> Self {
        Parameter { default: Some(default), ..self }
    }

    /// `0 to 1`, or `any` for an unbounded side, as printed to the user.
    pub fn range(&self) -> String {
        match (self.min.is_finite(), self.max.is_finite()) {
            (true, true) => format!("{} to {}", self.min, self.max),
            (true, false) => format!("{} or more", self.min),
            (false, true) => format!("{} or less", self.max),
            (false, false) => "any".to_owned(),
        }
    }
}

/// One model as the registry knows it.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    pub name: &'static str,
    /// One line for a list.
    pub summary: &'static str,
    /// `f_r` in one line.
    pub formula: &'static str,
    /// Numeric parameters with ranges.
    pub parameters: &'static [Parameter],
    /// Whether `material=NAME` is understood beside `n` and `k`.
    pub takes_material: bool,
    /// Whether `f_r(wi, wo) = f_r(wo, wi)`.
    pub reciprocal: bool,
    /// What is known about `albedo <= 1`.
    pub energy: &'static str,
    /// Author, year, equation.
    pub source: &'static str,
    /// An example that parses.
    pub example: &'static str,
    /// Builds the model from checked arguments.
    pub build: fn(&Arguments) -> Result<Box<dyn Brdf>>,
}

impl Entry {
    fn keys(&self) -> String {
        let mut keys: Vec<&str> = self.parameters.iter().map(|p| p.name).collect();
        if self.takes_material {
            keys.push("material");
        }
        if keys.is_empty() { "none".to_owned() } else { keys.join(", ") }
    }

    fn error(&self, what: impl std::fmt::Display) -> Error {
        Error::parameter(format!("model `{}`: {what}", self.name), format!("write for example {}", self.example))
    }
}

/// The checked `key=value` pairs of one model.
#[derive(Debug)]
pub struct Arguments {
    entry: &'static Entry,
    values: Vec<(&'static str, f64)>,
    material: Option<Material>,
}

impl Arguments {
    fn read(entry: &'static Entry, text: &str, wavelength: f64) -> Result<Self> {
        let mut arguments = Arguments { entry, values: Vec::new(), material: None };
        for pair in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = pair.split_once('=').ok_or_else(|| entry.error(format!("`{pair}` is not key=value")))?;
            let (key, value) = (key.trim(), value.trim());
            if entry.takes_material && key == "material" {
                if arguments.material.is_some() {
                    return Err(entry.error("`material` is given twice"));
                }
                arguments.material = Some(Material::parse(value, wavelength)?);
                continue;
            }
            let Some(parameter) = entry.parameters.iter().find(|p| p.name == key) else {
                return Err(entry.error(format!("there is no parameter `{key}` (it has: {})", entry.keys())));
            };
            if arguments.get(parameter.name).is_some() {
                return Err(entry.error(format!("`{key}` is given twice")));
            }
            let number: f64 = value.parse().map_err(|_| entry.error(format!("`{key}={value}` is not a number")))?;
            // Written so that a NaN fails too; no parameter may be infinite.
            if !(number >= parameter.min && number <= parameter.max && number.is_finite()) {
                return Err(entry.error(format!("`{key}={value}` is outside its range, {}", parameter.range())));
            }
            arguments.values.push((parameter.name, number));
        }
        Ok(arguments)
    }

    /// Value of `key` if the user gave it.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.values.iter().find(|(name, _)| *name == key).map(|&(_, value)| value)
    }

    /// Value of `key`, else its default.
    ///
    /// # Errors
    /// `Error::Parameter` if there is neither.
    pub fn required(&self, key: &str) -> Result<f64> {
        let default = || self.entry.parameters.iter().find(|p| p.name == key).and_then(|p| p.default);
        self.get(key).or_else(default).ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    /// Roughness along x and y: either `alpha`, or both `alpha_x` and `alpha_y`.
    ///
    /// # Errors
    /// `Error::Parameter` if neither or both ways are used.
    pub fn alpha(&self) -> Result<[f64; 2]> {
        match (self.get("alpha"), self.get("alpha_x"), self.get("alpha_y")) {
            (Some(a), None, None) => Ok([a, a]),
            (None, Some(x), Some(y)) => Ok([x, y]),
            _ => Err(self.error("give either `alpha`, or both `alpha_x` and `alpha_y`")),
        }
    }

    /// `[rho_d, rho_s]` of a lobe over a diffuse floor.
    ///
    /// # Errors
    /// `Error::Parameter` if `rho_s` is missing or the two reflect more than all light.
    pub fn floor_and_lobe(&self) -> Result<[f64; 2]> {
        let (rho_d, rho_s) = (self.required("rho_d")?, self.required("rho_s")?);
        if rho_d + rho_s > 1.0 {
            return Err(self.error(format!("rho_d + rho_s = {} is more than 1", rho_d + rho_s)));
        }
        Ok([rho_d, rho_s])
    }

    /// The interface: `n`, `n` with `k`, or `material=NAME`.
    ///
    /// # Errors
    /// `Error::Parameter` if neither or both ways are used, or a clear material has n below 1.
    pub fn material(&self) -> Result<Material> {
        match (self.material, self.get("n"), self.get("k").filter(|&k| k > 0.0)) {
            (Some(material), None, None) => Ok(material),
            (None, Some(n), Some(k)) => Ok(Material::Conductor { n, k }),
            (None, Some(n), None) if n >= 1.0 => Ok(Material::Dielectric { n }),
            (None, Some(n), None) => Err(self.error(format!("n={n} without k is below 1, the index of air"))),
            _ => Err(self.error("give the interface as `n`, as `n` and `k`, or as `material`")),
        }
    }

    /// An error of this model, with its example as advice.
    pub fn error(&self, what: impl std::fmt::Display) -> Error {
        self.entry.error(what)
    }
}

/// Whether `text` starts with the name of a model, so that it is not the name of a file.
pub fn is_model(text: &str) -> bool {
    find(text).is_some()
}

fn find(text: &str) -> Option<&'static Entry> {
    let name = text.split(':').next().unwrap_or_default().trim();
    MODELS.iter().find(|entry| entry.name.eq_ignore_ascii_case(name))
}

/// Builds the model written as `name:key=value,...`; `wavelength` \[m\] selects the index of a named material.
///
/// # Errors
/// `Error::Parameter` naming the model, the parameter, its range, and an example that works.
pub fn parse(text: &str, wavelength: f64) -> Result<Box<dyn Brdf>> {
    let entry = find(text).ok_or_else(|| {
        let names: Vec<&str> = MODELS.iter().map(|entry| entry.name).collect();
        Error::parameter(
            format!("`{text}` is not a model"),
            format!("write name:key=value,... with one of {}", names.join(", ")),
        )
    })?;
    let arguments = text.split_once(':').map_or("", |(_, rest)| rest);
    (entry.build)(&Arguments::read(entry, arguments, wavelength)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_parses_its_own_example_and_documents_itself() {
        for entry in MODELS {
            assert!(is_model(entry.example));
            assert!(parse(entry.example, 550e-9).is_ok(), "{}", entry.example);
            assert!(!entry.summary.is_empty() && !entry.source.is_empty() && !entry.energy.is_empty());
            for p in entry.parameters {
                assert!(p.min < p.max && !p.meaning.is_empty(), "{} {}", entry.name, p.name);
                assert!(p.default.is_none_or(|d| d >= p.min && d <= p.max));
            }
        }
        assert!(!is_model("map.x3p") && !is_model(""));
    }

    #[test]
    fn errors_name_what_is_wrong_and_what_works() {
        let cases = [
            ("plastic:n=1.5", "not a model", "lambert"),
            ("lambert:rho=1.5", "0 to 1", "lambert:rho="),
            ("lambert:rho=nan", "outside its range", "lambert:rho="),
            ("lambert", "`rho` is missing", "lambert:rho="),
            ("lambert:albedo=1", "no parameter `albedo`", "rho"),
            ("lambert:rho=0.1,rho=0.2", "twice", "rho"),
            ("lambert:rho", "not key=value", "rho"),
            ("lambert:rho=half", "not a number", "rho"),
            ("beckmann:alpha=0.1", "material", "beckmann:"),
            ("beckmann:alpha=0.1,n=0.5", "below 1", "beckmann:"),
            ("beckmann:alpha=0.1,alpha_x=0.1,n=1.5", "either `alpha`", "beckmann:"),
            ("beckmann:alpha_x=0.1,n=1.5", "either `alpha`", "beckmann:"),
            ("beckmann:alpha=0.1,n=1.5,material=cu", "interface", "beckmann:"),
            ("ggx:alpha=-0.1,n=1.5", "outside its range", "ggx:"),
            ("ward:rho_s=0.6,rho_d=0.5,alpha=0.1", "more than 1", "ward:"),
            ("phong:exponent=10", "`rho_s` is missing", "phong:"),
        ];
        for (text, what, advice) in cases {
            let message = parse(text, 550e-9).err().expect(text).to_string();
            assert!(message.contains(what) && message.contains(advice), "{text}: {message}");
        }
        assert!(parse(" GGX : alpha = 0.1 , material = cu ", 550e-9).is_ok());
    }
}
