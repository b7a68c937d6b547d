//! What preparing a map found that its user should know.

use super::fill::USUAL_LIMIT;

/// Share of the slope variance above which noise is worth a warning.
pub const LARGEST_NOISE_SHARE: f64 = 0.05;

/// Share of spikes above which the rule, rather than the map, is in doubt.
pub const MOST_SPIKES: f64 = 0.01;

/// A full sentence with advice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// The file states its own pitch, so the one given for it was not used.
    PitchOfFile {
        /// Pitch along x and y as the file has it \[m\].
        stated: [f64; 2],
        /// As given \[m\].
        given: [f64; 2],
    },
    /// Instrument noise explains much of the slopes.
    NoiseInSlopes {
        /// Standard deviation of the height noise \[m\].
        noise: f64,
        /// Share of the slope variance.
        share: f64,
        /// Sdq as measured and without the noise.
        sdq: [f64; 2],
    },
    /// An S-filter shorter than the sampling can carry was left out.
    SFilterBelowSampling {
        /// Cut-off \[m\].
        cut_off: f64,
        /// Coarser pitch \[m\].
        pitch: f64,
    },
    /// Many points were taken for spikes.
    ManySpikes {
        /// Share of the measured points.
        fraction: f64,
    },
    /// Many points were filled.
    ManyFilled {
        /// Share of the map.
        fraction: f64,
    },
    /// A hole was too large for the relaxation.
    FillNotConverged {
        /// Points of the largest hole.
        largest_hole: usize,
    },
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Warning::PitchOfFile { stated, given } => write!(
                f,
                "The file states a pitch of {:.6} x {:.6} um, which was used; the {:.6} x {:.6} um given are for files \
                 without one. If the file is wrong, convert it to .npy and give the pitch with that.",
                stated[0] * 1e6,
                stated[1] * 1e6,
                given[0] * 1e6,
                given[1] * 1e6
            ),
            Warning::NoiseInSlopes { noise, share, sdq: [measured, corrected] } => write!(
                f,
                "Instrument noise of {:.3} nm makes {:.1} % of the slope variance (more than {:.0} %): Sdq is {corrected:.5} \
                 without it instead of {measured:.5}, and the predicted gloss is too low. Remove the noise with an \
                 S-filter at the instrument's lateral resolution, such as --s-filter 2.5um, or average repeated maps.",
                noise * 1e9,
                100.0 * share,
                100.0 * LARGEST_NOISE_SHARE
            ),
            Warning::SFilterBelowSampling { cut_off, pitch } => write!(
                f,
                "The S-filter of {:.4} um was left out because waves shorter than two pitches of {:.4} um are not in the \
                 map. Maps are comparable only over the same band: choose a cut-off that suits the coarsest of them.",
                cut_off * 1e6,
                pitch * 1e6
            ),
            Warning::ManySpikes { fraction } => write!(
                f,
                "{:.2} % of the points were taken for spikes, more than {:.0} %: steep facets may be among them, and the \
                 predicted gloss is then too high. Raise the threshold, for example --despike 10.",
                100.0 * fraction,
                100.0 * MOST_SPIKES
            ),
            Warning::ManyFilled { fraction } => write!(
                f,
                "{:.2} % of the map was filled, more than {:.0} %: filled points are smoother than the surface, so Sdq is \
                 too low and gloss too high. Leave the points missing unless a whole map is needed.",
                100.0 * fraction,
                100.0 * USUAL_LIMIT
            ),
            Warning::FillNotConverged { largest_hole } => write!(
                f,
                "Filling did not converge to one millionth of the rim heights; the largest hole has {largest_hole} points. \
                 Leave large holes open with --fill-hole, for example --fill-hole 10000."
            ),
        }
    }
}

impl serde::Serialize for Warning {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
