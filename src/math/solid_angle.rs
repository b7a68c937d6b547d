//! Solid angles of the shapes that instruments look through.

use super::frame::DVec3;

/// `4 asin(sin(a/2) sin(b/2))`: solid angle \[sr\] of a gnomonic rectangle with full plane angles `a`, `b` \[rad\].
pub fn rectangle(a: f64, b: f64) -> f64 {
    4.0 * ((a / 2.0).sin() * (b / 2.0).sin()).asin()
}

/// `(sin^2 t2 - sin^2 t1) (p2 - p1) / 2`: projected solid angle \[sr\] of a theta-phi bin, angles in radians.
pub fn projected_bin(theta_1: f64, theta_2: f64, phi_1: f64, phi_2: f64) -> f64 {
    (theta_2.sin().powi(2) - theta_1.sin().powi(2)) * (phi_2 - phi_1) / 2.0
}

/// A rectangle of directions about `axis`, flat in the focal plane of a lens (gnomonic), as the
/// field stops of a glossmeter are.
#[derive(Debug, Clone, Copy)]
pub struct RectangularAperture {
    axis: DVec3,
    /// Unit vector in the plane of measurement, perpendicular to `axis`.
    in_plane: DVec3,
    across: DVec3,
    /// Tangent of half the full plane angle, in plane and across.
    half: [f64; 2],
}

impl RectangularAperture {
    /// Aperture centred on `(theta, phi)`; `width` in the plane through z and the axis, `height` across it. All in radians.
    pub fn new(theta: f64, phi: f64, width: f64, height: f64) -> Self {
        let (st, ct) = theta.sin_cos();
        let (sp, cp) = phi.sin_cos();
        RectangularAperture {
            axis: DVec3::new(st * cp, st * sp, ct),
            in_plane: DVec3::new(ct * cp, ct * sp, -st),
            across: DVec3::new(-sp, cp, 0.0),
            half: [(width / 2.0).tan(), (height / 2.0).tan()],
        }
    }

    /// Whether the direction `w` passes through the aperture.
    pub fn contains(&self, w: DVec3) -> bool {
        let z = w.dot(self.axis);
        z > 0.0 && w.dot(self.in_plane).abs() <= self.half[0] * z && w.dot(self.across).abs() <= self.half[1] * z
    }

    /// Axis, unit vector in the plane of measurement, unit vector across it.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.axis, self.in_plane, self.across]
    }

    /// Tangent of half the full plane angle, in plane and across.
    pub fn half_tangents(&self) -> [f64; 2] {
        self.half
    }

    /// Inward normals of the four planes through the origin that bound the aperture: `w` passes if no `n . w` is negative.
    pub fn edges(&self) -> [DVec3; 4] {
        let [a, b] = self.half.map(|half| half * self.axis);
        [a - self.in_plane, a + self.in_plane, b - self.across, b + self.across]
    }

    /// Direction through the plane point `u` in `[0, 1]^2` and the density of that map per steradian
    /// for uniform `u`: `1 / (A cos^3 a)` with `A` the plane area and `a` the angle to the axis.
    pub fn direction(&self, u: [f64; 2]) -> (DVec3, f64) {
        let x = (2.0 * u[0] - 1.0) * self.half[0];
        let y = (2.0 * u[1] - 1.0) * self.half[1];
        let w = (self.axis + x * self.in_plane + y * self.across).normalize();
        (w, self.density(w))
    }

    /// Density per steradian of [`Self::direction`] at `w`; 0 outside the aperture.
    pub fn density(&self, w: DVec3) -> f64 {
        if !self.contains(w) {
            return 0.0;
        }
        let cos = w.dot(self.axis);
        1.0 / (4.0 * self.half[0] * self.half[1] * cos * cos * cos)
    }

    /// Solid angle of the aperture \[sr\].
    pub fn solid_angle(&self) -> f64 {
        rectangle(2.0 * self.half[0].atan(), 2.0 * self.half[1].atan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::gauss_legendre;

    /// TV14 and TV15: receptor solid angles of the three gloss geometries.
    #[test]
    fn receptors_have_the_published_solid_angles() {
        let cases = [
            (20.0, 1.8, 3.6, 1.97351511945e-3, 1.8541163752e-3),
            (60.0, 4.4, 11.7, 1.56506661342e-2, 7.8098504152e-3),
            (85.0, 4.0, 6.0, 7.30599819155e-3, 6.3633978655e-4),
        ];
        let rule = gauss_legendre(24);
        for (angle, a, b, omega, projected) in cases {
            let r = |x: f64| f64::to_radians(x);
            let aperture = RectangularAperture::new(r(angle), 0.0, r(a), r(b));
            assert!((aperture.solid_angle() - omega).abs() < 1e-12);
            let (mut sum, mut sum_projected) = (0.0, 0.0);
            for &(x, wx) in &rule {
                for &(y, wy) in &rule {
                    let (w, density) = aperture.direction([(x + 1.0) / 2.0, (y + 1.0) / 2.0]);
                    sum += wx * wy / 4.0 / density;
                    sum_projected += wx * wy / 4.0 / density * w.z.max(0.0);
                }
            }
            assert!((sum - omega).abs() < 1e-12, "{sum} {omega}");
            assert!((sum_projected - projected).abs() < 1e-10);
        }
    }
}
