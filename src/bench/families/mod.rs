//! The questions: one file each. A new one is a line in [`all`].

pub mod metering;
pub mod rendering;
pub mod sampling;
pub mod scattering;
pub mod tables;

use super::method::Family;
use super::surface::Surface;
use crate::error::Result;
use crate::render::description::Materials;
use crate::sample::TableBrdf;

/// What the families measure with; they borrow from it.
pub struct Material<'a> {
    pub surface: Surface<'a>,
    /// Table of a smooth Gaussian map, alpha 0.02.
    pub table: TableBrdf,
    pub scene: rendering::SceneFile,
    pub materials: Materials,
    /// Beams of the reference of scattering.
    pub reference_rays: u64,
}

impl<'a> Material<'a> {
    /// Prepares everything for `surface`.
    ///
    /// # Errors
    /// As the parts.
    pub fn new(surface: Surface<'a>, reference_rays: u64) -> Result<Self> {
        let scene = rendering::SceneFile::new()?;
        let materials = scene.materials()?;
        Ok(Material { surface, table: sampling::table()?, scene, materials, reference_rays })
    }
}

/// Every family, its reference worked out.
///
/// # Errors
/// As the families.
pub fn all<'a>(m: &'a Material<'a>, progress: &dyn Fn(f64)) -> Result<Vec<Family<'a>>> {
    let mut families = Vec::new();
    for theta_i in scattering::ANGLES {
        families.push(scattering::family(&m.surface, theta_i, m.reference_rays));
        progress(families.len() as f64 / 6.0);
    }
    families.push(tables::family());
    families.push(sampling::family(&m.table));
    families.push(metering::family()?);
    progress(5.0 / 6.0);
    families.push(rendering::family(&m.scene, &m.materials)?);
    progress(1.0);
    Ok(families)
}
