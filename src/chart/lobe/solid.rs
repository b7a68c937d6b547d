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

/// Rings about the mirror direction, half of them by equal ratios and half by equal steps, and points on each.
const RINGS: usize = 44;
const AROUND: usize = 56;
/// First ring as a share of the way to the horizon.
const INNERMOST: f64 = 1.5e-3;
/// View: azimuth from the plane of incidence and height above the horizon.
const VIEW: (f64, f64) = (2.05, 0.42);
/// Light, in the frame of the view.
const LIGHT: DVec3 = DVec3::new(-0.35, 0.65, 0.67);

/// Room for the label, and of a lobe above and below its foot in units of its scale.
const TITLE: f64 = 40.0;
const ABOVE: f64 = 1.0;
const BELOW: f64 = 0.45;

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
        let scale = (0.44 * w).min((h - TITLE) / (ABOVE + BELOW));
        // In the middle of the height that is there.
        let top = area.y as f64 + 0.5 * (h - TITLE - (ABOVE + BELOW) * scale);
        let foot = (area.x as f64 + 0.5 * w, top + TITLE + ABOVE * scale);
        View { right, up, eye, foot, scale }
    }

    fn place(&self, v: DVec3) -> Point {
        (self.foot.0 + self.scale * v.dot(self.right), self.foot.1 - self.scale * v.dot(self.up))
    }
}

/// Draws the lobe with its horizon, normal, source and mirror direction.
pub fn draw(drawing: &mut Drawing, area: Area, lobe: &Lobe, radius: &Radius, limit: f64, ink: Colour) {
    // The mirror direction comes towards the reader's right.
    let view = View::new(area, lobe.phi_i);
    let wi = direction(lobe.theta_i, lobe.phi_i);
    let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
    let label = fitting(&lobe.label, area.width);
    let title = (view.foot.0, view.foot.1 - ABOVE * view.scale - TITLE + 14.0);
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
    let skin = Skin { lobe, wi, mirror, limit };
    skin.draw(drawing, &view, radius, ink);
    if !behind {
        source(drawing);
    }
    if lobe.brdf.specular_core(wi) > 0.0 {
        drawing.dashed(vec![view.place(DVec3::ZERO), view.place(mirror)], ink, 2.5, [8.0, 5.0]);
    }
}

/// What a lobe looks like from outside.
struct Skin<'a> {
    lobe: &'a Lobe<'a>,
    wi: DVec3,
    mirror: DVec3,
    /// Polar angle of its edge.
    limit: f64,
}

impl Skin<'_> {
    /// Points by ring and azimuth about the mirror direction, each at its radius; on every meridian the last lies at the
    /// limit.
    fn grid(&self, radius: &Radius) -> Vec<Vec<DVec3>> {
        let (t, b) = tangents(self.mirror);
        let vertex = |share: f64, k: usize| {
            let chi = TAU * k as f64 / AROUND as f64;
            let side = chi.cos() * t + chi.sin() * b;
            // cos a m.z + sin a side.z = cos limit.
            let (whole, phase) = (self.mirror.z.hypot(side.z), side.z.atan2(self.mirror.z));
            let a = share * (phase + (self.limit.cos() / whole).min(1.0).acos()).max(0.0);
            let wo = (a.cos() * self.mirror + a.sin() * side).normalize();
            radius.share(self.lobe.brdf.eval(self.wi, wo)) * wo
        };
        let half = RINGS / 2;
        let even = (1..=half).map(|k| k as f64 / half as f64);
        let narrow = (0..half).map(|k| INNERMOST.powf(1.0 - k as f64 / half as f64));
        let mut shares: Vec<f64> = even.chain(narrow).chain([0.0]).collect();
        shares.sort_by(f64::total_cmp);
        shares.into_iter().map(|share| (0..AROUND).map(|k| vertex(share, k)).collect()).collect()
    }

    /// Far patches first.
    fn draw(&self, drawing: &mut Drawing, view: &View, radius: &Radius, ink: Colour) {
        let grid = self.grid(radius);
        let mut patches = Vec::new();
        for rings in grid.windows(2) {
            for k in 0..AROUND {
                let next = (k + 1) % AROUND;
                let corners = [rings[0][k], rings[1][k], rings[1][next], rings[0][next]];
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
            drawing.line(points.iter().copied().chain([points[0]]).collect(), shade(ink, 0.39 + 0.56 * lit), 0.7);
            drawing.polygon(points, colour);
        }
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
