//! Gloss straight from the facets of a height map, without a table between.
//!
//! `G = 100 / Phi(standard) * mean over facets of K(p, q)`,
//! `K = int_{P(n)} R(cos_beta) V(wi, wo) (n . wi) / n.z dwi`
//!
//! with `P(n)` the part of the source stop that a facet of normal `n` mirrors into the receptor, an exact polygon
//! ([`super::overlap`]), and V the share of facets neither hidden from the source nor from the receptor (Smith's, of the
//! measured slopes). K is smooth but for kinks where a stop's edge passes; [`super::slope_cells`] sums it.

use super::geometry::Geometry;
use super::path::Path;
use super::slope_cells::{Gathered, Means, Radial, Seen};
use crate::error::{Error, Result};
use crate::facets::distribution::{Hiding, hidden_excess};
use crate::heightmap::HeightMap;
use crate::math::Estimate;
use crate::optics::Material;
use glam::DVec3;

/// Which azimuths of the source to average over.
#[derive(Debug, Clone, PartialEq)]
pub enum Azimuths {
    /// All of them, exactly: for a surface without a direction.
    All,
    /// These \[rad\].
    At(Vec<f64>),
}

/// Gloss of the facets at each geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct FacetGloss {
    /// Gloss \[GU\]; its standard error is the scatter of 16 sub-areas over the root of their number.
    pub gloss: Vec<Estimate>,
    /// Lambda at each angle of incidence: facet area hidden from the source per unit of lit area. The gloss accounts for
    /// it as Smith's function does, or by tracing ([`super::traced_gloss`]).
    pub hidden: Vec<f64>,
}

/// Gloss of the facets of `map`: single reflections, hidden facets by Smith's function of the measured slopes. Where that is not
/// enough [`super::traced_gloss`] goes on.
///
/// # Errors
/// `Error::Parameter` if the map has no facet, a geometry cannot exist or there is no azimuth.
pub fn facet_gloss(
    map: &HeightMap,
    material: &Material,
    geometries: &[Geometry],
    azimuths: &Azimuths,
) -> Result<FacetGloss> {
    Ok(with_slopes(map, material, geometries, azimuths)?.0)
}

/// What [`facet_gloss`] knows of the slopes.
pub(super) struct Slopes {
    /// Gradients with their shares of the facets, rising.
    pub gradients: Vec<(f64, f64)>,
    /// Masking and shadowing; `None` if nothing is hidden from the stops.
    pub hiding: Option<Hiding>,
}

/// [`facet_gloss`], and the slopes it is made of.
pub(super) fn with_slopes(
    map: &HeightMap,
    material: &Material,
    geometries: &[Geometry],
    azimuths: &Azimuths,
) -> Result<(FacetGloss, Slopes)> {
    geometries.iter().try_for_each(Geometry::validate)?;
    let list = match azimuths {
        Azimuths::At(list) if list.is_empty() => {
            return Err(Error::parameter("there is no azimuth to read the gloss at", "give at least one"));
        }
        Azimuths::At(list) => list.as_slice(),
        Azimuths::All => &[0.0],
    };
    let paths: Vec<Vec<Path>> = geometries.iter().map(|g| list.iter().map(|&phi| g.path(phi)).collect()).collect();
    let reach = paths.iter().flatten().map(Path::steepest).fold(0.0, f64::max);
    let radial = Gathered::of(map, Radial { reach });
    if radial.facets() == 0 {
        return Err(Error::parameter("the map has no facet", "every triangle touches a missing point"));
    }
    let gradients = radial.gradients();
    let hiding = hiding(&gradients, paths.iter().flatten());

    let (mut gloss, mut hidden) = (Vec::new(), Vec::new());
    for (geometry, paths) in geometries.iter().zip(&paths) {
        let means: Vec<Means> = paths
            .iter()
            .map(|path| {
                let kernel = |n: DVec3| {
                    path.facet(n, |cos_beta, wi, wo| {
                        let seen = hiding.as_ref().map_or(1.0, |h| h.visible(wi.z, wo.z));
                        material.reflectance(cos_beta) * seen
                    })
                };
                match azimuths {
                    Azimuths::All => radial.means(&kernel),
                    Azimuths::At(_) => Gathered::of(map, Seen::by(path)).means(&kernel),
                }
            })
            .collect();
        let scale = geometry.units_per_flux() / means.len() as f64;
        let parts: Vec<f64> =
            (0..means[0].parts.len()).map(|k| scale * means.iter().map(|m| m.parts[k]).sum::<f64>()).collect();
        let value = scale * means.iter().map(|m| m.whole).sum::<f64>();
        gloss.push(Estimate { value, ..Estimate::from_repeats(&parts) });
        hidden.push(hiding.as_ref().map_or(0.0, |h| h.lambda(geometry.theta_i.cos())));
    }
    Ok((FacetGloss { gloss, hidden }, Slopes { gradients, hiding }))
}

/// Masking and shadowing of the gradients; `None` if no facet is steep enough to hide another from these paths.
fn hiding<'a>(gradients: &[(f64, f64)], paths: impl Iterator<Item = &'a Path>) -> Option<Hiding> {
    let lowest = paths.map(|p| p.source().lowest().min(p.receptor().lowest())).fold(1.0, f64::min).max(1e-6);
    let steepest = gradients.last().map_or(0.0, |g| g.0);
    let cotangent = lowest / (1.0 - lowest * lowest).max(0.0).sqrt().max(1e-300);
    // Means of cells: the steepest facet may be one cell steeper.
    (1.05 * steepest > cotangent).then(|| Hiding::tabulate(|theta| hidden_excess(gradients.iter().copied(), theta)))
}
