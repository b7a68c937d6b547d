//! The plane of incidence as a half disc: the normal upwards, the source on the left.

use super::radius::Radius;
use super::{Lobe, series_colour};
use crate::chart::raster::{Align, Area, GRID, INK, SOFT_INK};
use crate::chart::shapes::{Drawing, Point};
use crate::math::direction;
use crate::render::caption::Lettering;

/// Room for the labels round the rim.
const RIM: f64 = 44.0;

/// Where all rays start.
pub fn foot(area: Area) -> Point {
    (area.x as f64 + 0.5 * area.width as f64, (area.y + area.height) as f64)
}

fn rim(area: Area) -> f64 {
    (0.5 * area.width as f64).min(area.height as f64) - RIM
}

/// Draws grid, curves, sources and cores.
pub fn draw(drawing: &mut Drawing, area: Area, lobes: &[Lobe], cuts: &[Vec<(f64, f64)>], radius: &Radius) {
    let (x0, y0) = foot(area);
    let whole = rim(area);
    let at = |theta: f64, r: f64| (x0 + whole * r * theta.sin(), y0 - whole * r * theta.cos());
    let deg = f64::to_radians;
    let circle = |r: f64| (-90..=90).map(|k| at(deg(f64::from(k)), r)).collect::<Vec<_>>();
    for k in (-90i32..=90).step_by(15) {
        let theta = deg(f64::from(k));
        drawing.line(vec![at(theta, 0.0), at(theta, 1.0)], GRID, 1.0);
        if k % 30 == 0 {
            let label = format!("{}\u{b0}", k.abs());
            drawing.text(&label, at(theta, 1.0 + 22.0 / whole), Align::Middle, Lettering::Small, SOFT_INK);
        }
    }
    let circles = radius.circles();
    circles.iter().for_each(|(v, _)| drawing.line(circle(radius.share(*v)), GRID, 1.0));
    drawing.line(circle(1.0), SOFT_INK, 1.2);
    drawing.line(vec![at(deg(-90.0), 1.0), at(deg(90.0), 1.0)], INK, 1.5);
    // Values of the circles below the surface, on the side of the mirror direction; one that would touch the last is
    // left out.
    let mut labels: Vec<(f64, &str)> = circles.iter().map(|(v, label)| (radius.share(*v), label.as_str())).collect();
    labels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut free = f64::INFINITY;
    for (share, label) in labels {
        let x = at(deg(90.0), share).0;
        let half = 0.5 * Lettering::Small.text_width(label) as f64;
        if x + half + 8.0 < free && x - half > x0 {
            drawing.text(label, (x, y0 + 16.0), Align::Middle, Lettering::Small, SOFT_INK);
            free = x - half;
        }
    }
    let unit = if radius.decades.is_some() { "f_r [1/sr], logarithmic radius" } else { "f_r [1/sr]" };
    drawing.text(unit, (x0 + 0.5 * whole, y0 + 40.0), Align::Middle, Lettering::Small, SOFT_INK);
    drawing.text("source side", (x0 - 0.5 * whole, y0 + 16.0), Align::Middle, Lettering::Small, SOFT_INK);
    for (k, (lobe, cut)) in lobes.iter().zip(cuts).enumerate() {
        let ink = series_colour(k);
        let core = lobe.brdf.specular_core(direction(lobe.theta_i, lobe.phi_i));
        if core > 0.0 {
            drawing.dashed(vec![at(lobe.theta_i, 0.0), at(lobe.theta_i, 1.0)], ink, 2.0, [8.0, 5.0]);
        }
        // Lobes from the same direction share one arrow.
        if !lobes[..k].iter().any(|l| l.theta_i == lobe.theta_i) {
            let alone = lobes.iter().all(|l| l.theta_i == lobe.theta_i) && lobes.len() > 1;
            drawing.arrow(at(-lobe.theta_i, 0.97), at(-lobe.theta_i, 0.80), if alone { INK } else { ink }, 2.5);
        }
        if cut.iter().any(|p| p.1 > 0.0) {
            let mut points = vec![(x0, y0)];
            points.extend(cut.iter().map(|&(t, f)| at(t, radius.share(f))));
            points.push((x0, y0));
            drawing.line(points[1..points.len() - 1].to_vec(), ink, 2.2);
        }
    }
}
