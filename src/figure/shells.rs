//! Figure 14: two automotive shells with first surfaces of different gloss over one metallic base.

use super::finish::{Finish, View};
use super::meters::{coat, coat_of_gloss, read};
use super::paint::{BLUE, Paint};
use super::shell::{add_backdrop, car_shell, wheels_of};
use super::vases::facing_stage;
use crate::error::Result;
use crate::model::{Lambert, Layered, metallic::Metallic};
use crate::render::{Coat, Cover, Paint as Radiance, Reflector, Scene};
use glam::{DAffine3, DVec3};

static WHITE: Lambert = Lambert { rho: 1.0 };
const GLOSS: [f64; 2] = [10.0, 60.0];
const BASE: Paint = BLUE;
const SPACING: f64 = 0.50;
/// The nose turns towards the camera.
const YAW_DEG: f64 = 38.0;

/// Where it is seen from.
pub const VIEW: View = View { eye: DVec3::new(0.0, -1.75, 0.62), target: DVec3::new(0.0, 0.0, 0.062), field: 0.56 };
/// Width over height.
pub const ASPECT: f64 = 2.35;

/// The middle of a shell on the floor.
pub fn middle(k: usize) -> DVec3 {
    DVec3::new((k as f64 - 0.5) * SPACING, 0.0, 0.0)
}

/// First surfaces solved by the meter, over the base.
pub fn finishes(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let mut list = Vec::new();
    for (k, wanted) in GLOSS.into_iter().enumerate() {
        let first = coat_of_gloss(wanted)?;
        // What the meter reads on both layers, by the luminance of the base.
        let whole = Layered::new(coat(first.alpha)?, Box::new(Metallic::new(BASE.luminance())));
        let [total, _] = read(&whole)?;
        let lines = vec![
            format!("first-surface 20\u{b0} gloss {:.1}", first.gloss.value),
            format!("Beckmann alpha {:.4}, n 1.5", first.alpha),
            format!("20\u{b0} gloss with the base {:.1}", total.value),
        ];
        list.push((Finish::Colour(BASE.flakes.coated(first.brdf)), lines));
        progress((k + 1) as f64 / GLOSS.len() as f64);
    }
    Ok(list)
}

/// Two shells under the light bars of an inspection bay.
pub fn scene(finishes: &[Finish]) -> Result<Scene<'_>> {
    let mut scene = Scene::new(DVec3::splat(0.16))?;
    let matt = |rho: f64| Coat::new(Reflector::Grey(&WHITE), DVec3::splat(rho));
    add_backdrop(&mut scene, 1.6, matt(0.40))?;
    let shell = car_shell()?;
    let turn = DAffine3::from_rotation_z(YAW_DEG.to_radians());
    let places: Vec<DAffine3> = (0..finishes.len()).map(|k| DAffine3::from_translation(middle(k)) * turn).collect();
    for (place, finish) in places.iter().zip(finishes) {
        scene.add(shell.transformed(place)?, Cover::Plain(finish.coat()));
    }
    let (tyres, hubs) = wheels_of(&places)?;
    scene.add(tyres, Cover::Plain(matt(0.035)));
    hubs.into_iter().for_each(|hub| scene.add(hub, Cover::Plain(matt(0.5))));
    // Bars across the line of sight, from before to behind the shells.
    for k in 0..3 {
        let y = -0.8 + 0.6 * f64::from(k);
        let bar = facing_stage(DVec3::new(-1.3, y, 1.15), 2.6 * DVec3::X, 0.14 * DVec3::Y)?;
        scene.add_emitter(bar, Radiance::plain(13.0 * DVec3::new(1.0, 0.99, 0.96))?)?;
    }
    // A window to the left.
    let window = facing_stage(DVec3::new(-1.7, -1.2, 0.15), DVec3::new(0.35, -0.75, 0.0), 0.8 * DVec3::Z)?;
    scene.add_emitter(window, Radiance::plain(6.0 * DVec3::new(0.92, 0.96, 1.0))?)?;
    Ok(scene)
}
