//! Colour at several angles: reflectance factors by wavelength, tristimulus values, CIELAB.

use super::gloss::Options;
use super::instrument::Instrument;
use crate::error::Result;
use crate::math::Estimate;
use crate::optics::Brdf;
use crate::optics::colour::{Illuminant, lab, nodes, white};

/// Colour under one receptor.
#[derive(Debug, Clone, PartialEq)]
pub struct Colour {
    /// Reading of the instrument: for the metallic ones the aspecular angle in degrees.
    pub name: String,
    /// Tristimulus values, 1 for Y of the perfect diffuser, with the error of the integration.
    pub xyz: [Estimate; 3],
    /// L*, a*, b* against the perfect diffuser.
    pub lab: [f64; 3],
}

/// Readings of `instrument` weighted by illuminant and observer: `X = sum_k x(lambda_k) S(lambda_k) F(lambda_k)`.
///
/// `surface` is the surface at a wavelength \[m\]; it is asked at every 20 nm from 380 to 780 nm. Y alone is a reading weighted
/// by V(lambda), as glossmeters are.
///
/// # Errors
/// What `surface` says, and `Error::Parameter` if the instrument cannot exist.
pub fn colours(
    surface: &dyn Fn(f64) -> Result<Box<dyn Brdf>>,
    instrument: &Instrument,
    illuminant: Illuminant,
    options: &Options,
) -> Result<Vec<Colour>> {
    let mut found: Vec<Colour> = instrument
        .readings()
        .into_iter()
        .map(|name| Colour { name: name.to_owned(), xyz: [Estimate::default(); 3], lab: [0.0; 3] })
        .collect();
    for node in nodes(illuminant) {
        let readings = instrument.measure(surface(node.wavelength)?.as_ref(), options)?;
        for (colour, reading) in found.iter_mut().zip(readings) {
            for (sum, weight) in colour.xyz.iter_mut().zip(node.xyz) {
                sum.value += weight * reading.estimate.value / 100.0;
                // The same points at every wavelength: the errors go together.
                sum.standard_error += weight * reading.estimate.standard_error / 100.0;
            }
        }
    }
    let white = white(illuminant);
    for colour in &mut found {
        colour.lab = lab(colour.xyz.map(|x| x.value), white);
    }
    Ok(found)
}
