//! Figure 7: four spheres of rising gloss on a chequered floor under six lamps.

use super::epoxy::{Map, WAVELENGTH, table};
use super::finish::{Finish, View};
use crate::error::Result;
use crate::meter::{Geometry, Options, gloss};
use crate::model::Lambert;
use crate::optics::Material;
use crate::render::{Camera, Coat, Cover, Paint, Quad, Reflector, Scene, Sphere};
use glam::DVec3;

static WHITE: Lambert = Lambert { rho: 1.0 };

/// Roughness of the spheres from left to right.
const MAPS: [Map; 4] = [
    Map { sq: 2.4e-6, seed: 11 },
    Map { sq: 0.95e-6, seed: 12 },
    Map { sq: 0.4e-6, seed: 13 },
    Map { sq: 0.15e-6, seed: 14 },
];
const RADIUS: f64 = 0.85;
const SPACING: f64 = 1.95;
const LAMP_RADIANCE: f64 = 12.0;

/// Where it is seen from.
pub const VIEW: View = View { eye: DVec3::new(0.0, -8.2, 2.75), target: DVec3::new(0.0, 0.0, 0.66), field: 0.94 };
/// Width over height.
pub const ASPECT: f64 = 2.5;

/// Tables of the four surfaces, all of aluminium, and a caption for each.
pub fn finishes(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let aluminium = Material::parse("al", WAVELENGTH)?;
    let mut list = Vec::new();
    for (k, map) in MAPS.into_iter().enumerate() {
        let part = |done: f64| progress((k as f64 + done) / MAPS.len() as f64);
        let brdf = table(map, aluminium, &part)?;
        let g60 = gloss(&brdf, &Geometry::gloss60(), &Options::default());
        let lines = vec![format!("Sq {:.2} \u{b5}m", map.sq * 1e6), format!("60\u{b0} gloss {:.0} GU", g60.value)];
        list.push((Finish::Grey(Box::new(brdf)), lines));
    }
    Ok(list)
}

/// Centre of a sphere.
pub fn centre(k: usize) -> DVec3 {
    DVec3::new((k as f64 - 1.5) * SPACING, 0.0, RADIUS)
}

/// Which sphere a ray of the camera meets in the picture point `(x, y)`: spheres do not hide each other.
pub fn sphere_at(camera: &Camera, x: f64, y: f64) -> Option<usize> {
    let ray = camera.ray(x, y);
    (0..MAPS.len()).find(|&k| Sphere::new(centre(k), RADIUS).is_ok_and(|s| s.intersect(&ray, f64::INFINITY).is_some()))
}

/// A room of matt walls with the spheres in it.
pub fn scene(finishes: &[Finish]) -> Result<Scene<'_>> {
    let mut scene = Scene::new(DVec3::ZERO)?;
    let matt = |r, g, b| Coat::new(Reflector::Grey(&WHITE), DVec3::new(r, g, b));
    for (k, finish) in finishes.iter().enumerate() {
        scene.add(Sphere::new(centre(k), RADIUS)?, Cover::Plain(finish.coat()));
    }
    // x and y of the room, height.
    let ([left, right], [near, far], height) = ([-8.0, 8.0], [-11.0, 6.0], 5.5);
    let corner = DVec3::new(left, near, 0.0);
    let (x, y, z) = ((right - left) * DVec3::X, (far - near) * DVec3::Y, height * DVec3::Z);
    let tiles = [matt(0.72, 0.70, 0.64), matt(0.07, 0.08, 0.10)];
    scene.add(Quad::new(corner, x, y)?, Cover::Checker(tiles, 0.625));
    let walls = Cover::Plain(matt(0.36, 0.41, 0.48));
    for (at, u, v) in [(corner + y, x, z), (corner, x, z), (corner, y, z), (corner + x, y, z)] {
        scene.add(Quad::new(at, u, v)?, walls);
    }
    scene.add(Quad::new(corner + z, x, y)?, Cover::Plain(matt(0.50, 0.50, 0.50)));
    for (x, y) in [(-4.2, -3.4), (0.0, -3.6), (4.2, -3.4), (-4.2, 1.6), (0.0, 1.8), (4.2, 1.6)] {
        let lamp = Sphere::new(DVec3::new(x, y, 4.5), 0.62)?;
        scene.add_emitter(lamp, Paint::plain(LAMP_RADIANCE * DVec3::new(1.0, 0.94, 0.84))?)?;
    }
    Ok(scene)
}
