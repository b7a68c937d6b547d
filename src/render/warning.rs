//! What a picture may hide: said in full sentences.

use super::camera::Camera;
use super::film::Film;
use super::scene::Scene;
use crate::math::frame::DVec3;
use std::fmt;

/// Something that makes a picture other than it should be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RenderWarning {
    /// The camera is inside closed shapes.
    CameraInside(Vec<String>),
    /// Neither lamps nor sky.
    NothingShines,
    /// No pixel has any radiance, although something shines.
    Black,
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenderWarning::CameraInside(names) => write!(
                f,
                "The camera is inside {}: it sees the inner side and nothing beyond. Move the camera or the shape.",
                names.join(" and ")
            ),
            RenderWarning::NothingShines => write!(
                f,
                "Nothing shines: the scene has neither lamps nor a sky, so the picture is black. Give a shape a radiance, or \
                 the sky."
            ),
            RenderWarning::Black => write!(
                f,
                "The picture is black although something shines: no path from the camera met light. Lamps shine from their \
                 front only; check which way they and the camera look, and the depth."
            ),
        }
    }
}

impl RenderWarning {
    /// What can be said before rendering.
    pub fn of_scene(scene: &Scene, camera: &Camera) -> Vec<RenderWarning> {
        let mut warnings = Vec::new();
        let inside = scene.around(camera.eye());
        if !inside.is_empty() {
            warnings.push(RenderWarning::CameraInside(inside));
        }
        if scene.sky == DVec3::ZERO && scene.lights.len() == 0 {
            warnings.push(RenderWarning::NothingShines);
        }
        warnings
    }

    /// What can be said of the picture, after those of the scene.
    pub fn of_film(film: &Film, scene: &Scene) -> Option<RenderWarning> {
        let shines = scene.sky != DVec3::ZERO || scene.lights.len() > 0;
        let black = film.pixels().iter().all(|p| p.radiance == [0.0; 3]);
        (black && shines).then_some(RenderWarning::Black)
    }
}
