//! Solid angles of the shapes that instruments look through.

/// `4 asin(sin(a/2) sin(b/2))`: solid angle \[sr\] of a gnomonic rectangle with full plane angles `a`, `b` \[rad\].
pub fn rectangle(a: f64, b: f64) -> f64 {
    4.0 * ((a / 2.0).sin() * (b / 2.0).sin()).asin()
}

/// `(sin^2 t2 - sin^2 t1) (p2 - p1) / 2`: projected solid angle \[sr\] of a theta-phi bin, angles in radians.
pub fn projected_bin(theta_1: f64, theta_2: f64, phi_1: f64, phi_2: f64) -> f64 {
    (theta_2.sin().powi(2) - theta_1.sin().powi(2)) * (phi_2 - phi_1) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// TV14: receptor solid angles of the three gloss geometries.
    #[test]
    fn rectangles_have_the_published_solid_angles() {
        let r = |x: f64| f64::to_radians(x);
        for (a, b, omega) in [(1.8, 3.6, 1.97351511945e-3), (4.4, 11.7, 1.56506661342e-2), (4.0, 6.0, 7.30599819155e-3)]
        {
            assert!((rectangle(r(a), r(b)) - omega).abs() < 1e-12);
        }
    }

    #[test]
    fn a_hemisphere_projects_to_pi() {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        assert!((projected_bin(0.0, FRAC_PI_2, 0.0, TAU) - PI).abs() < 1e-14);
    }
}
