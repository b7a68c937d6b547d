//! The deterministic facet sum: every facet is a beam.

use super::accumulator::Accumulator;
use super::bounce::{Arrival, Walk};
use super::detectors::Detectors;
use super::facing::facing;
use super::selection::Selection;
use super::tally::CORE_SLOPE;
use crate::facets::slopes::{self, Facet};
use crate::facets::visibility::Fate;
use crate::math::direction;
use glam::DVec3;
use rayon::prelude::*;

/// Fractional part of the golden ratio: its multiples fill a circle as evenly as any number of points can.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Fractional part of the plastic number: chooses facets evenly and unrelated to their azimuth.
const PLASTIC: f64 = 0.754_877_666_246_692_7;

/// Rows per task.
const ROWS: usize = 16;

/// The azimuth of the source: one, or all of them averaged by giving every facet its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Azimuth {
    /// `phi_i` \[rad\].
    Fixed(f64),
    /// Isotropic average; cells then lie in the frame of the source (`phi_i = 0`).
    Averaged,
}

impl Azimuth {
    /// Azimuth for item `k` when averaging, and the turn into the frame of the cells.
    #[inline]
    pub fn of(self, u: f64) -> (f64, f64) {
        match self {
            Azimuth::Fixed(phi) => (phi, 0.0),
            Azimuth::Averaged => (std::f64::consts::TAU * u, std::f64::consts::TAU * u),
        }
    }
}

/// `v` turned by `-angle` about z.
#[inline]
pub fn turned_back(v: DVec3, angle: f64) -> DVec3 {
    if angle == 0.0 {
        return v;
    }
    let (s, c) = angle.sin_cos();
    DVec3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z)
}

/// `E_k = sum over facets of w V R(beta) [o in k] / sum w V`, with `w = max(0, 1 - tan(theta_i) (p cos phi_i + q sin phi_i))`
/// and V = 1 where a short march from the facet's centroid reaches the source; a blocked exit goes on as a ray.
///
/// `selection` says which facets are lit. Deterministic: same map, same sums, for any number of threads or parts.
pub fn facet_sum<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    selection: &Selection,
) -> Accumulator {
    let map = walk.field.map();
    let lit = selection.lit(walk.field.cells());
    let blocks = lit.rows[0] / ROWS..lit.rows[1].div_ceil(ROWS);
    blocks
        .into_par_iter()
        .filter(|&block| selection.part.has(block as u64))
        .fold(
            || Accumulator::new(detectors.len()),
            |mut sum, block| {
                for row in (block * ROWS).max(lit.rows[0])..((block + 1) * ROWS).min(lit.rows[1]) {
                    slopes::visit_row(map, row, |facet| {
                        let id = (facet.row * walk.field.cells()[0] + facet.column) * 2 + usize::from(facet.upper);
                        let inside = (lit.columns[0]..lit.columns[1]).contains(&facet.column);
                        if inside && (id as f64 * PLASTIC).fract() < selection.share {
                            add_facet(walk, detectors, theta_i, azimuth, id, facet, &mut sum);
                        }
                    });
                }
                sum
            },
        )
        .reduce(|| Accumulator::new(detectors.len()), Accumulator::merged)
}

fn add_facet<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    id: usize,
    facet: Facet,
    sum: &mut Accumulator,
) {
    let (phi, turn) = azimuth.of((id as f64 * GOLDEN).fract());
    let wi = direction(theta_i, phi);
    // `None` for the specular core and for detectors that do not go by slope.
    let own_cell = detectors.slope_cells().and_then(|cells| {
        let flat = facet.p.abs().max(facet.q.abs()) < CORE_SLOPE;
        let slope = turned_back(DVec3::new(facet.p, facet.q, 0.0), turn);
        (!flat).then(|| cells.locate(slope.x, slope.y))
    });
    if let Some(cell) = own_cell {
        sum.asked(cell);
    }
    let Some(beam) = facing(facet.p, facet.q, wi) else { return };
    let (u, v) = if facet.upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
    let (column, row) = (facet.column as f64 + u, facet.row as f64 + v);
    let arrival = Arrival {
        point: [column, row, centroid_height(walk, &facet)],
        facet: ([facet.column, facet.row], facet.upper),
        slope: (facet.p, facet.q),
        back: wi,
        flip: [1.0, 1.0],
    };
    if let Fate::Hit(_) = walk.onward(&arrival, wi) {
        sum.shadowed(beam.weight);
        return;
    }
    let end = walk.follow(arrival);
    let Some((wo, energy)) = end.escaped else {
        sum.lost(beam.weight, end.lost);
        return;
    };
    match own_cell {
        Some(cell) if end.bounces == 1 => sum.escaped(cell, 1, beam.weight, energy),
        None if end.bounces == 1 && detectors.slope_cells().is_some() => sum.core(beam.weight, energy),
        _ => {
            let detector = detectors.index(direction(theta_i, phi - turn), turned_back(wo, turn));
            sum.escaped(detector, end.bounces, beam.weight, energy);
        }
    }
}

fn centroid_height(walk: &Walk, facet: &Facet) -> f64 {
    let map = walk.field.map();
    let (c, r) = (facet.column, facet.row);
    let (c1, r1) = ((c + 1) % map.width(), (r + 1) % map.height());
    let third = if facet.upper { map.heights[[r, c1]] } else { map.heights[[r1, c]] };
    (f64::from(map.heights[[r, c]]) + f64::from(map.heights[[r1, c1]]) + f64::from(third)) / 3.0
}
