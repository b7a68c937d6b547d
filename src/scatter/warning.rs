//! What a scatter run has to say against itself.

use super::detectors::Detectors;
use super::selection::Footprint;
use super::tally::Tally;
use crate::facets::{HeightField, SlopeStatistics, slopes};
use crate::heightmap::{Edges, HeightMap};
use crate::math::direction;
use std::fmt;

/// Slope from which a facet is a wall: 84.3 deg.
pub const WALL: f64 = 10.0;
/// Fewer beams than this are no statistics.
pub const FEWEST_BEAMS: u64 = 1000;

/// A full sentence with advice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// Hardly anything was counted.
    FewBeams {
        /// Incident polar angle \[rad\].
        theta_i: f64,
        beams: u64,
    },
    /// Energy went neither out nor into the material.
    Lost {
        /// Incident polar angle \[rad\].
        theta_i: f64,
        share: f64,
    },
    /// Most of what faces the source lies in shadow.
    MostlyShadowed {
        /// Incident polar angle \[rad\].
        theta_i: f64,
        /// Hidden share of the facing area.
        share: f64,
    },
    /// Light that comes in over the border of an open map was never shadowed.
    OpenBorder {
        /// Incident polar angle \[rad\].
        theta_i: f64,
        /// Length of the longest shadow \[m\] over the side of the map.
        reach: f64,
    },
    /// Detectors that do not resolve the lobe.
    WideDetectors {
        /// Incident polar angle \[rad\].
        theta_i: f64,
        /// Widths of the detector in the mirror direction, along theta and across \[rad\].
        width: [f64; 2],
        /// Standard deviations of the lobe there, likewise \[rad\].
        lobe: [f64; 2],
        /// Share that the mean over the detector lacks to the peak of a Gaussian lobe in the mirror direction.
        loss: f64,
    },
    /// Walls that no height map can hold.
    Walls {
        /// Facets steeper than [`WALL`].
        count: u64,
        /// Share of the facets.
        share: f64,
        /// Largest slope.
        steepest: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Warning::FewBeams { theta_i, beams } => write!(
                f,
                "At {} deg only {beams} beam{} met the surface: the numbers are single glints, not a distribution. \
                 Use a larger map or region, more --rays, or fewer and larger detectors.",
                degrees(theta_i),
                if beams == 1 { "" } else { "s" },
            ),
            Warning::Lost { theta_i, share } => write!(
                f,
                "At {} deg {:.2} % of the energy is lost: it fell through gaps, went down over the border or was still under \
                 way after the last bounce. Raise --bounces, close the gaps with --fill, or continue the map with --edges \
                 mirrored.",
                degrees(theta_i),
                100.0 * share,
            ),
            Warning::MostlyShadowed { theta_i, share } => write!(
                f,
                "At {} deg {:.0} % of the area that faces the source lies in the shadow of the rest: the result rests on the \
                 few peaks that stick out. Trust it only as far as another spot of the specimen agrees.",
                degrees(theta_i),
                100.0 * share,
            ),
            Warning::OpenBorder { theta_i, reach } => write!(
                f,
                "At {} deg shadows may be {:.0} % of the map long, and nothing beyond its border casts any: facets there are \
                 lit too freely. Continue the map with --edges mirrored, or light only its middle with --footprint \
                 0.15,0.15,0.85,0.85.",
                degrees(theta_i),
                100.0 * reach,
            ),
            Warning::WideDetectors { theta_i, width, lobe, loss } => write!(
                f,
                "At {} deg the detector in the mirror direction is {:.2} x {:.2} deg wide and the lobe, as one standard \
                 deviation, {:.2} x {:.2} deg: f_r there is about {:.0} % below the peak of the lobe. The energies hold; \
                 for the shape take more detectors or --detectors half-vector, for gloss `asperity gloss`.",
                degrees(theta_i),
                width[0].to_degrees(),
                width[1].to_degrees(),
                lobe[0].to_degrees(),
                lobe[1].to_degrees(),
                100.0 * loss,
            ),
            Warning::Walls { count, share, steepest } => write!(
                f,
                "{count} facets ({:.3} %) are steeper than {:.1} deg, with slopes up to {steepest:.1}: a height map cannot hold a \
                 vertical or overhanging wall, and such a facet lies wherever the points happened to fall. Cut these places \
                 out with --region, or take them for spikes with --despike 6.",
                100.0 * share,
                WALL.atan().to_degrees(),
            ),
        }
    }
}

/// What the sums of one incident direction betray.
pub fn of_tally(theta_i: f64, tally: &Tally, tolerance: f64) -> Vec<Warning> {
    let mut found = Vec::new();
    if tally.beams < FEWEST_BEAMS {
        found.push(Warning::FewBeams { theta_i, beams: tally.beams });
    }
    let lost = tally.book().lost;
    if lost > tolerance {
        found.push(Warning::Lost { theta_i, share: lost });
    }
    let hidden = hidden(tally);
    if hidden > 0.5 {
        found.push(Warning::MostlyShadowed { theta_i, share: hidden });
    }
    found
}

/// Hidden share of the area that faces the source.
fn hidden(tally: &Tally) -> f64 {
    tally.shadowed / (1.0 + tally.shadowed)
}

/// Whether an open border lets in light that a larger map would keep out: the strip as long as the longest shadow, times
/// the share of the area that is in shadow elsewhere, exceeds `tolerance`.
pub fn of_border(
    field: &HeightField,
    statistics: &SlopeStatistics,
    theta_i: f64,
    tally: &Tally,
    lit: Footprint,
    tolerance: f64,
) -> Option<Warning> {
    let map = field.map();
    if map.edges != Edges::Open || statistics.steepest * theta_i.tan() <= 1.0 {
        return None;
    }
    let [nx, ny] = field.cells();
    // The strip between the lit cells and the border casts its shadows.
    let spared = |[from, to]: [usize; 2], n: usize| from.min(n - to) as f64 / n as f64;
    let spared = spared(lit.columns, nx).min(spared(lit.rows, ny));
    let [lowest, highest] = field.height_range();
    let side = (nx as f64 * map.pitch_x).min(ny as f64 * map.pitch_y);
    let reach = (highest - lowest) * theta_i.tan() / side;
    let touched = (reach - spared).clamp(0.0, 1.0);
    (touched * hidden(tally) > tolerance).then_some(Warning::OpenBorder { theta_i, reach })
}

/// Whether the lit cells hold walls.
pub fn of_walls(map: &HeightMap, statistics: &SlopeStatistics, lit: Footprint) -> Option<Warning> {
    if statistics.steepest <= WALL {
        return None;
    }
    let (mut count, mut steepest2) = (0u64, 0.0f64);
    for row in lit.rows[0]..lit.rows[1] {
        slopes::visit_row(map, row, |facet| {
            let slope2 = facet.p * facet.p + facet.q * facet.q;
            if slope2 > WALL * WALL && lit.holds([facet.column, facet.row]) {
                count += 1;
                steepest2 = steepest2.max(slope2);
            }
        });
    }
    let share = count as f64 / statistics.facets as f64;
    (count > 0).then_some(Warning::Walls { count, share, steepest: steepest2.sqrt() })
}

/// Detectors wider than half a standard deviation of the lobe, at the angle where this tells most; an exactly flat surface has
/// no lobe.
///
/// A facet's slope turns the ray by twice as much along theta, across by `2 cos_theta` times.
pub fn of_detectors(detectors: &dyn Detectors, statistics: &SlopeStatistics, theta_i: &[f64]) -> Option<Warning> {
    let slope = (0.5 * (statistics.axes[0].powi(2) + statistics.axes[1].powi(2))).sqrt() * statistics.core;
    let worst = |theta: &f64| {
        let (wi, mirror) = (direction(*theta, 0.0), direction(*theta, std::f64::consts::PI));
        let b = detectors.bounds(detectors.index(wi, mirror));
        let width = [b.theta[1] - b.theta[0], (b.phi[1] - b.phi[0]) * theta.sin()];
        let lobe = [2.0 * slope, 2.0 * slope * theta.cos()];
        let ratio = width.iter().zip(lobe).map(|(w, l)| w / l).fold(0.0, f64::max);
        let across = [b.phi[0] - std::f64::consts::PI, b.phi[1] - std::f64::consts::PI].map(|a| a * theta.sin());
        let mean = mean_of_gaussian(b.theta.map(|t| t - theta), lobe[0]) * mean_of_gaussian(across, lobe[1]);
        (ratio, Warning::WideDetectors { theta_i: *theta, width, lobe, loss: 1.0 - mean })
    };
    let found = theta_i.iter().map(worst).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (slope > 0.0 && found.0 > WIDEST && detectors.slope_cells().is_none()).then_some(found.1)
}

/// Widest detector in standard deviations of the lobe: at half of one its mean is 1 % below the peak.
const WIDEST: f64 = 0.5;

/// Mean of `exp(-x^2 / (2 sigma^2))` from `low` to `high`.
fn mean_of_gaussian([low, high]: [f64; 2], sigma: f64) -> f64 {
    let scale = std::f64::consts::SQRT_2 * sigma;
    let mean = 0.5 * std::f64::consts::PI.sqrt() * scale * (libm::erf(high / scale) - libm::erf(low / scale));
    if high - low > 1e-6 * sigma { mean / (high - low) } else { (-(low / scale).powi(2)).exp() }
}

/// An angle \[rad\] in degrees with as many digits as it needs.
fn degrees(theta: f64) -> String {
    let text = format!("{:.2}", theta.to_degrees());
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

impl serde::Serialize for Warning {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_carry_numbers_and_advice() {
        let t = 60f64.to_radians();
        for (warning, parts) in [
            (Warning::FewBeams { theta_i: t, beams: 1 }, ["At 60 deg", "1 beam met", "larger map"]),
            (Warning::Lost { theta_i: 0.0, share: 0.25 }, ["At 0 deg", "25.00 %", "--edges mirrored"]),
            (Warning::MostlyShadowed { theta_i: t, share: 0.81 }, ["81 %", "peaks", "another spot"]),
            (Warning::OpenBorder { theta_i: 89.9f64.to_radians(), reach: 0.3 }, ["89.9 deg", "30 %", "--footprint"]),
            (Warning::Walls { count: 12, share: 0.5, steepest: 1e3 }, ["12 facets (50.000 %)", "84.3 deg", "--region"]),
        ] {
            let text = warning.to_string();
            assert!(parts.iter().all(|p| text.contains(p)) && text.ends_with('.'), "{text}");
        }
    }
}
