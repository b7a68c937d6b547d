//! Where the light of one incident direction goes: shares of the energy in the 145 patches of Klems.

use crate::bench::method::{Distance, Family, Method, Reference, half_decades};
use crate::bench::patches::shares;
use crate::bench::surface::{GLASS, Surface, WAVELENGTH};
use crate::facets::distribution::Hiding;
use crate::facets::slopes;
use crate::math::direction;
use crate::math::random::CounterRng;
use crate::scatter::beam::Beam;
use crate::scatter::cells::TOLERANCE;
use crate::scatter::detectors::{Detectors, Rings};
use crate::scatter::facet_sum::{Azimuth, facet_sum};
use crate::scatter::facing::facing;
use crate::scatter::rays::trace_rays;
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::spread::spread;
use crate::scatter::{Accumulator, HalfVectorCells, Method as How, Options, Selection, Symmetry, Tally, Wave, scatter};
use glam::DVec3;
use rayon::prelude::*;

/// Incident angles \[deg\] that are asked: one where next to nothing is hidden, one where much is.
pub const ANGLES: [f64; 2] = [45.0, 75.0];

/// Rays per task.
const BATCH: u64 = 1 << 14;

/// The seed of the reference is none that a repeat uses.
const REFERENCE_SEED: u64 = 0x5eed_0000;

/// The family at an incident angle \[deg\]; its reference is `reference_rays` traced rays, bounces and all.
pub fn family<'a>(surface: &'a Surface<'a>, theta_deg: f64, reference_rays: u64) -> Family<'a> {
    let theta_i = theta_deg.to_radians();
    let wi = direction(theta_i, 0.0);
    let by_rays = move |rays: u64, seed: u64| {
        let selection = Selection::default();
        trace_rays(&surface.walk(), &Rings::klems(), theta_i, Azimuth::Fixed(0.0), rays, seed, &selection).tally()
    };
    // Two halves of other seeds: half their distance is the error of their mean.
    let halves = [0, 1].map(|k| shares(&by_rays(reference_rays / 2, REFERENCE_SEED + k)));
    let noise = 0.5 * Distance::Moved.between(&halves[0], &halves[1]);
    let reference: Vec<f64> = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let taken = taken(surface, theta_i);
    let facets = surface.statistics.facets as f64;
    let by_density = move |tolerance: f64, hiding: &Hiding| {
        let cells = HalfVectorCells::for_lobe(&surface.statistics, false, tolerance);
        let density = SlopeDensity::measure(surface.map, &cells, false);
        in_patches(&density.tally(&cells, wi, &GLASS, hiding), &cells, wi)
    };
    let tolerances = [0.04, 0.01, 0.0025, 0.000_625];
    let mut family = Family {
        id: format!("scatter_{theta_deg:.0}"),
        title: format!("Scattering at {theta_deg:.0}\u{b0}"),
        error: "reflected light in the wrong place",
        distance: Distance::Moved,
        reference: Reference {
            text: format!(
                "145 Klems patches against {:.1} million traced rays of other seeds; without the time of the block pyramid",
                reference_rays as f64 / 1e6
            ),
            values: reference,
            noise,
        },
        methods: vec![
            Method::new(RAYS, "rays", half_decades(3, 8), move |rays, seed| {
                shares(&random_rays(surface, wi, rays as u64, seed).tally()).into()
            })
            .random()
            .hungry(6.0),
            Method::new("naive rays, even patches", "rays", half_decades(3, 8), move |rays, seed| {
                shares(&by_rays(rays as u64, seed)).into()
            })
            .random()
            .hungry(6.0),
            Method::new(FACETS, "facets", fractions(facets), move |asked, _| {
                let selection = Selection::share(asked / facets);
                let sum = facet_sum(&surface.walk(), &Rings::klems(), theta_i, Azimuth::Fixed(0.0), &selection);
                shares(&sum.tally()).into()
            }),
            Method::new("facet sum, nothing hidden", "facets", fractions(facets), move |asked, _| {
                lit_facets(surface, wi, asked / facets).into()
            }),
            Method::new(SLOPES, "cell tolerance", tolerances, move |tolerance, _| {
                by_density(tolerance, &surface.statistics.hiding()).into()
            }),
            Method::new("slopes, nothing hidden", "cell tolerance", tolerances, move |tolerance, _| {
                by_density(tolerance, &Hiding::tabulate(|_| 0.0)).into()
            }),
            Method::new(WAVES, "cell tolerance", tolerances, move |tolerance, _| {
                by_waves(surface, theta_i, tolerance).into()
            }),
        ],
    };
    for method in &mut family.methods {
        if method.name == taken {
            method.default = Some(if taken == FACETS { ASKED.min(facets) } else { TOLERANCE });
        }
    }
    family
}

/// The plain estimator, which others are compared with at equal time.
pub const RAYS: &str = "naive rays, random places";

/// The three ways that `auto` may take.
pub const FACETS: &str = "facet sum, visibility";
const SLOPES: &str = "slope distribution, Smith";
const WAVES: &str = "Kirchhoff (wave)";

/// Facets that `auto` asks per incident angle, and its tolerance.
const ASKED: f64 = (1u32 << 19) as f64;

/// Which of them it takes here.
fn taken(surface: &Surface, theta_i: f64) -> &'static str {
    let options = Options { material: GLASS, theta_i: vec![theta_i], phi_i: vec![0.0], ..Options::default() };
    let found = scatter(surface.map, &options, &|_| ());
    match found.ok().and_then(|s| s.decisions.first().copied()) {
        Some(d) if d.wave => WAVES,
        Some(d) if d.visibility => FACETS,
        _ => SLOPES,
    }
}

/// An eighth to all of the facets, and less.
fn fractions(facets: f64) -> Vec<f64> {
    [1024.0, 256.0, 64.0, 16.0, 4.0, 1.0].map(|part| (facets / part).round()).to_vec()
}

/// Energy of half-vector cells sent on to the patches.
fn in_patches(tally: &Tally, cells: &HalfVectorCells, wi: DVec3) -> Vec<f64> {
    let mut out = spread(&tally.energy, tally.core, cells, &Rings::klems(), wi, &GLASS);
    out.iter_mut().for_each(|e| *e /= tally.incident.max(f64::MIN_POSITIVE));
    out
}

/// Rays to independent random places: the plain estimator, whose error falls as one over the root of their number.
fn random_rays(surface: &Surface, wi: DVec3, rays: u64, seed: u64) -> Accumulator {
    let (walk, patches) = (surface.walk(), Rings::klems());
    let beam = Beam::new(&surface.field, wi, None);
    let batches: Vec<Accumulator> = (0..rays.div_ceil(BATCH))
        .into_par_iter()
        .map(|batch| {
            let mut sum = Accumulator::new(patches.len());
            for ray in batch * BATCH..((batch + 1) * BATCH).min(rays) {
                let [x, y, ..] = CounterRng::four(seed, 9, ray);
                let Some(arrival) = beam.strike([x, y]) else { continue };
                let end = walk.follow(arrival);
                match end.escaped {
                    Some((wo, energy)) => sum.escaped(patches.index(wi, wo), end.bounces, 1.0, energy),
                    None => sum.lost(1.0, end.lost),
                }
            }
            sum
        })
        .collect();
    batches.into_iter().fold(Accumulator::new(patches.len()), Accumulator::merged)
}

/// Every facet lit and none in the way of another: single reflections of a share of the rows.
fn lit_facets(surface: &Surface, wi: DVec3, share: f64) -> Vec<f64> {
    let patches = Rings::klems();
    let (_, rows) = slopes::cells(surface.map);
    // Fewer rows than wanted would be none.
    let every = (1.0 / share).round().clamp(1.0, rows as f64) as usize;
    let sums: Vec<(Vec<f64>, f64)> = (0..rows)
        .into_par_iter()
        .step_by(every)
        .map(|row| {
            let (mut energy, mut incident) = (vec![0.0; patches.len()], 0.0);
            slopes::visit_row(surface.map, row, |facet| {
                if let Some(f) = facing(facet.p, facet.q, wi) {
                    incident += f.weight;
                    if f.wo.z > 0.0 {
                        energy[patches.index(wi, f.wo)] += f.weight * GLASS.reflectance(f.cos_beta);
                    }
                }
            });
            (energy, incident)
        })
        .collect();
    let incident: f64 = sums.iter().map(|s| s.1).sum();
    (0..patches.len()).map(|k| sums.iter().map(|s| s.0[k]).sum::<f64>() / incident).collect()
}

/// The phase integral of the map at one incident angle.
fn by_waves(surface: &Surface, theta_i: f64, tolerance: f64) -> Vec<f64> {
    let options = Options {
        method: How::Kirchhoff,
        symmetry: Symmetry::Anisotropic,
        material: GLASS,
        wave: Wave { wavelength: WAVELENGTH, ..Wave::default() },
        theta_i: vec![theta_i],
        phi_i: vec![0.0],
        tolerance,
        ..Options::default()
    };
    // A map that has facets and options within their ranges: nothing can be refused.
    match scatter(surface.map, &options, &|_| ()) {
        Ok(found) => in_patches(&found.tallies[0][0], &found.cells, direction(theta_i, 0.0)),
        Err(_) => vec![f64::NAN; Rings::klems().len()],
    }
}
