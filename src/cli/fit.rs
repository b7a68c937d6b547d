//! `asperity fit`: the parameters of a model from a source, a list of `f_r`, or instrument readings.

use super::fit_target;
use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::quantity;
use super::scatter_options::ScatterOptions;
use super::source::{Source, file_name};
use super::written;
use crate::chart::fit_page;
use crate::columns::Columns;
use crate::error::Error;
use crate::fit::{Design, Family, Fitted, Observations, Options, Residual, Search, Weights, errors_from_repeats, fit};
use crate::math::Estimate;
use crate::model::{Definition, Parameter};
use crate::optics::Brdf;
use crate::output::write_bytes;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Arguments {
    /// Height map, table, model, or list of f_r (.csv with theta_i_deg, phi_i_deg, theta_r_deg,
    /// phi_r_deg, f_r_per_sr and, if known, standard_error); none with --gloss or --haze
    #[arg(required_unless_present_any = ["gloss", "haze"])]
    source: Option<String>,
    /// Model to fit; what is given a value stays, such as ward:rho_d=0
    #[arg(long, value_name = "NAME[:KEY=VALUE,...]")]
    model: String,
    /// Parameters to vary besides those without a value, such as alpha_x,alpha_y or k
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    free: Vec<String>,
    /// Where to write the residuals: .csv, or .png for a page with slices and residuals
    #[arg(short, long, value_name = "FILE", value_parser = written::csv_or_png)]
    output: Option<PathBuf>,
    /// Incident polar angles in degrees to look at the source [default: 5,20,35,50,60,70,80]
    #[arg(long, value_parser = quantity::angle, value_delimiter = ',', value_name = "LIST")]
    angles: Option<Vec<f64>>,
    /// Directions per incident angle
    #[arg(long, default_value_t = 160, value_parser = clap::value_parser!(u32).range(1..=1_000_000), value_name = "N")]
    directions: u32,
    /// What is compared [default: linear with error bars, log without]
    #[arg(long, value_enum)]
    residual: Option<ResidualFlag>,
    /// What each value counts [default: error bars if there are any, else equal]
    #[arg(long, value_enum)]
    weights: Option<WeightsFlag>,
    /// Error of the model as a share of f_r, added to the error bars
    #[arg(long, value_parser = quantity::share, default_value = "1%", value_name = "SHARE")]
    error_floor: f64,
    /// Places from which the search descends
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..), value_name = "N")]
    starts: u16,
    #[command(flatten)]
    target: fit_target::Flags,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum ResidualFlag {
    Linear,
    Log,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum WeightsFlag {
    Errors,
    SolidAngle,
    Equal,
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let definition = Definition::parse(&a.model)?;
    if a.target.is_given() {
        if a.source.is_some() {
            return Err(Error::parameter(
                "a source and instrument readings are two different fits",
                "leave out the source, or --gloss and --haze",
            )
            .into());
        }
        return fit_target::run(&definition, &a.free, &a.target, &a.scatter, json);
    }
    let family = Family::of_model(&definition, &a.free, a.scatter.wavelength())?;
    let text = a.source.as_deref().unwrap_or_default();
    let (data, source) = observe(a, text)?;
    let suited = Options::suited_to(&data);
    let options = Options {
        residual: a.residual.map_or(suited.residual, |r| match r {
            ResidualFlag::Linear => Residual::Linear,
            ResidualFlag::Log => Residual::Logarithmic,
        }),
        weights: a.weights.map_or(suited.weights, |w| match w {
            WeightsFlag::Errors => Weights::Errors,
            WeightsFlag::SolidAngle => Weights::SolidAngle,
            WeightsFlag::Equal => Weights::Equal,
        }),
        error_floor: a.error_floor.max(0.0),
        search: Search { starts: a.starts.into(), ..suited.search },
    };
    let mut found = fit(&family, &data, &options)?;
    // The error bars of one map are the same in all directions: what its sub-areas say counts.
    let repeats = source.as_ref().map_or_else(Vec::new, |s| subareas(s, &data));
    if repeats.len() >= FEWEST_SUBAREAS {
        let errors = errors_from_repeats(&family, &found, &repeats, &options);
        found.parameters.iter_mut().zip(errors).for_each(|(p, e)| p.standard_error = e);
    }
    let error_source = if repeats.len() >= FEWEST_SUBAREAS { "sub-areas" } else { "covariance" };
    let fitted = with_values(&definition, &found)?;
    let model = fitted.build(a.scatter.wavelength())?;
    for warning in &found.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(path) = &a.output {
        let page = || {
            let notes = notes(&fitted, &found, &options, data.list.len(), error_source);
            let title = format!("{} as {}", file_name(Path::new(text)), fitted.entry().name);
            let brdf = source.as_ref().map(Source::brdf);
            fit_page(&data, brdf, model.as_ref(), &title, &notes)
        };
        if written::ending(path) == "csv" {
            write_bytes(path, data.residual_csv(model.as_ref()).as_bytes())?;
        } else {
            page().save_png(path)?;
        }
    }
    if json {
        return print_json(&json!({
            "source": text, "model": fitted.to_string(), "parameters": found.parameters, "values": data.list.len(),
            "chi2": found.chi2, "dof": found.dof, "chi2_per_dof": found.chi2_per_dof(),
            "rms_log_error": found.rms_log_error, "residual": format!("{:?}", options.residual).to_lowercase(),
            "standard_errors_from": error_source, "weights": format!("{:?}", options.weights).to_lowercase(),
            "warnings": found.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        }));
    }
    for line in notes(&fitted, &found, &options, data.list.len(), error_source) {
        println!("{line}");
    }
    Ok(())
}

/// Looks at the source; a list of `f_r` has no source behind it.
fn observe(a: &Arguments, text: &str) -> anyhow::Result<(Observations, Option<Source>)> {
    let path = Path::new(text);
    // A height map may be a .csv file too, but has no angles.
    let listed = |c: &Columns| c.has("f_r_per_sr") || c.has("theta_i_deg") || c.has("theta_r_deg");
    if written::ending(path) == "csv" && Columns::read(path).is_ok_and(|c| listed(&c)) {
        return Ok((Observations::read(path)?, None));
    }
    let bar = Bar::new("source", 1);
    let source = Source::open(text, &a.map, &a.scatter, &|share| bar.set(0, share))?;
    bar.finish();
    source.print_preparation();
    let table = source.surface().map(|p| p.brdf.table());
    let design = Design { directions: a.directions as usize, ..Design::default() };
    let theta_i = a.angles.clone().unwrap_or(design.theta_i);
    // A brushed surface looks different from every side.
    let phi_i = if table.is_none_or(|t| t.is_isotropic()) {
        vec![0.0]
    } else {
        [0.0, 45.0, 90.0, 135.0].map(f64::to_radians).to_vec()
    };
    let brdf: &dyn Brdf = source.brdf();
    let estimate = |wi, wo| table.map_or_else(|| Estimate::exact(brdf.eval(wi, wo)), |t| t.estimate(wi, wo));
    let data = Observations::of(brdf, &estimate, &Design { theta_i, phi_i, ..design })?;
    Ok((data, Some(source)))
}

/// Sub-areas from which a scatter is worth having.
const FEWEST_SUBAREAS: usize = 4;

/// The same directions on each sub-area of the map behind a table.
fn subareas(source: &Source, data: &Observations) -> Vec<Observations> {
    let Some(table) = source.surface().map(|p| p.brdf.table()) else { return Vec::new() };
    (0..table.subareas())
        .map(|k| {
            let part = table.of_subarea(k);
            let mut repeat = data.clone();
            repeat.list.iter_mut().for_each(|o| o.f_r.value = part.eval(o.wi, o.wo));
            repeat
        })
        .collect()
}

/// The definition with everything found.
fn with_values(definition: &Definition, found: &Fitted) -> crate::Result<Definition> {
    let mut fitted = definition.clone();
    found.parameters.iter().try_for_each(|p| fitted.set(&p.name, p.value))?;
    Ok(fitted)
}

/// What was found, line by line.
fn notes(fitted: &Definition, found: &Fitted, options: &Options, values: usize, error_source: &str) -> Vec<String> {
    let mut lines = vec![format!("{}: {}", fitted.entry().name, fitted.entry().summary)];
    for p in &found.parameters {
        let parameter = fitted.entry().parameters.iter().find(|q| q.name == p.name);
        lines.push(format!("  {:<10} {}", p.name, value_text(parameter, p.value, p.standard_error)));
    }
    let compared = match options.residual {
        Residual::Linear => "differences",
        Residual::Logarithmic => "logarithms",
    };
    let counted = match options.weights {
        Weights::Errors => "weighed by error bars",
        Weights::SolidAngle => "weighed by solid angle",
        Weights::Equal => "of equal weight",
    };
    let goodness = match options.weights {
        Weights::Errors => format!("chi2/dof {:.3}, ", found.chi2_per_dof()),
        _ => String::new(),
    };
    lines.push(format!(
        "{goodness}rms of ln(model/data) {:.4}; {values} {compared} {counted}; standard errors from {error_source}",
        found.rms_log_error
    ));
    lines
}

/// `0.0600 +- 0.0002` with the unit of the parameter.
pub fn value_text(parameter: Option<&Parameter>, value: f64, error: Option<f64>) -> String {
    let unit = parameter.map_or("", |p| p.unit.name());
    // SI to the printed unit.
    let scale = match unit {
        "um" => 1e6,
        "deg" => 180.0 / std::f64::consts::PI,
        _ => 1.0,
    };
    let (value, error) = (value * scale, error.map(|e| e * scale));
    let number = match error {
        // Two digits of the error decide the decimals.
        Some(e) if e > 0.0 => {
            let decimals = (1.0 - e.log10().floor()).clamp(0.0, 9.0) as usize;
            format!("{value:.decimals$} +- {e:.decimals$}")
        }
        _ => format!("{value:.6}"),
    };
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}
