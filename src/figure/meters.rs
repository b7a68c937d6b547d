//! Parameters from readings: which models the light meter reads the wanted gloss and haze on.

use crate::error::Result;
use crate::fit::target::{Wanted, solve};
use crate::fit::{Family, Free};
use crate::math::Estimate;
use crate::meter::{Geometry, Options, gloss, standards};
use crate::model::{self, Scale};
use crate::optics::{Brdf, fresnel, material::STANDARD_GLASS_INDEX};

/// Readings within this are reached \[GU\].
const TOLERANCE: f64 = 0.05;
const WAVELENGTH: f64 = 550e-9;

/// A model and what the meter reads on it.
pub struct Solved {
    pub brdf: Box<dyn Brdf>,
    /// Lobe width.
    pub alpha: f64,
    /// Specular reflectance of Ward.
    pub rho_s: f64,
    /// Gloss at 20 deg \[GU\] and two-sided haze beside it.
    pub gloss: Estimate,
    pub haze: Estimate,
}

fn options() -> Options {
    // A search needs readings finer than the tolerance.
    Options { tolerance: 0.2 * TOLERANCE, ..Options::default() }
}

/// Gloss at 20 deg, and the haze of the two receptors beside it.
pub fn read(brdf: &dyn Brdf) -> Result<[Estimate; 2]> {
    let beside = standards::by_name("haze-20").expect("a named instrument").measure(brdf, &options())?;
    let haze = beside[1].estimate;
    Ok([gloss(brdf, &Geometry::gloss20(), &options()), haze])
}

/// The width of the lobe for which `reading` is `wanted`; `surface` makes the model of a width.
fn width(
    surface: &(dyn Fn(f64) -> Result<Box<dyn Brdf>> + Sync),
    range: [f64; 2],
    reading: &(dyn Fn(&dyn Brdf) -> f64 + Sync),
    wanted: f64,
) -> Result<f64> {
    let free = Free::new("alpha", range[0], range[1], Scale::Logarithmic)?;
    let family = Family::new(vec![free], |values| surface(values[0]));
    let found = solve(&family, &|brdf| vec![reading(brdf)], &[Wanted { value: wanted, tolerance: TOLERANCE }])?;
    Ok(found[0].values[0])
}

fn ward(rho_s: f64, alpha: f64) -> Result<Box<dyn Brdf>> {
    model::parse(&format!("ward:rho_s={rho_s},alpha={alpha},rho_d=0"), WAVELENGTH)
}

fn gloss20(brdf: &dyn Brdf) -> f64 {
    gloss(brdf, &Geometry::gloss20(), &options()).value
}

/// Ward's model of black glass that reads a 20 deg gloss \[GU\]: reflectance of the standard at 20 deg, width as needed.
///
/// # Errors
/// `Error::Parameter` if no width gives the reading.
pub fn ward_of_gloss(wanted: f64) -> Result<Solved> {
    let theta = 20f64.to_radians();
    // The lobe reflects rho_s cos_theta_i.
    let rho_s = fresnel::dielectric(theta.cos(), STANDARD_GLASS_INDEX) / theta.cos();
    let alpha = width(&|alpha| ward(rho_s, alpha), [1e-3, 0.3], &gloss20, wanted)?;
    solved(ward(rho_s, alpha)?, alpha, rho_s)
}

/// Ward's model that reads a haze at a 20 deg gloss \[GU\]. Both readings are proportional to `rho_s`, so their ratio
/// gives the width, and the gloss then the strength.
///
/// # Errors
/// `Error::Parameter` if no width gives the ratio, or the strength exceeds 1.
pub fn ward_of_haze(gloss: f64, haze: f64) -> Result<Solved> {
    const TRIAL: f64 = 0.1;
    let ratio = |brdf: &dyn Brdf| read(brdf).map_or(f64::NAN, |[g, h]| gloss * h.value / g.value);
    let alpha = width(&|alpha| ward(TRIAL, alpha), [1e-3, 0.05], &ratio, haze)?;
    let rho_s = TRIAL * gloss / gloss20(ward(TRIAL, alpha)?.as_ref());
    solved(ward(rho_s, alpha)?, alpha, rho_s)
}

/// A rough dielectric first surface, n = 1.5, that reads a 20 deg gloss \[GU\]; `rho_s` is 0.
///
/// # Errors
/// `Error::Parameter` if no width gives the reading.
pub fn coat_of_gloss(wanted: f64) -> Result<Solved> {
    let alpha = width(&coat, [1e-3, 0.5], &gloss20, wanted)?;
    solved(coat(alpha)?, alpha, 0.0)
}

/// Beckmann's rough dielectric, n = 1.5.
///
/// # Errors
/// `Error::Parameter` for a width outside the model's range.
pub fn coat(alpha: f64) -> Result<Box<dyn Brdf>> {
    model::parse(&format!("beckmann:alpha={alpha},n=1.5"), WAVELENGTH)
}

fn solved(brdf: Box<dyn Brdf>, alpha: f64, rho_s: f64) -> Result<Solved> {
    let [gloss, haze] = read(brdf.as_ref())?;
    Ok(Solved { brdf, alpha, rho_s, gloss, haze })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Widths of another program's integration for Ward with rho_s = R(20 deg) / cos(20 deg): .00754, .01108, .01607, .02596.
    #[test]
    fn gloss_tiles_have_the_widths_of_another_integration() {
        for (wanted, alpha) in [(80.0, 0.00754), (60.0, 0.01108), (40.0, 0.01607), (20.0, 0.02596)] {
            let s = ward_of_gloss(wanted).unwrap();
            assert!((s.gloss.value - wanted).abs() < TOLERANCE, "{wanted}: {:?}", s.gloss);
            assert!((s.alpha - alpha).abs() < 1e-5 + 1e-3 * alpha, "{wanted}: {}", s.alpha);
        }
    }

    /// As above with two receptors of 1.8 x 5.5 deg: .0067, .0125, .0172, .0228.
    #[test]
    fn haze_tiles_have_the_widths_of_another_integration() {
        for (wanted, alpha) in [(10.0, 0.0067), (60.0, 0.0125), (110.0, 0.0172), (160.0, 0.0228)] {
            let s = ward_of_haze(100.0, wanted).unwrap();
            assert!((s.gloss.value - 100.0).abs() < 2.0 * TOLERANCE && (s.haze.value - wanted).abs() < 2.0 * TOLERANCE);
            assert!((s.alpha - alpha).abs() < 1e-4, "{wanted}: {}", s.alpha);
        }
    }

    #[test]
    fn coats_read_their_gloss() {
        for wanted in [10.0, 60.0] {
            let s = coat_of_gloss(wanted).unwrap();
            assert!((s.gloss.value - wanted).abs() < TOLERANCE, "{:?}", s.gloss);
        }
        // A flat surface of n = 1.5 reads 82.
        assert!(coat_of_gloss(90.0).is_err());
    }
}
