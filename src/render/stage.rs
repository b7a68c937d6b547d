//! The scene in which tiles are compared: a tile on a matt table, a lit pattern at its far edge, a small lamp.
//!
//! ```text
//!                        o lamp
//!   camera                    |  pattern: fine checker
//!       `-._                  |           bars
//!           `-._ 35 deg       |           coarse checker
//!   ------------[== tile ====]|------- table
//! ```
//! x to the right, y away from the camera, z up, metres; the top of the tile is z = 0. The camera sees the pattern
//! in the mirror of the tile, and of the pattern itself only a strip along its foot: glass reflects a tenth or less,
//! so a picture that shows the mirror image well must over-expose what it mirrors.

use super::camera::Camera;
use super::material::Material;
use super::paint::{Paint, Pattern};
use super::scene::Scene;
use super::shape::{Quad, Sphere};
use crate::error::Result;
use crate::math::frame::DVec3;
use crate::model::Lambert;
use crate::optics::brdf::Brdf;

/// The matt furniture; its colour is the tint of the material.
const WHITE: Lambert = Lambert { rho: 1.0 };

/// Angle between the line of sight to the middle of the tile and the normal \[deg\].
pub(super) const VIEW_ANGLE_DEG: f64 = 55.0;

const MM: f64 = 1e-3;
/// The tile [m]: nearly square when seen at 55 deg.
const WIDTH: f64 = 60.0 * MM;
const DEPTH: f64 = 120.0 * MM;
const THICKNESS: f64 = 4.0 * MM;
/// Radiance of the bright cells and of the lamp [W/(m2 sr)].
const PATTERN_RADIANCE: f64 = 10.0;
const LAMP_RADIANCE: f64 = 40.0;

/// The top face of the tile.
pub(super) fn tile_top() -> Result<Quad> {
    Quad::new(DVec3::new(-WIDTH / 2.0, 0.0, 0.0), WIDTH * DVec3::X, DEPTH * DVec3::Y)
}

/// The camera for a picture of the given width over height.
pub(super) fn camera(aspect: f64) -> Result<Camera> {
    let distance = 700.0 * MM;
    let (sin, cos) = VIEW_ANGLE_DEG.to_radians().sin_cos();
    // A little before the middle: less of the over-exposed strip, and the front edge in full.
    let target = DVec3::new(0.0, 0.45 * DEPTH, 0.0);
    let eye = target + distance * DVec3::new(0.0, -sin, cos);
    // The frame is as wide as the tile with a margin of table.
    let half_height = 38.0 * MM / aspect;
    Camera::perspective(eye, target, DVec3::Z, 2.0 * (half_height / distance).atan(), aspect)
}

/// The scene with a tile of the given material.
pub(super) fn scene(tile: &dyn Brdf) -> Result<Scene<'_>> {
    let mut scene = Scene::new(DVec3::splat(0.12))?;
    scene.add(tile_top()?, Material { brdf: tile, tint: Paint::plain(DVec3::ONE)? });
    add_table(&mut scene)?;
    add_pattern(&mut scene)?;
    let lamp = Sphere::new(DVec3::new(0.0, 100.0 * MM, 66.0 * MM), 5.0 * MM)?;
    scene.add_emitter(lamp, Paint::plain(LAMP_RADIANCE * DVec3::new(1.0, 0.93, 0.80))?)?;
    Ok(scene)
}

/// The table and the front edge of the tile.
fn add_table(scene: &mut Scene<'_>) -> Result<()> {
    let cloth = Material { brdf: &WHITE, tint: Paint::plain(DVec3::new(0.13, 0.17, 0.22))? };
    let side = Material { brdf: &WHITE, tint: Paint::plain(DVec3::splat(0.03))? };
    let table = Quad::new(DVec3::new(-1.0, -1.0, -THICKNESS), 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
    scene.add(table, cloth);
    // The camera sees the front edge only.
    scene.add(Quad::new(-WIDTH / 2.0 * DVec3::X, WIDTH * DVec3::X, -THICKNESS * DVec3::Z)?, side);
    Ok(())
}

/// Three bands, coarse at the foot where even a rough tile mirrors well, fine at the top; one is not periodic.
fn add_pattern(scene: &mut Scene<'_>) -> Result<()> {
    let bright = PATTERN_RADIANCE * DVec3::ONE;
    let dark = 0.002 * bright;
    // Lower edge, height and width in mm; dark gaps keep the bands apart.
    let bands = [
        (0.0, 28.0, 98.0, Pattern::Checker { columns: 7, rows: 2 }),
        (31.0, 15.0, 74.0, Pattern::Bars { count: 8, ratio: 0.8 }),
        (49.0, 14.0, 101.5, Pattern::Checker { columns: 29, rows: 4 }),
    ];
    for (foot, height, width, pattern) in bands {
        let (across, up) = (width * MM * DVec3::X, height * MM * DVec3::Z);
        let corner = DVec3::new(0.0, DEPTH + 2.0 * MM, foot * MM - THICKNESS) - 0.5 * across;
        // X x Z looks towards the camera.
        scene.add_emitter(Quad::new(corner, across, up)?, Paint::new(pattern, bright, dark)?)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tile_is_seen_at_the_stated_angle() {
        let ray = camera(0.9).unwrap().ray(0.5, 0.5);
        let cos = -ray.direction.z;
        assert!((cos.acos().to_degrees() - VIEW_ANGLE_DEG).abs() < 1e-9);
        let t = tile_top().unwrap().intersect(&ray, f64::INFINITY).unwrap();
        assert!((ray.at(t) - DVec3::new(0.0, 0.054, 0.0)).length() < 1e-12);
    }
}
