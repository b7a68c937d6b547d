//! `asperity protocol`: a NEF-BM material from the scans of a goniometer, or the scans of a planted material.

use super::fit::value_text;
use super::print_json;
use crate::error::Error;
use crate::fit::protocol::{Characterised, Law, Noise, Scans, characterise, simulate};
use crate::model::Definition;
use crate::output::write_bytes;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Files: ZERO.csv has theta_deg, co_per_sr, cross_per_sr (source and detector in one direction); SPECULAR.csv has
/// theta_i_deg, theta_r_deg, polarisation (s or p), f_r_per_sr; BISTATIC.csv has beta_deg, theta_h_deg, co_per_sr,
/// cross_per_sr (source and detector 2 beta apart, the specimen turned by theta_h). Errors, if known, stand in co_error,
/// cross_error and standard_error. --simulate writes examples of all three.
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
    /// Write the scans of this nef-bm model instead
    #[arg(long, value_name = "MODEL", conflicts_with = "scans", requires = "output")]
    simulate: Option<String>,
    /// Noise of --simulate as a share of each value
    #[arg(long, default_value_t = 0.01, value_name = "SHARE")]
    noise: f64,
    /// Noise of --simulate everywhere \[1/sr\]
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
    let found = characterise(&scans, law)?;
    for warning in &found.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(path) = &a.output {
        write_bytes(path, residual_csv(&found).as_bytes())?;
    }
    let chi2_per_dof = found.chi2 / found.dof as f64;
    let albedo = found.definition.build(550e-9)?.albedo(20f64.to_radians());
    if json {
        let parameters: Vec<_> = found
            .parameters
            .iter()
            .map(|p| json!({ "name": p.name, "value": p.value, "standard_error": p.standard_error }))
            .collect();
        let steps: Vec<_> = found
            .steps
            .iter()
            .map(|s| {
                let values: serde_json::Map<String, serde_json::Value> =
                    s.found.iter().map(|(name, v)| ((*name).to_owned(), json!(v))).collect();
                json!({ "step": s.name, "found": values, "rms_in_errors": s.rms, "values": s.values })
            })
            .collect();
        return print_json(&json!({
            "model": found.definition.to_string(), "parameters": parameters, "steps": steps, "chi2": found.chi2,
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
    Ok(())
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
