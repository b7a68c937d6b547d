//! Everything that can be said about a map before light falls on it.

use super::HeightMap;
use super::parameters::{Gradient, Heights, Texture};
use super::sampling::{Sampling, Warning};
use super::spectrum::{Autocorrelation, Spectrum};

/// Fewer independent patches than this, and the next spot on the specimen gives other numbers.
const FEWEST_PATCHES: f64 = 30.0;

/// Numbers, functions and warnings of one map.
#[derive(Debug, Clone)]
pub struct Survey {
    pub heights: Heights,
    pub gradient: Gradient,
    pub texture: Texture,
    pub autocorrelation: Autocorrelation,
    pub spectrum: Spectrum,
    pub sampling: Sampling,
    /// Share of the points that are missing, 0 to 1.
    pub missing_fraction: f64,
    /// Reasons to distrust what follows from the map, each a sentence with advice.
    pub warnings: Vec<Warning>,
}

impl Survey {
    /// Measures a map; the same numbers for any number of threads. At its largest it needs about three times the memory
    /// of the heights.
    pub fn of(map: &HeightMap) -> Self {
        let heights = Heights::measure(map);
        let gradient = Gradient::measure(map);
        let spectrum = Spectrum::about(map, &heights);
        let autocorrelation = Autocorrelation::about(map, &heights);
        let texture = Texture::of(&autocorrelation, &spectrum);
        let sampling = Sampling::examine(map);
        let mut warnings = sampling.warnings.clone();
        match texture.sal {
            None if heights.sq > 0.0 => warnings.push(Warning::FormLeft),
            Some(sal) => {
                let area = heights.points as f64 * map.pitch_x * map.pitch_y;
                let longest = texture.str.map_or(sal, |s| sal / s);
                let patches = area / (4.0 * sal * longest);
                if patches < FEWEST_PATCHES {
                    warnings.push(Warning::FewPatches { patches, sal });
                }
                if let Some(str_bound) = texture.str.filter(|_| texture.str_is_upper_bound) {
                    warnings.push(Warning::LayLongerThanMap { str_bound });
                }
            }
            None => {}
        }
        Survey {
            heights,
            gradient,
            texture,
            autocorrelation,
            spectrum,
            sampling,
            missing_fraction: map.missing_fraction(),
            warnings,
        }
    }
}
