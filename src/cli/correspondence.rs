//! `asperity correspondence`: what the meters read along one parameter of a model, or of Gaussian surfaces by rays and by
//! waves.

use super::print_json;
use super::progress::Bar;
use super::{quantity, written};
use crate::chart::parameter_chart;
use crate::chart::ray_wave::ray_wave_chart;
use crate::error::Error;
use crate::meter::Options;
use crate::meter::correspondence::{Row, correspondence, ratios};
use crate::meter::ray_wave::{Plan, Reading, ray_wave};
use crate::model;
use crate::optics::Material;
use crate::optics::material::STANDARD_GLASS_INDEX;
use crate::output::write_bytes;
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// Model without the parameter that varies, such as ward:rho_s=0.0491. Without it: Ward, Phong and Cook-Torrance
    /// with the reflectance of the gloss standard
    #[arg(value_name = "MODEL")]
    model: Option<String>,
    /// The parameter that varies, with its range: alpha=0.002..0.5
    #[arg(long, value_name = "KEY=LOW..HIGH", requires = "model")]
    vary: Option<String>,
    /// Values of the parameter, in equal ratios
    #[arg(long, default_value_t = 19, value_parser = clap::value_parser!(u32).range(2..=1000))]
    steps: u32,
    /// Gloss by rays and by waves of Gaussian surfaces instead: Sq 20 nm to 2 um, autocorrelation length 3 um to 100 um
    #[arg(long, conflicts_with_all = ["model", "vary", "steps"])]
    surfaces: bool,
    /// Points along each side of those surfaces
    #[arg(long, default_value_t = 256, requires = "surfaces", value_name = "N")]
    size: usize,
    /// Wavelength at which materials are looked up
    #[arg(long, value_parser = quantity::wavelength, default_value = "550nm")]
    wavelength: f64,
    /// Write the tables as CSV
    #[arg(short, long, value_name = "FILE.csv", value_parser = written::csv)]
    output: Option<PathBuf>,
    /// Draw the first table (.png; with --surfaces .svg too)
    #[arg(long, value_name = "FILE", value_parser = written::drawing)]
    chart: Option<PathBuf>,
}

/// A model and the range of its parameter.
struct Family {
    model: String,
    key: String,
    low: f64,
    high: f64,
}

/// Ward and Phong carry R(20 deg) of the standard as their strength, Cook-Torrance its index.
const USUAL: [(&str, &str, f64, f64); 3] = [
    ("ward:rho_s=0.0490781", "alpha", 0.002, 0.5),
    ("phong:rho_s=0.0490781", "exponent", 10.0, 30000.0),
    ("cook-torrance:n=1.567", "alpha", 0.002, 0.5),
];

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    if a.surfaces {
        return surfaces(a, json);
    }
    if let Some(path) = a.chart.as_ref().filter(|path| written::ending(path) != "png") {
        return Err(Error::parameter(format!("{} is no name for this chart", path.display()), "name it .png").into());
    }
    let options = Options { tolerance: 0.01, max_points: 32768, ..Options::default() };
    let mut tables = Vec::new();
    for family in families(a)? {
        let separator = if family.model.contains(':') { ',' } else { ':' };
        let build = |v: f64| model::parse(&format!("{}{separator}{}={v}", family.model, family.key), a.wavelength);
        let table = |count: u32| correspondence(&build, &ratios(family.low, family.high, count as usize), &options);
        let rows = table(a.steps)?;
        if let Some(path) = a.chart.as_ref().filter(|_| tables.is_empty()) {
            // Four points where the table has one make the curves round.
            draw(&family, &table(4 * (a.steps - 1) + 1)?).save_png(path)?;
        }
        tables.push((family, rows));
    }
    if let Some(path) = &a.output {
        write_bytes(path, as_csv(&tables).as_bytes())?;
    }
    if json {
        let list: Vec<_> = tables.iter().map(|(f, rows)| as_json(f, rows)).collect();
        return print_json(&json!({ "correspondence": list }));
    }
    for (family, rows) in &tables {
        println!("{}", family.model);
        println!("{:>12}  {:>9}  {:>9}  {:>9}  {:>9}", family.key, "20 deg", "60 deg", "85 deg", "haze");
        for r in rows {
            let [a, b, c] = r.gloss.map(|g| g.value);
            println!("{:>12.6}  {a:>9.3}  {b:>9.3}  {c:>9.3}  {:>9.3}", r.parameter, r.haze.value);
        }
        println!();
    }
    println!("Gloss in GU; haze of both sides of 20 deg together (instrument haze-20). The way back, from readings to");
    println!("parameters: asperity fit --model ward --gloss 80,60,40,20");
    a.output.iter().chain(&a.chart).for_each(|path| println!("wrote {}", path.display()));
    Ok(())
}

fn families(a: &Arguments) -> anyhow::Result<Vec<Family>> {
    let Some(model) = &a.model else {
        let usual = |(model, key, low, high): (&str, &str, f64, f64)| Family {
            model: model.to_owned(),
            key: key.to_owned(),
            low,
            high,
        };
        return Ok(USUAL.map(usual).into());
    };
    let bad = |what: String| crate::Error::parameter(what, "write for example --vary alpha=0.002..0.5");
    let vary = a.vary.as_deref().ok_or_else(|| bad("the parameter that varies is not named".into()))?;
    let parts = vary.split_once('=').and_then(|(key, range)| Some((key, range.split_once("..")?)));
    let (key, (low, high)) = parts.ok_or_else(|| bad(format!("`--vary {vary}` is not KEY=LOW..HIGH")))?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| bad(format!("`{text}` is not a number")));
    let (low, high) = (number(low)?, number(high)?);
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Err(bad(format!("`--vary {vary}` is not a rising range above 0")).into());
    }
    Ok(vec![Family { model: model.clone(), key: key.trim().to_owned(), low, high }])
}

fn as_csv(tables: &[(Family, Vec<Row>)]) -> String {
    let mut csv = String::from("model,parameter,value,gloss_20,gloss_60,gloss_85,haze,largest_standard_error\n");
    for (family, rows) in tables {
        for r in rows {
            let [a, b, c] = r.gloss.map(|g| g.value);
            let worst = r.gloss.iter().chain([&r.haze]).map(|e| e.standard_error).fold(0.0, f64::max);
            let (model, key) = (&family.model, &family.key);
            let _ = writeln!(
                csv,
                "\"{model}\",{key},{:.8},{a:.4},{b:.4},{c:.4},{:.4},{worst:.4}",
                r.parameter, r.haze.value
            );
        }
    }
    csv
}

fn as_json(family: &Family, rows: &[Row]) -> serde_json::Value {
    let rows: Vec<_> = rows
        .iter()
        .map(|r| json!({ "value": r.parameter, "gloss": { "20": r.gloss[0], "60": r.gloss[1], "85": r.gloss[2] }, "haze": r.haze }))
        .collect();
    json!({ "model": family.model, "parameter": family.key, "rows": rows })
}

fn draw(family: &Family, rows: &[Row]) -> crate::chart::Raster {
    let curve = |label: &str, of: &dyn Fn(&Row) -> f64| {
        (label.to_owned(), rows.iter().map(|r| (r.parameter, of(r))).collect::<Vec<_>>())
    };
    let curves = [
        curve("gloss 20\u{b0}", &|r| r.gloss[0].value),
        curve("gloss 60\u{b0}", &|r| r.gloss[1].value),
        curve("gloss 85\u{b0}", &|r| r.gloss[2].value),
        curve("haze", &|r| r.haze.value),
    ];
    parameter_chart(&family.model, &family.key, "gloss and haze, GU", &curves)
}

/// Surfaces of `--surfaces`: polished to matt, short to long structures.
const SURFACES_SQ_NM: [f64; 11] = [20.0, 30.0, 50.0, 80.0, 120.0, 200.0, 300.0, 500.0, 800.0, 1200.0, 2000.0];
const SURFACES_ACL_UM: [f64; 7] = [3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0];

/// Rays against waves over Sq and autocorrelation length.
fn surfaces(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let plan = Plan {
        sq: SURFACES_SQ_NM.map(|v| v * 1e-9).to_vec(),
        acl: SURFACES_ACL_UM.map(|v| v * 1e-6).to_vec(),
        wavelength: a.wavelength,
        material: Material::Dielectric { n: STANDARD_GLASS_INDEX },
        size: a.size,
        seed: 1,
    };
    let bar = Bar::new("surfaces", 1);
    let readings = ray_wave(&plan, &|share| bar.set(0, share))?;
    bar.finish();
    if let Some(path) = &a.output {
        write_bytes(path, surfaces_csv(&readings).as_bytes())?;
    }
    if let Some(path) = &a.chart {
        let title = format!(
            "Gloss of Gaussian surfaces of black glass: waves less rays, {:.0} nm, {1} x {1} points",
            a.wavelength * 1e9,
            a.size
        );
        let drawing = ray_wave_chart(&readings, a.wavelength, &title);
        if written::ending(path) == "svg" {
            write_bytes(path, drawing.to_svg().as_bytes())?;
        } else {
            drawing.to_raster().save_png(path)?;
        }
    }
    if json {
        let list: Vec<_> = readings
            .iter()
            .map(|r| {
                json!({
                    "Sq_m": r.sq, "acl_m": r.acl, "theta_i_deg": r.theta_i.to_degrees(), "g": r.g, "ray": r.ray,
                    "wave": r.wave, "wave_in_doubt": r.doubt,
                })
            })
            .collect();
        return print_json(&json!({ "surfaces": list, "wavelength_nm": a.wavelength * 1e9 }));
    }
    println!("{:>8}  {:>8}  {:>7}  {:>8}  {:>9}  {:>9}", "Sq, nm", "ACL, um", "theta_i", "g", "rays, GU", "waves, GU");
    for r in &readings {
        let (sq, acl, star) = (r.sq * 1e9, r.acl * 1e6, if r.doubt { " *" } else { "" });
        let (theta, g, ray, wave) = (r.theta_i.to_degrees(), r.g, r.ray.value, r.wave.value);
        println!("{sq:>8.1}  {acl:>8.2}  {theta:>7.0}  {g:>8.3}  {ray:>9.3}  {wave:>9.3}{star}");
    }
    println!("* second bounces or sharp curvature: the wave calculation is in doubt too");
    a.output.iter().chain(&a.chart).for_each(|path| println!("wrote {}", path.display()));
    Ok(())
}

fn surfaces_csv(readings: &[Reading]) -> String {
    let mut csv = String::from(
        "sq_nm,acl_um,theta_i_deg,g,ray_gu,ray_standard_error,wave_gu,wave_standard_error,wave_in_doubt\n",
    );
    for r in readings {
        let _ = writeln!(
            csv,
            "{:.4},{:.4},{:.0},{:.5},{:.4},{:.4},{:.4},{:.4},{}",
            r.sq * 1e9,
            r.acl * 1e6,
            r.theta_i.to_degrees(),
            r.g,
            r.ray.value,
            r.ray.standard_error,
            r.wave.value,
            r.wave.standard_error,
            r.doubt
        );
    }
    csv
}
