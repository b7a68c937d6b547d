//! Floor 8: the pictures of Westlund, Meyer and Hunt, J. Res. NIST 107, 247 (2002), as built-in scenes.
//!
//! ```text
//! epoxy    height maps ─► tables ─┐
//! meters   gloss, haze ─► models ─┤
//! paint    tristimulus values ────┼► spheres, tiles, vases, shells: scene and camera ─► figure ─► picture, numbers
//! vase, shell   formulas ─► meshes┘                                                         noise
//! ```
//! | name | what it shows | surfaces |
//! |---|---|---|
//! | `fig7` | four spheres of rising gloss by direct light only, by uniform sampling, by alias sampling | height maps of aluminium |
//! | `fig8` | two black-glass tiles, Sq 201 and 805 nm | height maps |
//! | `fig9` | vases with coarse and fine metallic paint | NEF-BM, library |
//! | `fig11` | tiles of 20 deg gloss 80, 60, 40, 20 | Ward, solved by the meter |
//! | `fig12` | tiles of 2 deg haze 10, 60, 110, 160 at 20 deg gloss 100 | Ward, solved by the meter |
//! | `fig13` | three vases of metallic paint without a clear coat | tristimulus values at three angles |
//! | `fig14` | two automotive shells, 20 deg first-surface gloss 10 and 60 | Beckmann over tristimulus values |
//!
//! Lengths in metres, radiance in W/(m2 sr) per linear RGB channel, z up.

mod epoxy;
mod figures;
mod finish;
mod meters;
mod noise;
mod paint;
mod shell;
mod shells;
mod spheres;
mod tiles;
mod vases;

pub use figures::{Figure, Picture, Settings};
pub use finish::Finish;
pub use noise::{Noise, noise};
