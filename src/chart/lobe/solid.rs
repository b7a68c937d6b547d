//! One lobe in the round, seen from above and from the side: the radius in every direction is that of the slices.

use super::Lobe;
use super::radius::Radius;
use crate::chart::raster::{Align, Area, Colour, GRID, INK, SOFT_INK};
use crate::chart::shapes::{Drawing, Point};
use crate::math::direction;
use crate::math::frame::tangents;
use crate::render::caption::Lettering;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rings about the mirror direction and points on each.
const RINGS: usize = 30;
const AROUND: usize = 40;
/// First ring as a share of the way to the horizon.
const INNERMOST: f64 = 1.5e-3;
/// View: azimuth from the plane of incidence and height above the horizon.
const VIEW: (f64, f64) = (2.05, 0.42);
/// Light, in the frame of the view.
const LIGHT: DVec3 = DVec3::new(-0.35, 0.65, 0.67);

/// Axes of the picture in the frame of the surface: to the right, upwards, towards the eye.
struct View {
    right: DVec3,
    up: DVec3,
    eye: DVec3,
    foot: Point,
    scale: f64,
}

impl View {
    fn new(area: Area, turn: f64) -> Self {
        let eye = direction(FRAC_PI_2 - VIEW.1, turn + VIEW.0);
        let right = DVec3::Z.cross(eye).normalize();
        let up = eye.cross(right);
        let (w, h) = (area.width as f64, area.height as f64);
        let scale = (0.44 * w).min(0.62 * (h - 40.0));
        let foot = (area.x as f64 + 0.5 * w, area.y as f64 + 30.0 + 0.72 * (h - 40.0));
        View { right, up, eye, foot, scale }
    }

    fn place(&self, v: DVec3) -> Point {
        (self.foot.0 + self.scale * v.dot(self.right), self.foot.1 - self.scale * v.dot(self.up))
    }
}

/// Draws the lobe with its horizon, normal, source and mirror direction.
pub fn draw(drawing: &mut Drawing, area: Area, lobe: &Lobe, radius: &Radius, ink: Colour) {
    // The mirror direction comes towards the reader's right.
    let view = View::new(area, lobe.phi_i);
    let wi = direction(lobe.theta_i, lobe.phi_i);
    let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
    let label = fitting(&lobe.label, area.width);
    let title = (area.x as f64 + 0.5 * area.width as f64, area.y as f64 + 14.0);
    drawing.text(&label, title, Align::Middle, Lettering::Small, ink);
    let horizon: Vec<DVec3> = (0..=72).map(|k| direction(FRAC_PI_2, TAU * f64::from(k) / 72.0)).collect();
    drawing.polygon(horizon.iter().map(|&v| view.place(v)).collect(), [246, 246, 246]);
    for share in [0.25, 0.5, 0.75] {
        drawing.line(horizon.iter().map(|&v| view.place(share * v)).collect(), GRID, 1.0);
    }
    drawing.line(horizon.iter().map(|&v| view.place(v)).collect(), SOFT_INK, 1.0);
    for k in 0..6 {
        let v = direction(FRAC_PI_2, lobe.phi_i + PI / 6.0 * f64::from(k));
        drawing.line(vec![view.place(-v), view.place(v)], GRID, 1.0);
    }
    let behind = wi.dot(view.eye) < 0.0;
    let source = |drawing: &mut Drawing| {
        drawing.arrow(view.place(1.02 * wi), view.place(0.12 * wi), INK, 2.0);
    };
    let normal = |drawing: &mut Drawing| {
        drawing.dashed(vec![view.place(DVec3::ZERO), view.place(1.05 * DVec3::Z)], SOFT_INK, 1.0, [5.0, 4.0]);
    };
    normal(drawing);
    if behind {
        source(drawing);
    }
    surface(drawing, &view, lobe, wi, mirror, radius, ink);
    if !behind {
        source(drawing);
    }
    if lobe.brdf.specular_core(wi) > 0.0 {
        drawing.dashed(vec![view.place(DVec3::ZERO), view.place(mirror)], ink, 2.5, [8.0, 5.0]);
    }
}

/// The lobe's skin, far patches first.
fn surface(drawing: &mut Drawing, view: &View, lobe: &Lobe, wi: DVec3, mirror: DVec3, radius: &Radius, ink: Colour) {
    let (t, b) = tangents(mirror);
    // Rings crowd towards the mirror direction; on every meridian the last lies on the horizon.
    let share = |k: usize| if k == 0 { 0.0 } else { INNERMOST.powf(1.0 - k as f64 / RINGS as f64) };
    let vertex = |ring: usize, k: usize| {
        let chi = TAU * k as f64 / AROUND as f64;
        let side = chi.cos() * t + chi.sin() * b;
        // cos a m.z + sin a side.z = 0 at the horizon.
        let last = FRAC_PI_2 + (side.z / mirror.z.max(1e-9)).atan();
        let a = last * share(ring).min(1.0 - 1e-6);
        let wo = (a.cos() * mirror + a.sin() * side).normalize();
        radius.share(lobe.brdf.eval(wi, wo)) * wo
    };
    let grid: Vec<Vec<DVec3>> = (0..=RINGS).map(|r| (0..AROUND).map(|k| vertex(r, k)).collect()).collect();
    let mut patches = Vec::new();
    for r in 0..RINGS {
        for k in 0..AROUND {
            let next = (k + 1) % AROUND;
            let corners = [grid[r][k], grid[r + 1][k], grid[r + 1][next], grid[r][next]];
            let middle = corners.iter().sum::<DVec3>() / 4.0;
            let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or_zero();
            if normal == DVec3::ZERO {
                continue;
            }
            // Both sides of the skin are lit alike.
            let facing = if normal.dot(view.eye) < 0.0 { -normal } else { normal };
            let lit = DVec3::new(facing.dot(view.right), facing.dot(view.up), facing.dot(view.eye)).dot(LIGHT);
            patches.push((middle.dot(view.eye), corners, lit.max(0.0)));
        }
    }
    patches.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, corners, lit) in patches {
        let points: Vec<Point> = corners.iter().map(|&v| view.place(v)).collect();
        // A patch is drawn with its outline, so that no paper shows between neighbours.
        let colour = shade(ink, 0.42 + 0.58 * lit);
        drawing.line(points.iter().copied().chain([points[0]]).collect(), shade(ink, 0.36 + 0.54 * lit), 0.7);
        drawing.polygon(points, colour);
    }
}

/// `ink` between dark and light: 0.5 keeps it, 1 mixes it half with white.
fn shade(ink: Colour, light: f64) -> Colour {
    ink.map(|c| {
        let c = f64::from(c);
        let v = if light < 0.5 { c * (0.55 + 0.9 * light) } else { c + (255.0 - c) * (light - 0.5) };
        v.clamp(0.0, 255.0).round() as u8
    })
}

/// The label cut to the width of the panel.
fn fitting(label: &str, width: usize) -> String {
    let most = width / Lettering::Small.letter_width();
    if label.chars().count() <= most {
        return label.to_owned();
    }
    label.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
}
