//! From scans to the parameters of a NEF-BM material: step by step for a start, then all together.
//!
//! 1. `f_s = co - cross`, `f_v = 2 cross`: the first surface keeps the polarisation.
//! 2. `f_v = rho_D + 2 rho_V / (cos_theta_i + cos_theta_r)`: linear least squares over all cross-polarised values.
//! 3. n, k from the mirror directions: `f_s(beta) = (R_s,p(beta) / R(0)) f_zb(0) / cos^2 beta`.
//! 4. sigma and bias of the facet law from `Xi = 4 f_zb cos^2 theta_h / R(0)`, or the scan itself as the law.
//! 5. tau and Omega from `f_s / (f_s without SO)` of the fixed-bistatic scans.
//! 6. All parameters together by the errors of all values; standard errors from the covariance.
//!
//! Other wavelengths follow by [`super::spectrum`].

use super::material::{Material, bistatic_directions};
use super::scans::{Polarisation, Scans};
use crate::error::{Error, Result};
use crate::fit::brdf::{FittedParameter, uncertainty};
use crate::fit::family::Free;
use crate::fit::levenberg::{LeastSquares, Minimum};
use crate::fit::search::{Search, multi_start};
use crate::fit::warning::Warning;
use crate::math::Estimate;
use crate::math::least_squares::NormalEquations;
use crate::model::beard_maxwell::{Shadowing, Volume};
use crate::model::facet_normals::FacetNormals;
use crate::model::zero_bistatic::ZeroBistatic;
use crate::model::{Definition, Scale};
use crate::optics::fresnel::polarised;

/// Law of the facet normals to be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    Cauchy,
    Gaussian,
    /// The zero-bistatic scan itself.
    Scan,
}

/// What one step found, before all were fitted together.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    pub name: &'static str,
    /// SI.
    pub found: Vec<(&'static str, f64)>,
    /// Root mean square of the residuals in units of their errors.
    pub rms: f64,
    /// Values used.
    pub values: usize,
}

/// One value and what the material would give.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualRow {
    /// `zero_bistatic`, `specular` or `bistatic`.
    pub scan: &'static str,
    /// `co`, `cross`, `s` or `p`.
    pub channel: &'static str,
    /// \[rad\].
    pub theta_h: f64,
    /// \[rad\].
    pub beta: f64,
    /// [1/sr].
    pub measured: Estimate,
    /// [1/sr].
    pub model: f64,
}

/// A material as the protocol found it.
#[derive(Debug, Clone, PartialEq)]
pub struct Characterised {
    /// The `nef-bm` model.
    pub definition: Definition,
    /// With standard errors, SI.
    pub parameters: Vec<FittedParameter>,
    /// Of the parameters, in their order; 0 where one has no error.
    pub covariance: Vec<Vec<f64>>,
    pub(super) material: Material,
    pub steps: Vec<Step>,
    pub chi2: f64,
    pub dof: usize,
    pub residuals: Vec<ResidualRow>,
    pub warnings: Vec<Warning>,
}

/// Mirror directions within this of each other \[rad\] serve step 3.
const MIRROR: f64 = 0.0044;
/// Where no error is known: share of the value and of the largest one.
const UNKNOWN: [f64; 2] = [0.02, 1e-4];
/// A gain in chi2 beyond that of chance, for which absorption is worth a parameter.
const WORTH_A_PARAMETER: f64 = 9.0;

/// Parameters of a material with a `law`; absorption is added if it lowers chi2 by more than chance does.
///
/// # Errors
/// `Error::Parameter` if a scan is missing or does not determine its part.
pub fn characterise(scans: &Scans, law: Law) -> Result<Characterised> {
    let clear = Protocol { scans, law, absorbing: false }.run()?;
    let Ok(absorbing) = (Protocol { scans, law, absorbing: true }).run() else { return Ok(clear) };
    let scale = if scans.has_errors() { 1.0 } else { absorbing.chi2 / absorbing.dof as f64 };
    Ok(if clear.chi2 - absorbing.chi2 > WORTH_A_PARAMETER * scale { absorbing } else { clear })
}

struct Protocol<'a> {
    scans: &'a Scans,
    law: Law,
    absorbing: bool,
}

impl Protocol<'_> {
    fn run(&self) -> Result<Characterised> {
        let mut steps = Vec::new();
        let volume = self.volume(&mut steps)?;
        let [n, k] = self.index(volume, &mut steps)?;
        let normals = self.normals(n, k, &mut steps)?;
        let mut material = Material { n, k, normals, shadowing: Shadowing { tau: 0.25, omega: 0.7 }, volume };
        material.shadowing = self.shadowing(&material, &mut steps)?;
        self.together(&material, steps)
    }

    /// Error of a value, or a guess of it.
    fn error(&self, e: &Estimate) -> f64 {
        let peak = self.scans.zero_bistatic.iter().fold(0.0f64, |m, r| m.max(r.co.value.abs()));
        let guess = UNKNOWN[0] * e.value.abs() + UNKNOWN[1] * peak;
        if e.standard_error > 0.0 { e.standard_error } else { guess }
    }

    fn volume(&self, steps: &mut Vec<Step>) -> Result<Volume> {
        let zero = self.scans.zero_bistatic.iter().map(|r| (1.0 / r.theta.cos(), r.cross));
        let bistatic = self.scans.bistatic.iter().map(|r| {
            let [wi, wo] = bistatic_directions(r);
            (2.0 / (wi.z + wo.z), r.cross)
        });
        let rows: Vec<[f64; 3]> =
            zero.chain(bistatic).map(|(g, cross)| [g, 2.0 * cross.value, 1.0 / (2.0 * self.error(&cross))]).collect();
        let solve = |columns: [bool; 2]| -> Option<[f64; 2]> {
            let mut equations = NormalEquations::new(columns.iter().filter(|c| **c).count());
            for [g, y, w] in &rows {
                let row: Vec<f64> = [1.0, *g].iter().zip(columns).filter(|(_, c)| *c).map(|(v, _)| v * w).collect();
                equations.add(&row, y * w);
            }
            let mut solved = equations.solve()?.into_iter();
            Some(columns.map(|c| if c { solved.next().unwrap_or(0.0) } else { 0.0 }))
        };
        let cost = |v: &[f64; 2]| rows.iter().map(|[g, y, w]| ((v[0] + g * v[1] - y) * w).powi(2)).sum::<f64>();
        // Neither part can be negative: the best of what is left.
        let best = [[true, true], [true, false], [false, true]]
            .into_iter()
            .filter_map(solve)
            .filter(|v| v[0] >= 0.0 && v[1] >= 0.0)
            .chain([[0.0, 0.0]])
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
            .unwrap_or([0.0, 0.0]);
        let rms = (cost(&best) / rows.len() as f64).sqrt();
        let found = vec![("rho_D", best[0]), ("rho_V", best[1])];
        steps.push(Step { name: "volume from cross-polarised scans", found, rms, values: rows.len() });
        Ok(Volume { lambertian: best[0], directional: best[1] })
    }

    fn index(&self, volume: Volume, steps: &mut Vec<Step>) -> Result<[f64; 2]> {
        let scan = self.scan()?;
        let rows: Vec<_> = self.scans.specular.iter().filter(|r| (r.theta_i - r.theta_r).abs() <= MIRROR).collect();
        let both = [Polarisation::S, Polarisation::P].map(|p| rows.iter().any(|r| r.polarisation == p));
        if rows.len() < 4 || both != [true, true] {
            return Err(Error::parameter(
                format!("{} specular values in the mirror direction, in s and p, are too few for an index", rows.len()),
                "scan s and p at 20, 40 and 60 deg through the mirror direction",
            ));
        }
        let free = if self.absorbing {
            vec![boxed("n", 0.05, 8.0)?, boxed("k", 0.01, 15.0)?]
        } else {
            vec![boxed("n", 1.02, 4.0)?]
        };
        let index = |u: &[f64]| -> [f64; 2] { [free[0].value(u[0]), free.get(1).map_or(0.0, |f| f.value(u[1]))] };
        let zero = scan.at(0.0);
        let residuals = |u: &[f64]| {
            let [n, k] = index(u);
            let r0 = polarised(1.0, n, k)[0];
            let residual = |r: &&super::scans::Specular| {
                let (ci, co) = (r.theta_i.cos(), r.theta_r.cos());
                let beta = 0.5 * (r.theta_i + r.theta_r);
                let side = usize::from(r.polarisation == Polarisation::P);
                let first = polarised(beta.cos(), n, k)[side] / r0 * zero / (ci * co);
                (first + 0.5 * volume.at(ci, co) - r.f_r.value) / self.error(&r.f_r)
            };
            Some(rows.iter().map(residual).collect())
        };
        let best = best_of(&free, &residuals, "index of refraction")?;
        let [n, k] = index(&best.at);
        let mut found = vec![("n", n)];
        found.extend(self.absorbing.then_some(("k", k)));
        steps.push(step("index from specular scans in s and p", found, &best));
        Ok([n, k])
    }

    /// The first surface of the zero-bistatic scan; noise may leave a little below nothing.
    fn scan(&self) -> Result<ZeroBistatic> {
        let points: Vec<(f64, f64)> =
            self.scans.zero_bistatic.iter().map(|r| (r.theta, (r.co.value - r.cross.value).max(0.0))).collect();
        ZeroBistatic::new(&points)
    }

    fn normals(&self, n: f64, k: f64, steps: &mut Vec<Step>) -> Result<FacetNormals> {
        let r0 = polarised(1.0, n, k)[0];
        if self.law == Law::Scan {
            return Ok(FacetNormals::Scan { scan: self.scan()?, normal_reflectance: r0 });
        }
        let free = vec![boxed("sigma", 2e-3, 1.9)?, boxed("bias", 1e-5, 90.0)?];
        let residuals = |u: &[f64]| {
            let normals = law_of(self.law, free[0].value(u[0]), free[1].value(u[1]));
            let residual = |r: &super::scans::ZeroBistaticRow| {
                let c = r.theta.cos();
                let first = r0 * normals.xi(c) / (4.0 * c * c);
                let error = self.error(&r.co).hypot(self.error(&r.cross));
                (first - (r.co.value - r.cross.value)) / error
            };
            Some(self.scans.zero_bistatic.iter().map(residual).collect())
        };
        let best = best_of(&free, &residuals, "law of the facets")?;
        let (sigma, bias) = (free[0].value(best.at[0]), free[1].value(best.at[1]));
        steps.push(step("facets from the zero-bistatic scan", vec![("sigma", sigma), ("bias", bias)], &best));
        Ok(law_of(self.law, sigma, bias))
    }

    fn shadowing(&self, material: &Material, steps: &mut Vec<Step>) -> Result<Shadowing> {
        if self.scans.bistatic.len() < 4 {
            return Err(Error::parameter(
                format!("{} fixed-bistatic values are too few for tau and omega", self.scans.bistatic.len()),
                "scan beta 20, 30 and 40 deg with theta_h from 0 to 40 deg",
            ));
        }
        let free = vec![boxed("tau", 2e-3, 9.0)?, boxed("omega", 2e-3, 90.0)?];
        let residuals = |u: &[f64]| {
            let shadowing = Shadowing { tau: free[0].value(u[0]), omega: free[1].value(u[1]) };
            let material = Material { shadowing, ..material.clone() };
            let residual = |r: &super::scans::Bistatic| {
                let error = self.error(&r.co).hypot(self.error(&r.cross));
                (material.bistatic(r)[0] - (r.co.value - r.cross.value)) / error
            };
            Some(self.scans.bistatic.iter().map(residual).collect())
        };
        let best = best_of(&free, &residuals, "shadowing")?;
        let (tau, omega) = (free[0].value(best.at[0]), free[1].value(best.at[1]));
        steps.push(step("shadowing from fixed-bistatic scans", vec![("tau", tau), ("omega", omega)], &best));
        Ok(Shadowing { tau, omega })
    }

    /// Step 6, from where the others ended.
    fn together(&self, start: &Material, steps: Vec<Step>) -> Result<Characterised> {
        let mut free = Vec::new();
        let mut values = Vec::new();
        let mut add = |f: Free, v: f64| {
            free.push(f);
            values.push(v);
        };
        if let FacetNormals::Cauchy { sigma, bias } | FacetNormals::Gaussian { sigma, bias } = start.normals {
            add(boxed("sigma", 1e-3, 2.0)?, sigma);
            add(boxed("bias", 1e-6, 100.0)?, bias);
        }
        add(boxed("n", if self.absorbing { 0.02 } else { 1.01 }, 9.0)?, start.n);
        if self.absorbing {
            add(boxed("k", 1e-3, 40.0)?, start.k);
        }
        add(boxed("tau", 1e-3, 10.0)?, start.shadowing.tau);
        add(boxed("omega", 1e-3, 100.0)?, start.shadowing.omega);
        // A start at the very end of a box could not leave it.
        add(Free::new("rho_D", 0.0, 0.31, Scale::Linear)?, start.volume.lambertian.max(1e-5));
        add(Free::new("rho_V", 0.0, 0.1, Scale::Linear)?, start.volume.directional.max(1e-5));
        let material = |u: &[f64]| self.material(&free, u, start);
        let residuals = |u: &[f64]| {
            let rows = self.rows(&material(u));
            Some(rows.iter().map(|r| (r.model - r.measured.value) / self.error(&r.measured)).collect())
        };
        let at: Vec<f64> = free.iter().zip(&values).map(|(f, &v)| f.coordinate(v)).collect();
        let best = LeastSquares::default().descend(&residuals, &at).ok_or_else(|| {
            Error::parameter("the scans cannot be fitted together", "check their values: all must be finite")
        })?;
        let mut warnings = Vec::new();
        if !best.converged {
            warnings.push(Warning::NotConverged);
        }
        let dof = best.residuals.len().saturating_sub(free.len()).max(1);
        let spread = best.cost / dof as f64;
        if self.scans.has_errors() && spread > 4.0 {
            warnings.push(Warning::PoorFit { chi2_per_dof: spread });
        }
        let variance = if self.scans.has_errors() { spread.max(1.0) } else { spread };
        let known = uncertainty(&free, &best, variance, &mut warnings);
        let found = material(&best.at);
        let definition = found.definition()?;
        let named = |((f, &u), standard_error): ((&Free, &f64), Option<f64>)| FittedParameter {
            name: f.name.clone(),
            value: f.value(u),
            standard_error,
        };
        let parameters = free.iter().zip(&best.at).zip(known.errors).map(named).collect();
        let (covariance, residuals) = (known.covariance, self.rows(&found));
        let (chi2, material) = (best.cost, found);
        Ok(Characterised { definition, parameters, covariance, material, steps, chi2, dof, residuals, warnings })
    }

    fn material(&self, free: &[Free], u: &[f64], start: &Material) -> Material {
        let get = |name: &str| free.iter().zip(u).find(|(f, _)| f.name == name).map(|(f, &u)| f.value(u));
        let (n, k) = (get("n").unwrap_or(start.n), get("k").unwrap_or(0.0));
        let normals = match (&start.normals, get("sigma"), get("bias")) {
            (FacetNormals::Scan { scan, .. }, ..) => {
                FacetNormals::Scan { scan: scan.clone(), normal_reflectance: polarised(1.0, n, k)[0] }
            }
            (_, Some(sigma), Some(bias)) => law_of(self.law, sigma, bias),
            (other, ..) => other.clone(),
        };
        let mut material = Material { n, k, normals, ..start.clone() };
        for name in ["tau", "omega", "rho_D", "rho_V"] {
            material.set(name, get(name).unwrap_or(0.0));
        }
        material
    }

    /// Every value beside what `material` would give. If the scan is the law, its co-polarised values say nothing new.
    fn rows(&self, material: &Material) -> Vec<ResidualRow> {
        let mut rows = Vec::new();
        for r in &self.scans.zero_bistatic {
            let [first, half] = material.zero_bistatic(r.theta);
            let row = |channel, measured, model| ResidualRow {
                scan: "zero_bistatic",
                channel,
                theta_h: r.theta,
                beta: 0.0,
                measured,
                model,
            };
            if self.law != Law::Scan {
                rows.push(row("co", r.co, first + half));
            }
            rows.push(row("cross", r.cross, half));
        }
        for r in &self.scans.specular {
            rows.push(ResidualRow {
                scan: "specular",
                channel: if r.polarisation == Polarisation::S { "s" } else { "p" },
                theta_h: 0.5 * (r.theta_i - r.theta_r).abs(),
                beta: 0.5 * (r.theta_i + r.theta_r),
                measured: r.f_r,
                model: material.specular(r),
            });
        }
        for r in &self.scans.bistatic {
            let [first, half] = material.bistatic(r);
            let row = |channel, measured, model| ResidualRow {
                scan: "bistatic",
                channel,
                theta_h: r.theta_h,
                beta: r.beta,
                measured,
                model,
            };
            rows.push(row("co", r.co, first + half));
            rows.push(row("cross", r.cross, half));
        }
        rows
    }
}

fn law_of(law: Law, sigma: f64, bias: f64) -> FacetNormals {
    match law {
        Law::Gaussian => FacetNormals::Gaussian { sigma, bias },
        _ => FacetNormals::Cauchy { sigma, bias },
    }
}

fn boxed(name: &str, low: f64, high: f64) -> Result<Free> {
    Free::new(name, low, high, Scale::Logarithmic)
}

fn best_of(free: &[Free], residuals: &crate::fit::levenberg::Residuals, what: &str) -> Result<Minimum> {
    multi_start(free, residuals, &Search { starts: 4, ..Search::default() }).into_iter().next().ok_or_else(|| {
        Error::parameter(format!("the {what} cannot be found from the scans"), "check that their values are finite")
    })
}

fn step(name: &'static str, found: Vec<(&'static str, f64)>, best: &Minimum) -> Step {
    let values = best.residuals.len();
    Step { name, found, rms: (best.cost / values.max(1) as f64).sqrt(), values }
}
