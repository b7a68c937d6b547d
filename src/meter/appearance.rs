//! The scales of appearance that are computed from readings, and the usual set of them for one surface.

use super::gloss::Options;
use super::measure::Reading;
use super::standards;
use super::validity::Warning;
use crate::error::Result;
use crate::math::Estimate;
use crate::optics::Brdf;

/// `HU = 1285 log10(H / 20 + 1)`: log haze of ISO 13803 from the haze H of `haze-20`. The constant is recalled; it makes
/// H = 100 read 999.9.
pub fn log_haze(haze: Estimate) -> Estimate {
    let shifted = haze.value / 20.0 + 1.0;
    let slope = 1285.0 / (std::f64::consts::LN_10 * 20.0 * shifted);
    Estimate { value: 1285.0 * shifted.log10(), standard_error: slope * haze.standard_error }
}

/// `G60 - G20`: haze index (ASTM D4039).
pub fn haze_index(g60: Estimate, g20: Estimate) -> Estimate {
    Estimate { value: g60.value - g20.value, standard_error: g60.standard_error.hypot(g20.standard_error) }
}

/// `DOI = 100 (1 - R_beside / R_specular)`: distinctness of image (ASTM E430); `None` if nothing is reflected at the
/// specular angle. Negative where there is more light beside the mirror direction than in it, as chance has it on a surface that
/// mirrors no image ([`Appearance::doubt`]).
pub fn doi(specular: Estimate, beside: Estimate) -> Option<Estimate> {
    let ratio = beside.value / specular.value;
    let standard_error = 100.0 * beside.standard_error.hypot(ratio * specular.standard_error) / specular.value;
    (specular.value > 0.0).then_some(Estimate { value: 100.0 * (1.0 - ratio), standard_error })
}

/// `FI = 2.69 (L*15 - L*110)^1.11 / (L*45)^0.86`: flop index of a metallic coat (Alman, DuPont; recalled); 0 if it does not
/// darken away from the mirror direction, `None` if it is black at 45 deg.
pub fn flop_index(l15: f64, l45: f64, l110: f64) -> Option<f64> {
    (l45 > 0.0).then(|| 2.69 * (l15 - l110).max(0.0).powf(1.11) / l45.powf(0.86))
}

/// What a bench of meters reads on one surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Appearance {
    /// Gloss at 20, 60 and 85 deg \[GU\].
    pub gloss: [Reading; 3],
    /// Two-sided reflection haze beside 20 deg.
    pub haze: Reading,
    pub log_haze: Estimate,
    pub haze_index: Estimate,
    /// Distinctness of image; `None` for a surface without a specular reading.
    pub doi: Option<Reading>,
    /// Peak gloss at 20 deg.
    pub rspec: Reading,
}

impl Appearance {
    /// Every number in the order of the fields, haze index and image after haze; NaN for an image that is not there.
    pub fn numbers(&self) -> Vec<f64> {
        let doi = self.doi.as_ref().map_or(f64::NAN, |d| d.estimate.value);
        let gloss = self.gloss.iter().map(|g| g.estimate.value);
        let scales =
            [self.haze.estimate.value, self.log_haze.value, self.haze_index.value, doi, self.rspec.estimate.value];
        gloss.chain(scales).collect()
    }

    /// Joins further standard errors, in the order of [`Appearance::numbers`], in quadrature.
    pub fn with_errors(mut self, errors: &[f64]) -> Self {
        let mut doi = self.doi.as_mut().map_or_else(Estimate::default, |d| d.estimate);
        let [a, b, c] = &mut self.gloss;
        let mut all = [
            &mut a.estimate,
            &mut b.estimate,
            &mut c.estimate,
            &mut self.haze.estimate,
            &mut self.log_haze,
            &mut self.haze_index,
            &mut doi,
            &mut self.rspec.estimate,
        ];
        all.iter_mut().zip(errors).for_each(|(estimate, error)| **estimate = estimate.with_error(*error));
        if let Some(reading) = &mut self.doi {
            reading.estimate = doi;
        }
        self
    }

    /// What there is to say against the image: a negative distinctness.
    pub fn doubt(&self) -> Option<Warning> {
        let doi = self.doi.as_ref()?.estimate;
        (doi.value < 0.0).then_some(Warning::NoImage { doi: doi.value, standard_error: doi.standard_error })
    }
}

/// Reads the usual set.
///
/// # Errors
/// `Error::Parameter` if `options` ask for nothing.
pub fn appearance(brdf: &dyn Brdf, options: &Options) -> Result<Appearance> {
    let read = |name: &str| standards::by_name(name).expect("a named instrument").measure(brdf, options);
    let first = |name: &str| read(name).map(|mut readings| readings.remove(0));
    let gloss = [first("gloss-20")?, first("gloss-60")?, first("gloss-85")?];
    let haze = read("haze-20")?.remove(1);
    let image = read("doi")?;
    let converged = image.iter().all(|r| r.converged);
    let doi = doi(image[0].estimate, image[1].estimate);
    Ok(Appearance {
        log_haze: log_haze(haze.estimate),
        haze_index: haze_index(gloss[1].estimate, gloss[0].estimate),
        doi: doi.map(|estimate| Reading { name: "doi".into(), estimate, converged }),
        rspec: first("rspec")?,
        gloss,
        haze,
    })
}
