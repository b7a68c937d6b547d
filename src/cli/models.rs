//! `asperity models`: the model library and the material library.

use super::print_json;
use super::quantity;
use crate::error::Error;
use crate::math::direction;
use crate::model::library::{self, LibraryMaterial};
use crate::model::{self, Absent, Entry, MODELS};
use crate::optics::Brdf;
use clap::Args;
use serde_json::{Value, json};

#[derive(Args)]
pub struct Arguments {
    /// A model (ward, or with parameters ward:rho_s=0.5,alpha=0.1) or material:NAME: its page and directional albedo
    #[arg(value_name = "MODEL")]
    model: Option<String>,
    /// List the materials of the library instead of the models
    #[arg(long, conflicts_with = "model")]
    materials: bool,
    /// Materials of this category only
    #[arg(long, requires = "materials")]
    category: Option<String>,
    /// Wavelength of the light; of materials, those that cover it only
    #[arg(long, value_parser = quantity::wavelength, value_name = "LENGTH")]
    wavelength: Option<f64>,
    /// Angle of incidence the data must reach; with the wavelength the albedo is listed
    #[arg(long, value_parser = quantity::angle, value_name = "ANGLE", requires = "materials")]
    theta_i: Option<f64>,
    /// Angle of reflection: f_r is listed too [default for the azimuth: the mirror side]
    #[arg(long, value_parser = quantity::angle, value_name = "ANGLE", requires = "theta_i", allow_hyphen_values = true)]
    theta_r: Option<f64>,
    /// Azimuth of reflection, that of incidence being 0
    #[arg(long, value_parser = quantity::angle, value_name = "ANGLE", requires = "theta_r", default_value = "180", allow_hyphen_values = true)]
    phi_r: f64,
}

/// Wavelength where none is asked for \[m\].
const GREEN: f64 = 550e-9;

/// Angles of the albedo table \[deg\].
const ANGLES: [u32; 8] = [0, 20, 45, 60, 75, 80, 85, 89];

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    match &a.model {
        Some(text) => one(text, a.wavelength.unwrap_or(GREEN), json),
        None if a.materials => materials(a, json),
        None if json => print_json(&json!({ "models": MODELS.iter().map(|m| page_json(m)).collect::<Vec<_>>() })),
        None => {
            for m in MODELS {
                page(m);
                println!();
            }
            println!(
                "layered:COAT,over=BASE\n    a model or table as first surface over another, (1 - R_i)(1 - R_o) on the base"
            );
            println!("    for example layered:ggx:alpha=0.05,n=1.5,over=lambert:rho=0.4\n");
            println!("material:NAME\n    a material of the library: asperity models --materials");
            Ok(())
        }
    }
}

/// The page of one model or material, with its directional albedo.
fn one(text: &str, wavelength: f64, json: bool) -> anyhow::Result<()> {
    let (page, name) = match library::name_in(text) {
        Some(name) => {
            let material = library::find(name)?;
            if !json {
                describe(&material);
            }
            (material_json(&material), text.to_owned())
        }
        None if model::layered::split(text).is_some() => (json!({ "name": "layered" }), text.to_owned()),
        None => {
            let entry = model::entry(text)?;
            if !json {
                page_of(entry);
            }
            // A bare name is shown by its example.
            let bare = !text.contains(':') && !entry.parameters.is_empty();
            (page_json(entry), if bare { entry.example.to_owned() } else { text.to_owned() })
        }
    };
    let brdf = model::parse(&name, wavelength)?;
    let albedo: Vec<f64> = ANGLES.iter().map(|d| brdf.albedo(f64::from(*d).to_radians())).collect();
    let excess = first_excess(brdf.as_ref());
    if json {
        return print_json(&json!({
            "model": page, "text": name, "wavelength_nm": wavelength * 1e9, "theta_i_deg": ANGLES, "albedo": albedo,
            "albedo_exceeds_1_from_deg": excess,
        }));
    }
    println!("\nDirectional albedo of {name} at {:.0} nm", wavelength * 1e9);
    println!("  theta_i, deg {}", ANGLES.map(|d| format!("{d:>8}")).concat());
    println!("  albedo       {}", albedo.iter().map(|e| format!("{e:>8.4}")).collect::<String>());
    if let Some(angle) = excess {
        eprintln!(
            "warning: {name} reflects more light than it receives from {angle} deg on; bounded=true scales it to 1 \
             without breaking reciprocity"
        );
    }
    Ok(())
}

/// First whole degree at which the albedo exceeds 1 by more than its own error.
fn first_excess(brdf: &dyn Brdf) -> Option<u32> {
    (0..=89).find(|d| brdf.albedo(f64::from(*d).to_radians()) > 1.002)
}

fn page(m: &Entry) {
    page_of(m);
    println!("    for example {}", m.example);
}

fn page_of(m: &Entry) {
    println!("{}\n    {}\n    {}", m.name, m.summary, m.formula);
    let width = m.parameters.iter().map(|p| p.name.len()).max().unwrap_or(0).max(10);
    for p in m.parameters {
        let absent = match p.absent {
            Absent::Is(value) => format!(", default {}", p.unit.write(value)),
            Absent::Said(other) => format!(", instead of {other}"),
            Absent::Fine => ", optional".to_owned(),
            Absent::Refused => String::new(),
        };
        println!("      {:<width$} {}: {}{absent}", p.name, p.meaning, p.range());
    }
    for w in m.words {
        let options = if w.options.is_empty() { "text".to_owned() } else { w.options.join(" | ") };
        println!("      {:<width$} {}: {options}", w.name, w.meaning);
    }
    if m.interface {
        println!("      {:<width$} interface by name instead of n and k: black-glass, epoxy, al, cu, ...", "material");
    }
    if m.is_spectral() {
        println!("      {:<width$} of the light, instead of the command's --wavelength", "wavelength");
    }
    if m.exceeds_one {
        println!("      {:<width$} true: scaled so that the albedo stays at or below 1; default false", "bounded");
    }
    let reciprocal = m.not_reciprocal.map_or("yes".to_owned(), |form| format!("yes, except form={form}"));
    println!("    reciprocal: {reciprocal}; energy: {}\n    source: {}", m.energy, m.source);
}

fn page_json(m: &Entry) -> Value {
    let parameters: Vec<_> = m
        .parameters
        .iter()
        .map(|p| {
            let instead_of = if let Absent::Said(name) = p.absent { Some(name) } else { None };
            json!({
                "name": p.name, "meaning": p.meaning, "unit": p.unit.name(), "range": p.range(),
                "default": p.default().map(|v| p.unit.write(v)), "instead_of": instead_of,
                "optional": p.absent == Absent::Fine,
            })
        })
        .collect();
    let words: Vec<_> =
        m.words.iter().map(|w| json!({ "name": w.name, "meaning": w.meaning, "options": w.options })).collect();
    json!({
        "name": m.name, "summary": m.summary, "formula": m.formula, "parameters": parameters, "words": words,
        "material": m.interface, "spectral": m.is_spectral(), "not_reciprocal_form": m.not_reciprocal,
        "exceeds_one": m.exceeds_one, "energy": m.energy, "source": m.source, "example": m.example,
    })
}

/// The query of the material library.
fn materials(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let all = library::all()?;
    let wanted = |m: &&LibraryMaterial| {
        a.category.as_ref().is_none_or(|c| m.category.eq_ignore_ascii_case(c))
            && a.wavelength.is_none_or(|l| m.covers(l))
            && a.theta_i.is_none_or(|t| m.theta_i_max >= t)
    };
    let found: Vec<&LibraryMaterial> = all.iter().filter(wanted).collect();
    if found.is_empty() {
        let mut categories: Vec<&str> = all.iter().map(|m| m.category.as_str()).collect();
        categories.sort_unstable();
        categories.dedup();
        let advice = format!("the categories are {}", categories.join(", "));
        return Err(Error::parameter("no material matches", advice).into());
    }
    let mut rows = Vec::new();
    for m in found {
        let mut seen = json!({});
        let mut text = String::new();
        if let Some(theta_i) = a.theta_i {
            let brdf = m.at(a.wavelength.unwrap_or(GREEN))?;
            let albedo = brdf.albedo(theta_i);
            seen["albedo"] = json!(albedo);
            text += &format!("  albedo {albedo:.4}");
            if let Some(theta_r) = a.theta_r {
                let f = brdf.eval(direction(theta_i, 0.0), direction(theta_r, a.phi_r));
                seen["f_r_per_sr"] = json!(f);
                text += &format!("  f_r {f:.5} /sr");
            }
        }
        rows.push((m, seen, text));
    }
    if json {
        let list: Vec<Value> = rows
            .into_iter()
            .map(|(m, seen, _)| {
                let mut entry = material_json(m);
                entry["geometry"] = seen;
                entry
            })
            .collect();
        return print_json(&json!({ "materials": list }));
    }
    let width = |f: fn(&LibraryMaterial) -> &str| rows.iter().map(|r| f(r.0).chars().count()).max().unwrap_or(0);
    let (name, category, title) = (width(|m| &m.name), width(|m| &m.category), width(|m| &m.title));
    for (m, _, text) in &rows {
        println!("{:<name$}  {:<category$}  {:<title$}  {:<12}{text}", m.name, m.category, m.title, range(m));
    }
    println!("\nUse one as material:NAME; asperity models material:NAME tells its source.");
    if let Some(folder) = library::folder() {
        println!("Your own go into {}.", folder.display());
    }
    Ok(())
}

fn range(m: &LibraryMaterial) -> String {
    m.range.map_or("any".to_owned(), |[low, high]| format!("{:.0}-{:.0} nm", low * 1e9, high * 1e9))
}

fn describe(m: &LibraryMaterial) {
    println!("{}\n    {} ({}), {}", m.name, m.title, m.category, range(m));
    if m.theta_i_max < 89f64.to_radians() {
        println!("    measured up to theta_i = {:.0} deg", m.theta_i_max.to_degrees());
    }
    for band in &m.bands {
        let at = band.wavelength.map_or(String::new(), |l| format!("{:.0} nm: ", l * 1e9));
        println!("      {at}{}", band.model);
    }
    if let Some(note) = &m.note {
        println!("    {note}");
    }
    println!("    source: {}\n    licence: {}", m.source, m.licence);
}

fn material_json(m: &LibraryMaterial) -> Value {
    let bands: Vec<_> =
        m.bands.iter().map(|b| json!({ "wavelength_nm": b.wavelength.map(|l| l * 1e9), "model": b.model })).collect();
    json!({
        "name": m.name, "title": m.title, "category": m.category, "source": m.source, "licence": m.licence,
        "note": m.note, "range_nm": m.range.map(|r| r.map(|l| l * 1e9)), "theta_i_max_deg": m.theta_i_max.to_degrees(),
        "bands": bands, "file": m.file,
    })
}
