//! The measurement protocol of the NEF-BM model: from scans of a goniometer to parameters with their errors.
//!
//! What is measured, all as BRDF values \[1/sr\] of linearly polarised light:
//!
//! | scan | geometry | columns of its CSV file |
//! |---|---|---|
//! | zero-bistatic | source and detector in one direction, `theta` from the normal | `theta_deg, co_per_sr, cross_per_sr` |
//! | specular | source at 20, 40, 60 deg, detector about the mirror direction, polariser and analyser both s or both p | `theta_i_deg, theta_r_deg, polarisation, f_r_per_sr` |
//! | fixed bistatic | source and detector `2 beta` apart, the specimen turned by `theta_h` between them | `beta_deg, theta_h_deg, co_per_sr, cross_per_sr` |
//! | reflectance | all light that leaves under illumination at `theta_i` (20 deg), wavelength by wavelength | `wavelength_nm, dhr`, with `dhr_error, theta_i_deg, n, k` if known |
//!
//! `co` and `cross` are the means over s and p with analyser along and across the polariser: the first surface keeps the
//! polarisation, the volume loses it, so `co = f_s + f_v / 2`, `cross = f_v / 2`. Errors may stand in columns `co_error,
//! cross_error, standard_error` (1/sr).
//!
//! The first three are taken at one wavelength, that of a laser; the last carries the material to the others.
//!
//! Source: Westlund, Meyer, Hunt, J. Res. NIST 107, 247, 2002, section 3.1; order of the steps as handed down for the NEF
//! database.

mod characterise;
mod material;
mod scans;
mod simulate;
mod spectrum;

pub use characterise::{Characterised, Law, ResidualRow, Step, characterise};
pub use scans::{Bistatic, Polarisation, Scans, Specular, ZeroBistaticRow};
pub use simulate::{Noise, simulate};
pub use spectrum::{Band, Reflectance, Spectrum, carry};
