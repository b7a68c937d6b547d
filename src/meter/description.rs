//! Instruments as TOML: angles in degrees, one table per stop.
//!
//! ```toml
//! name = "haze of ours"
//! theta_i_deg = 20.0
//! source = { size_deg = [0.75, 2.5] }
//!
//! [[receptor]]
//! reading = "gloss"
//! theta_r_deg = 20.0            # positive on the mirror's side; phi_r_deg turns it out of the plane
//! size_deg = [1.8, 3.6]         # or diameter_deg = 5.0; turn_deg turns it about its axis
//!
//! [standard]                    # left out: black glass seen through the first reading
//! index = 1.567                 # or white = true: reflectance factors in percent
//! through = "gloss"
//!
//! [specimen]                    # left out: flat
//! tilt_deg = 0.1
//! ```

use super::instrument::{Instrument, Receptor, Specimen, Standard};
use super::stop::{Shape, in_degrees};
use crate::error::{Error, Result};
use crate::optics::material::STANDARD_GLASS_INDEX;
use serde::{Deserialize, Serialize};
use std::path::Path;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    about: String,
    theta_i_deg: f64,
    source: StopTable,
    receptor: Vec<ReceptorTable>,
    #[serde(default)]
    standard: StandardTable,
    #[serde(default)]
    specimen: SpecimenTable,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StopTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    size_deg: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diameter_deg: Option<f64>,
    #[serde(default)]
    turn_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReceptorTable {
    reading: String,
    theta_r_deg: f64,
    #[serde(default)]
    phi_r_deg: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    size_deg: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diameter_deg: Option<f64>,
    #[serde(default)]
    turn_deg: f64,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct StandardTable {
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    white: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    index: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    through: Option<String>,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct SpecimenTable {
    azimuth_deg: f64,
    tilt_deg: f64,
    tilt_azimuth_deg: f64,
}

impl Instrument {
    /// Reads an instrument from TOML.
    ///
    /// # Errors
    /// `Error::Parameter` for text that is no instrument, with line and column, or an instrument that cannot exist.
    pub fn from_toml(text: &str) -> Result<Instrument> {
        let file: File = toml::from_str(text).map_err(|e| {
            Error::parameter(
                format!("the instrument cannot be read: {}", e.to_string().trim_end()),
                "print one with `asperity instrument gloss-60` and change it",
            )
        })?;
        let receptors = file
            .receptor
            .into_iter()
            .map(|r| {
                Ok(Receptor {
                    shape: shape(&format!("receptor `{}`", r.reading), r.size_deg, r.diameter_deg)?,
                    reading: r.reading,
                    theta_r: r.theta_r_deg.to_radians(),
                    phi_r: r.phi_r_deg.to_radians(),
                    turn: r.turn_deg.to_radians(),
                })
            })
            .collect::<Result<Vec<_>>>()?;
        let standard = match file.standard {
            StandardTable { white: true, index: None, through: None } => Standard::WhiteDiffuser,
            StandardTable { white: true, .. } => {
                return Err(Error::parameter(
                    "the standard is white and has an index or a receptor as well",
                    "a white diffuser is seen through every reading; write white = true alone",
                ));
            }
            StandardTable { index, through, .. } => Standard::Glass {
                index: index.unwrap_or(STANDARD_GLASS_INDEX),
                through: through.or_else(|| receptors.first().map(|r| r.reading.clone())).unwrap_or_default(),
            },
        };
        let instrument = Instrument {
            source: shape("source", file.source.size_deg, file.source.diameter_deg)?,
            source_turn: file.source.turn_deg.to_radians(),
            name: file.name,
            about: file.about,
            theta_i: file.theta_i_deg.to_radians(),
            receptors,
            standard,
            specimen: Specimen {
                azimuth: file.specimen.azimuth_deg.to_radians(),
                tilt: file.specimen.tilt_deg.to_radians(),
                tilt_azimuth: file.specimen.tilt_azimuth_deg.to_radians(),
            },
        };
        instrument.validate()?;
        Ok(instrument)
    }

    /// Reads an instrument from a TOML file.
    ///
    /// # Errors
    /// `Error::Io` or, naming the file, what [`Instrument::from_toml`] says.
    pub fn load(path: &Path) -> Result<Instrument> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_toml(&text).map_err(|e| match e {
            Error::Parameter { what, advice } => Error::content(path, what, advice),
            other => other,
        })
    }

    /// The instrument as TOML that [`Instrument::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let (white, index, through) = match &self.standard {
            Standard::Glass { index, through } => (false, Some(*index), Some(through.clone())),
            Standard::WhiteDiffuser => (true, None, None),
        };
        let receptor = |r: &Receptor| {
            let (size_deg, diameter_deg) = sizes(r.shape);
            ReceptorTable {
                reading: r.reading.clone(),
                theta_r_deg: in_degrees(r.theta_r),
                phi_r_deg: in_degrees(r.phi_r),
                size_deg,
                diameter_deg,
                turn_deg: in_degrees(r.turn),
            }
        };
        let (size_deg, diameter_deg) = sizes(self.source);
        let file = File {
            name: self.name.clone(),
            about: self.about.clone(),
            theta_i_deg: in_degrees(self.theta_i),
            source: StopTable { size_deg, diameter_deg, turn_deg: in_degrees(self.source_turn) },
            receptor: self.receptors.iter().map(receptor).collect(),
            standard: StandardTable { white, index, through },
            specimen: SpecimenTable {
                azimuth_deg: in_degrees(self.specimen.azimuth),
                tilt_deg: in_degrees(self.specimen.tilt),
                tilt_azimuth_deg: in_degrees(self.specimen.tilt_azimuth),
            },
        };
        toml::to_string(&file).expect("numbers and words are TOML")
    }
}

fn sizes(shape: Shape) -> (Option<[f64; 2]>, Option<f64>) {
    match shape {
        Shape::Rectangle(sides) => (Some(sides.map(in_degrees)), None),
        Shape::Disc(diameter) => (None, Some(in_degrees(diameter))),
    }
}

fn shape(whose: &str, size_deg: Option<[f64; 2]>, diameter_deg: Option<f64>) -> Result<Shape> {
    match (size_deg, diameter_deg) {
        (Some(sides), None) => Ok(Shape::Rectangle(sides.map(f64::to_radians))),
        (None, Some(diameter)) => Ok(Shape::Disc(diameter.to_radians())),
        _ => Err(Error::parameter(
            format!("the stop of the {whose} has no size, or two"),
            "give either size_deg = [in plane, across] or diameter_deg",
        )),
    }
}
