//! Directions in the surface frame: z is the mean normal, `phi` is measured about +z from +x.

pub use glam::DVec3;

/// `(sin theta cos phi, sin theta sin phi, cos theta)`, angles in radians.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (st, ct) = theta.sin_cos();
    let (sp, cp) = phi.sin_cos();
    DVec3::new(st * cp, st * sp, ct)
}

/// `theta` of a unit vector, in radians; `atan2`, because `acos` cannot resolve small angles.
pub fn theta(w: DVec3) -> f64 {
    w.x.hypot(w.y).atan2(w.z)
}

/// `phi` of a vector in `[0, 2 pi)`; 0 on the axis.
pub fn phi(w: DVec3) -> f64 {
    let p = w.y.atan2(w.x);
    if p < 0.0 {
        // A tiny negative angle rounds to exactly 2 pi, which belongs to 0.
        let q = p + std::f64::consts::TAU;
        if q >= std::f64::consts::TAU { 0.0 } else { q }
    } else {
        p
    }
}

/// `wh = (wi + wo) / |wi + wo|`; the mean normal if the two cancel.
#[inline]
pub fn half_vector(wi: DVec3, wo: DVec3) -> DVec3 {
    (wi + wo).try_normalize().unwrap_or(DVec3::Z)
}

/// `o = 2 (n.i) n - i`: mirror image of `i` about the unit normal `n`.
#[inline]
pub fn reflect(i: DVec3, n: DVec3) -> DVec3 {
    2.0 * i.dot(n) * n - i
}

/// Unit normal of a facet with slopes `p = dh/dx`, `q = dh/dy`: `(-p, -q, 1) / sqrt(1 + p^2 + q^2)`.
#[inline]
pub fn normal_of_slope(p: f64, q: f64) -> DVec3 {
    DVec3::new(-p, -q, 1.0) / (1.0 + p * p + q * q).sqrt()
}

/// Slopes `(p, q) = (-wh.x, -wh.y) / wh.z` of the facet whose normal is `wh` (`wh.z > 0`).
#[inline]
pub fn slope_of_half_vector(wh: DVec3) -> (f64, f64) {
    (-wh.x / wh.z, -wh.y / wh.z)
}

/// Two unit vectors that complete the unit vector `n` to a right-handed frame `(t, b, n)`.
///
/// Source: Duff et al., J. Computer Graphics Techniques 6(1), 2017.
pub fn tangents(n: DVec3) -> (DVec3, DVec3) {
    n.any_orthonormal_pair()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_round_trip() {
        for &(t, p) in &[(0.3, 0.0), (1e-7, 2.0), (1.5, 6.2), (0.7, 3.3)] {
            let w = direction(t, p);
            assert!((theta(w) - t).abs() < 1e-14);
            assert!((phi(w) - p).abs() < 1e-8);
        }
        assert_eq!(phi(DVec3::new(1.0, -1e-300, 0.0)), 0.0);
    }

    #[test]
    fn half_vector_slopes_invert_the_normal() {
        let n = normal_of_slope(0.3, -0.1);
        let i = direction(0.5, 1.0);
        let o = reflect(i, n);
        let (p, q) = slope_of_half_vector(half_vector(i, o));
        assert!((p - 0.3).abs() < 1e-14 && (q + 0.1).abs() < 1e-14);
    }
}
