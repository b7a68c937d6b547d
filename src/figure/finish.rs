//! What the bodies of a figure are covered with, and from where they are seen.

use crate::error::Result;
use crate::optics::Brdf;
use crate::render::{Camera, Coat, Reflector, Spectral};
use glam::DVec3;

/// A reflector that a figure owns.
pub enum Finish {
    Grey(Box<dyn Brdf>),
    Colour(Spectral),
}

impl Finish {
    /// It as the renderer takes it.
    pub fn coat(&self) -> Coat<'_> {
        let reflector = match self {
            Finish::Grey(brdf) => Reflector::Grey(brdf.as_ref()),
            Finish::Colour(spectral) => Reflector::Spectral(spectral),
        };
        Coat::new(reflector, DVec3::ONE)
    }

    /// The reflector, if it is the same in all colours.
    pub fn grey(&self) -> Option<&dyn Brdf> {
        match self {
            Finish::Grey(brdf) => Some(brdf.as_ref()),
            Finish::Colour(_) => None,
        }
    }
}

/// A pinhole camera, upright.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub eye: DVec3,
    pub target: DVec3,
    /// Full horizontal field of view \[rad\].
    pub field: f64,
}

impl View {
    /// The camera for a picture of the given width over height.
    ///
    /// # Errors
    /// `Error::Parameter` if the view is not defined.
    pub fn camera(&self, aspect: f64) -> Result<Camera> {
        let vertical = 2.0 * ((0.5 * self.field).tan() / aspect).atan();
        Camera::perspective(self.eye, self.target, DVec3::Z, vertical, aspect)
    }

    /// Column in which a point is seen, from 0 at the left edge of the picture to 1 at the right.
    pub fn column(&self, point: DVec3) -> f64 {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let from = point - self.eye;
        0.5 + 0.5 * from.dot(right) / (from.dot(forward) * (0.5 * self.field).tan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_where_the_camera_sees_the_point() {
        let view = View { eye: DVec3::new(1.0, -5.0, 2.0), target: DVec3::new(0.5, 0.0, 0.3), field: 0.7 };
        let camera = view.camera(1.7).unwrap();
        for (x, y) in [(0.1, 0.4), (0.5, 0.9), (0.83, 0.2)] {
            let ray = camera.ray(x, y);
            assert!((view.column(ray.at(4.0)) - x).abs() < 1e-12);
        }
    }
}
