//! Which answer may be believed at a geometry, rays or waves, and what to say about it.

use super::geometry::Geometry;
use crate::scatter::Decision;
pub use crate::scatter::kirchhoff::{SMALLEST_FOR_RAYS, rayleigh_parameter};

/// Share of the light that the wave calculation may leave unfollowed, or of the facets that may be too steep for the pitch,
/// before its answer is not believed.
pub const LARGEST_FOR_WAVES: f64 = 0.05;

/// Which calculation holds at a geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// Rayleigh parameter of at least 9, or an exactly flat surface: the value is that of rays.
    Rays,
    /// Rayleigh parameter below 9: the value is that of the wave calculation.
    Waves,
    /// The value stands on a calculation that does not hold here.
    Neither,
}

impl Holds {
    /// Mark beside a value: none for rays, `~` for waves, `*` for neither.
    pub fn mark(self) -> char {
        match self {
            Holds::Rays => ' ',
            Holds::Waves => '~',
            Holds::Neither => '*',
        }
    }
}

impl std::fmt::Display for Holds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Holds::Rays => "rays",
            Holds::Waves => "waves",
            Holds::Neither => "neither",
        })
    }
}

/// What the meter has to say about its own result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// The surface is too smooth for rays at this angle and wavelength, but rays made the value.
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
    /// The surface is too smooth for rays, and the wave calculation made the value.
    WavesInstead {
        g: f64,
        /// Angle of incidence \[rad\].
        theta_i: f64,
        /// Gloss by waves, and what rays alone would have given \[GU\]; `None` for a stored table.
        wave: f64,
        ray: Option<f64>,
    },
    /// Rays made the value because the incident angles of the table end before this one.
    AngleMissing {
        /// Rayleigh parameter.
        g: f64,
        /// Angle of incidence and the nearest one of the table \[rad\].
        theta_i: f64,
        nearest: f64,
    },
    /// The heights come in steps, and with them the slopes.
    HeightsInSteps {
        /// Step of the heights \[m\].
        step: f64,
        /// Angle between the glints of facets one step apart \[rad\].
        glint_spacing: f64,
        /// Angle of incidence where it tells most \[rad\].
        theta_i: f64,
        /// Gloss with the heights as they are, and spread evenly within their steps \[GU\].
        value: f64,
        spread: f64,
    },
    /// More light beside the mirror direction than in it.
    NoImage {
        /// Distinctness of image, in percent.
        doi: f64,
        standard_error: f64,
    },
    /// Facets whose phase changes by more than half a turn from point to point.
    PhaseUndersampled {
        /// Angle of incidence \[rad\].
        theta_i: f64,
        /// Their share.
        share: f64,
    },
    /// The surface bends within a wavelength.
    TooCurved {
        /// Angle of incidence \[rad\].
        theta_i: f64,
        /// `4 pi r cos_theta / lambda`.
        criterion: f64,
    },
    /// Waves served where much of the light would bounce again.
    WavesBounceOnce {
        /// Angle of incidence \[rad\].
        theta_i: f64,
        /// Predicted share of facets in shadow.
        shadowed: f64,
        /// Share of the light hidden by Smith's factor or sent below the horizon.
        unfollowed: f64,
    },
}

impl Warning {
    /// Whether it casts doubt on the value; otherwise it says that waves took over where rays do not hold.
    pub fn is_doubt(&self) -> bool {
        !matches!(self, Warning::TooSmoothForRays { .. } | Warning::WavesInstead { .. })
    }
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
                     describe. The value needs a wave calculation (--method auto or kirchhoff); trust rays at this angle \
                     above Sq {:.0} nm.",
                    theta_i.to_degrees(),
                    sq * 1e9,
                    wavelength * 1e9,
                    100.0 * (-g).exp(),
                    needed * 1e9,
                )
            }
            Warning::WavesInstead { g, theta_i, wave, ray } => {
                write!(
                    f,
                    "At {:.0} deg the Rayleigh parameter is {g:.3}, below {SMALLEST_FOR_RAYS}, so no ray method holds: the \
                     value is that of the wave calculation (scalar Kirchhoff with its mirror beam), {wave:.2} GU",
                    theta_i.to_degrees(),
                )?;
                match ray {
                    Some(ray) => write!(f, "; rays alone would give {ray:.2} GU, {:+.2} GU off.", ray - wave),
                    None => write!(f, "."),
                }
            }
            Warning::AngleMissing { g, theta_i, nearest } => write!(
                f,
                "At {:.0} deg the Rayleigh parameter is {g:.3}, below {SMALLEST_FOR_RAYS}, so no ray method holds, but the incident \
                 angles asked for leave the value to {:.0} deg, where rays serve. Add {:.0} to --theta-i.",
                theta_i.to_degrees(),
                nearest.to_degrees(),
                theta_i.to_degrees(),
            ),
            Warning::HeightsInSteps { step, glint_spacing, theta_i, value, spread } => write!(
                f,
                "The heights come in steps of {:.2} nm, so facets have only certain slopes, whose glints lie {:.2} deg apart: at \
                 {:.0} deg gloss of the table reads {value:.3} GU with the heights as they are. The table has them spread evenly \
                 within their steps, which gives {spread:.3} GU ({:+.1} %); the standard errors hold the difference. Export the map with more digits, or low-pass it (--s-filter).",
                step * 1e9,
                glint_spacing.to_degrees(),
                theta_i.to_degrees(),
                100.0 * (spread / value - 1.0),
            ),
            Warning::NoImage { doi, standard_error } => write!(
                f,
                "DOI is {doi:.2} +- {standard_error:.2}, below its scale of 0 to 100: the receptor beside the mirror direction gets \
                 more light than the one in it, as chance or steps of the heights have it where a lobe is far wider than \
                 both. The surface mirrors no image; take it as 0."
            ),
            Warning::PhaseUndersampled { theta_i, share } => write!(
                f,
                "At {:.0} deg {:.1} % of the facets are too steep for the sampling distance: their phase changes by more \
                 than half a turn from point to point and the wave calculation sends their light to a wrong angle. Measure \
                 with a smaller pitch, or take the short waves off (--s-filter).",
                theta_i.to_degrees(),
                100.0 * share,
            ),
            Warning::TooCurved { theta_i, criterion } => write!(
                f,
                "At {:.0} deg 4 pi r cos(theta) / lambda is {criterion:.2}, with the rms radius of curvature r: the surface \
                 bends within a wavelength, which no tangent-plane calculation describes. The bending may be noise of the \
                 instrument: compare with --s-filter.",
                theta_i.to_degrees(),
            ),
            Warning::WavesBounceOnce { theta_i, shadowed, unfollowed } => write!(
                f,
                "At {:.0} deg {:.1} % of the facets lie in shadow; the wave calculation takes {:.1} % of the light off for \
                 shadow and for directions below the horizon, and does not follow it to where it would be reflected again.",
                theta_i.to_degrees(),
                100.0 * shadowed,
                100.0 * unfollowed,
            ),
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

/// Warnings if the wave calculation should not be believed where `decision` was for it.
pub fn check_waves(decision: &Decision) -> Vec<Warning> {
    let theta_i = decision.theta_i;
    let mut found = Vec::new();
    if decision.undersampled > LARGEST_FOR_WAVES {
        found.push(Warning::PhaseUndersampled { theta_i, share: decision.undersampled });
    }
    if decision.tangent_plane < 1.0 {
        found.push(Warning::TooCurved { theta_i, criterion: decision.tangent_plane });
    }
    if decision.unfollowed > LARGEST_FOR_WAVES {
        let shadowed = decision.predicted_shadowed;
        found.push(Warning::WavesBounceOnce { theta_i, shadowed, unfollowed: decision.unfollowed });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_carry_numbers_and_advice() {
        let theta_i = 85f64.to_radians();
        for (warning, parts) in [
            (
                Warning::AngleMissing { g: 0.3, theta_i, nearest: 60f64.to_radians() },
                ["At 85 deg", "to 60 deg", "Add 85 to --theta-i"],
            ),
            (
                Warning::HeightsInSteps { step: 7.45e-9, glint_spacing: 0.034, theta_i, value: 2.0, spread: 1.9 },
                ["7.45 nm", "1.95 deg apart", "(-5.0 %)"],
            ),
            (Warning::NoImage { doi: -38.0, standard_error: 20.0 }, ["-38.00 +- 20.00", "0 to 100", "no image"]),
        ] {
            let text = warning.to_string();
            assert!(parts.iter().all(|p| text.contains(p)) && text.ends_with('.') && warning.is_doubt(), "{text}");
        }
    }

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
