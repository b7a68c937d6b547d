//! Gloss of facets that hide one another: where Smith's function is not enough, facets ask for source and receptor themselves.
//!
//! `G = G_Smith <K V> / <K V_Smith> + 100 / Phi(standard) <later>`
//!
//! with `K` the light that a facet throws through the stops ([`super::facets`]), V whether it sees both, and the light that
//! reaches the receptor after further bounces. Means over evenly chosen facets, each with a source direction of its own; the
//! ratio is near 1 and shares its facets, so that few of them know it well.

use super::facets::{Azimuths, FacetGloss, Slopes, with_slopes};
use super::geometry::Geometry;
use super::overlap::overlap;
use super::path::Path;
use crate::error::Result;
use crate::facets::distribution::{Hiding, hidden_excess};
use crate::facets::slopes::{self, Facet};
use crate::facets::visibility::Fate;
use crate::facets::{HeightField, SlopeStatistics};
use crate::heightmap::HeightMap;
use crate::math::frame::normal_of_slope;
use crate::math::random::CounterRng;
use crate::math::{Estimate, reflect};
use crate::scatter::bounce::{Arrival, Walk};
use crate::scatter::facet_sum::turned_back;
use crate::scatter::{Footprint, Options};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Facets that are asked: the ratio of an isotropic map at 85 deg is then known to 0.3 %.
const ASKED: f64 = 400_000.0;

/// Sub-areas along each axis, for the error.
const ACROSS: usize = 4;

/// Fractional parts of the golden ratio and of the plastic number: azimuths and choices evenly spread and unrelated.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: f64 = 0.754_877_666_246_692_7;

/// Azimuths of a facet where the light that bounces again is predicted.
const AZIMUTHS: u32 = 32;

/// Gloss by rays: [`super::facet_gloss`] where Smith's function predicts that no more than a tenth of the tolerance bounces again,
/// the share that the choice of the method leaves to it; beyond, with every asked facet's own sight of source and receptor, and
/// with the light that comes to the receptor after further bounces.
///
/// Material, tolerance, bounces, footprint and seed are those of `options`.
///
/// # Errors
/// As [`super::facet_gloss`].
pub fn traced_gloss(
    map: &HeightMap,
    geometries: &[Geometry],
    azimuths: &Azimuths,
    options: &Options,
) -> Result<FacetGloss> {
    let part = options.footprint.map(|footprint| footprint.cut(map));
    let (mut result, slopes) = with_slopes(part.as_ref().unwrap_or(map), &options.material, geometries, azimuths)?;
    let paths: Vec<Path> = geometries.iter().map(|g| g.path(0.0)).collect();
    let steepest = 1.05 * slopes.gradients.last().map_or(0.0, |g| g.0);
    if paths.iter().all(|path| nothing_blocks(path.centre(), steepest)) {
        return Ok(result);
    }
    let Slopes { gradients, hiding } = slopes;
    let hiding = hiding.unwrap_or_else(|| Hiding::tabulate(|theta| hidden_excess(gradients.iter().copied(), theta)));
    let asked: Vec<usize> = (0..paths.len())
        .filter(|&k| !nothing_blocks(paths[k].centre(), steepest))
        .filter(|&k| blocked(&gradients, &hiding, paths[k].centre()) > 0.1 * options.tolerance)
        .collect();
    if asked.is_empty() {
        return Ok(result);
    }
    let field = HeightField::new(map);
    let (material, max_bounces) = (options.material, options.bounces);
    let walk = Walk { field: &field, material, max_bounces, steepest: SlopeStatistics::measure(map)?.steepest };
    let lit = options.footprint.unwrap_or(Footprint::whole(field.cells()));
    for k in asked {
        let stops = Stops { walk: &walk, path: &paths[k], azimuths, hiding: &hiding, seed: options.seed };
        result.gloss[k] = stops.corrected(result.gloss[k], lit, geometries[k].units_per_flux());
    }
    Ok(result)
}

/// Whether a beam from `wi` climbs, off the steepest facet that leans away, faster than any facet.
fn nothing_blocks(wi: DVec3, steepest: f64) -> bool {
    let elevation = wi.z.clamp(-1.0, 1.0).asin() - 2.0 * steepest.atan();
    elevation > 0.0 && elevation.tan() >= steepest
}

/// Share of the light of a mirror that Smith's function predicts to bounce again: hidden from its exit or sent below the horizon.
fn blocked(gradients: &[(f64, f64)], hiding: &Hiding, wi: DVec3) -> f64 {
    let (mut lit, mut seen) = (0.0, 0.0);
    for &(gradient, share) in gradients {
        for k in 0..AZIMUTHS {
            let (s, c) = (TAU * (f64::from(k) + 0.5) / f64::from(AZIMUTHS)).sin_cos();
            let n = normal_of_slope(gradient * c, gradient * s);
            let (weight, wo) = (share * (wi.dot(n) / n.z).max(0.0), reflect(wi, n));
            lit += weight / (1.0 + hiding.lambda(wi.z));
            if wo.z > 0.0 {
                seen += weight * hiding.visible(wi.z, wo.z);
            }
        }
    }
    1.0 - seen / lit.max(f64::MIN_POSITIVE)
}

/// Source and receptor over a map.
struct Stops<'a> {
    walk: &'a Walk<'a>,
    /// At azimuth 0: facets are turned instead.
    path: &'a Path,
    azimuths: &'a Azimuths,
    hiding: &'a Hiding,
    seed: u64,
}

/// Sums over the facets of a sub-area.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    facets: f64,
    /// Light of single reflections: of facets that see both stops, and as Smith's function has it.
    seen: f64,
    smith: f64,
    /// Light after further bounces.
    later: f64,
}

impl Sums {
    fn merged(self, other: Sums) -> Sums {
        Sums {
            facets: self.facets + other.facets,
            seen: self.seen + other.seen,
            smith: self.smith + other.smith,
            later: self.later + other.later,
        }
    }

    fn gloss(&self, smith: f64, units_per_flux: f64) -> f64 {
        let ratio = if self.smith > 0.0 { self.seen / self.smith } else { 1.0 };
        smith * ratio + units_per_flux * self.later / self.facets.max(1.0)
    }
}

impl Stops<'_> {
    /// The gloss by Smith's function with what the facets say; the errors of both.
    fn corrected(&self, smith: Estimate, lit: Footprint, units_per_flux: f64) -> Estimate {
        let pieces: Vec<Sums> = (0..ACROSS * ACROSS)
            .into_par_iter()
            .map(|k| self.sums(lit.piece(k % ACROSS, k / ACROSS, ACROSS), lit))
            .collect();
        let all = pieces.iter().copied().fold(Sums::default(), Sums::merged);
        let value = all.gloss(smith.value, units_per_flux);
        let filled = pieces.iter().filter(|s| s.smith > 0.0);
        let parts: Vec<f64> = filled.map(|s| s.gloss(smith.value, units_per_flux)).collect();
        let own = if parts.len() > 1 { Estimate::from_repeats(&parts).standard_error } else { 0.0 };
        let scaled = if smith.value > 0.0 { smith.standard_error * value / smith.value } else { 0.0 };
        Estimate { value, standard_error: scaled.hypot(own) }
    }

    fn sums(&self, piece: Footprint, lit: Footprint) -> Sums {
        let map = self.walk.field.map();
        let all = 2 * (lit.columns[1] - lit.columns[0]) * (lit.rows[1] - lit.rows[0]);
        let share = (ASKED / all as f64).min(1.0);
        let width = self.walk.field.cells()[0];
        let mut sums = Sums::default();
        for row in piece.rows[0]..piece.rows[1] {
            slopes::visit_row(map, row, |facet| {
                let id = 2 * (row * width + facet.column) + usize::from(facet.upper);
                let inside = (piece.columns[0]..piece.columns[1]).contains(&facet.column);
                if inside && (id as f64 * PLASTIC).fract() < share {
                    self.ask(&facet, id as u64, &mut sums);
                }
            });
        }
        sums
    }

    /// Adds what one facet throws into the receptor.
    fn ask(&self, facet: &Facet, id: u64, sums: &mut Sums) {
        let phi = match self.azimuths {
            Azimuths::All => TAU * (id as f64 * GOLDEN).fract(),
            Azimuths::At(list) => list[(list.len() as f64 * (id as f64 * GOLDEN).fract()) as usize],
        };
        let [source, receptor] = [self.path.source(), self.path.receptor()];
        let n = turned_back(normal_of_slope(facet.p, facet.q), phi);
        let [u, v, x, y] = CounterRng::four(self.seed, 85, id);
        sums.facets += 1.0;

        let outline = overlap(source, receptor.edges(), n);
        let area = outline.area();
        if area > 0.0 {
            let wi = source.direction(outline.point([u, v]));
            let (wo, cos_beta) = (reflect(wi, n), wi.dot(n));
            if wi.z > 0.0 && wo.z > 0.0 && cos_beta > 0.0 {
                let light = self.walk.material.reflectance(cos_beta) * self.weight(wi, n, area);
                sums.smith += light * self.hiding.visible(wi.z, wo.z);
                let arrival = self.arrival(facet, turned_back(wi, -phi));
                if self.is_free(&arrival, arrival.back) && self.is_free(&arrival, turned_back(wo, -phi)) {
                    sums.seen += light;
                }
            }
        }

        let whole = overlap(source, &[], n);
        let wi = source.direction(whole.point([x, y]));
        if wi.z <= 0.0 || wi.dot(n) <= 0.0 {
            return;
        }
        let arrival = self.arrival(facet, turned_back(wi, -phi));
        if self.is_free(&arrival, turned_back(reflect(wi, n), -phi)) || !self.is_free(&arrival, arrival.back) {
            return;
        }
        if let Some((wo, energy)) = self.walk.follow(arrival).escaped
            && receptor.contains(turned_back(wo, phi))
        {
            sums.later += energy * self.weight(wi, n, whole.area());
        }
    }

    /// Light that falls on a facet from an area of the tangent plane of the source, per unit of plan area \[sr\].
    fn weight(&self, wi: DVec3, n: DVec3, area: f64) -> f64 {
        wi.dot(n) / n.z * area * wi.dot(self.path.centre()).powi(3)
    }

    /// A beam from `wi` at the middle of a facet.
    fn arrival(&self, facet: &Facet, wi: DVec3) -> Arrival {
        let Facet { column, row, upper, p, q } = *facet;
        let [a, b, c, d] = self.walk.field.corners(column, row).map(f64::from);
        let ([u, v], z) = match upper {
            true => ([2.0, 1.0], a + b + d),
            false => ([1.0, 2.0], a + c + d),
        };
        Arrival {
            point: [column as f64 + u / 3.0, row as f64 + v / 3.0, z / 3.0],
            facet: ([column, row], upper),
            slope: (p, q),
            back: wi,
            flip: [1.0; 2],
        }
    }

    fn is_free(&self, arrival: &Arrival, w: DVec3) -> bool {
        w.z > 0.0 && matches!(self.walk.onward(arrival, w), Fate::Escaped(_))
    }
}
