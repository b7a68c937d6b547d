//! The scanned material at other wavelengths: scaled to its directional-hemispherical reflectance (DHR).
//!
//! `f_r(lambda) = s(lambda) f_r`, `s = DHR(lambda) / E(theta_i)`, `E` the albedo of the scanned material
//!
//! First surface and volume keep their proportion: `bias`, `rho_D`, `rho_V` (or the scan that is the law) are multiplied
//! by `s`, widths and shadowing stay. Where the index of the wavelength is known, the first surface takes it and `E` is
//! that of the material with it.
//!
//! Errors: `var(ln p) = (error / DHR)^2 + g C g`, `g = d(ln p - ln E)`, `C` the covariance of the fit: a parameter and the
//! albedo it belongs to err together, which leaves a band less uncertain than its parts.
//!
//! Source: the step of the NEF database as handed down: DHR at 20 deg over the spectrum scales the whole model.

use super::characterise::Characterised;
use super::material::Material;
use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::fit::brdf::FittedParameter;
use crate::fit::warning::Warning;
use crate::math::Estimate;
use crate::model::Definition;
use std::path::Path;

/// DHR at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflectance {
    /// \[m\].
    pub wavelength: f64,
    pub dhr: Estimate,
    /// `[n, k]` of the first surface, if it is known to change.
    pub index: Option<[f64; 2]>,
}

/// DHR over the spectrum, under illumination from one angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// \[rad\].
    pub theta_i: f64,
    /// By wavelength.
    pub rows: Vec<Reflectance>,
}

/// The material at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// \[m\].
    pub wavelength: f64,
    /// `s`.
    pub scale: Estimate,
    /// What changed: `bias`, `rho_D`, `rho_V`.
    pub parameters: Vec<FittedParameter>,
    pub definition: Definition,
}

/// Angle of illumination of a DHR that does not say \[deg\].
const USUAL: f64 = 20.0;

impl Spectrum {
    /// Reads `wavelength_nm, dhr` and, where there are such columns, `dhr_error`, `theta_i_deg` (one angle), `n`, `k`.
    ///
    /// # Errors
    /// `Error::Io` or `Error::Content` naming file, line and column.
    pub fn read(path: &Path) -> Result<Self> {
        Spectrum::of(&Columns::read(path)?)
    }

    fn of(columns: &Columns) -> Result<Self> {
        let wavelength = columns.numbers_within("wavelength_nm", 100.0, 20_000.0)?;
        let dhr = columns.numbers_within("dhr", 1e-6, 1.0)?;
        let within = |name: &str, low: f64, high: f64| {
            columns.has(name).then(|| columns.numbers_within(name, low, high)).transpose()
        };
        let errors = within("dhr_error", 0.0, 1.0)?;
        let theta = within("theta_i_deg", 0.0, 85.0)?.unwrap_or_else(|| vec![USUAL; dhr.len()]);
        let (n, k) = (within("n", 0.01, 20.0)?, within("k", 0.0, 100.0)?);
        if let Some(row) = theta.iter().position(|t| *t != theta[0]) {
            let what = format!("`theta_i_deg` is {} after {}", theta[row], theta[0]);
            return Err(columns.row_fault(row, what, "give one file one angle of incidence"));
        }
        if k.is_some() && n.is_none() {
            return Err(columns.row_fault(0, "there is `k` without `n`", "give both, or neither"));
        }
        let mut rows: Vec<Reflectance> = (0..dhr.len())
            .map(|j| Reflectance {
                wavelength: wavelength[j] * 1e-9,
                dhr: Estimate { value: dhr[j], standard_error: errors.as_ref().map_or(0.0, |e| e[j]) },
                index: n.as_ref().map(|n| [n[j], k.as_ref().map_or(0.0, |k| k[j])]),
            })
            .collect();
        if let Some(row) = rows.iter().position(|r| r.index.is_some_and(|[n, k]| k == 0.0 && n < 1.0)) {
            return Err(columns.row_fault(row, "`n` is below 1 without `k`", "a clear material has n of at least 1"));
        }
        rows.sort_by(|a, b| a.wavelength.total_cmp(&b.wavelength));
        if let Some(pair) = rows.windows(2).find(|pair| pair[0].wavelength == pair[1].wavelength) {
            let what = format!("{:.3} nm is there twice", pair[0].wavelength * 1e9);
            return Err(Error::content(columns.path(), what, "give every wavelength once"));
        }
        Ok(Spectrum { theta_i: theta[0].to_radians(), rows })
    }

    /// DHR at `wavelength` \[m\] between two rows; `None` outside all of them.
    pub fn at(&self, wavelength: f64) -> Option<Reflectance> {
        let above = self.rows.iter().position(|r| r.wavelength >= wavelength * (1.0 - 1e-9))?;
        let high = self.rows[above];
        if high.wavelength <= wavelength * (1.0 + 1e-9) {
            return Some(high);
        }
        let low = *self.rows.get(above.checked_sub(1)?)?;
        let t = (wavelength - low.wavelength) / (high.wavelength - low.wavelength);
        let mix = |a: f64, b: f64| a + t * (b - a);
        let dhr = Estimate {
            value: mix(low.dhr.value, high.dhr.value),
            standard_error: mix(low.dhr.standard_error, high.dhr.standard_error),
        };
        let index = low.index.zip(high.index).map(|(a, b)| [mix(a[0], b[0]), mix(a[1], b[1])]);
        Some(Reflectance { wavelength, dhr, index })
    }
}

/// A scale beyond this share and this many errors from 1 is no chance.
const MISMATCH: (f64, f64) = (0.05, 3.0);

/// The scanned material at every wavelength of the spectrum. If the wavelength of the scans is known \[m\] and the spectrum
/// covers it, both are compared there.
///
/// # Errors
/// `Error::Parameter` if a band would need a parameter outside the range of the model, naming the wavelength.
pub fn carry(
    found: &Characterised,
    spectrum: &Spectrum,
    scanned_at: Option<f64>,
) -> Result<(Vec<Band>, Option<Warning>)> {
    let bands = spectrum.rows.iter().map(|row| band(found, row, spectrum.theta_i)).collect::<Result<Vec<_>>>()?;
    let compared = scanned_at.and_then(|l| spectrum.at(l));
    // At the wavelength of the scans their own index is the right one.
    let own = compared.map(|row| band(found, &Reflectance { index: None, ..row }, spectrum.theta_i)).transpose()?;
    let warning = own.map(|b| (b.wavelength, b.scale)).filter(|(_, s)| {
        let off = (s.value - 1.0).abs();
        off > MISMATCH.0 && off > MISMATCH.1 * s.standard_error
    });
    let mismatch = |(wavelength, s): (f64, Estimate)| Warning::HemisphericalMismatch {
        wavelength,
        scale: s.value,
        standard_error: s.standard_error,
    };
    Ok((bands, warning.map(mismatch)))
}

fn band(found: &Characterised, row: &Reflectance, theta_i: f64) -> Result<Band> {
    let with_index = |mut material: Material| {
        if let Some([n, k]) = row.index {
            material.set("n", n);
            material.set("k", k);
        }
        material
    };
    let base = with_index(found.material.clone());
    let albedo = base.albedo(theta_i);
    let scale = row.dhr.value / albedo;
    // d ln E by every parameter that the index of the wavelength has not replaced.
    let slope = |p: &FittedParameter| {
        if row.index.is_some() && ["n", "k"].contains(&p.name.as_str()) {
            return 0.0;
        }
        let step = 1e-3 * p.value.abs().max(1e-6);
        let at = |value: f64| {
            let mut material = found.material.clone();
            material.set(&p.name, value);
            with_index(material).albedo(theta_i)
        };
        (at(p.value + step) - at(p.value - step)) / (2.0 * step * albedo)
    };
    let slopes: Vec<f64> = found.parameters.iter().map(slope).collect();
    let relative = row.dhr.standard_error / row.dhr.value;
    // Relative error of a parameter (none for `s` itself) over the albedo.
    let spread = |of: Option<usize>| {
        let mut g: Vec<f64> = slopes.iter().map(|e| -e).collect();
        if let Some(j) = of {
            g[j] += 1.0 / found.parameters[j].value;
        }
        let row = |(gj, row): (&f64, &Vec<f64>)| gj * row.iter().zip(&g).map(|(c, gl)| c * gl).sum::<f64>();
        (relative * relative + g.iter().zip(&found.covariance).map(row).sum::<f64>().max(0.0)).sqrt()
    };
    let material = base.scaled(scale)?;
    let definition = material.definition().map_err(|e| {
        let what =
            format!("at {:.0} nm the reflectance asks for {scale:.3} times the scanned material", row.wavelength * 1e9);
        Error::parameter(what, format!("check `dhr` there: {e}"))
    })?;
    let changed = ["bias", "rho_D", "rho_V"];
    let parameters = (found.parameters.iter().enumerate())
        .filter(|(_, p)| changed.contains(&p.name.as_str()))
        .map(|(j, p)| FittedParameter {
            name: p.name.clone(),
            value: scale * p.value,
            standard_error: p.standard_error.map(|_| scale * p.value * spread(Some(j))),
        })
        .collect();
    let scale = Estimate { value: scale, standard_error: scale * spread(None) };
    Ok(Band { wavelength: row.wavelength, scale, parameters, definition })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Spectrum> {
        Spectrum::of(&Columns::parse(Path::new("dhr.csv"), text).unwrap())
    }

    #[test]
    fn rows_are_sorted_and_read_between() {
        let spectrum = parse("wavelength_nm,dhr,dhr_error,n\n700,0.4,0.02,1.4\n500,0.2,0.01,1.6\n").unwrap();
        assert!((spectrum.theta_i.to_degrees() - 20.0).abs() < 1e-12);
        let at = spectrum.at(550e-9).unwrap();
        assert!((at.dhr.value - 0.25).abs() < 1e-12 && (at.index.unwrap()[0] - 1.55).abs() < 1e-12);
        assert!(spectrum.at(499e-9).is_none() && spectrum.at(701e-9).is_none());
        assert_eq!(spectrum.at(500e-9).unwrap(), spectrum.rows[0]);
    }

    #[test]
    fn faults_are_told() {
        for (text, what) in [
            ("wavelength_nm,dhr\n500,1.2\n", "line 2: `dhr` is 1.2, outside"),
            ("wavelength_nm,dhr\n500,0\n", "`dhr` is 0, outside"),
            ("wavelength_nm\n500\n", "dhr"),
            ("wavelength_nm,dhr\n5,0.5\n", "`wavelength_nm` is 5"),
            ("wavelength_nm,dhr\n500,0.5\n500,0.4\n", "twice"),
            ("wavelength_nm,dhr,theta_i_deg\n500,0.5,8\n600,0.4,20\n", "line 3: `theta_i_deg` is 20 after 8"),
            ("wavelength_nm,dhr,k\n500,0.5,1\n", "`k` without `n`"),
            ("wavelength_nm,dhr,n\n500,0.5,0.5\n", "below 1"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains(what), "{text}: {error}");
        }
    }
}
