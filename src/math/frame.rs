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

/// Added to a small number it leaves the whole part in the last bits.
const ROUNDING: f64 = 1.5 * (1u64 << 52) as f64;

/// `(sin, cos)` of `2 pi turns` for `turns` in `[0, 1]`, to 3e-16: the few operations that drawing a direction can afford.
///
/// Taylor series about the nearest quarter turn, `|x| <= pi / 4`.
#[inline(always)]
pub fn sin_cos_turns(turns: f64) -> (f64, f64) {
    // Whole quarter turns end up in the last bits: a conversion to integers would keep lanes apart.
    let shifted = 4.0 * turns + ROUNDING;
    let x = (turns - 0.25 * (shifted - ROUNDING)) * std::f64::consts::TAU;
    let y = x * x;
    // Even and odd powers of y side by side.
    let y2 = y * y;
    let y4 = y2 * y2;
    let s_low = (1.0 - y * (1.0 / 6.0)) + y2 * (1.0 / 120.0 - y * (1.0 / 5040.0));
    let s_high =
        (1.0 / 362_880.0 - y * (1.0 / 39_916_800.0)) + y2 * (1.0 / 6_227_020_800.0 - y * (1.0 / 1_307_674_368_000.0));
    let c_low = (1.0 - y * 0.5) + y2 * (1.0 / 24.0 - y * (1.0 / 720.0));
    let c_high = (1.0 / 40_320.0 - y * (1.0 / 3_628_800.0)) + y2 * (1.0 / 479_001_600.0 - y * (1.0 / 87_178_291_200.0));
    let (s, c) = (x * (s_low + y4 * s_high), c_low + y4 * (c_high + y4 * (1.0 / 20_922_789_888_000.0)));
    // A quarter turn takes (s, c) to (c, -s). By products: where a direction falls is random, and no branch could be foreseen.
    let (bits, one) = (shifted.to_bits(), 1f64.to_bits());
    let odd = f64::from_bits(one & (bits & 1).wrapping_neg());
    let (even, sign) = (1.0 - odd, f64::from_bits(one | (bits & 2) << 62));
    (sign * (even * s + odd * c), sign * (even * c - odd * s))
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
    fn turns_have_the_sines_of_their_angles() {
        for k in 0..=100_000 {
            let turns = f64::from(k) / 100_000.0;
            let ((s, c), (sin, cos)) = (sin_cos_turns(turns), (std::f64::consts::TAU * turns).sin_cos());
            assert!((s - sin).abs() < 1e-15 && (c - cos).abs() < 1e-15, "{turns}: {s} {sin} {c} {cos}");
        }
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
