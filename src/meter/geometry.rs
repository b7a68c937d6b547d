//! What a glossmeter looks like from the specimen: angles and stops of the standard instruments.
//!
//! Every number is a public field, because part of them could not be checked against the text of the standards:
//!
//! | field | value | source |
//! |---|---|---|
//! | incidence | 20, 60, 85 deg | ISO 2813, ASTM D523 |
//! | source stop | 0.75 x 2.5 deg | the well-known table of ASTM D523; recalled, the standard's text was not seen |
//! | receptor stop 20 deg | 1.8 x 3.6 deg | instrument specifications quoting ISO 2813; the 1.8 deg also in ISO 13803 |
//! | receptor stop 60 deg | 4.4 x 11.7 deg | instrument specifications quoting ISO 2813 |
//! | receptor stop 85 deg | 4.0 x 6.0 deg | instrument specifications quoting ISO 2813 |
//! | standard | polished black glass, n = 1.567 | ISO 2813: at 587.6 nm; ASTM D523: sodium D line (0.02 units apart) |
//!
//! First the angle in the plane of measurement, then the angle across it. The stops are rectangles in the focal plane
//! of a lens: they select directions, not places on the specimen (parallel-beam design).

use super::path::Path;
use super::stop::{Shape, Stop};
use crate::error::{Error, Result};
use crate::optics::fresnel;
use crate::optics::material::STANDARD_GLASS_INDEX;
use std::f64::consts::PI;

/// A glossmeter: one direction of incidence, a source stop, a receptor stop and the standard that defines 100.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// Angle of incidence \[rad\]; the receptor axis lies at the same angle on the other side.
    pub theta_i: f64,
    /// Full angles of the source stop [rad]: in the plane of measurement, across it.
    pub source: [f64; 2],
    /// Full angles of the receptor stop [rad]: in the plane of measurement, across it.
    pub receptor: [f64; 2],
    /// Angle of the receptor axis beyond the specular direction, positive away from the normal \[rad\]; 0 for gloss.
    pub offset: f64,
    /// Refractive index of the flat black glass that reads 100.
    pub standard_index: f64,
}

impl Geometry {
    /// A gloss geometry with the standard source stop and black glass; all arguments in degrees.
    pub fn with_receptor(theta_i_deg: f64, receptor_deg: [f64; 2]) -> Self {
        Geometry {
            theta_i: theta_i_deg.to_radians(),
            source: [0.75, 2.5].map(f64::to_radians),
            receptor: receptor_deg.map(f64::to_radians),
            offset: 0.0,
            standard_index: STANDARD_GLASS_INDEX,
        }
    }

    /// 20 deg: high gloss, above 70 gloss units at 60 deg.
    pub fn gloss20() -> Self {
        Self::with_receptor(20.0, [1.8, 3.6])
    }

    /// 60 deg: the general one.
    pub fn gloss60() -> Self {
        Self::with_receptor(60.0, [4.4, 11.7])
    }

    /// 85 deg: low gloss, below 10 gloss units at 60 deg.
    pub fn gloss85() -> Self {
        Self::with_receptor(85.0, [4.0, 6.0])
    }

    /// The three geometries of ISO 2813 in rising order.
    pub fn standard_three() -> [Self; 3] {
        [Self::gloss20(), Self::gloss60(), Self::gloss85()]
    }

    /// The two stops in place, the source at azimuth `phi` \[rad\] of the specimen and the receptor opposite.
    pub fn path(&self, phi: f64) -> Path {
        let source = Stop::new(Shape::Rectangle(self.source), self.theta_i, phi, 0.0);
        let receptor = Stop::new(Shape::Rectangle(self.receptor), self.theta_i + self.offset, phi + PI, 0.0);
        Path::new(source, receptor)
    }

    /// `100 / Phi(standard)`: the standard is always read at the specular angle, also for a receptor beside it.
    pub fn units_per_flux(&self) -> f64 {
        let through = Geometry { offset: 0.0, ..self.clone() }.path(0.0);
        100.0 / through.core(|wi| fresnel::dielectric(wi.z, self.standard_index))
    }

    /// Checks that the instrument can exist.
    ///
    /// # Errors
    /// `Error::Parameter` if a stop is empty or wider than 90 deg, an axis is not above the surface, or the standard
    /// does not reflect.
    pub fn validate(&self) -> Result<()> {
        let right_angle = std::f64::consts::FRAC_PI_2;
        let stops = self.source.iter().chain(&self.receptor);
        let (what, advice) = if stops.clone().any(|&a| !(a > 0.0 && a < right_angle)) {
            (
                "a stop of the glossmeter is not between 0 and 90 deg",
                "give both full angles in degrees, as in --source-stop 0.75,2.5",
            )
        } else if !(self.theta_i >= 0.0 && self.theta_i < right_angle) {
            ("the angle of incidence of the glossmeter is not between 0 and 90 deg", "take 20, 60 or 85 deg")
        } else if (self.theta_i + self.offset).abs().partial_cmp(&right_angle) != Some(std::cmp::Ordering::Less) {
            ("the receptor of the glossmeter is below the surface", "move it towards the normal")
        } else if !(self.standard_index > 1.0 && self.standard_index.is_finite()) {
            ("the index of the gloss standard is not above 1", "take that of black glass, 1.567")
        } else {
            return Ok(());
        };
        Err(Error::parameter(what, advice))
    }
}
