//! The measured rungs as CSV and as charts.

use super::equal_time::equal_time;
use super::machine::Machine;
use super::method::Family;
use super::runner::Rung;
use crate::chart::Drawing;
use crate::chart::panels::{Mark, Panel, Quantity, Series, panels};
use std::fmt::Write;

/// One row per rung, the machine in a comment line above.
pub fn rungs_csv(rungs: &[Rung], machine: &Machine) -> String {
    let mut csv = format!(
        "# {machine}\nfamily,method,effort_of,effort,repeats,seconds_min,seconds_median,seconds_max,error,error_se,\
         error_unit,default\n"
    );
    for r in rungs {
        let [low, median, high] = r.seconds;
        // Writing to a string cannot fail.
        let _ = writeln!(
            csv,
            "{},\"{}\",{},{},{},{low:.4e},{median:.4e},{high:.4e},{:.4e},{:.2e},{},{}",
            r.family, r.method, r.effort_of, r.effort, r.repeats, r.error, r.error_se, r.unit, r.default
        );
    }
    csv
}

/// The name of the slope that independent samples have.
const RANDOM: &str = "slope -1/2: random samples";

/// Time against error, one panel per family.
pub fn accuracy_chart(families: &[Family], rungs: &[Rung], surface: &str, machine: &Machine) -> Drawing {
    let list: Vec<Panel> = families
        .iter()
        .map(|family| Panel {
            title: family.title.clone(),
            note: note(family, rungs),
            x: (Quantity::Seconds, "time (median; bar: shortest to longest)".into()),
            y: (error_quantity(family), family.error.into()),
            series: series(family, rungs, |r| r.seconds, None),
            guide: Some((-0.5, RANDOM.into())),
            floor: (family.reference.noise > 0.0).then(|| (family.reference.noise, "error of the reference".into())),
        })
        .collect();
    panels("Accuracy against time", &list, &footer(surface, machine))
}

/// What the family rests on, and how facets and rays compare in the same time.
fn note(family: &Family, rungs: &[Rung]) -> String {
    let reference = &family.reference;
    match equal_time(family, rungs) {
        Some(found) => format!("{}; {found}", reference.text),
        None => reference.text.clone(),
    }
}

/// Rays and facets: how many per second, and the error against their number.
pub fn counts_chart(families: &[Family], rungs: &[Rung], surface: &str, machine: &Machine) -> Drawing {
    let mut list = Vec::new();
    let counted = ["rays", "facets"];
    for family in families.iter().filter(|f| f.methods.iter().any(|m| m.effort == "rays")) {
        list.push(Panel {
            title: format!("{}: error", family.title),
            note: family.reference.text.clone(),
            x: (Quantity::Count, "rays or facets".into()),
            y: (error_quantity(family), family.error.into()),
            series: series(family, rungs, |r| [r.effort; 3], Some(&counted)),
            guide: Some((-0.5, RANDOM.into())),
            floor: Some((family.reference.noise, "error of the reference".into())),
        });
        let mut speed = series(family, rungs, |r| [r.effort; 3], Some(&counted));
        for s in &mut speed {
            let of = rungs.iter().filter(|r| r.family == family.id && r.method == s.label);
            for (mark, r) in s.marks.iter_mut().zip(of) {
                let [low, median, high] = r.seconds;
                mark.y = [high, median, low].map(|seconds| r.effort / seconds);
            }
        }
        list.push(Panel {
            title: format!("{}: speed", family.title),
            note: "all threads together; few rays cannot fill the threads".into(),
            x: (Quantity::Count, "rays or facets".into()),
            y: (Quantity::Count, "rays or facets per second".into()),
            series: speed,
            guide: None,
            floor: None,
        });
    }
    panels("Scatter counts", &list, &footer(surface, machine))
}

fn error_quantity(family: &Family) -> Quantity {
    if family.distance.unit() == "share" { Quantity::Share } else { Quantity::Number }
}

fn footer(surface: &str, machine: &Machine) -> Vec<String> {
    vec![
        format!("Surface of the scattering panels: {surface}."),
        format!("Error: root mean square of the repeats, bar: one standard error. {machine}."),
    ]
}

/// The rungs of every method, or of those that count something in `counted`.
fn series(family: &Family, rungs: &[Rung], x: impl Fn(&Rung) -> [f64; 3], counted: Option<&[&str]>) -> Vec<Series> {
    let methods = family.methods.iter().filter(|m| counted.is_none_or(|c| c.contains(&m.effort)));
    methods
        .map(|m| {
            let own: Vec<&Rung> = rungs.iter().filter(|r| r.family == family.id && r.method == m.name).collect();
            let mark = |r: &&Rung| Mark { x: x(r), y: [r.error - r.error_se, r.error, r.error + r.error_se] };
            Series {
                label: m.name.to_owned(),
                marks: own.iter().map(mark).collect(),
                chosen: own.iter().position(|r| r.default),
            }
        })
        .collect()
}
