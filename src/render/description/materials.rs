//! The materials of a scene file, opened.

use super::schema::{Cell, Material, Metallic};
use super::{Description, Place};
use crate::error::{Error, Result};
use crate::math::direction;
use crate::model::{self, Lambert};
use crate::optics::Brdf;
use crate::render::MetallicPaint;
use crate::render::material::{Coat, Cover, Reflector};
use crate::render::spectral::{Spectral, to_linear_srgb};
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::Range;

/// Wavelength of what is not spectral \[m\].
const WAVELENGTH: f64 = 550e-9;

/// The matt material behind every colour.
static WHITE: Lambert = Lambert { rho: 1.0 };

/// What a scene file asks for: whoever opens it knows about files, maps and methods.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// The SOURCE as written.
    pub source: &'a str,
    /// \[m\]
    pub wavelength: f64,
    /// How a height map scatters; `None` if the file does not say.
    pub method: Option<&'a str>,
    /// What a height map is made of; `None` if the file does not say.
    pub surface: Option<&'a str>,
    /// More flags for a height map, such as `--pitch=0.5um`.
    pub flags: &'a [String],
}

/// Opens a SOURCE.
pub type Opener<'a> = dyn Fn(&Wanted) -> Result<Box<dyn Brdf>> + 'a;

enum Stored {
    Colour(DVec3),
    Grey(Box<dyn Brdf>, DVec3),
    Spectral(Spectral, DVec3),
    /// Indices of two others and the side of a cell \[m\].
    Checker([usize; 2], f64),
}

/// Everything that the shapes of a scene are covered with.
pub struct Materials {
    names: BTreeMap<String, usize>,
    stored: Vec<Stored>,
}

impl Description {
    /// Opens every material, maps and tables through `open`; `progress` is told the finished share.
    ///
    /// # Errors
    /// Those of `open`, with the line of the material; `Error::Content` for a material that is nothing, or two things.
    pub fn materials(&self, open: &Opener, progress: &dyn Fn(f64)) -> Result<Materials> {
        let mut materials = Materials { names: BTreeMap::new(), stored: Vec::new() };
        let count = self.file.materials.len() as f64;
        for (done, (name, table)) in self.file.materials.iter().enumerate() {
            let stored = match plain(table.get_ref(), &table.span(), name, &self.place, open)? {
                Some(stored) => stored,
                // Set when all names are known.
                None => Stored::Colour(DVec3::ZERO),
            };
            materials.names.insert(name.clone(), materials.stored.len());
            materials.stored.push(stored);
            progress((done + 1) as f64 / count);
        }
        for (name, table) in &self.file.materials {
            self.lay_checker(name, table.get_ref(), &table.span(), &mut materials)?;
        }
        Ok(materials)
    }

    fn lay_checker(&self, name: &str, material: &Material, span: &Range<usize>, all: &mut Materials) -> Result<()> {
        let Some(checker) = &material.checker else { return Ok(()) };
        let unit = self.unit()?;
        let bad = |what: String, advice: &str| self.place.error_in(span, "checker", what, advice);
        if !(checker.size > 0.0 && checker.size.is_finite()) {
            let what = format!("material `{name}`: key `checker`: the size {} is not above 0", checker.size);
            return Err(bad(what, "give the side of a cell in length_unit"));
        }
        let mut cells = [0; 2];
        for (index, cell) in cells.iter_mut().zip([&checker.a, &checker.b]) {
            *index = match cell {
                Cell::Colour(colour) => {
                    let rgb = reflectance(colour.rgb()).map_err(|what| {
                        bad(format!("material `{name}`: key `checker`: {what}"), "give numbers from 0 to 1")
                    })?;
                    all.stored.push(Stored::Colour(rgb));
                    all.stored.len() - 1
                }
                Cell::Name(other) => match all.names.get(other) {
                    Some(&k) if self.file.materials[other].get_ref().checker.is_none() => k,
                    Some(_) => {
                        let what = format!("material `{name}`: key `checker`: `{other}` is a checker itself");
                        return Err(bad(what, "make its cells of a source or a colour"));
                    }
                    None => {
                        let what = format!("material `{name}`: key `checker`: there is no material `{other}`");
                        return Err(bad(what, &all.advice()));
                    }
                },
            };
        }
        let own = all.names[name];
        all.stored[own] = Stored::Checker(cells, checker.size * unit);
        Ok(())
    }
}

/// A material that needs no other; `None` for a checker.
fn plain(m: &Material, span: &Range<usize>, name: &str, place: &Place, open: &Opener) -> Result<Option<Stored>> {
    let bad =
        |key: &str, what: String, advice: &str| place.error_in(span, key, format!("material `{name}`: {what}"), advice);
    let colour = |key: &str, value: Option<super::schema::Colour>| {
        let rgb = value.map(|c| reflectance(c.rgb())).transpose();
        rgb.map_err(|what| bad(key, format!("key `{key}`: {what}"), "give numbers from 0 to 1"))
    };
    let tint = colour("tint", m.tint)?.unwrap_or(DVec3::ONE);
    if m.metallic.is_none() && m.coat.is_some() {
        return Err(bad("coat", "key `coat` is for metallic paint".into(), "write a layered: source instead"));
    }
    if m.source.is_none() && m.coat.is_none() {
        let only = [
            ("method", m.method.is_some()),
            ("surface", m.surface.is_some()),
            ("flags", !m.flags.is_empty()),
            ("wavelength_nm", m.wavelength_nm.is_some()),
        ];
        if let Some((key, _)) = only.iter().find(|k| k.1) {
            return Err(bad(key, format!("key `{key}` is for a source"), "leave it out"));
        }
    }
    let wavelength = m.wavelength_nm.map(|w| w * 1e-9);
    if wavelength.is_some_and(|w| !(w > 0.0 && w.is_finite())) {
        return Err(bad("wavelength_nm", "key `wavelength_nm` is not above 0".into(), "give for example 550"));
    }
    let opened = |key: &str, source: &str, wavelength: f64| {
        let (method, surface) = (m.method.as_deref(), m.surface.as_deref());
        open(&Wanted { source, wavelength, method, surface, flags: &m.flags })
            .map_err(|e| place.error_in(span, key, format!("material `{name}`: {}", said(&e)), mend(&e)))
    };
    if let Some(metallic) = &m.metallic {
        if m.source.is_some() || m.rgb.is_some() || m.checker.is_some() {
            return Err(bad(
                "metallic",
                "it needs one of `source`, `rgb`, `checker` and `metallic`".into(),
                "keep one",
            ));
        }
        let paint = flakes(metallic).map_err(|(key, what)| {
            bad(
                "metallic",
                format!("key `{key}`: {what}"),
                "give X, Y, Z of a colour that sRGB holds, Y = 100 for white",
            )
        })?;
        let coat = m.coat.as_deref().map(|coat| opened("coat", coat, wavelength.unwrap_or(WAVELENGTH))).transpose()?;
        return Ok(Some(Stored::Spectral(coat.map_or_else(|| paint.bare(), |coat| paint.coated(coat)), tint)));
    }
    match (&m.source, m.rgb, &m.checker) {
        (None, Some(_), None) => Ok(Some(Stored::Colour(tint * colour("rgb", m.rgb)?.unwrap_or(DVec3::ONE)))),
        (None, None, Some(_)) if m.tint.is_some() => Err(bad("tint", "a checker has no tint".into(), "tint its cells")),
        (None, None, Some(_)) => Ok(None),
        (Some(source), None, None) => {
            let at = |wavelength: f64| opened("source", source, wavelength);
            if wavelength.is_none() && model::is_model(source) && is_coloured(&at)? {
                return Ok(Some(Stored::Spectral(Spectral::new(&at)?, tint)));
            }
            Ok(Some(Stored::Grey(at(wavelength.unwrap_or(WAVELENGTH))?, tint)))
        }
        _ => Err(bad(
            "",
            "it needs one of `source`, `rgb`, `checker` and `metallic`".into(),
            "write for example rgb = 0.5",
        )),
    }
}

/// The paint, if it can be shown at all three angles; else the key and what is wrong.
fn flakes(metallic: &Metallic) -> std::result::Result<MetallicPaint, (&'static str, String)> {
    let angles = [("xyz_15", metallic.xyz_15), ("xyz_45", metallic.xyz_45), ("xyz_110", metallic.xyz_110)];
    for (key, xyz) in angles {
        MetallicPaint::new([xyz; 3]).map_err(|e| (key, said(&e)))?;
        let rgb = to_linear_srgb(DVec3::from(xyz) / 100.0);
        // Rounded readings of black.
        if rgb.min_element() < -1e-4 {
            return Err((key, format!("{xyz:?} lies outside of sRGB, as {:.3?}", rgb.to_array())));
        }
    }
    MetallicPaint::new(angles.map(|a| a.1)).map_err(|e| ("metallic", said(&e)))
}

/// Whether red and blue light find another surface.
fn is_coloured(at: &dyn Fn(f64) -> Result<Box<dyn Brdf>>) -> Result<bool> {
    let (blue, red) = (at(450e-9)?, at(640e-9)?);
    let differ = |a: f64, b: f64| (a - b).abs() > 1e-9 * a.abs().max(b.abs());
    let directions = [(0.1, 0.0, 0.15, 3.1), (0.8, 0.0, 0.8, 3.1), (0.8, 0.0, 0.1, 1.0), (1.2, 0.3, 1.1, 3.0)];
    Ok(directions.iter().any(|&(ti, pi, tr, pr)| {
        let (wi, wo) = (direction(ti, pi), direction(tr, pr));
        differ(blue.eval(wi, wo), red.eval(wi, wo)) || differ(blue.specular_core(wi), red.specular_core(wi))
    }))
}

/// A colour of something that reflects.
fn reflectance(rgb: [f64; 3]) -> std::result::Result<DVec3, String> {
    if rgb.iter().all(|x| (0.0..=1.0).contains(x)) {
        Ok(rgb.into())
    } else {
        Err(format!("{rgb:?} is not a reflectance"))
    }
}

/// What is wrong and what to do, apart.
pub(super) fn said(e: &Error) -> String {
    match e {
        Error::Content { path, what, .. } => format!("{}: {what}", path.display()),
        Error::Parameter { what, .. } => what.clone(),
        other => other.to_string(),
    }
}

pub(super) fn mend(e: &Error) -> String {
    match e {
        Error::Content { advice, .. } | Error::Parameter { advice, .. } => advice.clone(),
        _ => "mend the file or name another".to_owned(),
    }
}

impl Materials {
    /// What to write instead of a name that is not known.
    fn advice(&self) -> String {
        if self.names.is_empty() {
            return "describe it in [materials.NAME]".to_owned();
        }
        format!("name one of {}", self.names.keys().cloned().collect::<Vec<_>>().join(", "))
    }

    /// The cover of that name.
    pub(super) fn cover(&self, name: &str) -> std::result::Result<Cover<'_>, String> {
        let index = *self.names.get(name).ok_or_else(|| self.advice())?;
        Ok(match &self.stored[index] {
            Stored::Checker(cells, size) => Cover::Checker(cells.map(|k| self.coat(k)), *size),
            _ => Cover::Plain(self.coat(index)),
        })
    }

    fn coat(&self, index: usize) -> Coat<'_> {
        match &self.stored[index] {
            Stored::Colour(rgb) => Coat::new(Reflector::Grey(&WHITE), *rgb),
            Stored::Grey(brdf, tint) => Coat::new(Reflector::Grey(brdf.as_ref()), *tint),
            Stored::Spectral(spectral, tint) => Coat::new(Reflector::Spectral(spectral), *tint),
            // Cells of a checker are no checkers: that was refused.
            Stored::Checker(..) => Coat::new(Reflector::Grey(&WHITE), DVec3::ZERO),
        }
    }
}
