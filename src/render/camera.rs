//! Where the picture is seen from.

use super::shape::Ray;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;

/// A pinhole or a parallel projection onto a rectangle of `width / height = aspect`.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    eye: DVec3,
    forward: DVec3,
    /// Half extents of the picture: lengths at unit distance for a pinhole, metres for a parallel projection.
    right: DVec3,
    up: DVec3,
    parallel: bool,
}

impl Camera {
    /// A pinhole at `eye` looking at `target`; `field` is the full vertical field of view \[rad\].
    ///
    /// # Errors
    /// `Error::Parameter` if the view is not defined (eye at target, `up` along the view, field outside `(0, pi)`).
    pub fn perspective(eye: DVec3, target: DVec3, up: DVec3, field: f64, aspect: f64) -> Result<Self> {
        if !(field > 0.0 && field < std::f64::consts::PI) {
            return Err(Error::parameter(
                format!("a field of view of {} deg is not possible", field.to_degrees()),
                "choose an angle above 0 and below 180 degrees",
            ));
        }
        Self::oriented(eye, target, up, (field / 2.0).tan(), aspect, false)
    }

    /// A parallel projection along `target - eye` that shows `height` metres from bottom to top.
    ///
    /// # Errors
    /// As [`Self::perspective`]; `height` must be above 0.
    pub fn orthographic(eye: DVec3, target: DVec3, up: DVec3, height: f64, aspect: f64) -> Result<Self> {
        Self::oriented(eye, target, up, height / 2.0, aspect, true)
    }

    fn oriented(eye: DVec3, target: DVec3, up: DVec3, half: f64, aspect: f64, parallel: bool) -> Result<Self> {
        let refuse = |what: &str, advice: &str| Err(Error::parameter(what, advice));
        let Some(forward) = (target - eye).try_normalize() else {
            return refuse("the camera stands in the point it looks at", "move the eye or the target");
        };
        let Some(right) = forward.cross(up).try_normalize() else {
            return refuse("the camera looks along its up direction", "choose another up direction, such as y");
        };
        if !(half > 0.0 && half.is_finite() && aspect > 0.0 && aspect.is_finite()) {
            return refuse("the picture of the camera has no area", "give a height and an aspect ratio above 0");
        }
        let up = right.cross(forward);
        Ok(Camera { eye, forward, right: half * aspect * right, up: half * up, parallel })
    }

    /// Where it stands; for a parallel projection the middle of the picture.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The ray through the picture point `(x, y)` in `[0, 1]^2`, x to the right and y downwards.
    #[inline(always)]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let ray = self.line(x, y);
        Ray { direction: ray.direction.normalize(), ..ray }
    }

    /// As [`Self::ray`], with a direction of any length.
    #[inline(always)]
    pub(super) fn line(&self, x: f64, y: f64) -> Ray {
        let shift = (2.0 * x - 1.0) * self.right + (1.0 - 2.0 * y) * self.up;
        if self.parallel {
            Ray { origin: self.eye + shift, direction: self.forward }
        } else {
            Ray { origin: self.eye, direction: self.forward + shift }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_through_the_corners_of_the_picture() {
        let field = std::f64::consts::FRAC_PI_2;
        let camera = Camera::perspective(DVec3::ZERO, DVec3::Y, DVec3::Z, field, 2.0).unwrap();
        let top_left = camera.ray(0.0, 0.0).direction;
        assert!((top_left - DVec3::new(-2.0, 1.0, 1.0).normalize()).length() < 1e-15);
        assert!((camera.ray(0.5, 0.5).direction - DVec3::Y).length() < 1e-15);
        let parallel = Camera::orthographic(DVec3::ZERO, -DVec3::Z, DVec3::Y, 4.0, 0.5).unwrap();
        let bottom_right = parallel.ray(1.0, 1.0);
        assert!((bottom_right.origin - DVec3::new(1.0, -2.0, 0.0)).length() < 1e-15);
        assert_eq!(bottom_right.direction, -DVec3::Z);
    }

    #[test]
    fn undefined_views_are_refused() {
        let (o, z) = (DVec3::ZERO, DVec3::Z);
        assert!(Camera::perspective(o, o, z, 1.0, 1.0).is_err());
        assert!(Camera::perspective(o, z, z, 1.0, 1.0).is_err());
        assert!(Camera::perspective(o, z, DVec3::Y, 4.0, 1.0).is_err());
        assert!(Camera::perspective(o, z, DVec3::Y, 1.0, 0.0).is_err());
        assert!(Camera::orthographic(o, z, DVec3::Y, f64::NAN, 1.0).is_err());
    }
}
