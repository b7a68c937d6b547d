//! What an instrument reads on a surface.

use super::gloss::{Options, integrate};
use super::instrument::Instrument;
use super::path::Path;
use crate::error::Result;
use crate::math::Estimate;
use crate::optics::Brdf;

/// One reading of an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    pub name: String,
    /// Value in percent of the standard; the error of the integration only.
    pub estimate: Estimate,
    /// Whether the error came below the tolerance within the points allowed.
    pub converged: bool,
}

impl Instrument {
    /// Reads `brdf`: `100 Phi(specimen) / Phi(standard)` per reading, averaged over the azimuths of `options`.
    ///
    /// # Errors
    /// `Error::Parameter` if the instrument cannot exist or there is no azimuth.
    pub fn measure(&self, brdf: &dyn Brdf, options: &Options) -> Result<Vec<Reading>> {
        self.readings_by(options, |paths, scale| {
            let core: f64 = paths.iter().map(|path| path.core(|wi| brdf.specular_core(wi))).sum();
            let rest = integrate(brdf, paths, options, scale);
            Estimate { value: scale * core + rest.value, ..rest }
        })
    }

    /// The readings by any integrator, which is given the paths of one reading at all azimuths and the units per flux.
    pub(super) fn readings_by(
        &self,
        options: &Options,
        integrator: impl Fn(&[Path], f64) -> Estimate,
    ) -> Result<Vec<Reading>> {
        self.validate()?;
        options.validate()?;
        let read = |name: &str| {
            let paths: Vec<Path> = options.azimuths.iter().flat_map(|&phi| self.paths(name, phi)).collect();
            let estimate = integrator(&paths, self.units_per_flux(name) / options.azimuths.len() as f64);
            let converged = estimate.standard_error <= options.tolerance;
            Reading { name: name.to_owned(), estimate, converged }
        };
        Ok(self.readings().into_iter().map(read).collect())
    }
}
