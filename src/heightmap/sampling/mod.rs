//! Is the map sampled well enough for slopes to mean something? Slopes against sampling distance, and what they betray.

mod diagnosis;
mod quantum;
mod scales;
mod spikes;
mod warning;

pub use quantum::Quantum;
pub use scales::SlopeScale;
pub use spikes::Spikes;
pub use warning::{MapAxis, Warning};

use crate::heightmap::HeightMap;

/// Slopes at growing sampling distance, the steps of the heights, the spikes, and what follows from them.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// `s(d), s(2d), s(4d), ..` along x, up to a quarter of the map.
    pub along_x: Vec<SlopeScale>,
    /// The same along y.
    pub along_y: Vec<SlopeScale>,
    /// Steps the heights come in, if there are few.
    pub quantum: Option<Quantum>,
    /// Single points that stand out from their neighbours, if there are any.
    pub spikes: Option<Spikes>,
    /// What is wrong with the sampling, worst first within each axis.
    pub warnings: Vec<Warning>,
}

impl Sampling {
    /// Examines a map; the same findings for any number of threads.
    pub fn examine(map: &HeightMap) -> Self {
        let [along_x, along_y] = [MapAxis::X, MapAxis::Y].map(|axis| scales::slope_scales(map, axis));
        let quantum = quantum::find(map);
        let spikes = spikes::find(map, quantum.map_or(0.0, |q| q.step));
        let mut warnings = Vec::new();
        warnings.extend(diagnosis::of_axis(MapAxis::X, &along_x));
        warnings.extend(diagnosis::of_axis(MapAxis::Y, &along_y));
        warnings.extend(diagnosis::of_quantum(quantum));
        warnings.extend(diagnosis::of_spikes(spikes));
        warnings.extend(diagnosis::of_gaps(map.missing_fraction()));
        Sampling { along_x, along_y, quantum, spikes, warnings }
    }
}
