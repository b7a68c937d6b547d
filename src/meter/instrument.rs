//! A light meter: one source, any number of receptors, a standard, and how the specimen lies.
//!
//! Every reading is `100 Phi(specimen) / Phi(standard)`, the flux summed over the receptors that bear its name.

use super::path::Path;
use super::stop::{Shape, Stop, in_degrees};
use crate::error::{Error, Result};
use crate::optics::fresnel;
use crate::optics::material::STANDARD_GLASS_INDEX;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// One receptor stop.
#[derive(Debug, Clone, PartialEq)]
pub struct Receptor {
    /// Reading to which its flux is added.
    pub reading: String,
    /// Angle from the normal in the plane of measurement \[rad\]: positive on the side of the mirror direction,
    /// negative on the side of the source.
    pub theta_r: f64,
    /// Azimuth out of the plane of measurement about the normal \[rad\].
    pub phi_r: f64,
    pub shape: Shape,
    /// Turn of the stop about its axis \[rad\].
    pub turn: f64,
}

/// What reads 100.
#[derive(Debug, Clone, PartialEq)]
pub enum Standard {
    /// Flat glass of this index, seen through the receptors of the named reading, whatever is being read.
    Glass { index: f64, through: String },
    /// The perfectly reflecting diffuser, seen through the receptors of each reading itself: a reflectance factor
    /// `pi f_r` in percent.
    WhiteDiffuser,
}

/// How the specimen lies: turned about its normal by `azimuth`, then tilted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Specimen {
    /// Azimuth of the source on the specimen \[rad\].
    pub azimuth: f64,
    /// Tilt of the specimen's normal out of the instrument's \[rad\]. The standard lies flat.
    pub tilt: f64,
    /// Azimuth, from the source, towards which the normal leans \[rad\].
    pub tilt_azimuth: f64,
}

impl Specimen {
    /// Turns directions of the instrument into the frame of the specimen.
    fn seen_from(&self) -> DMat3 {
        // Rodrigues about the horizontal axis across the lean; the normal goes back to z.
        let axis = DVec3::new(-self.tilt_azimuth.sin(), self.tilt_azimuth.cos(), 0.0);
        DMat3::from_rotation_z(self.azimuth) * DMat3::from_axis_angle(axis, -self.tilt)
    }
}

/// A light meter.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Name on the command line.
    pub name: String,
    /// What it is and where its numbers come from.
    pub about: String,
    /// Angle of incidence \[rad\].
    pub theta_i: f64,
    pub source: Shape,
    /// Turn of the source stop about its axis \[rad\].
    pub source_turn: f64,
    pub receptors: Vec<Receptor>,
    pub standard: Standard,
    pub specimen: Specimen,
}

impl Instrument {
    /// A gloss instrument: rectangular source, one receptor called `gloss` at the mirror angle, black glass.
    pub fn gloss(name: &str, theta_i: f64, source: [f64; 2], receptor: Shape) -> Self {
        Instrument {
            name: name.to_owned(),
            about: String::new(),
            theta_i,
            source: Shape::Rectangle(source),
            source_turn: 0.0,
            receptors: vec![Receptor {
                reading: "gloss".into(),
                theta_r: theta_i,
                phi_r: 0.0,
                shape: receptor,
                turn: 0.0,
            }],
            standard: Standard::Glass { index: STANDARD_GLASS_INDEX, through: "gloss".into() },
            specimen: Specimen::default(),
        }
    }

    /// The same instrument with one more receptor.
    pub fn and(mut self, reading: &str, theta_r: f64, shape: Shape) -> Self {
        self.receptors.push(Receptor { reading: reading.to_owned(), theta_r, phi_r: 0.0, shape, turn: 0.0 });
        self
    }

    /// The same instrument with a sentence about it.
    pub fn about(self, about: &str) -> Self {
        Instrument { about: about.to_owned(), ..self }
    }

    /// Names of the readings in the order of their receptors.
    pub fn readings(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for r in &self.receptors {
            if !names.contains(&r.reading.as_str()) {
                names.push(&r.reading);
            }
        }
        names
    }

    /// Paths of one reading, in the frame of the specimen turned by a further `azimuth` \[rad\].
    pub fn paths(&self, reading: &str, azimuth: f64) -> Vec<Path> {
        let specimen = Specimen { azimuth: self.specimen.azimuth + azimuth, ..self.specimen };
        self.paths_in(reading, &specimen.seen_from())
    }

    /// `100 / Phi(standard)` for one reading [1/sr]: infinite if the standard sends nothing through.
    pub fn units_per_flux(&self, reading: &str) -> f64 {
        let flux: f64 = match &self.standard {
            Standard::Glass { index, through } => self
                .paths_in(through, &DMat3::IDENTITY)
                .iter()
                .map(|path| path.core(|wi| fresnel::dielectric(wi.z, *index)))
                .sum(),
            Standard::WhiteDiffuser => self
                .paths_in(reading, &DMat3::IDENTITY)
                .iter()
                .map(|p| p.source().projected_solid_angle() * p.receptor().projected_solid_angle() / PI)
                .sum(),
        };
        100.0 / flux
    }

    fn paths_in(&self, reading: &str, frame: &DMat3) -> Vec<Path> {
        let source = self.source_stop().seen_from(frame);
        self.receptors
            .iter()
            .filter(|r| r.reading == reading)
            .map(|r| Path::new(source.clone(), receptor_stop(r).seen_from(frame)))
            .collect()
    }

    fn source_stop(&self) -> Stop {
        Stop::new(self.source, self.theta_i, 0.0, self.source_turn)
    }

    /// Checks that the instrument can exist and measure.
    ///
    /// # Errors
    /// `Error::Parameter` with the first thing that is wrong: an angle of incidence outside 0 to 90 deg, a stop of no or
    /// too large a size, a stop that reaches below the horizon of instrument or specimen, no receptor, a standard
    /// that sends no light through its receptors.
    pub fn validate(&self) -> Result<()> {
        let bad =
            |what: String, advice: &str| Err(Error::parameter(format!("instrument `{}`: {what}", self.name), advice));
        if !(self.theta_i >= 0.0 && self.theta_i < FRAC_PI_2) {
            let what = format!("the angle of incidence is {} deg", in_degrees(self.theta_i));
            return bad(what, "give 0 to 90 deg, 90 excluded");
        }
        self.source.check(&format!("the source stop of instrument `{}`", self.name))?;
        if self.receptors.is_empty() {
            return bad("there is no receptor".into(), "give at least one [[receptor]]");
        }
        let Specimen { azimuth, tilt, tilt_azimuth } = self.specimen;
        if !(azimuth.is_finite() && tilt_azimuth.is_finite() && tilt.abs() < FRAC_PI_2) {
            return bad(format!("the specimen is tilted by {} deg", in_degrees(tilt)), "keep the tilt below 90 deg");
        }
        let turned = self.specimen.seen_from();
        let above = |stop: &Stop| stop.lowest().min(stop.seen_from(&turned).lowest()) > 0.0;
        if !above(&self.source_stop()) {
            return bad("the source stop reaches below the horizon".into(), "make it smaller or the angle steeper");
        }
        for r in &self.receptors {
            let whose = format!("the receptor `{}` of instrument `{}`", r.reading, self.name);
            if r.reading.is_empty() {
                return bad("a receptor has no reading".into(), "give each the name of the reading it belongs to");
            }
            r.shape.check(&whose)?;
            let somewhere = r.theta_r.abs() < FRAC_PI_2 && r.phi_r.is_finite() && r.turn.is_finite();
            if !(somewhere && above(&receptor_stop(r))) {
                let what = format!("{whose}, at {} deg, reaches below the horizon", in_degrees(r.theta_r));
                return Err(Error::parameter(what, "make it smaller or move it towards the normal"));
            }
        }
        if let Standard::Glass { index, through } = &self.standard {
            if !(*index > 1.0 && index.is_finite()) {
                return bad(format!("the standard has an index of {index}"), "give an index above 1, such as 1.567");
            }
            if !self.readings().contains(&through.as_str()) {
                let what = format!("the standard is seen through `{through}`, and no receptor has that reading");
                return bad(what, "name one of its readings");
            }
        }
        match self.readings().into_iter().find(|reading| !self.units_per_flux(reading).is_finite()) {
            Some(reading) => bad(
                format!("the standard sends no light through the receptor, so `{reading}` has no scale"),
                "put the standard's receptor where a mirror sends the source, or use the white diffuser",
            ),
            None => Ok(()),
        }
    }
}

fn receptor_stop(r: &Receptor) -> Stop {
    Stop::new(r.shape, r.theta_r, PI + r.phi_r, r.turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;

    #[test]
    fn a_tilted_specimen_sees_its_own_normal_as_z() {
        let specimen = Specimen { azimuth: 0.4, tilt: 0.1, tilt_azimuth: 0.7 };
        let normal = direction(0.1, 0.7);
        assert!((specimen.seen_from() * normal - DVec3::Z).length() < 1e-14);
        // Untilted, the source lies at its azimuth on the specimen.
        let flat = Specimen { tilt: 0.0, ..specimen };
        assert!((flat.seen_from() * direction(1.0, 0.0) - direction(1.0, 0.4)).length() < 1e-14);
    }
}
