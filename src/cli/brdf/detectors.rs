//! Detectors counted one by one.

use super::super::progress::Bar;
use super::super::source::file_name;
use super::{Answer, Arguments, degrees};
use crate::heightmap::{HeightMap, parameters};
use crate::meter::validity::{self, rayleigh_parameter};
use crate::output::write_bytes;
use crate::report::{Settings, detectors_csv};
use crate::scatter::count::Direction;
use crate::scatter::{Counting, Counts, Footprint, Method, Options, Run, Symmetry, count};
use serde_json::json;
use std::fmt::Write;

pub(super) fn run(a: &Arguments, settings: &Settings, map: &HeightMap) -> anyhow::Result<Answer> {
    let mut options: Options = settings.scatter.clone();
    if !a.scatter.names_azimuths() {
        options.phi_i = vec![0.0];
    }
    let counting = Counting {
        partition: a.counting.detectors.unwrap_or_default(),
        footprint: a.counting.footprint.map(|region| Footprint::of(region, map)).transpose()?,
        averaged: options.symmetry == Symmetry::Isotropic,
    };
    let mut run = a.parts.run(map, &options, &format!("{counting:?}"))?;
    let bar = Bar::new("scatter", 1);
    let counts = count(map, &options, &counting, &mut run, &|share| bar.set(0, share))?;
    bar.finish();
    if let Run::Part(sums) = &run {
        sums.save(&a.output)?;
        return Ok(Answer::of_part(sums));
    }
    write_bytes(&a.output, detectors_csv(&counts).as_bytes())?;
    let mut warnings: Vec<String> = counts.warnings.iter().map(ToString::to_string).collect();
    warnings.extend(too_smooth(map, &options, settings.wavelength).map(|w| w.to_string()));
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    let method = if options.method == Method::Rays { "rays" } else { "facets" };
    Ok(describe(&counts, &file_name(&a.map_file), method, &warnings))
}

/// The Rayleigh parameter falls with the angle: the first angle that is too flat speaks for all beyond.
fn too_smooth(map: &HeightMap, options: &Options, wavelength: f64) -> Option<validity::Warning> {
    let sq = parameters::sq(map);
    options.theta_i.iter().find_map(|&theta_i| {
        let g = rayleigh_parameter(sq, theta_i, wavelength);
        (sq > 0.0 && g < validity::SMALLEST_FOR_RAYS).then_some(validity::Warning::TooSmoothForRays {
            g,
            theta_i,
            sq,
            wavelength,
        })
    })
}

fn describe(counts: &Counts, name: &str, method: &str, warnings: &[String]) -> Answer {
    let of = |value: &dyn Fn(&Direction) -> f64| counts.directions.iter().map(value).collect::<Vec<f64>>();
    let empty = |d: &Direction| d.tally.hits.iter().filter(|h| **h == 0).count();
    let mut text = format!(
        "{name}: {} facets, {} detectors, method {method}\n\
         theta_i  phi_i    beams      albedo            1 bounce  2         3 +       lost      shadowed  empty\n",
        counts.statistics.facets,
        counts.detectors.len(),
    );
    for d in &counts.directions {
        let [one, two, more] = d.tally.bounce_fractions();
        let _ = writeln!(
            text,
            "{:>6.1}   {:>5.1}  {:>9}  {:.5} +- {:.5}  {one:.6}  {two:.6}  {more:.6}  {:.6}  {:.6}  {}",
            degrees(d.theta_i),
            degrees(d.phi_i),
            d.tally.beams,
            d.albedo.value,
            d.albedo.standard_error,
            d.tally.book().lost,
            d.tally.shadowed,
            empty(d),
        );
    }
    let json = json!({
        "method": method, "facets": counts.statistics.facets, "detectors": counts.detectors.len(),
        "theta_i_deg": of(&|d| degrees(d.theta_i)), "phi_i_deg": of(&|d| degrees(d.phi_i)),
        "albedo": of(&|d| d.albedo.value), "albedo_se": of(&|d| d.albedo.standard_error),
        "multiple_bounce_fraction": of(&|d| d.tally.multiple / d.tally.incident),
        "lost_fraction": of(&|d| d.tally.book().lost),
        "absorbed_fraction": of(&|d| d.tally.book().absorbed),
        "bounce_fractions": counts.directions.iter().map(|d| d.tally.bounce_fractions()).collect::<Vec<_>>(),
        "shadowed_fraction": of(&|d| d.tally.shadowed),
        "beams": counts.directions.iter().map(|d| d.tally.beams).collect::<Vec<_>>(),
        "empty_detectors": counts.directions.iter().map(empty).collect::<Vec<_>>(),
        "warnings": warnings,
    });
    Answer { json, text }
}
