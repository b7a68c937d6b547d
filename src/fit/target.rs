//! Which parameters make an instrument read a wanted number: the correspondence between a model and a glossmeter.
//!
//! `reading_k(model(x)) = wanted_k` for all k, x inside the box of the free parameters.
//!
//! The instruments come in as one closure, so that anything that looks at a [`Brdf`] will do: gloss, haze, albedo. One
//! unknown and one reading are bracketed and bisected, so that every root is found (haze rises and falls again with
//! roughness); more are a least-squares search from many starts.

use super::family::Family;
use super::levenberg::LeastSquares;
use super::search::{Search, multi_start};
use crate::error::{Error, Result};
use crate::optics::Brdf;
use rayon::prelude::*;

/// What an instrument should read, and how closely, in the unit of the reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    pub value: f64,
    pub tolerance: f64,
}

/// One set of parameters and what the instruments read there.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Values of the free parameters, in their order.
    pub values: Vec<f64>,
    pub readings: Vec<f64>,
}

/// Readings of a model, one per [`Wanted`].
pub type Instruments<'a> = dyn Fn(&dyn Brdf) -> Vec<f64> + Sync + 'a;

/// Places of the box of one unknown at which the reading is looked up before bracketing.
const PLACES: usize = 65;

/// Readings may be sums over fixed points, which jump a little: differences are taken over a wide step.
const SEARCH: Search = Search {
    scouts: 48,
    starts: 3,
    seed: 1,
    // Far enough inside the tolerance that two ways to the same reading agree.
    descent: LeastSquares { difference: 4e-3, steps: 40, gain: 1e-9, shift: 1e-7, enough: 1e-4 },
};

/// Every set of parameters found for which all readings are within tolerance, by rising value of the first parameter.
///
/// # Errors
/// `Error::Parameter` if there are more unknowns than readings, a tolerance is not positive, the instruments answer
/// with another number of readings, or no parameters reach the target: then with the nearest that do not.
pub fn solve(family: &Family, instruments: &Instruments, wanted: &[Wanted]) -> Result<Vec<Solution>> {
    let unknowns = family.free().len();
    if unknowns == 0 || unknowns > wanted.len() {
        return Err(Error::parameter(
            format!("{unknowns} free parameters cannot be found from {} readings", wanted.len()),
            "free at least one parameter and no more than there are readings; give the others a value",
        ));
    }
    if let Some(w) = wanted.iter().find(|w| !(w.tolerance > 0.0 && w.value.is_finite())) {
        return Err(Error::parameter(
            format!("a reading of {} +- {} cannot be aimed at", w.value, w.tolerance),
            "give a finite value and a tolerance above 0",
        ));
    }
    let read = |values: &[f64]| -> Option<Vec<f64>> {
        let readings = instruments(family.model(values).ok()?.as_ref());
        (readings.len() == wanted.len()).then_some(readings)
    };
    let tried = if unknowns == 1 && wanted.len() == 1 {
        roots(family, &read, wanted[0])
    } else {
        minima(family, &read, wanted)
    };
    let miss = |s: &Solution| -> f64 {
        s.readings.iter().zip(wanted).map(|(r, w)| ((r - w.value) / w.tolerance).abs()).fold(0.0, f64::max)
    };
    let mut found: Vec<Solution> = tried.iter().filter(|s| miss(s) <= 1.0).cloned().collect();
    if found.is_empty() {
        return Err(unreachable_target(family, wanted, tried.iter().min_by(|a, b| miss(a).total_cmp(&miss(b)))));
    }
    found.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
    let shares = |s: &Solution| -> Vec<f64> {
        family.free().iter().zip(&s.values).map(|(f, &v)| 1.0 / (1.0 + (-f.coordinate(v)).exp())).collect()
    };
    // Starts that came to the same place count once.
    found.dedup_by(|b, a| shares(a).iter().zip(shares(b)).all(|(x, y)| (x - y).abs() < 1e-3));
    Ok(found)
}

type Read<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a;

/// Every crossing of one reading along one parameter, or the nearest place if there is none.
fn roots(family: &Family, read: &Read, wanted: Wanted) -> Vec<Solution> {
    let free = &family.free()[0];
    let at = |share: f64| {
        let value = free.at_share(share);
        let reading = read(&[value])?[0];
        reading.is_finite().then(|| Solution { values: vec![value], readings: vec![reading] })
    };
    let excess = |s: &Solution| s.readings[0] - wanted.value;
    let places: Vec<(f64, Solution)> = (0..PLACES)
        .into_par_iter()
        .filter_map(|k| {
            let share = k as f64 / (PLACES - 1) as f64;
            Some((share, at(share)?))
        })
        .collect();
    // A place that already fits is a root of its own: at an end of the box, or where a reading stays level.
    let mut found: Vec<Solution> = places.iter().filter(|(_, s)| excess(s).abs() <= 0.0).map(|p| p.1.clone()).collect();
    for pair in places.windows(2) {
        let (mut low, mut high) = (pair[0].clone(), pair[1].clone());
        if excess(&low.1) * excess(&high.1) >= 0.0 {
            continue;
        }
        for _ in 0..60 {
            let Some(s) = at(0.5 * (low.0 + high.0)) else { break };
            let middle = 0.5 * (low.0 + high.0);
            if excess(&s) * excess(&low.1) > 0.0 {
                low = (middle, s)
            } else {
                high = (middle, s)
            }
            // Well inside the tolerance, so that two ways to the same reading agree.
            if excess(&low.1).abs().min(excess(&high.1).abs()) < 1e-3 * wanted.tolerance || high.0 - low.0 < 1e-12 {
                break;
            }
        }
        found.push(if excess(&low.1).abs() < excess(&high.1).abs() { low.1 } else { high.1 });
    }
    if found.is_empty() {
        found.extend(places.into_iter().map(|p| p.1).min_by(|a, b| excess(a).abs().total_cmp(&excess(b).abs())));
    }
    found
}

/// Where the least-squares searches ended.
fn minima(family: &Family, read: &Read, wanted: &[Wanted]) -> Vec<Solution> {
    let residuals = |u: &[f64]| {
        let readings = read(&family.values(u))?;
        Some(readings.iter().zip(wanted).map(|(r, w)| (r - w.value) / w.tolerance).collect())
    };
    multi_start(family.free(), &residuals, &SEARCH)
        .into_iter()
        .filter_map(|m| {
            let values = family.values(&m.at);
            Some(Solution { readings: read(&values)?, values })
        })
        .collect()
}

fn unreachable_target(family: &Family, wanted: &[Wanted], nearest: Option<&Solution>) -> Error {
    let list = |numbers: &mut dyn Iterator<Item = f64>| -> String {
        numbers.map(|v| format!("{:.4}", v)).collect::<Vec<_>>().join(", ")
    };
    let target = list(&mut wanted.iter().map(|w| w.value));
    match nearest {
        Some(s) => {
            let at: Vec<String> =
                family.free().iter().zip(&s.values).map(|(f, v)| format!("{}={v:.6}", f.name)).collect();
            Error::parameter(
                format!(
                    "no parameters give the reading {target}; the nearest found is {} at {}",
                    list(&mut s.readings.iter().copied()),
                    at.join(",")
                ),
                "ask for a reading the model can reach, free another parameter, or widen its range",
            )
        }
        None => Error::parameter(
            format!("no parameters give the reading {target}: the instruments read nothing in the whole range"),
            "narrow the range of the free parameters to models that can be built",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::family::Free;
    use super::*;
    use crate::math::direction;
    use crate::model;
    use crate::model::Scale;

    fn family(names: &'static [&'static str], boxes: &[[f64; 2]], fixed: &'static str) -> Family<'static> {
        let free = names.iter().zip(boxes).map(|(n, b)| Free::new(n, b[0], b[1], Scale::Logarithmic).unwrap());
        Family::new(free.collect(), move |v| {
            let pairs: Vec<String> = names.iter().zip(v).map(|(n, v)| format!("{n}={v}")).collect();
            model::parse(&format!("{fixed}{}", pairs.join(",")), 550e-9)
        })
    }

    /// Ward's peak is `rho_s / (4 pi alpha^2)` at normal incidence: the root is known in closed form.
    #[test]
    fn one_unknown_has_the_root_of_the_closed_form() {
        let family = family(&["alpha"], &[[1e-3, 1.0]], "ward:rho_s=0.05,");
        let peak = |b: &dyn Brdf| vec![b.eval(direction(0.0, 0.0), direction(0.0, 0.0))];
        let s = solve(&family, &peak, &[Wanted { value: 2.0, tolerance: 1e-6 }]).unwrap();
        assert_eq!(s.len(), 1);
        let exact = (0.05 / (8.0 * std::f64::consts::PI)).sqrt();
        assert!((s[0].values[0] / exact - 1.0).abs() < 1e-6, "{s:?} {exact}");
    }

    /// Off the peak a lobe first rises and then falls with its width: both roots of `exp(-t/a^2)/a^2` are found.
    #[test]
    fn both_roots_of_a_reading_that_rises_and_falls() {
        let family = family(&["alpha"], &[[1e-3, 1.0]], "ward:rho_s=0.05,");
        let beside = |b: &dyn Brdf| vec![b.eval(direction(0.0, 0.0), direction(0.2, 0.0))];
        let s = solve(&family, &beside, &[Wanted { value: 0.05, tolerance: 1e-9 }]).unwrap();
        assert_eq!(s.len(), 2, "{s:?}");
        assert!(s[0].values[0] < 0.1 && s[1].values[0] > 0.1);
        let message = solve(&family, &beside, &[Wanted { value: 9.0, tolerance: 1e-3 }]).unwrap_err().to_string();
        assert!(message.contains("nearest found") && message.contains("alpha="), "{message}");
    }

    #[test]
    fn two_unknowns_from_two_readings() {
        let family = family(&["rho_s", "alpha"], &[[1e-3, 1.0], [1e-3, 1.0]], "ward:");
        let two = |b: &dyn Brdf| [0.0, 0.1].map(|t| b.eval(direction(0.0, 0.0), direction(t, 0.0))).to_vec();
        let truth = model::parse("ward:rho_s=0.07,alpha=0.04", 550e-9).unwrap();
        let wanted: Vec<Wanted> =
            two(truth.as_ref()).iter().map(|&value| Wanted { value, tolerance: 1e-6 * value }).collect();
        let s = solve(&family, &two, &wanted).unwrap();
        assert_eq!(s.len(), 1, "{s:?}");
        assert!((s[0].values[0] / 0.07 - 1.0).abs() < 1e-5 && (s[0].values[1] / 0.04 - 1.0).abs() < 1e-5);
        let short = solve(&family, &two, &wanted[..1]).unwrap_err().to_string();
        assert!(short.contains("2 free parameters"), "{short}");
    }
}
