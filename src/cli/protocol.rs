//! `asperity protocol`: a NEF-BM material from the scans of a goniometer, or the scans of a planted material.

use super::fit::value_text;
use super::print_json;
use super::quantity;
use crate::error::Error;
use crate::fit::FittedParameter;
use crate::fit::protocol::{Band, Characterised, Law, Noise, Scans, Spectrum, carry, characterise, simulate};
use crate::math::Estimate;
use crate::model::Definition;
use crate::model::library::LibraryMaterial;
use crate::output::write_bytes;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Files: ZERO.csv has theta_deg, co_per_sr, cross_per_sr (source and detector in one direction); SPECULAR.csv has
/// theta_i_deg, theta_r_deg, polarisation (s or p), f_r_per_sr; BISTATIC.csv has beta_deg, theta_h_deg, co_per_sr,
/// cross_per_sr (source and detector 2 beta apart, the specimen turned by theta_h). Errors, if known, stand in co_error,
/// cross_error and standard_error. --simulate writes examples of all three. --dhr carries the material to other
/// wavelengths, --material writes it for the library.
#[derive(Args)]
pub struct Arguments {
    /// Zero-bistatic, specular and fixed-bistatic scan
    #[arg(num_args = 3, value_names = ["ZERO.csv", "SPECULAR.csv", "BISTATIC.csv"], required_unless_present = "simulate")]
    scans: Vec<PathBuf>,
    /// Law of the facet normals
    #[arg(long, value_enum, default_value_t = LawFlag::Cauchy)]
    distribution: LawFlag,
    /// Where to write the residuals (.csv); with --simulate the folder of the three scans
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Directional-hemispherical reflectance over the spectrum: columns wavelength_nm, dhr, and dhr_error, theta_i_deg
    /// (one angle, else 20 deg), n, k if known
    #[arg(long, value_name = "DHR.csv", conflicts_with = "simulate")]
    dhr: Option<PathBuf>,
    /// Wavelength of the scans, at which both reflectances are compared
    #[arg(long, value_parser = quantity::wavelength, value_name = "LENGTH", conflicts_with = "simulate")]
    wavelength: Option<f64>,
    /// Where to write the material as material:NAME reads it (.toml), one band per wavelength
    #[arg(long, value_name = "NAME.toml", value_parser = super::written::toml, conflicts_with = "simulate")]
    material: Option<PathBuf>,
    /// Category of that material
    #[arg(long, default_value = "paint", requires = "material")]
    category: String,
    /// Write the scans of this nef-bm model instead
    #[arg(long, value_name = "MODEL", conflicts_with = "scans", requires = "output")]
    simulate: Option<String>,
    /// Noise of --simulate as a share of each value
    #[arg(long, value_parser = quantity::share, default_value = "1%", value_name = "SHARE")]
    noise: f64,
    /// Noise of --simulate everywhere, in 1/sr
    #[arg(long, default_value_t = 1e-5, value_name = "PER_SR")]
    noise_floor: f64,
    /// Same seed, same scans
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum LawFlag {
    Cauchy,
    Gaussian,
    Scan,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    if let (Some(planted), Some(folder)) = (&a.simulate, &a.output) {
        return write_scans(a, planted, folder, json);
    }
    let [zero, specular, bistatic] = a.scans.as_slice() else {
        return Err(Error::parameter("three scans are needed", "give ZERO.csv SPECULAR.csv BISTATIC.csv").into());
    };
    let law = match a.distribution {
        LawFlag::Cauchy => Law::Cauchy,
        LawFlag::Gaussian => Law::Gaussian,
        LawFlag::Scan => Law::Scan,
    };
    let scans = Scans::read(zero, specular, bistatic)?;
    let spectrum = a.dhr.as_deref().map(Spectrum::read).transpose()?;
    let mut found = characterise(&scans, law)?;
    let bands = match &spectrum {
        Some(spectrum) => {
            let (bands, warning) = carry(&found, spectrum, a.wavelength)?;
            found.warnings.extend(warning);
            bands
        }
        None => Vec::new(),
    };
    for warning in &found.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(path) = &a.material {
        write_bytes(path, material_text(path, &a.category, &found, &bands, a.wavelength)?.as_bytes())?;
    }
    if let Some(path) = &a.output {
        write_bytes(path, residual_csv(&found).as_bytes())?;
    }
    let chi2_per_dof = found.chi2 / found.dof as f64;
    let albedo = found.definition.build(550e-9)?.albedo(20f64.to_radians());
    if json {
        let steps: Vec<_> = found
            .steps
            .iter()
            .map(|s| {
                let values: serde_json::Map<String, serde_json::Value> =
                    s.found.iter().map(|(name, v)| ((*name).to_owned(), json!(v))).collect();
                json!({ "step": s.name, "found": values, "rms_in_errors": s.rms, "values": s.values })
            })
            .collect();
        let bands: Vec<_> = bands.iter().map(band_json).collect();
        return print_json(&json!({
            "bands": bands, "theta_i_deg": spectrum.map(|s| s.theta_i.to_degrees()),
            "model": found.definition.to_string(), "parameters": found.parameters, "steps": steps, "chi2": found.chi2,
            "dof": found.dof, "chi2_per_dof": chi2_per_dof, "albedo_20_deg": albedo,
            "warnings": found.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        }));
    }
    let parameter = |name: &str| found.definition.entry().parameters.iter().find(|p| p.name == name);
    println!("step by step");
    for s in &found.steps {
        let values: Vec<String> =
            s.found.iter().map(|(name, v)| format!("{name} {}", value_text(parameter(name), *v, None))).collect();
        println!("  {:<42} {}   (rms {:.2} errors, {} values)", s.name, values.join(", "), s.rms, s.values);
    }
    println!("all together");
    for p in &found.parameters {
        println!("  {:<8} {}", p.name, value_text(parameter(&p.name), p.value, p.standard_error));
    }
    println!("chi2/dof {chi2_per_dof:.3} ({} degrees of freedom); albedo at 20 deg {albedo:.4}", found.dof);
    println!("{}", found.definition);
    if let Some(spectrum) = &spectrum {
        println!("scaled to the hemispherical reflectance at {:.0} deg", spectrum.theta_i.to_degrees());
        for band in &bands {
            println!("  {:>6.0} nm  scale {}  {}", band.wavelength * 1e9, in_digits(&band.scale), of_band(band));
        }
    }
    Ok(())
}

fn in_digits(e: &Estimate) -> String {
    value_text(None, e.value, Some(e.standard_error))
}

/// What differs from band to band, with errors.
fn of_band(band: &Band) -> String {
    let entry = band.definition.entry();
    let one = |p: &FittedParameter| {
        let parameter = entry.parameters.iter().find(|q| q.name == p.name);
        format!("{} {}", p.name, value_text(parameter, p.value, p.standard_error))
    };
    band.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn band_json(band: &Band) -> serde_json::Value {
    json!({
        "wavelength_nm": band.wavelength * 1e9, "scale": band.scale.value, "scale_error": band.scale.standard_error,
        "parameters": band.parameters, "model": band.definition.to_string(),
    })
}

/// A material file for the library; without bands it holds the wavelength of the scans, or any.
fn material_text(
    path: &Path,
    category: &str,
    found: &Characterised,
    bands: &[Band],
    scanned_at: Option<f64>,
) -> anyhow::Result<String> {
    let name = path.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let mut text = format!(
        "name = {}\ntitle = {}\ncategory = {}\nsource = \"fitted by asperity protocol to scans of a goniometer\"\n\
         licence = \"that of the scans\"\n",
        toml::Value::from(name),
        toml::Value::from(name),
        toml::Value::from(category),
    );
    let mut band = |wavelength: Option<f64>, note: &str, definition: &Definition| {
        let _ = writeln!(text, "\n[[band]]");
        if let Some(l) = wavelength {
            let _ = writeln!(text, "wavelength_nm = {}", (l * 1e12).round() / 1e3);
        }
        let _ = writeln!(text, "# {note}\nmodel = \"{definition}\"");
    };
    if bands.is_empty() {
        band(scanned_at, "as scanned", &found.definition);
    }
    for b in bands {
        band(Some(b.wavelength), &format!("scale {}, {}", in_digits(&b.scale), of_band(b)), &b.definition);
    }
    // What the library could not read is not written.
    LibraryMaterial::read(&text, path, false)?;
    Ok(text)
}

fn write_scans(a: &Arguments, planted: &str, folder: &Path, json: bool) -> anyhow::Result<()> {
    for (name, v) in [("--noise", a.noise), ("--noise-floor", a.noise_floor)] {
        if !(v >= 0.0 && v.is_finite()) {
            return Err(Error::parameter(format!("{name} {v} is no noise"), "give a number of 0 or more").into());
        }
    }
    let noise = Noise { share: a.noise, floor: a.noise_floor, seed: a.seed };
    let scans = simulate(&Definition::parse(planted)?, noise)?;
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    let paths = ["zero_bistatic.csv", "specular.csv", "bistatic.csv"].map(|name| folder.join(name));
    for (path, text) in paths.iter().zip(scans.to_csv()) {
        write_bytes(path, text.as_bytes())?;
    }
    if json {
        return print_json(&json!({ "files": paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>() }));
    }
    paths.iter().for_each(|p| println!("wrote {}", p.display()));
    Ok(())
}

/// One row per value: which, where, measured, model, and the difference in errors.
fn residual_csv(found: &Characterised) -> String {
    let mut text =
        "scan,channel,theta_h_deg,beta_deg,measured_per_sr,standard_error,model_per_sr,difference_in_errors\n"
            .to_owned();
    for r in &found.residuals {
        let (t, b) = (r.theta_h.to_degrees(), r.beta.to_degrees());
        let difference = r.model - r.measured.value;
        let in_errors = if r.measured.standard_error > 0.0 {
            format!("{:.3}", difference / r.measured.standard_error)
        } else {
            String::new()
        };
        let _ = writeln!(
            text,
            "{},{},{t:.4},{b:.4},{:.6e},{:.3e},{:.6e},{in_errors}",
            r.scan, r.channel, r.measured.value, r.measured.standard_error, r.model
        );
    }
    text
}
