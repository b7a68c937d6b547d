//! A BRDF cut by the plane of incidence: the angles to look at, the values there, and colours for several cuts.

use super::raster::Colour;
use crate::math::direction;
use crate::optics::Brdf;
use std::f64::consts::PI;

/// Lines told apart by every kind of colour vision (Okabe and Ito 2008), dark enough for white paper.
pub const SERIES: [Colour; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 130, 95], [170, 70, 130], [45, 150, 210], [190, 130, 0], [70, 70, 70]];

/// Colour of series number `k`.
pub fn series_colour(k: usize) -> Colour {
    SERIES[k % SERIES.len()]
}

/// Half-degree steps over the plane of incidence.
const STEPS: i32 = 356;
/// Angles on either side of the mirror direction, by equal ratios from a thousandth of a degree.
const NEAR: i32 = 90;

/// Polar angles `theta_r` \[rad\] in the plane of incidence, rising, -89 to 89 deg, positive on the side of the mirror
/// direction of `theta_i`, and crowded towards it, so that a lobe of any width is seen.
pub fn in_plane_angles(theta_i: f64) -> Vec<f64> {
    let limit = 89f64.to_radians();
    let even = (0..=STEPS).map(|k| limit * (2.0 * f64::from(k) / f64::from(STEPS) - 1.0));
    let near = (0..=NEAR).flat_map(|k| {
        let offset = 1e-3f64.to_radians() * 10f64.powf(4.3 * f64::from(k) / f64::from(NEAR));
        [theta_i - offset, theta_i + offset]
    });
    let mut angles: Vec<f64> = even.chain(near).chain([theta_i]).filter(|t| t.abs() <= limit).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles
}

/// `(theta_r, f_r)` of a source lit from `(theta_i, phi_i)`, [rad] and [1/sr], at [`in_plane_angles`].
pub fn slice(brdf: &dyn Brdf, theta_i: f64, phi_i: f64) -> Vec<(f64, f64)> {
    let wi = direction(theta_i, phi_i);
    let value = |t: f64| {
        let wo = if t >= 0.0 { direction(t, phi_i + PI) } else { direction(-t, phi_i) };
        brdf.eval(wi, wo)
    };
    in_plane_angles(theta_i).into_iter().map(|t| (t, value(t))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;

    #[test]
    fn the_peak_of_a_narrow_lobe_is_on_the_slice() {
        let brdf = model::parse("ward:rho_s=1,alpha=0.001", 550e-9).unwrap();
        let theta_i = 0.7;
        let peak = brdf.eval(direction(theta_i, 1.0), direction(theta_i, 1.0 + PI));
        let cut = slice(brdf.as_ref(), theta_i, 1.0);
        let highest = cut.iter().copied().fold((0.0, 0.0), |m, p| if p.1 > m.1 { p } else { m });
        assert!((highest.1 / peak - 1.0).abs() < 1e-6 && (highest.0 - theta_i).abs() < 1e-3);
        assert!(cut.windows(2).all(|p| p[0].0 < p[1].0));
        // Neighbours within the lobe, so that it is a curve and not a spike.
        assert!(cut.iter().filter(|p| p.1 > 0.1 * peak).count() > 20);
    }
}
