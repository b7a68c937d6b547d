//! From a height map to its table and its gloss.

use crate::error::Result;
use crate::heightmap::{HeightMap, parameters};
use crate::math::Estimate;
use crate::meter::{self, Geometry, Warning, check_rays, rayleigh_parameter, surface_gloss};
use crate::sample::TableBrdf;
use crate::scatter::tally::BOUNCES;
use crate::scatter::{self, Decision, Run, Tally};
use crate::table::{Provenance, Table};

/// Source azimuths over which the gloss of an anisotropic surface is averaged \[rad\].
pub const GLOSS_AZIMUTHS: [f64; 4] =
    [0.0, std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_2, 3.0 * std::f64::consts::FRAC_PI_4];

/// How to predict.
#[derive(Debug, Clone)]
pub struct Settings {
    pub scatter: scatter::Options,
    /// Wavelength at which rays are judged \[m\].
    pub wavelength: f64,
    pub meter: meter::Options,
    /// The glossmeter at 20, 60, 85 deg.
    pub glossmeter: [Geometry; 3],
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            scatter: scatter::Options::default(),
            wavelength: 550e-9,
            meter: meter::Options::default(),
            glossmeter: Geometry::standard_three(),
        }
    }
}

/// Everything one map predicts.
pub struct Prediction {
    pub name: String,
    /// Sq \[m\], Sdq and missing share of the map.
    pub sq: f64,
    pub sdq: f64,
    pub missing_fraction: f64,
    pub isotropic: bool,
    pub decisions: Vec<Decision>,
    /// Facets with three measured vertices; 0 if unknown.
    pub facets: u64,
    /// Share of the incident energy that left after 1, 2, 3 and more bounces, per incident polar angle, the mean over azimuths.
    pub bounce_fractions: Vec<[f64; BOUNCES]>,
    pub brdf: TableBrdf,
    /// Gloss at 20, 60, 85 deg \[GU\].
    pub gloss: [Estimate; 3],
    /// Rayleigh parameter at 20, 60, 85 deg.
    pub rayleigh: [f64; 3],
    pub warnings: Vec<Warning>,
}

/// The whole chain for one map: slopes, scatter, table, alias sampler, gloss with its standard error.
///
/// # Errors
/// `Error::Parameter` for a map without facets or options outside their ranges.
pub fn predict(
    map: &HeightMap,
    name: &str,
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Prediction> {
    predict_run(map, name, settings, &mut Run::Whole, progress)
}

/// As [`predict`], with the beams of `run`: all of them, or the merged sums of several parts.
///
/// # Errors
/// As [`predict`]; also if the sums in `run` are not of this map and these settings.
pub fn predict_run(
    map: &HeightMap,
    name: &str,
    settings: &Settings,
    run: &mut Run,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Prediction> {
    let sq = parameters::sq(map);
    // The ISO number of `inspect`, over edges; the cells follow the mean over facets, which a gap weighs differently.
    let sdq = parameters::Gradient::measure(map).sdq;
    let scattered = scatter::scatter_run(map, &settings.scatter, run, &|done| progress(0.8 * done))?;
    let provenance = Provenance {
        source: name.to_owned(),
        sq,
        sdq,
        missing_fraction: map.missing_fraction(),
        wavelength: settings.wavelength,
        method: settings.scatter.method,
        seed: settings.scatter.seed,
        program: concat!("asperity ", env!("CARGO_PKG_VERSION")).to_owned(),
    };
    let table = Table::from_scatter(&scattered, provenance);
    let bounce_fractions = scattered.tallies.iter().map(|row| mean_bounces(row)).collect();
    let brdf = TableBrdf::new(table)?;
    let mut prediction = Prediction {
        name: name.to_owned(),
        sq,
        sdq,
        missing_fraction: map.missing_fraction(),
        isotropic: scattered.isotropic,
        decisions: scattered.decisions,
        facets: scattered.statistics.facets,
        bounce_fractions,
        gloss: [Estimate::default(); 3],
        rayleigh: [0.0; 3],
        warnings: Vec::new(),
        brdf,
    };
    measure_gloss(&mut prediction, settings)?;
    progress(1.0);
    Ok(prediction)
}

/// A prediction from a stored table.
///
/// # Errors
/// `Error::Parameter` if the table cannot be sampled.
pub fn from_table(table: Table, name: &str, settings: &Settings) -> Result<Prediction> {
    let provenance = table.provenance.clone();
    let mut prediction = Prediction {
        name: name.to_owned(),
        sq: provenance.sq,
        sdq: provenance.sdq,
        missing_fraction: provenance.missing_fraction,
        isotropic: table.is_isotropic(),
        decisions: Vec::new(),
        facets: 0,
        bounce_fractions: Vec::new(),
        brdf: TableBrdf::new(table)?,
        gloss: [Estimate::default(); 3],
        rayleigh: [0.0; 3],
        warnings: Vec::new(),
    };
    measure_gloss(&mut prediction, settings)?;
    Ok(prediction)
}

fn mean_bounces(row: &[Tally]) -> [f64; BOUNCES] {
    std::array::from_fn(|b| row.iter().map(|tally| tally.bounce_fractions()[b]).sum::<f64>() / row.len() as f64)
}

fn measure_gloss(prediction: &mut Prediction, settings: &Settings) -> Result<()> {
    let azimuths = if prediction.isotropic { vec![0.0] } else { GLOSS_AZIMUTHS.to_vec() };
    let options = settings.meter.clone().with_azimuths(azimuths);
    let gloss = surface_gloss(&prediction.brdf, &settings.glossmeter, &options)?;
    for (k, geometry) in settings.glossmeter.iter().enumerate() {
        prediction.gloss[k] = gloss[k];
        prediction.rayleigh[k] = rayleigh_parameter(prediction.sq, geometry.theta_i, settings.wavelength);
        prediction.warnings.extend(check_rays(prediction.sq, geometry, settings.wavelength));
    }
    Ok(())
}

impl Prediction {
    /// Whether rays may be believed at 20, 60, 85 deg: Rayleigh parameter at least 9, or an exactly flat map.
    pub fn ray_valid(&self) -> [bool; 3] {
        self.rayleigh.map(|g| self.sq == 0.0 || g >= meter::validity::SMALLEST_FOR_RAYS)
    }

    /// How the incident angles were served, in a few words for people.
    pub fn method_summary(&self) -> String {
        if self.decisions.is_empty() {
            return "stored table".to_owned();
        }
        match self.decisions.iter().find(|d| d.visibility) {
            None => "slope distribution at all angles".to_owned(),
            Some(first) => format!("facet visibility from {:.0} deg", first.theta_i.to_degrees()),
        }
    }
}
