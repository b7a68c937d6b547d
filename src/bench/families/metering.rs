//! Gloss of a known lobe at 20, 60 and 85 deg by three integrators.

use crate::bench::method::{Answer, Distance, Family, Method, Reference, half_decades};
use crate::error::Result;
use crate::math::random::CounterRng;
use crate::meter::stop::Stop;
use crate::meter::{Instrument, Options, standards};
use crate::model;
use crate::optics::Brdf;

/// Rough black glass of alpha 0.02, index 1.567 at the wavelength where it has that index.
const LOBE: &str = "beckmann:alpha=0.02,n=1.567";

/// Its gloss \[GU\]: quasi-Monte Carlo over source, receptor and half vector in another program (scipy), within 0.002 GU.
const GLOSS: [f64; 3] = [29.8026, 82.1901, 77.6384];
const GLOSS_ERROR: f64 = 0.002;

/// The three gloss meters.
fn meters() -> Vec<Instrument> {
    ["gloss-20", "gloss-60", "gloss-85"].iter().filter_map(|name| standards::by_name(name)).collect()
}

/// Pairs of random points, one of the source stop and one of the receptor, with no thought of the lobe.
fn random_pairs(brdf: &dyn Brdf, meter: &Instrument, pairs: f64, seed: u64) -> f64 {
    let point = |stop: &Stop, u: [f64; 2]| {
        let [a, b] = stop.half();
        let [x, y] = [a * (2.0 * u[0] - 1.0), b * (2.0 * u[1] - 1.0)];
        let w = stop.direction([x, y]);
        // Solid angle per area of the tangent plane, times the area.
        (w, 4.0 * a * b * w.dot(stop.axes()[0]).powi(3))
    };
    let name = meter.readings()[0].to_owned();
    let path = &meter.paths(&name, 0.0)[0];
    let flux = |k: u64| {
        let u = CounterRng::four(seed, 13, k);
        let (wi, di) = point(path.source(), [u[0], u[1]]);
        let (wo, d_o) = point(path.receptor(), [u[2], u[3]]);
        if wi.z > 0.0 && wo.z > 0.0 { brdf.eval(wi, wo) * wi.z * wo.z * di * d_o } else { 0.0 }
    };
    meter.units_per_flux(&name) / pairs * (0..pairs as u64).map(flux).sum::<f64>()
}

/// Half vectors, subdivision and random pairs, one thread.
///
/// # Errors
/// Never in practice: the lobe is ours.
pub fn family<'a>() -> Result<Family<'a>> {
    let lobe = || model::parse(LOBE, 587.6e-9);
    let (a, b, c) = (lobe()?, lobe()?, lobe()?);
    let read = |brdf: &dyn Brdf, tolerance: f64, seed: u64, divide: bool| -> Answer {
        let options = Options { tolerance, points: 32, max_points: 65536, seed: seed as u32, ..Options::default() };
        let one = |m: &Instrument| {
            let readings = if divide { m.subdivide(brdf, &options) } else { m.measure(brdf, &options) };
            readings.ok().and_then(|r| r.first().map(|r| r.estimate.value)).unwrap_or(f64::NAN)
        };
        meters().iter().map(one).collect::<Vec<_>>().into()
    };
    let tolerances = [1.0, 0.3, 0.1, 0.05, 0.025, 0.01, 0.003];
    Ok(Family {
        id: "meter".into(),
        title: "Gloss at 20\u{b0}, 60\u{b0} and 85\u{b0}".into(),
        error: "largest error / GU",
        distance: Distance::Gloss,
        reference: Reference {
            text: format!(
                "Beckmann lobe of alpha 0.02, n = 1.567, against independent quadrature good to {GLOSS_ERROR} GU; one thread"
            ),
            values: GLOSS.to_vec(),
            noise: GLOSS_ERROR,
        },
        methods: vec![
            Method::new("half vectors, Sobol", "tolerance GU", tolerances, move |t, seed| read(&*a, t, seed, false))
                .random()
                .taken_at(0.025),
            Method::new("adaptive subdivision", "tolerance GU", tolerances, move |t, seed| read(&*b, t, seed, true)),
            Method::new("random pairs", "pairs", half_decades(3, 8), move |n, seed| {
                meters().iter().map(|m| random_pairs(&*c, m, n, seed)).collect::<Vec<_>>().into()
            })
            .random(),
        ],
    })
}
