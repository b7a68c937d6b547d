//! What a map has to say against itself.

use std::fmt;

/// Along the rows or along the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapAxis {
    X,
    Y,
}

impl fmt::Display for MapAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MapAxis::X => "x",
            MapAxis::Y => "y",
        })
    }
}

/// A reason to distrust slopes, and with them gloss and BRDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// Finer sampling would find steeper slopes.
    Unresolved {
        axis: MapAxis,
        /// Pitch \[m\].
        distance: f64,
        /// `s(d) / s(2d) - 1`.
        change: f64,
    },
    /// Neighbours differ by what looks like noise of the instrument.
    Noise {
        axis: MapAxis,
        /// Pitch \[m\].
        distance: f64,
        /// Share of the squared slope.
        share: f64,
        /// Standard deviation of the height noise \[m\].
        sigma: f64,
    },
    /// The slope grows as a power of the sampling distance, as far as it can be seen.
    NoRmsSlope {
        axis: MapAxis,
        /// `s(d)` goes as `d^-exponent`.
        exponent: f64,
        /// Finest and coarsest distance at which it does \[m\].
        range: [f64; 2],
    },
    /// The heights come in steps.
    QuantisedHeights {
        /// Step \[m\].
        step: f64,
        /// Distinct height differences of neighbours.
        distinct: usize,
        /// Between neighbouring glints \[rad\].
        glint_spacing: f64,
    },
    /// Single points stand out and carry much of the slope.
    Spikes {
        count: u64,
        /// The farthest from its neighbours \[m\].
        largest: f64,
        /// Share of the squared slope.
        slope_share: f64,
    },
    /// Many points are missing.
    MissingPoints {
        /// Share of the points.
        fraction: f64,
    },
    /// The map is too small for the texture on it.
    FewPatches {
        /// Independent patches, about.
        patches: f64,
        /// Autocorrelation length \[m\].
        sal: f64,
    },
    /// The lay, or form, runs out of the map.
    LayLongerThanMap {
        /// Upper bound of Str.
        str_bound: f64,
    },
    /// The heights are alike over the whole map.
    FormLeft,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Warning::Unresolved { axis, distance, change } => write!(
                f,
                "Slopes along {axis} are not resolved: the rms slope at the pitch ({}) is {:.0} % above that at twice \
                 the pitch, and finer sampling would find it steeper still. Gloss comes out too high: measure with a \
                 pitch of a quarter of the autocorrelation length or less, or take the result as an upper bound.",
                length(distance),
                100.0 * change,
            ),
            Warning::Noise { axis, distance, share, sigma } => write!(
                f,
                "About {:.0} % of the squared slope along {axis} looks like noise from point to point (height noise of \
                 about {} at a pitch of {}). Gloss comes out too low: average repeated measurements, subtract the noise \
                 known from repeats, or low-pass the map at the optical resolution of the instrument.",
                100.0 * share,
                length(sigma),
                length(distance),
            ),
            Warning::NoRmsSlope { axis, exponent, range } => write!(
                f,
                "This surface has no rms slope along {axis}: from {} to {} the slope grows as distance to the power \
                 -{exponent:.2}, so gloss and BRDF depend on the pitch. State the bandwidth with every result, and \
                 low-pass the map where the light does not resolve it (about one wavelength).",
                length(range[0]),
                length(range[1]),
            ),
            Warning::QuantisedHeights { step, distinct, glint_spacing } => write!(
                f,
                "The heights come in steps of {}: neighbours differ by one of only {distinct} values, and the BRDF \
                 splits into glints {:.2} deg apart. Export the map with more digits, or low-pass it.",
                length(step),
                glint_spacing.to_degrees(),
            ),
            Warning::Spikes { count, largest, slope_share } => write!(
                f,
                "{count} single point{} stand{} more than six standard deviations off the neighbours (up to {}) and \
                 carr{} {:.0} % of the squared slope. If they are not real, take them out before scattering (--despike 6): \
                 gloss at 85 deg suffers most.",
                if count == 1 { "" } else { "s" },
                if count == 1 { "s" } else { "" },
                length(largest),
                if count == 1 { "ies" } else { "y" },
                100.0 * slope_share,
            ),
            Warning::MissingPoints { fraction } => write!(
                f,
                "{:.1} % of the points are missing. Instruments lose steep facets first, so slopes and the tails of the \
                 lobe come out too low: measure with a larger aperture, or use a region without gaps.",
                100.0 * fraction,
            ),
            Warning::FewPatches { patches, sal } => write!(
                f,
                "The map holds only about {patches:.0} independent patches (autocorrelation length Sal {}): its numbers \
                 differ from those of the next spot. Measure a larger field, or several, or filter out the waviness.",
                length(sal),
            ),
            Warning::LayLongerThanMap { str_bound } => write!(
                f,
                "In some direction the autocorrelation stays above 0.2 as far as the map reaches: Str is at most \
                 {str_bound:.3}. Measure a longer field if Str itself matters.",
            ),
            Warning::FormLeft => f.write_str(
                "The autocorrelation stays above 0.2 in every direction as far as the map reaches, so Sal and Str cannot \
                 be given: what is left is form, not texture. Remove a polynomial or a sphere, or apply an L-filter.",
            ),
        }
    }
}

/// A length with three digits and the unit that suits it.
fn length(metres: f64) -> String {
    let (unit, name) = match metres.abs() {
        m if m >= 1e-3 => (1e-3, "mm"),
        m if m >= 1e-6 => (1e-6, "um"),
        m if m >= 1e-9 => (1e-9, "nm"),
        _ => (1e-12, "pm"),
    };
    let value = metres / unit;
    let decimals = if value.abs() >= 99.95 {
        0
    } else if value.abs() >= 9.995 {
        1
    } else {
        2
    };
    format!("{value:.decimals$} {name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_carry_numbers_and_advice() {
        for (warning, parts) in [
            (Warning::Unresolved { axis: MapAxis::X, distance: 5e-7, change: 0.183 }, ["18 %", "500 nm", "quarter"]),
            (
                Warning::Noise { axis: MapAxis::Y, distance: 1e-6, share: 0.6, sigma: 1.04e-9 },
                ["60 %", "1.04 nm", "low-pass"],
            ),
            (
                Warning::Spikes { count: 1, largest: 3e-6, slope_share: 0.5 },
                ["1 single point stands", "3.00 um", "carries 50 %"],
            ),
            (
                Warning::Spikes { count: 7, largest: 3e-6, slope_share: 0.5 },
                ["7 single points stand ", "up to", "carry 50 %"],
            ),
        ] {
            let text = warning.to_string();
            assert!(parts.iter().all(|p| text.contains(p)) && text.ends_with('.'), "{text}");
        }
        assert_eq!([0.0, 2.5e-13, 9.999e-9, 0.0123].map(length), ["0.00 pm", "0.25 pm", "10.0 nm", "12.3 mm"]);
    }
}
