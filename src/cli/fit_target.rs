//! `asperity fit --gloss 80,60 --haze 10`: the parameters for which the light meter reads wanted numbers.

use super::print_json;
use super::scatter_options::ScatterOptions;
use crate::error::Error;
use crate::fit::Family;
use crate::fit::target::{Solution, Wanted, solve};
use crate::meter::{self, Geometry};
use crate::model::{Absent, Definition, Parameter};
use crate::optics::{Brdf, fresnel, material::STANDARD_GLASS_INDEX};
use clap::Args;
use serde_json::json;

#[derive(Args)]
#[command(next_help_heading = "Readings to reach instead of a source")]
pub struct Flags {
    /// Specular gloss in GU; each value of the list is a target of its own
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    gloss: Vec<f64>,
    /// Angle of --gloss: 20, 60 or 85
    #[arg(long, default_value = "20", value_name = "DEG", value_parser = ["20", "60", "85"])]
    gloss_angle: String,
    /// Reflection haze 1.9 deg beside the 20 deg highlight, both sides together; each value a target of its own
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    haze: Vec<f64>,
}

impl Flags {
    /// Whether there is a reading to reach.
    pub fn is_given(&self) -> bool {
        !(self.gloss.is_empty() && self.haze.is_empty())
    }

    /// The pairs of gloss and haze to reach; one value of the one serves all of the other.
    fn targets(&self) -> Result<Vec<[Option<f64>; 2]>, Error> {
        let n = self.gloss.len().max(self.haze.len());
        for (name, list) in [("--gloss", &self.gloss), ("--haze", &self.haze)] {
            if ![0, 1, n].contains(&list.len()) {
                return Err(Error::parameter(
                    format!("{name} has {} values, the other list {n}", list.len()),
                    "give both lists as many values, or one of them a single one",
                ));
            }
            if let Some(v) = list.iter().find(|v| !(**v >= 0.0 && v.is_finite())) {
                return Err(Error::parameter(format!("{name} {v} cannot be read"), "give readings of 0 or more"));
            }
        }
        let value = |list: &[f64], k: usize| if list.len() > 1 { list.get(k) } else { list.first() }.copied();
        Ok((0..n).map(|k| [value(&self.gloss, k), value(&self.haze, k)]).collect())
    }
}

/// Readings within this are reached \[GU\].
const TOLERANCE: f64 = 0.05;

pub fn run(
    definition: &Definition,
    also: &[String],
    flags: &Flags,
    scatter: &ScatterOptions,
    json: bool,
) -> anyhow::Result<()> {
    let targets = flags.targets()?;
    let readings = usize::from(!flags.gloss.is_empty()) + usize::from(!flags.haze.is_empty());
    let (definition, assumed) = settle(definition, also, readings)?;
    for note in &assumed {
        eprintln!("note: {note}");
    }
    let family = Family::of_model(&definition, also, scatter.wavelength())?;
    let settings = scatter.settings()?;
    let [g20, g60, g85] = settings.glossmeter;
    let specular = match flags.gloss_angle.as_str() {
        "60" => g60,
        "85" => g85,
        _ => g20.clone(),
    };
    let beside = haze_geometries(&g20);
    // A search needs readings finer than the tolerance.
    let options = meter::Options { tolerance: 0.2 * TOLERANCE, ..settings.meter };
    let mut list = Vec::new();
    for [gloss, haze] in targets {
        let instruments = |brdf: &dyn Brdf| {
            let read = |g: &Geometry| meter::gloss(brdf, g, &options).value;
            let haze_reading = || beside.iter().map(read).sum();
            gloss.map(|_| read(&specular)).into_iter().chain(haze.map(|_| haze_reading())).collect()
        };
        let wanted: Vec<Wanted> =
            gloss.into_iter().chain(haze).map(|value| Wanted { value, tolerance: TOLERANCE }).collect();
        let found = solve(&family, &instruments, &wanted)?;
        list.push((gloss, haze, found));
    }
    let text = |s: &Solution| -> crate::Result<String> {
        let mut set = definition.clone();
        family.free().iter().zip(&s.values).try_for_each(|(f, &v)| set.set(&f.name, v))?;
        Ok(set.to_string())
    };
    if json {
        let mut targets = Vec::new();
        for (gloss, haze, found) in &list {
            let mut solutions = Vec::new();
            for s in found {
                let values: serde_json::Map<String, serde_json::Value> =
                    family.free().iter().zip(&s.values).map(|(f, v)| (f.name.clone(), json!(v))).collect();
                solutions.push(json!({ "model": text(s)?, "values": values, "readings": s.readings }));
            }
            targets.push(json!({ "gloss": gloss, "haze": haze, "solutions": solutions }));
        }
        return print_json(&json!({ "gloss_angle_deg": flags.gloss_angle, "assumed": assumed, "targets": targets }));
    }
    for (gloss, haze, found) in &list {
        let name = |label: &str, v: &Option<f64>| v.map(|v| format!("{label} {v}"));
        let gloss = name(&format!("gloss({}\u{b0})", flags.gloss_angle), gloss);
        let wanted: Vec<String> = gloss.into_iter().chain(name("haze", haze)).collect();
        for s in found {
            let values: Vec<String> =
                family.free().iter().zip(&s.values).map(|(f, v)| format!("{} = {v:.6}", f.name)).collect();
            let read: Vec<String> = s.readings.iter().map(|r| format!("{r:.2}")).collect();
            println!("{:<28} {}   (reads {})", wanted.join(", "), values.join(", "), read.join(", "));
        }
    }
    Ok(())
}

/// The two receptors beside the highlight: 1.8 by 5.5 deg at 18.1 and 21.9 deg.
fn haze_geometries(g20: &Geometry) -> [Geometry; 2] {
    let receptor = [1.8, 5.5].map(f64::to_radians);
    [-1.9f64, 1.9].map(|offset| Geometry { receptor, offset: offset.to_radians(), ..g20.clone() })
}

/// Gives what is not aimed at the value of polished black glass, until there are as many unknowns as readings: the
/// index, then the strength of the lobe. Returns what was assumed, in words.
fn settle(definition: &Definition, also: &[String], readings: usize) -> crate::Result<(Definition, Vec<String>)> {
    let mut settled = definition.clone();
    let mut assumed = Vec::new();
    let usual = |name: &str| match name {
        "n" => Some((STANDARD_GLASS_INDEX, "black glass")),
        // The lobe reflects rho_s cos_theta_i.
        "rho_s" => {
            let theta = 20f64.to_radians();
            Some((fresnel::dielectric(theta.cos(), STANDARD_GLASS_INDEX) / theta.cos(), "black glass at 20 deg"))
        }
        _ => None,
    };
    // What has a default keeps it unless it was named.
    let defaults: Vec<&Parameter> = definition
        .free()
        .into_iter()
        .filter(|p| matches!(p.absent, Absent::Is(_)) && !also.iter().any(|n| n == p.name))
        .collect();
    for p in defaults {
        settled.set(p.name, p.default().unwrap_or(p.min))?;
    }
    for name in ["n", "rho_s"] {
        let open = Family::of_model(&settled, also, 550e-9).map_or(0, |f| f.free().len());
        let is_open = settled.free().iter().any(|p| p.name == name) && !also.iter().any(|n| n == name);
        if open > readings
            && is_open
            && let Some((value, of)) = usual(name)
        {
            settled.set(name, value)?;
            assumed.push(format!("{name} = {value:.6} ({of}); write {name}=... into --model to change it"));
        }
    }
    Ok((settled, assumed))
}
