//! Detectors as CSV: one row per detector and incident direction.

use crate::scatter::Counts;
use std::fmt::Write;

/// `f_r_per_sr` is the mean over the detector. Where `hits` is 0 the standard error is the 95 % bound of the rule of three, unless
/// waves served, which have no hits.
const HEADER: &str = "index,theta_min_deg,theta_max_deg,phi_min_deg,phi_max_deg,projected_solid_angle_sr,\
energy_fraction,f_r_per_sr,standard_error,hits,theta_i_deg,phi_i_deg";

/// The rows as text. Bounds are those of the exit direction, for half-vector cells those of the half vector; `phi_min_deg`
/// may be negative so that it stays below `phi_max_deg`.
pub fn detectors_csv(counts: &Counts) -> String {
    let mut text = format!("{HEADER}\n");
    let boxes: Vec<String> = (0..counts.detectors.len())
        .map(|k| {
            let b = counts.detectors.bounds(k);
            [b.theta[0], b.theta[1], b.phi[0], b.phi[1]].map(degrees).join(",")
        })
        .collect();
    for d in &counts.directions {
        let source = format!("{},{}", degrees(d.theta_i), degrees(d.phi_i));
        for (k, bounds) in boxes.iter().enumerate() {
            let f = d.f_r(k);
            let hits = d.tally.hits.get(k).unwrap_or(&0);
            let (omega, share) = (d.projected_solid_angle[k], d.share[k].value);
            let _ = writeln!(text, "{k},{bounds},{omega},{share},{},{},{hits},{source}", f.value, f.standard_error);
        }
    }
    text
}

/// An angle \[rad\] in degrees to a millionth, without trailing zeros.
fn degrees(angle: f64) -> String {
    let text = format!("{:.6}", angle.to_degrees());
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_short() {
        for (angle, text) in [(15f64.to_radians(), "15"), (-1e-12, "0"), (0.1, "5.729578"), (-0.5, "-28.64789")] {
            assert_eq!(degrees(angle), text);
        }
        assert_eq!(degrees(90f64.to_radians()), "90");
    }
}
