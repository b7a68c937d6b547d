//! Flags that say how to scatter.

use super::quantity;
use crate::error::Result;
use crate::meter::{self, Geometry};
use crate::optics::Material;
use crate::report::Settings;
use crate::scatter::{Method, Options, Symmetry, Wave};
use clap::{Args, ValueEnum};

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scattering and meter")]
pub struct ScatterOptions {
    /// How to scatter: auto takes the cheapest method that holds at each incident angle, waves (kirchhoff) where rays do not;
    /// geometric is auto without waves
    #[arg(long, value_enum, default_value_t = MethodFlag::Auto)]
    method: MethodFlag,
    /// Material of the surface: mirror, n=1.5, n=1.0+6.6k, black-glass, epoxy, al, cu, au, ag, fe, cr, ni
    #[arg(long, default_value = "n=1.5", value_name = "NAME")]
    material: String,
    /// Wavelength at which the material is looked up, rays are judged and waves are computed
    #[arg(long, value_parser = quantity::wavelength, default_value = "550nm")]
    wavelength: f64,
    /// Full width of the band of wavelengths that the wave calculation averages over
    #[arg(long, value_parser = quantity::length, default_value = "0nm", value_name = "LENGTH")]
    band: f64,
    /// Full angle in degrees of a source that the wave calculation averages over; the glossmeter adds its own stop
    #[arg(long, value_parser = quantity::angle, default_value = "0", value_name = "DEG")]
    source_cone: f64,
    /// Incident polar angles in degrees, rising [default: those of 14 from 0 to 88 that --tolerance needs]
    #[arg(long, value_parser = quantity::angle, value_delimiter = ',', value_name = "LIST")]
    theta_i: Option<Vec<f64>>,
    /// Source azimuths in degrees of an anisotropic table, rising [default: those of every 30 that --tolerance needs, and one where
    /// no visibility is traced: its density serves every azimuth]
    #[arg(long, value_parser = quantity::angle, value_delimiter = ',', value_name = "LIST")]
    phi_i: Option<Vec<f64>>,
    /// Whether to average over source azimuths
    #[arg(long, value_enum, default_value_t = SymmetryFlag::Auto)]
    symmetry: SymmetryFlag,
    /// Share of the energy that may go astray: decides the size of the cells, how many incident angles a table keeps, and
    /// whether visibility is computed
    #[arg(long, value_parser = quantity::tolerance, default_value = "1%")]
    tolerance: f64,
    /// Rays per incident direction of --method rays
    #[arg(long, value_parser = quantity::count, default_value = "1000000", value_name = "N")]
    rays: u64,
    /// Reflections a ray may make
    #[arg(long, default_value_t = 8, value_name = "N")]
    bounces: u32,
    /// Source stop of the glossmeter, full angles in degrees in and across the plane of measurement
    #[arg(long, value_name = "IN,ACROSS", value_parser = quantity::stop, default_value = "0.75,2.5")]
    source_stop: [f64; 2],
    /// Same seed, same bytes
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum MethodFlag {
    Auto,
    Geometric,
    Facets,
    Rays,
    Kirchhoff,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum SymmetryFlag {
    Auto,
    Isotropic,
    Anisotropic,
}

impl ScatterOptions {
    /// Wavelength \[m\].
    pub fn wavelength(&self) -> f64 {
        self.wavelength
    }

    /// The same at another wavelength \[m\].
    pub fn at_wavelength(&self, wavelength: f64) -> Self {
        ScatterOptions { wavelength, ..self.clone() }
    }

    /// The same by rays alone.
    pub fn by_rays(&self) -> Self {
        ScatterOptions { method: MethodFlag::Geometric, ..self.clone() }
    }

    /// The same by waves alone.
    pub fn by_waves(&self) -> Self {
        ScatterOptions { method: MethodFlag::Kirchhoff, ..self.clone() }
    }

    /// Seed of everything random.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The flags without the incident angles, which are given apart: for verbs that ask about one direction.
    pub fn without_angles(mut self) -> (Self, Option<Vec<f64>>, Option<Vec<f64>>) {
        let (theta_i, phi_i) = (self.theta_i.take(), self.phi_i.take());
        (self, theta_i, phi_i)
    }

    /// Directions of incidence asked for, `(theta_i, phi_i)` \[rad\]; 20 deg at azimuth 0 unless said otherwise.
    pub fn directions(&self) -> Result<Vec<(f64, f64)>> {
        self.settings()?;
        let theta_i = self.theta_i.clone().unwrap_or_else(|| vec![20f64.to_radians()]);
        let phi_i = self.phi_i.clone().unwrap_or_else(|| vec![0.0]);
        Ok(theta_i.iter().flat_map(|&t| phi_i.iter().map(move |&p| (t, p))).collect())
    }

    /// Whether --phi-i was given.
    pub fn names_azimuths(&self) -> bool {
        self.phi_i.is_some()
    }

    /// What to say of --phi-i where it has no effect.
    pub fn unused_azimuths(&self, isotropic: bool) -> Option<String> {
        let unused = isotropic && self.names_azimuths();
        unused.then(|| {
            "The table is averaged over source azimuths, so --phi-i has no effect: --symmetry anisotropic keeps them.".to_owned()
        })
    }

    /// The library's settings.
    pub fn settings(&self) -> Result<Settings> {
        let defaults = Options::default();
        let scatter = Options {
            method: match self.method {
                MethodFlag::Auto => Method::Auto,
                MethodFlag::Geometric => Method::Geometric,
                MethodFlag::Facets => Method::Facets,
                MethodFlag::Rays => Method::Rays,
                MethodFlag::Kirchhoff => Method::Kirchhoff,
            },
            symmetry: match self.symmetry {
                SymmetryFlag::Auto => Symmetry::Auto,
                SymmetryFlag::Isotropic => Symmetry::Isotropic,
                SymmetryFlag::Anisotropic => Symmetry::Anisotropic,
            },
            material: Material::parse(&self.material, self.wavelength)?,
            wave: Wave { wavelength: self.wavelength, band: self.band, source: self.source_cone },
            theta_i: self.theta_i.clone().unwrap_or(defaults.theta_i),
            phi_i: self.phi_i.clone().unwrap_or(defaults.phi_i),
            all_phi_i: self.phi_i.is_some(),
            footprint: None,
            tolerance: self.tolerance,
            rays: self.rays,
            bounces: self.bounces,
            seed: self.seed,
        };
        scatter.check()?;
        let glossmeter = Geometry::standard_three().map(|g| Geometry { source: self.source_stop, ..g });
        glossmeter.iter().try_for_each(Geometry::validate)?;
        let fewest_angles = self.theta_i.is_none() && self.phi_i.is_none();
        Ok(Settings {
            scatter,
            fewest_angles,
            wavelength: self.wavelength,
            meter: meter::Options::default(),
            glossmeter,
        })
    }
}
