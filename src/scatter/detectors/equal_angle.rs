//! Detectors at equal steps of theta and phi, as a goniometer stops.

use super::Rings;
use crate::error::{Error, Result};
use std::f64::consts::{FRAC_PI_2, TAU};

/// More detectors than this take longer to add up than to count into.
pub(super) const MOST: usize = 1 << 20;

impl Rings {
    /// Detectors centred on multiples of `step_theta` and `step_phi` \[rad\]; one round cap about the pole, and a last
    /// ring cut at the horizon.
    ///
    /// # Errors
    /// `Error::Parameter` if a step is out of range, if `step_phi` does not divide the circle, or if there are too many.
    pub fn equal_angle(step_theta: f64, step_phi: f64) -> Result<Self> {
        let advice = "give steps in degrees as theta-phi:DT,DP, such as theta-phi:5,10";
        if !(step_theta > 0.0 && step_theta <= FRAC_PI_2 && step_phi > 0.0 && step_phi <= TAU) {
            return Err(Error::parameter(
                format!("detectors of {} deg by {} deg", step_theta.to_degrees(), step_phi.to_degrees()),
                advice,
            ));
        }
        let sectors = (TAU / step_phi).round();
        if (sectors * step_phi / TAU - 1.0).abs() > 1e-9 {
            return Err(Error::parameter(
                format!("steps of {} deg do not close the circle", step_phi.to_degrees()),
                "give a DP that divides 360",
            ));
        }
        // The edge half a step inside the horizon belongs to the last detector but for rounding.
        let rings = ((FRAC_PI_2 / step_theta + 0.5 - 1e-9).ceil()).max(1.0);
        if rings * sectors > MOST as f64 {
            return Err(Error::parameter(
                format!("{rings} x {sectors} detectors are more than {MOST}"),
                "give larger steps, or cells that follow the lobe with --detectors half-vector",
            ));
        }
        let (rings, sectors) = (rings as usize, sectors as usize);
        let inner = (0..rings).map(|j| if j == 0 { 0.0 } else { (j as f64 - 0.5) * step_theta }).collect();
        let counts = (0..rings).map(|j| if j == 0 { 1 } else { sectors }).collect();
        Ok(Rings::new(inner, counts))
    }
}
