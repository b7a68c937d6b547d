//! Floor 5: the BRDF as numbers.

mod angles;
mod balance;
mod build;
mod core;
mod eval;
mod file;
mod floor;
mod masking;
mod mesh;
mod nodes;
mod variants;

pub(crate) use balance::{STEPS as BALANCE_STEPS, albedos, coarse_mesh, mesh};
pub(crate) use eval::Incident;
pub use file::FORMAT_VERSION;
pub(crate) use masking::Masking;
pub(crate) use mesh::Mesh;
pub use nodes::NodeWeights;
pub(crate) use nodes::{BUCKETS, Nodes, Place, not_below, turn};
pub use variants::Steps;

use crate::optics::Material;
use crate::scatter::{HalfVectorCells, Method};
use serde::{Deserialize, Serialize};

/// Where a table comes from; stored in the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct Provenance {
    /// File name of the height map, without its folder.
    pub source: String,
    /// Root-mean-square height after levelling \[m\].
    #[serde(rename = "Sq_m")]
    pub sq: f64,
    /// Root-mean-square gradient.
    #[serde(rename = "Sdq")]
    pub sdq: f64,
    /// Share of missing points.
    pub missing_fraction: f64,
    /// Wavelength at which the material was looked up and the rays are judged \[m\].
    #[serde(rename = "wavelength_m")]
    pub wavelength: f64,
    pub method: Method,
    pub seed: u64,
    /// Program and version.
    pub program: String,
}

/// `f_r(wi, wo) = specular core + F(wi) / pi + b R(beta) G T(theta_i, phi_i; slope) / (4 cos_theta_i cos_theta_r cos^4 theta_h)`.
///
/// `F` is the albedo of the diffuse floor. `G T` is the density of lit, unhidden facets per unit slope area: `G` is
/// Smith's factor of the measured slopes, which takes care of the horizon, and `T` is tabulated over
/// half-vector cells for each incident direction and interpolated linearly in both axes, tan(theta_i) and the turn of
/// phi_i; `R` is the Fresnel reflectance, never tabulated; the core runs as
/// `exp(-a cos^2 theta_i)` between nodes, as a mirror beam does; `b` is 1 at the nodes and keeps the energy between them. The half
/// vector fixes the facet (Torrance and Sparrow 1967), so lobes move with `wi` instead of fading from node to node. Outside
/// the nodes the nearest one serves.
///
/// An isotropic table lies in the frame of the source (`phi_i = 0`), an anisotropic one in that of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub(crate) cells: HalfVectorCells,
    pub(crate) isotropic: bool,
    pub(crate) material: Material,
    /// Incident polar angles \[rad\], rising.
    pub(crate) theta_i: Vec<f64>,
    /// Source azimuths \[rad\], rising; one if isotropic or if nothing is hidden.
    pub(crate) phi_i: Vec<f64>,
    /// Both, prepared for finding.
    pub(crate) finder: Nodes,
    /// `T` at the cell centres, `[theta][phi][cell]`.
    pub(crate) density: Vec<f64>,
    /// Standard error of `T` relative to it, same shape.
    pub(crate) relative_error: Vec<f64>,
    /// `T` of each sub-area of the map relative to the whole, `[sub-area][cell]`.
    pub(crate) subarea_ratio: Vec<Vec<f64>>,
    /// The same for nodes of the wave calculation: `T` of independent parts of the speckle; empty if there is no such node.
    pub(crate) speckle_ratio: Vec<Vec<f64>>,
    /// `G` of the formula.
    pub(crate) masking: Masking,
    /// Facts per node, `[theta][phi]`.
    pub(crate) nodes: Vec<Node>,
    /// Energy between the nodes, derived from `density`; not stored in the file.
    pub(crate) balance: balance::Balance,
    /// The core between the nodes, derived from `nodes`.
    pub(crate) cores: core::Cores,
    /// The table with the heights as they are, where they come in steps and were spread within them.
    pub(crate) steps: Option<Steps>,
    pub provenance: Provenance,
}

/// The energy of one incident direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Node {
    /// Share of the lit area that is the specular core (before Fresnel).
    pub core_share: f64,
    /// Albedo of the diffuse floor.
    pub diffuse: f64,
    /// Escaped share of the incident energy, core and floor included: the albedo.
    pub albedo: f64,
    /// Standard error of the albedo.
    pub albedo_error: f64,
    pub absorbed: f64,
    pub lost: f64,
    /// Share of the incident energy that escaped after more than one bounce.
    pub multiple: f64,
    /// Facet area hidden from the source, relative to the lit area.
    pub shadowed: f64,
    /// 1 if the wave calculation served, 0 if rays did.
    pub wave: f64,
    /// Share of the incident energy that one ray carried away; 0 if rays were not counted. Three of them are the 95 % bound of
    /// a cell that received none.
    pub one_ray: f64,
    /// Standard error of the core relative to it: map-to-map scatter of the mirror beam; 0 for rays.
    pub core_error: f64,
}

impl Node {
    /// Escaped energy that is neither core nor floor.
    pub(crate) fn rest(&self, material: &Material, cos_theta_i: f64) -> f64 {
        (self.albedo - self.core_share * material.reflectance(cos_theta_i) - self.diffuse).max(0.0)
    }
}

impl Table {
    /// Incident polar angles of the nodes \[rad\].
    pub fn theta_i(&self) -> &[f64] {
        &self.theta_i
    }

    /// Source azimuths of the nodes \[rad\].
    pub fn phi_i(&self) -> &[f64] {
        &self.phi_i
    }

    /// Whether the table holds the average over source azimuths.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// The half-vector cells.
    pub fn cells(&self) -> &HalfVectorCells {
        &self.cells
    }

    /// The interface whose Fresnel reflectance multiplies the table.
    pub fn material(&self) -> Material {
        self.material
    }

    /// Energy book of a node.
    pub fn node(&self, theta: usize, phi: usize) -> Node {
        self.nodes[theta * self.phi_i.len() + phi]
    }

    /// Number of sub-areas that carry the map-to-map error.
    pub fn subareas(&self) -> usize {
        self.subarea_ratio.len()
    }

    /// Range of a node's cells in `density` and `relative_error`.
    pub(crate) fn node_range(&self, node: usize) -> std::ops::Range<usize> {
        node * self.cells.len()..(node + 1) * self.cells.len()
    }
}
