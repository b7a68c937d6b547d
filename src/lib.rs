#![forbid(unsafe_code)]
//! `asperity` predicts how a surface looks from how it was measured.
//!
//! An interferometer height map becomes facet normals; rays scattered by the facets become a BRDF; the BRDF is
//! tabulated, alias-sampled, and fed to a virtual glossmeter and a path tracer (after Westlund, Meyer and Hunt, J. Res.
//! NIST 107, 247, 2002).
//!
//! # Conventions, kept everywhere
//!
//! - Right-handed frame, z = mean surface normal. Row 0 of a map is the top row: column grows with +x, row grows with
//!   -y. A height sample is a vertex; a cell is two triangles along the diagonal (row, col) to (row+1, col+1).
//! - `wi` points to the source, `wo` to the detector; both leave the surface. `phi` is the azimuth about +z from +x; specular
//!   reflection is at `phi_r = phi_i + 180 deg`.
//! - SI units and radians, f64. Degrees, um and nm appear only in the command line and in files, with the unit in the name.
//! - `f_r` is the BRDF in 1/sr without the cosine; `pdf` is per solid angle; gloss is in gloss units (GU).
//! - A number that was estimated is an [`Estimate`](math::Estimate) with its standard error; a bare f64 is exact.
//!
//! # Rooms, from the ground floor up; a file uses lower floors and its own folder only
//!
//! `error`, `output`, `npy`, `archive`, `columns`, [`math`] · [`optics`] · [`heightmap`] · [`facets`] · [`scatter`] · [`table`], [`model`] ·
//! [`sample`], [`fit`] · [`meter`], [`render`] · [`chart`], [`figure`] · [`report`], [`bench`] · [`cli`]
//!
//! # The whole pipeline
//!
//! ```
//! use asperity::heightmap::{Edges, level, synth};
//! use asperity::meter::{Geometry, Options, gloss};
//! use asperity::sample::TableBrdf;
//! use asperity::scatter;
//! use asperity::table::{Provenance, Table};
//!
//! // A Gaussian surface, 0.1 um rms, 8 um correlation length, as an instrument would deliver it.
//! let grid = synth::Grid { width: 256, height: 256, pitch: [1e-6, 1e-6] };
//! let surface = synth::Gaussian { sq: 0.1e-6, acl: 8e-6, seed: 1, exact: true };
//! let map = level::level(&synth::gaussian(grid, surface)?, Edges::Periodic)?;
//!
//! // Scatter off n = 1.5, tabulate, make it samplable, read the 60-degree gloss.
//! let scattered = scatter::scatter(&map, &scatter::Options::default(), &|_| ())?;
//! let brdf = TableBrdf::new(Table::from_scatter(&scattered, Provenance::default()))?;
//! let g60 = gloss(&brdf, &Geometry::gloss60(), &Options::default());
//! // Flat n = 1.5 would read 89.1; alpha = 2 Sq / acl = 0.025 lowers it.
//! assert!(g60.value > 50.0 && g60.value < 80.0);
//! # Ok::<(), asperity::Error>(())
//! ```

pub mod archive;
pub mod bench;
pub mod chart;
pub mod cli;
pub mod columns;
pub mod error;
pub mod facets;
pub mod figure;
pub mod fit;
pub mod heightmap;
pub mod math;
pub mod meter;
pub mod model;
pub mod npy;
pub mod optics;
pub mod output;
pub mod render;
pub mod report;
pub mod sample;
pub mod scatter;
pub mod table;

pub use error::{Error, Result};
