//! The material library: one TOML file per material, an embedded starter set and a folder of the user's own.
//!
//! ```toml
//! name = "blue-paint"                 # the file is blue-paint.toml; written material:blue-paint
//! title = "Blue paint, measured"
//! category = "paint"                  # for queries
//! source = "who measured or published it"
//! licence = "MIT"
//! note = "anything else"              # optional
//! theta_i_max_deg = 80                # optional: how far from the normal the data reach
//! range_nm = [380, 780]               # optional: default from the first to the last band, any if no band has one
//! model = "lafortune"                 # optional: default of the bands
//!
//! [[band]]                            # one or more, by wavelength
//! wavelength_nm = 550                 # may be left out if there is one band: the model itself knows the spectrum
//! model = "ward"                      # a name with parameters below, or a whole text: "ward:rho_s=0.04,alpha=0.1"
//! parameters = { rho_s = 0.04, alpha = 0.1, sigma = "20deg" }  # numbers, or text with a unit
//! ```
//!
//! Between two bands `f_r` is interpolated linearly in wavelength, from the ends of the range to the first and last band it
//! is constant. Sampling picks a band by the same weights; the density is that of the mixture.
//!
//! The folder is `$ASPERITY_MATERIALS`, else `asperity/materials` in `$XDG_CONFIG_HOME` or `~/.config`. A material there hides
//! the embedded one of the same name.

use super::registry;
use crate::error::{Error, Result};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The starter set, file by file.
const EMBEDDED: &[&str] = &[
    include_str!("materials/aluminium-satin.toml"),
    include_str!("materials/black-glass.toml"),
    include_str!("materials/blue-paint.toml"),
    include_str!("materials/brushed-metal.toml"),
    include_str!("materials/cement.toml"),
    include_str!("materials/clay.toml"),
    include_str!("materials/copper-satin.toml"),
    include_str!("materials/dusty-black.toml"),
    include_str!("materials/epoxy-ground.toml"),
    include_str!("materials/felt.toml"),
    include_str!("materials/gloss-red.toml"),
    include_str!("materials/gloss-white.toml"),
    include_str!("materials/gold-polished.toml"),
    include_str!("materials/lumber.toml"),
    include_str!("materials/matte-black.toml"),
    include_str!("materials/metallic-blue-clear-coat.toml"),
    include_str!("materials/metallic-coarse.toml"),
    include_str!("materials/metallic-fine.toml"),
    include_str!("materials/metallic-silver.toml"),
    include_str!("materials/nef-olive-paint.toml"),
    include_str!("materials/plaster.toml"),
    include_str!("materials/primer.toml"),
    include_str!("materials/satin-cloth.toml"),
    include_str!("materials/scanned-satin-paint.toml"),
    include_str!("materials/semi-gloss-grey.toml"),
    include_str!("materials/silver-polished.toml"),
    include_str!("materials/skin.toml"),
    include_str!("materials/steel-brushed.toml"),
];

/// `material:` in front of a text.
const PREFIX: &str = "material:";

/// A material as its file has it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    title: String,
    category: String,
    source: String,
    licence: String,
    note: Option<String>,
    theta_i_max_deg: Option<f64>,
    range_nm: Option<[f64; 2]>,
    model: Option<String>,
    band: Vec<FileBand>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileBand {
    wavelength_nm: Option<f64>,
    model: Option<String>,
    #[serde(default)]
    parameters: toml::Table,
}

/// A model at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Wavelength \[m\]; `None` if the one band serves all.
    pub wavelength: Option<f64>,
    /// The model's text.
    pub model: String,
}

/// A material of the library.
#[derive(Debug, Clone, PartialEq)]
pub struct LibraryMaterial {
    pub name: String,
    pub title: String,
    pub category: String,
    pub source: String,
    pub licence: String,
    pub note: Option<String>,
    /// Largest angle of incidence of the data \[rad\]; a right angle if the file does not say.
    pub theta_i_max: f64,
    /// Wavelengths it covers \[m\]; `None` if any.
    pub range: Option<[f64; 2]>,
    /// By wavelength.
    pub bands: Vec<Band>,
    /// Its file, unless it is embedded.
    pub file: Option<PathBuf>,
}

impl LibraryMaterial {
    /// Reads and checks one file's text.
    ///
    /// # Errors
    /// `Error::Content` naming the file, the line or the band, and what is wrong with it.
    pub fn read(text: &str, path: &Path, embedded: bool) -> Result<Self> {
        let advice = "see the head of the material files: name, title, category, source, licence and [[band]]";
        let bad = |what: String| Error::content(path, what, advice);
        let file: File = toml::from_str(text).map_err(|e| {
            let line = e.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            bad(format!("line {line}: {}", e.message().replace('\n', " ")))
        })?;
        let nm = |v: f64| v * 1e-9;
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if file.name.is_empty() || !file.name.chars().all(plain) {
            return Err(bad(format!("name `{}` has more than letters, digits, - and _", file.name)));
        }
        let mut bands = Vec::new();
        for (k, band) in file.band.iter().enumerate() {
            let place = |what: String| bad(format!("band {}: {what}", k + 1));
            let model = band.model.as_ref().or(file.model.as_ref()).ok_or_else(|| place("no model".to_owned()))?;
            let pairs: Vec<String> = band
                .parameters
                .iter()
                .map(|(key, value)| match value {
                    toml::Value::String(text) => Ok(format!("{key}={text}")),
                    toml::Value::Integer(_) | toml::Value::Float(_) | toml::Value::Boolean(_) => {
                        Ok(format!("{key}={value}"))
                    }
                    _ => Err(place(format!("`{key}` is neither a number nor text"))),
                })
                .collect::<Result<_>>()?;
            let mark = if pairs.is_empty() {
                ""
            } else if model.contains(':') {
                ","
            } else {
                ":"
            };
            let band =
                Band { wavelength: band.wavelength_nm.map(nm), model: format!("{model}{mark}{}", pairs.join(",")) };
            if band.wavelength.is_some_and(|l| !(l > 0.0 && l.is_finite()))
                || band.wavelength.is_none() && file.band.len() > 1
            {
                return Err(place("needs its wavelength_nm above 0, since there are several bands".to_owned()));
            }
            if band.model.starts_with(PREFIX) {
                return Err(place("a material cannot be made of another".to_owned()));
            }
            // A fault of the model is one of this file.
            registry::parse(&band.model, band.wavelength.unwrap_or(550e-9)).map_err(|e| place(e.to_string()))?;
            bands.push(band);
        }
        if bands.is_empty() {
            return Err(bad("there is no [[band]]".to_owned()));
        }
        bands.sort_by(|a, b| a.wavelength.partial_cmp(&b.wavelength).expect("wavelengths are numbers"));
        let ends = || Some([bands.first()?.wavelength?, bands.last()?.wavelength?]);
        let range = file.range_nm.map(|r| r.map(nm)).or_else(ends);
        if range.is_some_and(|[low, high]| !(low > 0.0 && low <= high)) {
            return Err(bad("range_nm is not a pair of a lower and a higher wavelength".to_owned()));
        }
        let theta_i_max = file.theta_i_max_deg.unwrap_or(90.0).to_radians();
        if !(theta_i_max > 0.0 && theta_i_max <= 90f64.to_radians()) {
            return Err(bad("theta_i_max_deg is not between 0 and 90".to_owned()));
        }
        let File { name, title, category, source, licence, note, .. } = file;
        let file = (!embedded).then(|| path.to_owned());
        Ok(LibraryMaterial { name, title, category, source, licence, note, theta_i_max, range, bands, file })
    }

    /// Whether the data reach `wavelength` \[m\].
    pub fn covers(&self, wavelength: f64) -> bool {
        // A hair of room for the rounding of units.
        self.range.is_none_or(|[low, high]| wavelength >= low * (1.0 - 1e-9) && wavelength <= high * (1.0 + 1e-9))
    }

    /// The BRDF at `wavelength` \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` if the material does not cover it.
    pub fn at(&self, wavelength: f64) -> Result<Box<dyn Brdf>> {
        if !self.covers(wavelength) {
            let [low, high] = self.range.unwrap_or_default().map(|l| l * 1e9);
            return Err(Error::parameter(
                format!("material `{}` has no data at {:.0} nm", self.name, wavelength * 1e9),
                format!("it covers {low:.0} nm to {high:.0} nm"),
            ));
        }
        let build = |band: &Band| registry::parse(&band.model, wavelength);
        let above = self.bands.iter().position(|b| b.wavelength.is_none_or(|l| l >= wavelength));
        match above {
            Some(0) => build(&self.bands[0]),
            None => build(&self.bands[self.bands.len() - 1]),
            Some(k) => {
                let (low, high) = (&self.bands[k - 1], &self.bands[k]);
                let (a, b) = (low.wavelength.unwrap_or_default(), high.wavelength.unwrap_or_default());
                let t = (wavelength - a) / (b - a);
                // A band's own wavelength needs no neighbour.
                if t > 1.0 - 1e-9 {
                    build(high)
                } else {
                    Ok(Box::new(Between { low: build(low)?, high: build(high)?, t }))
                }
            }
        }
    }
}

/// Every material: the user's, then the embedded that they do not hide; by name.
///
/// # Errors
/// `Error::Content` for the first file that is not a material.
pub fn all() -> Result<Vec<LibraryMaterial>> {
    let mut found = Vec::new();
    if let Some(folder) = folder().filter(|f| f.is_dir()) {
        let entries = std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, "read", e))?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
        files.sort();
        for path in files {
            found.push(load(&path)?);
        }
    }
    for material in embedded() {
        if !found.iter().any(|m| m.name == material.name) {
            found.push(material);
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// The material of that name.
///
/// # Errors
/// `Error::Content` if the user's file of that name is faulty; `Error::Parameter` with the names there are.
pub fn find(name: &str) -> Result<LibraryMaterial> {
    let own = folder().map(|f| f.join(format!("{name}.toml"))).filter(|_| !name.contains(['/', '\\']));
    if let Some(path) = own.filter(|path| path.is_file()) {
        return load(&path);
    }
    embedded().into_iter().find(|m| m.name == name).ok_or_else(|| {
        let names: Vec<String> = embedded().into_iter().map(|m| m.name).collect();
        Error::parameter(
            format!("there is no material `{name}`"),
            format!("`asperity models --materials` lists them all; embedded are {}", names.join(", ")),
        )
    })
}

/// Name behind `material:`; `None` if the text is something else.
pub fn name_in(text: &str) -> Option<&str> {
    let text = text.trim();
    text.get(..PREFIX.len()).filter(|p| p.eq_ignore_ascii_case(PREFIX)).map(|_| text[PREFIX.len()..].trim())
}

fn load(path: &Path) -> Result<LibraryMaterial> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
    let material = LibraryMaterial::read(&text, path, false)?;
    if path.file_stem().is_none_or(|stem| stem != material.name.as_str()) {
        let what = format!("its name is `{}`", material.name);
        return Err(Error::content(
            path,
            what,
            format!("call the file {}.toml, so that it can be found", material.name),
        ));
    }
    Ok(material)
}

fn embedded() -> Vec<LibraryMaterial> {
    let read = |text: &&str| LibraryMaterial::read(text, Path::new("embedded material"), true);
    EMBEDDED.iter().map(|text| read(text).expect("the starter set is tested")).collect()
}

/// Folder of the user's own materials.
pub fn folder() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let config = || variable("XDG_CONFIG_HOME").or_else(|| variable("HOME").map(|home| home.join(".config")));
    variable("ASPERITY_MATERIALS").or_else(|| config().map(|c| c.join("asperity").join("materials")))
}

/// `(1 - t) f_low + t f_high`.
struct Between {
    low: Box<dyn Brdf>,
    high: Box<dyn Brdf>,
    t: f64,
}

impl Between {
    fn mix(&self, low: f64, high: f64) -> f64 {
        low + self.t * (high - low)
    }
}

impl Brdf for Between {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.mix(self.low.eval(wi, wo), self.high.eval(wi, wo))
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let draw = if u[0] < self.t {
            self.high.sample(wi, [u[0] / self.t, u[1]])?
        } else {
            self.low.sample(wi, [((u[0] - self.t) / (1.0 - self.t)).min(1.0 - f64::EPSILON), u[1]])?
        };
        if draw.specular {
            // Chosen as often as it counts.
            return Some(draw);
        }
        let pdf = self.pdf(wi, draw.wo);
        (pdf > 0.0).then(|| BrdfSample { weight: self.eval(wi, draw.wo) * draw.wo.z / pdf, pdf, ..draw })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.mix(self.low.pdf(wi, wo), self.high.pdf(wi, wo))
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.mix(self.low.albedo(theta_i), self.high.albedo(theta_i))
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        self.mix(self.low.albedo_towards(wi), self.high.albedo_towards(wi))
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.mix(self.low.specular_core(wi), self.high.specular_core(wi))
    }
}
