//! The three scans, read from and written to CSV.

use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::math::Estimate;
use std::fmt::Write;
use std::path::Path;

/// Direction of polariser and analyser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarisation {
    /// Across the plane of incidence.
    S,
    /// In the plane of incidence.
    P,
}

/// Source and detector both at `theta` \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZeroBistaticRow {
    pub theta: f64,
    /// [1/sr].
    pub co: Estimate,
    /// [1/sr].
    pub cross: Estimate,
}

/// Source at `theta_i`, detector in the plane of incidence at `theta_r` on the mirror side \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Specular {
    pub theta_i: f64,
    pub theta_r: f64,
    pub polarisation: Polarisation,
    /// [1/sr].
    pub f_r: Estimate,
}

/// Source and detector at `theta_h + beta` and `theta_h - beta` from the normal, in one plane \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bistatic {
    pub beta: f64,
    pub theta_h: f64,
    /// [1/sr].
    pub co: Estimate,
    /// [1/sr].
    pub cross: Estimate,
}

/// All scans of one specimen at one wavelength.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scans {
    pub zero_bistatic: Vec<ZeroBistaticRow>,
    pub specular: Vec<Specular>,
    pub bistatic: Vec<Bistatic>,
}

/// Largest angle of a direction \[deg\]: beyond it the footprint leaves every specimen.
const STEEPEST: f64 = 89.0;

impl Scans {
    /// Reads the three files; their columns are listed in the module's head.
    ///
    /// # Errors
    /// `Error::Io` or `Error::Content` naming file, line and column.
    pub fn read(zero_bistatic: &Path, specular: &Path, bistatic: &Path) -> Result<Self> {
        Ok(Scans {
            zero_bistatic: read_zero(&Columns::read(zero_bistatic)?)?,
            specular: read_specular(&Columns::read(specular)?)?,
            bistatic: read_bistatic(&Columns::read(bistatic)?)?,
        })
    }

    /// Whether every value has an error above 0.
    pub fn has_errors(&self) -> bool {
        let known = |e: &Estimate| e.standard_error > 0.0;
        self.zero_bistatic.iter().all(|r| known(&r.co) && known(&r.cross))
            && self.specular.iter().all(|r| known(&r.f_r))
            && self.bistatic.iter().all(|r| known(&r.co) && known(&r.cross))
    }

    /// The three files as text: zero-bistatic, specular, fixed bistatic.
    pub fn to_csv(&self) -> [String; 3] {
        let mut zero = "theta_deg,co_per_sr,cross_per_sr,co_error,cross_error\n".to_owned();
        for r in &self.zero_bistatic {
            let _ = writeln!(zero, "{:.4},{}", r.theta.to_degrees(), pair(&r.co, &r.cross));
        }
        let mut specular = "theta_i_deg,theta_r_deg,polarisation,f_r_per_sr,standard_error\n".to_owned();
        for r in &self.specular {
            let name = if r.polarisation == Polarisation::S { "s" } else { "p" };
            let (ti, tr) = (r.theta_i.to_degrees(), r.theta_r.to_degrees());
            let _ = writeln!(specular, "{ti:.4},{tr:.4},{name},{:.6e},{:.3e}", r.f_r.value, r.f_r.standard_error);
        }
        let mut bistatic = "beta_deg,theta_h_deg,co_per_sr,cross_per_sr,co_error,cross_error\n".to_owned();
        for r in &self.bistatic {
            let (b, t) = (r.beta.to_degrees(), r.theta_h.to_degrees());
            let _ = writeln!(bistatic, "{b:.4},{t:.4},{}", pair(&r.co, &r.cross));
        }
        [zero, specular, bistatic]
    }
}

fn pair(co: &Estimate, cross: &Estimate) -> String {
    format!("{:.6e},{:.6e},{:.3e},{:.3e}", co.value, cross.value, co.standard_error, cross.standard_error)
}

/// A column with its errors, 0 where there is no column of errors.
fn estimates(columns: &Columns, value: &str, error: &str) -> Result<Vec<Estimate>> {
    let values = columns.numbers(value)?;
    let errors = columns.optional_numbers(error)?.unwrap_or_else(|| vec![0.0; values.len()]);
    if let Some(row) = errors.iter().position(|e| *e < 0.0) {
        return Err(columns.row_fault(row, format!("`{error}` is negative"), "give an error of 0 or more, in 1/sr"));
    }
    Ok(values.into_iter().zip(errors).map(|(value, standard_error)| Estimate { value, standard_error }).collect())
}

fn read_zero(columns: &Columns) -> Result<Vec<ZeroBistaticRow>> {
    let theta = columns.numbers_within("theta_deg", 0.0, STEEPEST)?;
    let co = estimates(columns, "co_per_sr", "co_error")?;
    let cross = estimates(columns, "cross_per_sr", "cross_error")?;
    if theta.len() < 4 {
        return Err(Error::content(columns.path(), "there are fewer than 4 angles", "scan from 0 to 80 deg"));
    }
    let row = |((t, co), cross): ((f64, Estimate), Estimate)| ZeroBistaticRow { theta: t.to_radians(), co, cross };
    Ok(theta.into_iter().zip(co).zip(cross).map(row).collect())
}

fn read_specular(columns: &Columns) -> Result<Vec<Specular>> {
    let theta_i = columns.numbers_within("theta_i_deg", 0.0, STEEPEST)?;
    let theta_r = columns.numbers_within("theta_r_deg", 0.0, STEEPEST)?;
    let f_r = estimates(columns, "f_r_per_sr", "standard_error")?;
    let texts = columns.texts("polarisation")?;
    (0..f_r.len())
        .map(|k| {
            let polarisation = match texts[k] {
                "s" | "S" => Polarisation::S,
                "p" | "P" => Polarisation::P,
                other => {
                    let what = format!("`polarisation` is `{other}`");
                    return Err(columns.row_fault(k, what, "write s or p"));
                }
            };
            let (theta_i, theta_r) = (theta_i[k].to_radians(), theta_r[k].to_radians());
            Ok(Specular { theta_i, theta_r, polarisation, f_r: f_r[k] })
        })
        .collect()
}

fn read_bistatic(columns: &Columns) -> Result<Vec<Bistatic>> {
    let beta = columns.numbers_within("beta_deg", 0.0, STEEPEST)?;
    let theta_h = columns.numbers_within("theta_h_deg", 0.0, STEEPEST)?;
    let co = estimates(columns, "co_per_sr", "co_error")?;
    let cross = estimates(columns, "cross_per_sr", "cross_error")?;
    (0..beta.len())
        .map(|k| {
            if beta[k] + theta_h[k] > STEEPEST {
                let what = format!("theta_h + beta is {} deg: a direction is below the surface", beta[k] + theta_h[k]);
                return Err(columns.row_fault(k, what, "keep theta_h + beta below 89 deg"));
            }
            let (beta, theta_h) = (beta[k].to_radians(), theta_h[k].to_radians());
            Ok(Bistatic { beta, theta_h, co: co[k], cross: cross[k] })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_told_by_line() {
        let parse = |text: &str| Columns::parse(Path::new("s.csv"), text).unwrap();
        let specular = "theta_i_deg,theta_r_deg,polarisation,f_r_per_sr\n20,20,s,1\n20,20,x,1\n";
        assert!(read_specular(&parse(specular)).unwrap_err().to_string().contains("line 3"));
        let bistatic = "beta_deg,theta_h_deg,co_per_sr,cross_per_sr\n40,60,1,1\n";
        assert!(read_bistatic(&parse(bistatic)).unwrap_err().to_string().contains("below the surface"));
        let zero = "theta_deg,co_per_sr,cross_per_sr,co_error\n0,1,0,0\n1,1,0,-1\n2,1,0,0\n3,1,0,0\n";
        assert!(read_zero(&parse(zero)).unwrap_err().to_string().contains("`co_error` is negative"));
        assert!(read_zero(&parse("theta_deg,co_per_sr,cross_per_sr\n0,1,0\n")).is_err());
    }
}
