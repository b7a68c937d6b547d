//! The audit: what every BRDF and its sampler must keep, measured from outside.
//!
//! For each incident direction: `f_r >= 0` and finite, 0 below the horizon; `integral of f_r cos_theta_r dw + core =
//! albedo <= 1`; `f_r(wi, wo) = f_r(wo, wi)`; draws follow the pdf (chi-square over boxes of about equal share); the pdf integrates to
//! 1 less the draws that carry nothing and the core; `weight = f_r cos_theta_r / pdf`; the mean weight is the albedo.

mod tree;

use crate::math::random::CounterRng;
use crate::math::statistics::chi_square_test;
use crate::math::{Estimate, direction};
use crate::optics::Brdf;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use tree::Tree;

/// Standard error of `f_r(wi, wo)`, where it is known.
pub type ErrorOf<'a> = &'a (dyn Fn(DVec3, DVec3) -> Estimate + Sync);

/// What to look at.
#[derive(Debug, Clone)]
pub struct Options {
    /// Incident polar angles and azimuths \[rad\].
    pub theta_i: Vec<f64>,
    pub phi_i: Vec<f64>,
    /// Draws per incident direction.
    pub draws: u64,
    pub seed: u64,
    /// Largest share by which energies may differ, and largest mean asymmetry where no errors are known.
    pub tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        let degrees = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect();
        Options {
            theta_i: degrees(&[0.0, 10.0, 20.0, 33.0, 45.0, 60.0, 67.0, 75.0, 80.0, 85.0]),
            phi_i: degrees(&[0.0, 37.0, 110.0, 250.0]),
            draws: 200_000,
            seed: 1,
            tolerance: 0.01,
        }
    }
}

/// What was found for one incident direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub theta_i_deg: f64,
    pub phi_i_deg: f64,
    /// What the BRDF says of itself, and what its quadrature and its draws say.
    pub albedo: f64,
    pub integral: f64,
    pub mean_weight: Estimate,
    /// Mean of `|f(i,o) - f(o,i)| / (f(i,o) + f(o,i))` by energy, that of the core included, and the same in standard errors where they are known.
    pub asymmetry: f64,
    pub asymmetry_sigma: Option<f64>,
    /// Integral of the pdf, and what it should be.
    pub pdf_integral: f64,
    pub pdf_expected: f64,
    pub chi_square: f64,
    pub degrees_of_freedom: f64,
    pub p_value: f64,
    /// Largest relative error of a draw's weight and pdf.
    pub weight_error: f64,
    /// Values that no BRDF may have: negative, not finite, light from below the horizon.
    pub impossible: u64,
}

/// Which statement a direction breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Statement {
    Values,
    Energy,
    Reciprocity,
    PdfIntegral,
    ChiSquare,
    Weight,
    MeanWeight,
}

/// One broken statement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub statement: Statement,
    pub theta_i_deg: f64,
    pub phi_i_deg: f64,
    pub what: String,
}

/// The whole audit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Audit {
    pub passed: bool,
    pub rows: Vec<Row>,
    pub findings: Vec<Finding>,
}

/// Audits `brdf`; `error_of` turns asymmetries into numbers of standard errors.
pub fn audit(brdf: &dyn Brdf, error_of: Option<ErrorOf>, options: &Options) -> Audit {
    let mut directions: Vec<(f64, f64)> = Vec::new();
    for &theta in &options.theta_i {
        directions.extend(options.phi_i.iter().map(|&phi| (theta, phi)));
    }
    let rows: Vec<Row> = directions
        .par_iter()
        .enumerate()
        .map(|(k, &(theta, phi))| row(brdf, error_of, options, k as u64, theta, phi))
        .collect();
    // A fault of one in ten thousand over all the tests together.
    let chance = 1e-4 / rows.len().max(1) as f64;
    let findings: Vec<Finding> = rows.iter().flat_map(|row| judge(row, options, chance)).collect();
    Audit { passed: findings.is_empty(), rows, findings }
}

/// Mean and standard error by sums.
#[derive(Default)]
struct Moments {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.n += 1.0;
        self.sum += x;
        self.squares += x * x;
    }

    fn estimate(&self) -> Estimate {
        let mean = self.sum / self.n.max(1.0);
        let variance = (self.squares / self.n.max(1.0) - mean * mean).max(0.0);
        Estimate { value: mean, standard_error: (variance / self.n.max(1.0)).sqrt() }
    }
}

/// Draws asked for at once.
const TOGETHER: usize = 1024;

fn row(brdf: &dyn Brdf, error_of: Option<ErrorOf>, options: &Options, number: u64, theta: f64, phi: f64) -> Row {
    let wi = direction(theta, phi);
    let mut rng = CounterRng::new(options.seed, 11, number);
    let mut impossible = 0;
    let mut check = |ok: bool| impossible += u64::from(!ok);
    let pilot: Vec<DVec3> = (0..options.draws / 2)
        .filter_map(|_| brdf.sample(wi, [rng.uniform(), rng.uniform()]))
        .filter(|s| !s.specular && s.wo.z > 0.0)
        .map(|s| s.wo)
        .collect();
    let tree = Tree::new(pilot);
    let masses = tree.integrals(&|wo| [brdf.pdf(wi, wo), brdf.eval(wi, wo) * wo.z]);

    let mut counts = vec![0.0; tree.leaves()];
    let mut weights = Moments::default();
    let (mut specular, mut nothing) = (0.0, 0.0);
    let (mut asymmetry, mut energy) = (0.0, 0.0);
    let mut sigma = Moments::default();
    let mut weight_error = 0.0f64;
    // The pilot was drawn one by one, these many at a time: both ways are held against the pdf.
    let numbers = |_| {
        let u: Vec<[f64; 2]> = (0..TOGETHER).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let mut drawn = vec![None; TOGETHER];
        brdf.sample_many(&[wi; TOGETHER], &u, &mut drawn);
        drawn
    };
    let drawn = (0..options.draws.div_ceil(TOGETHER as u64)).flat_map(numbers);
    for (draw, s) in (0..options.draws).zip(drawn) {
        let Some(s) = s else {
            nothing += 1.0;
            weights.add(0.0);
            continue;
        };
        weights.add(s.weight);
        check(s.weight >= 0.0 && s.weight.is_finite() && s.wo.z > 0.0 && (s.wo.length() - 1.0).abs() < 1e-6);
        // Twenty thousand draws tell of values; every draw is counted.
        let of_values = draw % (options.draws / 20_000).max(1) == 0;
        if s.specular {
            specular += 1.0;
            // A mirror beam is the same both ways.
            energy += if of_values { s.weight } else { 0.0 };
            continue;
        }
        counts[tree.leaf(s.wo)] += 1.0;
        if !of_values {
            continue;
        }
        let (f, back) = (brdf.eval(wi, s.wo), brdf.eval(s.wo, wi));
        let pdf = brdf.pdf(wi, s.wo);
        check(f >= 0.0 && f.is_finite() && pdf > 0.0 && pdf.is_finite());
        let expected = f * s.wo.z / pdf;
        let scale = expected.abs().max(1e-6);
        weight_error = weight_error.max((s.weight - expected).abs() / scale).max((s.pdf / pdf - 1.0).abs());
        if f + back > 0.0 {
            // By energy: where there is next to no light its asymmetry is of no account.
            energy += s.weight;
            asymmetry += s.weight * (f - back).abs() / (f + back);
        }
        if let Some(error_of) = error_of {
            let (a, b) = (error_of(wi, s.wo), error_of(s.wo, wi));
            let error = a.standard_error.hypot(b.standard_error);
            // What is known to the last digit is no matter of errors.
            if error > 1e-9 * (a.value + b.value) {
                sigma.add((a.value - b.value).abs() / error);
            }
        }
    }
    for _ in 0..2_000 {
        // Where no draw falls there may be light as well, but not below the horizon.
        let wo = direction((1.0 - rng.uniform()).acos(), std::f64::consts::TAU * rng.uniform());
        let (f, pdf) = (brdf.eval(wi, wo), brdf.pdf(wi, wo));
        check(f >= 0.0 && f.is_finite() && pdf >= 0.0 && pdf.is_finite());
        let below = DVec3::new(wo.x, wo.y, -wo.z);
        check(brdf.eval(wi, below) == 0.0 && brdf.pdf(wi, below) == 0.0 && brdf.eval(below, wi) == 0.0);
    }
    let n = options.draws as f64;
    let pdf_integral: f64 = masses.iter().map(|m| m[0]).sum();
    let landed: f64 = counts.iter().sum();
    let expected: Vec<f64> = masses.iter().map(|m| m[0] / pdf_integral.max(1e-300) * landed).collect();
    let (chi_square, degrees_of_freedom, p_value) =
        if landed > 100.0 { chi_square_test(&counts, &expected, 10.0) } else { (0.0, 0.0, 1.0) };
    Row {
        theta_i_deg: theta.to_degrees(),
        phi_i_deg: phi.to_degrees(),
        albedo: brdf.albedo_towards(wi),
        integral: masses.iter().map(|m| m[1]).sum::<f64>() + brdf.specular_core(wi),
        mean_weight: weights.estimate(),
        asymmetry: if energy > 0.0 { asymmetry / energy } else { 0.0 },
        asymmetry_sigma: (sigma.n > 0.0).then(|| sigma.estimate().value),
        pdf_integral,
        pdf_expected: 1.0 - (nothing + specular) / n,
        chi_square,
        degrees_of_freedom,
        p_value,
        weight_error,
        impossible,
    }
}

/// Every statement that a row breaks.
fn judge(row: &Row, options: &Options, chance: f64) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut say = |statement: Statement, what: String| {
        findings.push(Finding { statement, theta_i_deg: row.theta_i_deg, phi_i_deg: row.phi_i_deg, what });
    };
    let t = options.tolerance;
    if row.impossible > 0 {
        say(Statement::Values, format!("{} values are negative, not finite or below the horizon", row.impossible));
    }
    let scale = row.albedo.max(1e-6);
    if !((row.integral - row.albedo).abs() <= t * scale) {
        say(Statement::Energy, format!("f_r integrates to {:.5}, the albedo is {:.5}", row.integral, row.albedo));
    }
    if row.integral > 1.0 + t {
        say(Statement::Energy, format!("{:.5} of the light is reflected", row.integral));
    }
    let noise = 4.0 * row.mean_weight.standard_error;
    if !((row.mean_weight.value - row.integral).abs() <= noise + 0.1 * t * scale) {
        let m = row.mean_weight;
        say(
            Statement::MeanWeight,
            format!("draws carry {:.5} +- {:.5}, f_r integrates to {:.5}", m.value, m.standard_error, row.integral),
        );
    }
    // Within the errors, where they are known; a mean of |N(0, 1)| is 0.8.
    if row.asymmetry > 5.0 * t && row.asymmetry_sigma.is_none_or(|sigma| sigma > 3.0) {
        say(
            Statement::Reciprocity,
            format!("f_r(i,o) and f_r(o,i) differ by {:.1} % in the mean", 200.0 * row.asymmetry),
        );
    }
    let draws = options.draws as f64;
    let share = row.pdf_expected.clamp(0.0, 1.0);
    let slack = 4.0 * ((share * (1.0 - share)).max(1.0 / draws) / draws).sqrt() + 0.2 * t;
    if !((row.pdf_integral - row.pdf_expected).abs() <= slack) {
        say(
            Statement::PdfIntegral,
            format!("the pdf integrates to {:.5}, {:.5} of the draws land", row.pdf_integral, row.pdf_expected),
        );
    }
    if !(row.p_value >= chance) {
        say(
            Statement::ChiSquare,
            format!("chi-square {:.0} for {:.0} degrees of freedom", row.chi_square, row.degrees_of_freedom),
        );
    }
    if !(row.weight_error <= 1e-3) {
        say(Statement::Weight, format!("a draw's weight or pdf is off by {:.2} %", 100.0 * row.weight_error));
    }
    findings
}
