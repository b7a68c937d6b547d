//! The 145 patches of Klems for windows and daylighting.

use super::Rings;

/// Inner edges of the rings \[deg\] and patches per ring.
const RINGS: [(f64, usize); 9] =
    [(0.0, 1), (5.0, 8), (15.0, 16), (25.0, 20), (35.0, 24), (45.0, 24), (55.0, 24), (65.0, 16), (75.0, 12)];

impl Rings {
    /// The full basis of 145 patches: theta edges 0 5 15 25 35 45 55 65 75 90 deg with 1 8 16 20 24 24 24 16 12 patches,
    /// the first of every ring centred on phi = 0 (Klems, ASHRAE Trans. 100(1), 1065, 1994).
    pub fn klems() -> Self {
        Rings::new(RINGS.map(|r| r.0.to_radians()).to_vec(), RINGS.map(|r| r.1).to_vec())
    }
}
