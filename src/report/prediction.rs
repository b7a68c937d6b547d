//! From a height map to its table and its gloss.

use crate::error::Result;
use crate::heightmap::sampling::Quantum;
use crate::heightmap::{HeightMap, parameters};
use crate::math::{Estimate, direction};
use crate::meter::validity::SMALLEST_FOR_RAYS;
use crate::meter::{
    self, Azimuths, Geometry, Holds, Warning, check_rays, check_waves, facet_gloss, rayleigh_parameter, surface_gloss,
    traced_gloss,
};
use crate::sample::TableBrdf;
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::tally::BOUNCES;
use crate::scatter::{self, Decision, Method, Run, Tally};
use crate::table::{Provenance, Steps, Table};

/// Source azimuths over which the gloss of an anisotropic surface is averaged \[rad\].
pub const GLOSS_AZIMUTHS: [f64; 4] =
    [0.0, std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_2, 3.0 * std::f64::consts::FRAC_PI_4];

/// Angles of the glossmeter \[deg\].
const ANGLES: [f64; 3] = [20.0, 60.0, 85.0];

/// How to predict.
#[derive(Debug, Clone)]
pub struct Settings {
    pub scatter: scatter::Options,
    /// Leave out the incident angles, polar and azimuthal, that interpolation gives within half of `scatter.tolerance`: a matt
    /// surface needs few.
    pub fewest_angles: bool,
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
            fewest_angles: false,
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
    /// Gloss at 20, 60, 85 deg \[GU\], from the table: by rays or by waves, whichever served there.
    pub gloss: [Estimate; 3],
    /// What rays alone give, straight from the facets; `None` for a stored table.
    pub ray_gloss: Option<[Estimate; 3]>,
    /// Whether waves served at 20, 60, 85 deg.
    pub wave: [bool; 3],
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
    let part = settings.scatter.footprint.map(|footprint| footprint.cut(map));
    let lit = part.as_ref().unwrap_or(map);
    let sq = parameters::sq(lit);
    // The ISO number of `inspect`, over edges; the cells follow the mean over facets, which a gap weighs differently.
    let sdq = parameters::Gradient::measure(lit).sdq;
    let scattered = scatter::scatter_run(map, &settings.scatter, run, &|done| progress(0.8 * done))?;
    let provenance = Provenance {
        source: name.to_owned(),
        sq,
        sdq,
        missing_fraction: lit.missing_fraction(),
        wavelength: settings.wavelength,
        method: settings.scatter.method,
        seed: settings.scatter.seed,
        program: concat!("asperity ", env!("CARGO_PKG_VERSION")).to_owned(),
    };
    let mut table = Table::from_scatter(&scattered, provenance);
    let quantum = Quantum::of(lit);
    let spread = quantum.map(|q| q.spread(lit, settings.scatter.seed));
    if let Some((quantum, spread)) = quantum.zip(spread.as_ref()) {
        let density = SlopeDensity::measure(spread, table.cells(), scattered.isotropic);
        table = table.with_steps_spread(&quantum, &scattered.density, &density);
    }
    let mut decisions = scattered.decisions;
    let mut bounce_fractions: Vec<_> = scattered.tallies.iter().map(|row| mean_bounces(row)).collect();
    if settings.fewest_angles {
        let tolerance = 0.5 * settings.scatter.tolerance;
        let all: Vec<usize> = (0..table.phi_i().len()).collect();
        let kept = table.needed_theta_i(tolerance);
        table = table.at_nodes(&kept, &all);
        let azimuths = table.needed_phi_i(tolerance);
        table = table.at_nodes(&(0..kept.len()).collect::<Vec<_>>(), &azimuths);
        decisions = kept.iter().map(|&k| decisions[k]).collect();
        bounce_fractions = kept.iter().map(|&k| bounce_fractions[k]).collect();
    }
    let brdf = TableBrdf::new(table)?;
    let mut prediction = Prediction {
        name: name.to_owned(),
        sq,
        sdq,
        missing_fraction: lit.missing_fraction(),
        isotropic: scattered.isotropic,
        decisions,
        facets: scattered.statistics.facets,
        bounce_fractions,
        gloss: [Estimate::default(); 3],
        ray_gloss: None,
        wave: [false; 3],
        rayleigh: [0.0; 3],
        warnings: Vec::new(),
        brdf,
    };
    let azimuths = if prediction.isotropic { Azimuths::All } else { Azimuths::At(GLOSS_AZIMUTHS.to_vec()) };
    let mut by_facets = traced_gloss(map, &settings.glossmeter, &azimuths, &settings.scatter)?.gloss;
    if let Some(spread) = &spread {
        // Hidden facets are as many in both.
        let of = |map| facet_gloss(map, &settings.scatter.material, &settings.glossmeter, &azimuths);
        let (raw, spread) = (of(lit)?.gloss, of(spread)?.gloss);
        for (k, gloss) in by_facets.iter_mut().enumerate() {
            *gloss = gloss.with_error(spread[k].value - raw[k].value);
        }
    }
    prediction.ray_gloss = Some([by_facets[0], by_facets[1], by_facets[2]]);
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
        ray_gloss: None,
        wave: [false; 3],
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
        let theta_i = geometry.theta_i;
        let (_, wave) = prediction.brdf.table().wave_at(direction(theta_i, 0.0));
        prediction.gloss[k] = gloss[k];
        prediction.wave[k] = wave;
        let g = rayleigh_parameter(prediction.sq, theta_i, settings.wavelength);
        prediction.rayleigh[k] = g;
        if !wave {
            let found = check_rays(prediction.sq, geometry, settings.wavelength);
            prediction.warnings.extend(found.map(|w| prediction.missing_angle(g, theta_i).unwrap_or(w)));
            continue;
        }
        if g < SMALLEST_FOR_RAYS {
            let ray = prediction.ray_gloss.map(|rays| rays[k].value);
            prediction.warnings.push(Warning::WavesInstead { g, theta_i, wave: gloss[k].value, ray });
        }
        let doubts = prediction.decision_at(theta_i).map(check_waves);
        prediction.warnings.extend(doubts.unwrap_or_default());
    }
    let steps = steps_warning(prediction, &settings.glossmeter, &options)?;
    prediction.warnings.extend(steps);
    Ok(())
}

/// What steps of the heights do to gloss by rays, at the angle where it is most of the value.
fn steps_warning(
    prediction: &Prediction,
    glossmeter: &[Geometry; 3],
    options: &meter::Options,
) -> Result<Option<Warning>> {
    let table = prediction.brdf.table();
    let (Some(steps), Some(raw)) = (table.steps(), table.of_raw_steps()) else { return Ok(None) };
    let brdf = TableBrdf::new(raw)?;
    let by_rays = (0..3).filter(|&k| !prediction.wave[k] && prediction.gloss[k].value > 0.0);
    let found = by_rays.map(|k| {
        let (spread, value) = (prediction.gloss[k].value, meter::gloss(&brdf, &glossmeter[k], options).value);
        let Steps { step, glint_spacing, .. } = *steps;
        let theta_i = glossmeter[k].theta_i;
        ((value / spread - 1.0).abs(), Warning::HeightsInSteps { step, glint_spacing, theta_i, value, spread })
    });
    let worst = found.max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(worst.map(|(_, warning)| warning))
}

impl Prediction {
    /// That the angle lies beyond those of a table whose method would have chosen waves there.
    fn missing_angle(&self, g: f64, theta_i: f64) -> Option<Warning> {
        let table = self.brdf.table();
        let angles = table.theta_i();
        let nearest = theta_i.clamp(angles[0], angles[angles.len() - 1]);
        let missing = (nearest - theta_i).abs() > 1e-6 && table.provenance.method == Method::Auto;
        missing.then_some(Warning::AngleMissing { g, theta_i, nearest })
    }

    /// The decision for the incident angle nearest to `theta_i`.
    fn decision_at(&self, theta_i: f64) -> Option<&Decision> {
        self.decisions.iter().min_by(|a, b| (a.theta_i - theta_i).abs().total_cmp(&(b.theta_i - theta_i).abs()))
    }

    /// Whether rays may be believed at 20, 60, 85 deg: Rayleigh parameter at least 9, or an exactly flat map.
    pub fn ray_valid(&self) -> [bool; 3] {
        self.rayleigh.map(|g| self.sq == 0.0 || g >= SMALLEST_FOR_RAYS)
    }

    /// Which calculation stands behind the gloss at 20, 60, 85 deg.
    pub fn holds(&self) -> [Holds; 3] {
        let ray_valid = self.ray_valid();
        [0, 1, 2].map(|k| match (self.wave[k], ray_valid[k]) {
            (false, true) => Holds::Rays,
            (false, false) => Holds::Neither,
            (true, _) => {
                let doubts = self.decision_at(ANGLES[k].to_radians()).map(check_waves);
                if doubts.unwrap_or_default().is_empty() { Holds::Waves } else { Holds::Neither }
            }
        })
    }

    /// Gloss by waves at 20 (k = 0), 60, 85 deg where they served \[GU\].
    pub fn wave_gloss(&self, k: usize) -> Option<Estimate> {
        self.wave[k].then_some(self.gloss[k])
    }

    /// How the incident angles were served, in a few words for people.
    pub fn method_summary(&self) -> String {
        if self.decisions.is_empty() {
            return "stored table".to_owned();
        }
        // Both hiding and waves grow towards grazing: the first angle says it all.
        let first = |served: fn(&Decision) -> bool| {
            let decision = self.decisions.iter().find(|d| served(d));
            decision.map(|d| (d.theta_i <= self.decisions[0].theta_i, d.theta_i.to_degrees()))
        };
        let rays = match first(|d| d.visibility) {
            None => "slope distribution".to_owned(),
            Some((true, _)) => "facet visibility".to_owned(),
            Some((false, degrees)) => format!("facet visibility from {degrees:.0} deg"),
        };
        match first(|d| d.wave) {
            None if rays == "slope distribution" => "slope distribution at all angles".to_owned(),
            None => rays,
            Some((true, _)) => "waves at all angles".to_owned(),
            Some((false, degrees)) => format!("{rays}, waves from {degrees:.0} deg"),
        }
    }
}
