//! Figures 9 and 13: vases of metallic paint before a plain backdrop.

use super::finish::{Finish, View};
use super::paint::{BLUE, GOLD, RED};
use super::shell::add_backdrop;
use crate::error::Result;
use crate::math::Estimate;
use crate::meter::appearance::flop_index;
use crate::meter::{Options, standards};
use crate::model::{self, Lambert};
use crate::optics::Brdf;
use crate::optics::colour::lab;
use crate::render::{Coat, Cover, Paint, Quad, Reflector, Scene, revolution};
use glam::{DAffine3, DVec3};

static WHITE: Lambert = Lambert { rho: 1.0 };

/// Outline of a vase `[r, z]` \[m\], from the foot over the lip into the neck.
const PROFILE: [[f64; 2]; 19] = [
    [0.0, 0.0],
    [0.040, 0.0],
    [0.046, 0.004],
    [0.050, 0.016],
    [0.066, 0.050],
    [0.086, 0.100],
    [0.094, 0.140],
    [0.090, 0.178],
    [0.072, 0.215],
    [0.049, 0.245],
    [0.037, 0.270],
    [0.036, 0.290],
    [0.043, 0.308],
    [0.056, 0.322],
    [0.0565, 0.3245],
    [0.054, 0.3245],
    [0.041, 0.309],
    [0.033, 0.288],
    [0.033, 0.200],
];
const SPACING: f64 = 0.26;

/// Where it is seen from: farther away the more vases there are.
pub fn view(count: usize) -> View {
    let eye = DVec3::new(0.0, -1.55 - 0.3 * (count as f64 - 2.0), 0.52);
    View { eye, target: DVec3::new(0.0, 0.0, 0.148), field: 0.175 + 0.10 * count as f64 }
}

/// Width over height.
pub fn aspect(count: usize) -> f64 {
    0.66 + 0.38 * count as f64
}

/// Foot of a vase.
pub fn foot(k: usize, count: usize) -> DVec3 {
    DVec3::new((k as f64 - 0.5 * (count as f64 - 1.0)) * SPACING, 0.0, 0.0)
}

/// Paints of the library with coarse and with fine flakes.
pub fn flakes(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let mut list = Vec::new();
    for (name, title) in [("metallic-coarse", "coarse flakes"), ("metallic-fine", "fine flakes")] {
        let brdf = model::parse(&format!("material:{name}"), 550e-9)?;
        let factors = three_angles(brdf.as_ref())?;
        let lightness = factors.map(|f| lab([f.value / 100.0; 3], [1.0; 3])[0]);
        let mut lines = vec![
            title.to_owned(),
            format!("R {:.0}, {:.0}, {:.0} %", factors[0].value, factors[1].value, factors[2].value),
        ];
        let flop = flop_index(lightness[0], lightness[1], lightness[2]);
        lines.push("at 15\u{b0}, 45\u{b0}, 110\u{b0}".to_owned());
        lines.extend(flop.map(|f| format!("flop index {f:.1}")));
        list.push((Finish::Grey(brdf), lines));
    }
    progress(1.0);
    Ok(list)
}

/// Reflectance factors at 15, 45 and 110 deg from the mirror direction of 45 deg \[%\].
fn three_angles(brdf: &dyn Brdf) -> Result<[Estimate; 3]> {
    let meter = standards::by_name("metallic-3").expect("a named instrument");
    let readings = meter.measure(brdf, &Options::default())?;
    Ok([0, 1, 2].map(|k| readings[k].estimate))
}

/// Three colours from tristimulus values.
pub fn colours(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let mut list = Vec::new();
    for paint in [RED, GOLD, BLUE] {
        let y = paint.luminance().map(|y| 100.0 * y);
        let mut lines = vec![format!("{} metallic", paint.name), format!("Y {:.0}, {:.0}, {:.0} %", y[0], y[1], y[2])];
        lines.push("at 15\u{b0}, 45\u{b0}, 110\u{b0}".to_owned());
        lines.extend(paint.flop().map(|f| format!("flop index {f:.1}")));
        list.push((Finish::Colour(paint.flakes.bare()), lines));
    }
    progress(1.0);
    Ok(list)
}

/// Vases in a row, a large window to the left, a strip to the right, a lamp above.
pub fn scene(finishes: &[Finish]) -> Result<Scene<'_>> {
    let mut scene = Scene::new(DVec3::splat(0.28))?;
    add_backdrop(&mut scene, 1.2, Coat::new(Reflector::Grey(&WHITE), DVec3::new(0.42, 0.43, 0.45)))?;
    let vase = revolution(&PROFILE, true)?;
    for (k, finish) in finishes.iter().enumerate() {
        let place = DAffine3::from_translation(foot(k, finishes.len()));
        scene.add(vase.transformed(&place)?, Cover::Plain(finish.coat()));
    }
    let lamps: [(DVec3, DVec3, DVec3, f64, DVec3); 3] = [
        // Window to the left, front.
        (
            DVec3::new(-1.35, -1.15, 0.25),
            DVec3::new(0.55, -0.45, 0.0),
            DVec3::new(0.12, 0.14, 0.75),
            7.0,
            DVec3::new(1.0, 0.98, 0.95),
        ),
        // Strip to the right, behind.
        (
            DVec3::new(1.15, 0.30, 0.10),
            DVec3::new(0.10, -0.22, 0.0),
            DVec3::new(0.0, 0.0, 0.80),
            5.0,
            DVec3::new(0.92, 0.96, 1.0),
        ),
        // Above.
        (DVec3::new(-0.4, -0.3, 1.25), DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.8, 0.0, 0.0), 4.0, DVec3::ONE),
    ];
    for (corner, u, v, radiance, colour) in lamps {
        scene.add_emitter(facing_stage(corner, u, v)?, Paint::plain(radiance * colour)?)?;
    }
    Ok(scene)
}

/// A quad whose front looks at the vases.
pub fn facing_stage(corner: DVec3, u: DVec3, v: DVec3) -> Result<Quad> {
    let centre = corner + 0.5 * (u + v);
    let inward = DVec3::new(0.0, 0.0, 0.1) - centre;
    if u.cross(v).dot(inward) >= 0.0 { Quad::new(corner, u, v) } else { Quad::new(corner, v, u) }
}
