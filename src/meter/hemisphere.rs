//! Directional-hemispherical reflectance, with and without the specular beam.

use super::stop::in_degrees;
use crate::error::{Error, Result};
use crate::math::{Estimate, direction, reflect};
use crate::optics::Brdf;
use glam::DVec3;
use sobol_burley::sample;

/// Points per repeat, and repeats whose scatter is the error.
const POINTS: u32 = 4096;
const REPEATS: u32 = 16;

/// What an integrating sphere reads under light from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hemispherical {
    /// `rho = int f_r cos_theta_r dwo` + specular core: gloss trap closed.
    pub included: Estimate,
    /// The same without what leaves within the trap.
    pub excluded: Estimate,
}

/// Reflectance into the hemisphere for light from `(theta_i, phi)`, all of it and without a cone of half angle `trap` about
/// the mirror direction (all in radians; an integrating sphere d/8 has a trap of about 4 deg).
///
/// Drawn by the surface's own sampler, weight `f_r cos_theta_r / pdf`: independent of [`Brdf::albedo`].
///
/// # Errors
/// `Error::Parameter` if the angle of incidence is not in 0 to 90 deg or the trap is negative.
pub fn hemispherical(brdf: &dyn Brdf, theta_i: f64, phi: f64, trap: f64) -> Result<Hemispherical> {
    if !((0.0..std::f64::consts::FRAC_PI_2).contains(&theta_i) && trap >= 0.0 && phi.is_finite()) {
        return Err(Error::parameter(
            format!("no sphere has light from {} deg and a trap of {} deg", in_degrees(theta_i), in_degrees(trap)),
            "give an angle of incidence from 0 to 90 deg and a trap of 0 deg or more",
        ));
    }
    let wi = direction(theta_i, phi);
    let mirror = reflect(wi, DVec3::Z);
    let mut repeats = [Vec::new(), Vec::new()];
    for repeat in 0..REPEATS {
        let mut sums = [0.0; 2];
        for k in 0..POINTS {
            let u = [0, 1].map(|axis| f64::from(sample(k, axis, repeat)));
            let Some(draw) = brdf.sample(wi, u).filter(|d| !d.specular) else { continue };
            sums[0] += draw.weight;
            let beside = draw.wo.cross(mirror).length().atan2(draw.wo.dot(mirror));
            sums[1] += if beside > trap { draw.weight } else { 0.0 };
        }
        repeats.iter_mut().zip(sums).for_each(|(list, sum)| list.push(sum / f64::from(POINTS)));
    }
    let [all, outside] = repeats.map(|list| Estimate::from_repeats(&list));
    let included = Estimate { value: all.value + brdf.specular_core(wi), ..all };
    Ok(Hemispherical { included, excluded: outside })
}
