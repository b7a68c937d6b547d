//! Detectors counted one by one.

use super::super::progress::Bar;
use super::super::source::file_name;
use super::{Answer, Arguments, degrees};
use crate::heightmap::{HeightMap, parameters};
use crate::meter::validity::{self, check_waves};
use crate::output::write_bytes;
use crate::report::{Settings, detectors_csv};
use crate::scatter::count::Direction;
use crate::scatter::{Counting, Counts, Decision, Method, Run, Symmetry, count};
use serde_json::json;
use std::fmt::Write;

pub(super) fn run(a: &Arguments, settings: &Settings, map: &HeightMap) -> anyhow::Result<Answer> {
    let mut options = settings.scatter.clone();
    if !a.scatter.names_azimuths() {
        options.phi_i = vec![0.0];
    }
    let counting = Counting {
        partition: a.counting.detectors.unwrap_or_default(),
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
    warnings.extend(too_smooth(map, &counts.decisions, settings.wavelength).map(|w| w.to_string()));
    warnings.extend(counts.decisions.iter().filter(|d| d.wave).flat_map(check_waves).map(|w| w.to_string()));
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    let by_beams = if options.method == Method::Rays { "rays" } else { "facets" };
    Ok(describe(&counts, &file_name(&a.map_file), by_beams, &warnings))
}

/// The Rayleigh parameter falls with the angle: the first angle at which rays served a surface too smooth for them speaks for
/// all beyond.
fn too_smooth(map: &HeightMap, decisions: &[Decision], wavelength: f64) -> Option<validity::Warning> {
    let sq = parameters::sq(map);
    let bad = decisions.iter().find(|d| !d.wave && sq > 0.0 && d.rayleigh < validity::SMALLEST_FOR_RAYS)?;
    Some(validity::Warning::TooSmoothForRays { g: bad.rayleigh, theta_i: bad.theta_i, sq, wavelength })
}

/// What served, in a few words.
fn method(decisions: &[Decision], by_beams: &str) -> String {
    match decisions.iter().position(|d| d.wave) {
        None => by_beams.to_owned(),
        Some(0) => "waves".to_owned(),
        Some(k) => format!("{by_beams}, waves from {:.0} deg", degrees(decisions[k].theta_i)),
    }
}

fn describe(counts: &Counts, name: &str, by_beams: &str, warnings: &[String]) -> Answer {
    let method = method(&counts.decisions, by_beams);
    let of = |value: &dyn Fn(&Direction) -> f64| counts.directions.iter().map(value).collect::<Vec<f64>>();
    let empty = |d: &Direction| d.share.iter().filter(|e| e.value == 0.0).count();
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
    for d in &counts.decisions {
        let _ = writeln!(text, "{:>6.1}   {d}", degrees(d.theta_i));
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
        "waves": counts.decisions.iter().map(|d| d.wave).collect::<Vec<_>>(),
        "reasons": counts.decisions.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "warnings": warnings,
    });
    Answer { json, text }
}
