//! The list of models: names, parameters and ranges are data, so the parser, the error messages, the fit and the printed
//! list cannot drift apart.

use super::MODELS;
use super::definition::{Definition, Values};
use super::layered::{self, Layered};
use super::library;
use super::parameter::{Parameter, Word};
use crate::error::{Error, Result};
use crate::optics::Brdf;

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
    /// Words: forms of the model, files.
    pub words: &'static [Word],
    /// Whether `material=NAME` is understood beside `n` and `k`.
    pub interface: bool,
    /// Whether the wavelength enters the formula itself.
    pub wave: bool,
    /// The `form` for which `f_r(wi, wo)` is not `f_r(wo, wi)`; in every other it is.
    pub not_reciprocal: Option<&'static str>,
    /// Whether some parameters reflect more than is received; `bounded=true` mends it.
    pub exceeds_one: bool,
    /// What is known about `albedo <= 1`.
    pub energy: &'static str,
    /// Author, year, equation.
    pub source: &'static str,
    /// An example that builds.
    pub example: &'static str,
    /// Builds the model from checked values.
    pub build: fn(&Values) -> Result<Box<dyn Brdf>>,
}

/// Two entries are the same if they have the same name.
impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Entry {
    /// What most models are: no words, no interface, reciprocal, conserving. Fill in the rest with `..Entry::PLAIN`.
    pub const PLAIN: Entry = Entry {
        name: "",
        summary: "",
        formula: "",
        parameters: &[],
        words: &[],
        interface: false,
        wave: false,
        not_reciprocal: None,
        exceeds_one: false,
        energy: "",
        source: "",
        example: "",
        build: |values| Err(values.error("the model has no constructor")),
    };

    /// Whether the model depends on the wavelength for at least some of its definitions.
    pub fn is_spectral(&self) -> bool {
        self.interface || self.wave
    }

    /// All keys, for an error message.
    pub fn keys(&self) -> String {
        let mut keys: Vec<&str> = self.parameters.iter().map(|p| p.name).collect();
        keys.extend(self.words.iter().map(|w| w.name));
        keys.extend(self.interface.then_some("material"));
        keys.extend(self.is_spectral().then_some("wavelength"));
        keys.push("bounded");
        keys.join(", ")
    }

    /// An error of this model, with its example as advice.
    pub fn error(&self, what: impl std::fmt::Display) -> Error {
        Error::parameter(format!("model `{}`: {what}", self.name), format!("write for example {}", self.example))
    }
}

/// Whether `text` starts with the name of a model, is layered or a material, so that it is not the name of a file.
pub fn is_model(text: &str) -> bool {
    find(text).is_some() || layered::split(text).is_some() || library::name_in(text).is_some()
}

fn find(text: &str) -> Option<&'static Entry> {
    let name = text.split(':').next().unwrap_or_default().trim();
    MODELS.iter().copied().find(|entry| entry.name.eq_ignore_ascii_case(name))
}

/// The model that `name` or `name:...` starts with.
///
/// # Errors
/// `Error::Parameter` with the names there are.
pub fn entry(text: &str) -> Result<&'static Entry> {
    find(text).ok_or_else(|| {
        let names: Vec<&str> = MODELS.iter().map(|entry| entry.name).collect();
        Error::parameter(
            format!("`{text}` is not a model"),
            format!("write name:key=value,... with one of {}", names.join(", ")),
        )
    })
}

/// Builds the model written as `name:key=value,...`, `layered:COAT,over=BASE` or `material:NAME`; `wavelength` \[m\] selects
/// the index of a named interface, the band of a material and enters wave optics, unless the text has a `wavelength` of its
/// own. Colour asks once per wavelength.
///
/// # Errors
/// `Error::Parameter` naming the model, the parameter, its range, and an example that works; `Error::Content` naming the
/// file of a faulty material.
pub fn parse(text: &str, wavelength: f64) -> Result<Box<dyn Brdf>> {
    parse_with(text, &|part| match library::name_in(part) {
        Some(name) => library::find(name)?.at(wavelength),
        None => Definition::parse(part)?.build(wavelength),
    })
}

/// Takes `layered:COAT,over=BASE` apart and builds every part by `build`, so that a layer may be a table or a file.
///
/// # Errors
/// `Error::Parameter` if a layer is missing; those of `build`.
pub fn parse_with(text: &str, build: &dyn Fn(&str) -> Result<Box<dyn Brdf>>) -> Result<Box<dyn Brdf>> {
    let Some((coat, base)) = layered::split(text) else { return build(text) };
    if coat.is_empty() || base.is_empty() {
        return Err(Error::parameter(
            format!("`{text}` has no {}", if coat.is_empty() { "coat" } else { "base" }),
            "write layered:COAT,over=BASE, for example layered:ggx:alpha=0.05,n=1.5,over=lambert:rho=0.4",
        ));
    }
    Ok(Box::new(Layered::new(build(coat)?, parse_with(base, build)?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parameter::{Absent, Scale};

    #[test]
    fn every_entry_builds_its_own_example_and_documents_itself() {
        for entry in MODELS {
            assert!(is_model(entry.example));
            assert!(parse(entry.example, 550e-9).is_ok(), "{}", entry.example);
            assert!(!entry.summary.is_empty() && !entry.source.is_empty() && !entry.energy.is_empty());
            for p in entry.parameters {
                let [low, high] = p.usual;
                assert!(p.min < p.max && !p.meaning.is_empty(), "{} {}", entry.name, p.name);
                assert!(low < high && low >= p.min && high <= p.max, "{} {}", entry.name, p.name);
                assert!(p.scale == Scale::Linear || low > 0.0, "{} {}", entry.name, p.name);
                assert!(p.default().is_none_or(|d| p.allows(d)));
                if let Absent::Said(name) = p.absent {
                    assert!(entry.parameters.iter().any(|q| q.name == name));
                }
            }
            // What a definition writes, it reads.
            let definition = Definition::parse(entry.example).unwrap();
            assert_eq!(Definition::parse(&definition.to_string()).unwrap(), definition);
        }
        let mut names: Vec<&str> = MODELS.iter().map(|entry| entry.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), MODELS.len());
        assert!(!is_model("map.x3p") && !is_model(""));
    }

    #[test]
    fn errors_name_what_is_wrong_and_what_works() {
        let cases = [
            ("plastic:n=1.5", "not a model", "lambert"),
            ("lambert:rho=1.5", "0 to 1", "lambert:rho="),
            ("lambert:rho=nan", "outside its range", "lambert:rho="),
            ("lambert:rho=inf", "outside its range", "lambert:rho="),
            ("lambert", "`rho` is missing", "lambert:rho="),
            ("lambert:albedo=1", "no parameter `albedo`", "rho"),
            ("lambert:rho=0.1,rho=0.2", "twice", "rho"),
            ("lambert:rho", "not key=value", "rho"),
            ("lambert:rho=half", "not a number", "rho"),
            ("lambert:rho=0.5,bounded=maybe", "neither true nor false", "rho"),
            ("lambert:rho=0.5,wavelength=500nm", "no parameter `wavelength`", "rho"),
            ("beckmann:alpha=0.1", "material", "beckmann:"),
            ("beckmann:alpha=0.1,n=0.5", "below 1", "beckmann:"),
            ("beckmann:alpha=0.1,n=-1.5", "outside its range", "beckmann:"),
            ("beckmann:alpha=0.1,alpha_x=0.1,n=1.5", "either `alpha`", "beckmann:"),
            ("beckmann:alpha_x=0.1,n=1.5", "either `alpha`", "beckmann:"),
            ("beckmann:alpha=0.1,n=1.5,material=cu", "interface", "beckmann:"),
            ("beckmann:alpha=0.1,material=glue", "unknown", "al"),
            ("beckmann:alpha=0.1,material=cu,wavelength=5", "not a length", "beckmann:"),
            ("beckmann:alpha=0.1,material=cu,wavelength=5m", "outside its range, 0.1 um to 20 um", "beckmann:"),
            ("beckmann:alpha=0.1,material=cu,wavelength=900nm", "780", "n="),
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

    #[test]
    fn the_wavelength_of_the_text_wins() {
        let core = |text: &str, wavelength: f64| parse(text, wavelength).unwrap().albedo(0.0);
        let red = core("conductor:material=cu", 611e-9);
        assert!((core("conductor:material=cu,wavelength=611nm", 464e-9) - red).abs() < 1e-12);
        assert!(core("conductor:material=cu", 464e-9) < 0.7 * red);
    }

    #[test]
    fn what_a_fit_may_vary() {
        let free =
            |text: &str| -> Vec<&str> { Definition::parse(text).unwrap().free().iter().map(|p| p.name).collect() };
        assert_eq!(free("beckmann"), ["alpha", "n"]);
        assert_eq!(free("beckmann:alpha_x=0.1,material=cu"), [""; 0]);
        assert_eq!(free("ward:rho_d=0"), ["rho_s", "alpha"]);
        let mut ward = Definition::parse("ward:rho_d=0").unwrap();
        ward.set("rho_s", 0.2).unwrap();
        ward.set("alpha", 0.3).unwrap();
        ward.set("alpha", 0.1).unwrap();
        assert_eq!(ward.to_string(), "ward:rho_d=0,rho_s=0.2,alpha=0.1");
        assert!(ward.set("alpha", -1.0).is_err() && ward.set("beta", 0.0).is_err());
    }
}
