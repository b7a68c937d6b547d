//! Whether rays may be believed at a geometry: the Rayleigh parameter.

use super::geometry::Geometry;

/// Below this Rayleigh parameter more than 1e-4 of the reflected light is a coherent mirror beam that rays
/// know nothing of: `exp(-9) = 1.2e-4`.
pub const SMALLEST_FOR_RAYS: f64 = 9.0;

/// `g = (4 pi Sq cos_theta / lambda)^2` at specular reflection; `exp(-g)` of the reflectance is coherent.
///
/// `sq` and `wavelength` in the same unit, `theta` in rad.
/// Source: Beckmann and Spizzichino 1963, chapter 5; He et al., SIGGRAPH 1991.
pub fn rayleigh_parameter(sq: f64, theta: f64, wavelength: f64) -> f64 {
    (4.0 * std::f64::consts::PI * sq * theta.cos() / wavelength).powi(2)
}

/// What the meter has to say about its own result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// The surface is too smooth for rays at this angle and wavelength.
    TooSmoothForRays {
        /// Rayleigh parameter.
        g: f64,
        /// Angle of incidence \[rad\].
        theta_i: f64,
        /// Root-mean-square height \[m\].
        sq: f64,
        /// Wavelength \[m\].
        wavelength: f64,
    },
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Warning::TooSmoothForRays { g, theta_i, sq, wavelength } => {
                let needed = SMALLEST_FOR_RAYS.sqrt() / (4.0 * std::f64::consts::PI * theta_i.cos()) * wavelength;
                write!(
                    f,
                    "At {:.0} deg the Rayleigh parameter is {g:.2} (Sq {:.0} nm, wavelength {:.0} nm), below \
                     {SMALLEST_FOR_RAYS}: {:.1} % of the reflected light stays a mirror beam that rays do not \
                     describe. The value needs a wave calculation; trust rays at this angle above Sq {:.0} nm.",
                    theta_i.to_degrees(),
                    sq * 1e9,
                    wavelength * 1e9,
                    100.0 * (-g).exp(),
                    needed * 1e9,
                )
            }
        }
    }
}

/// A warning if rays should not be believed for a surface of rms height `sq` \[m\] at `geometry` and `wavelength` \[m\].
///
/// None for an exactly flat surface, whose mirror beam rays do describe.
pub fn check_rays(sq: f64, geometry: &Geometry, wavelength: f64) -> Option<Warning> {
    let theta_i = geometry.theta_i;
    let g = rayleigh_parameter(sq, theta_i, wavelength);
    (sq > 0.0 && g < SMALLEST_FOR_RAYS).then_some(Warning::TooSmoothForRays { g, theta_i, sq, wavelength })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// TV32: coherent fraction of Sq 201 nm at 550 nm.
    #[test]
    fn coherent_fractions() {
        for (angle, fraction) in [(20f64, 8.16538e-9), (60.0, 0.00513015), (85.0, 0.851968)] {
            let g = rayleigh_parameter(201e-9, angle.to_radians(), 550e-9);
            assert!(((-g).exp() - fraction).abs() < 1e-6 * fraction.max(1e-3), "{angle}");
        }
    }

    /// Roughness at which g = 9, 550 nm: 140 nm at 20 deg, 263 at 60, 1506 at 85.
    #[test]
    fn the_warning_starts_where_g_is_nine() {
        for (geometry, nm) in Geometry::standard_three().iter().zip([140.0, 263.0, 1506.0]) {
            assert!(check_rays((nm - 1.0) * 1e-9, geometry, 550e-9).is_some());
            assert!(check_rays((nm + 1.0) * 1e-9, geometry, 550e-9).is_none());
            let text = check_rays(50e-9, geometry, 550e-9).unwrap().to_string();
            assert!(text.contains("wave calculation") && text.contains("above Sq "), "{text}");
        }
        assert_eq!(check_rays(0.0, &Geometry::gloss20(), 550e-9), None);
    }
}
