//! The page of one fit: data and model in the plane of incidence, and the residuals against the tilt of the half vector.

use super::axis::Axis;
use super::plot::{Curve, Plot, Stroke, decades, exact};
use super::raster::{Align, Area, Colour, INK, Raster, SOFT_INK, WHITE};
use super::slices::{series_colour, slice};
use crate::fit::Observations;
use crate::math::{frame, half_vector};
use crate::optics::Brdf;
use crate::render::caption::Lettering;

const WIDTH: usize = 1680;
const MARGIN: usize = 40;
const PANEL: (usize, usize) = (780, 640);
const GAP: usize = 40;
const HEADER: usize = 76;
const LINE: usize = 24;

/// Incident angles drawn; more would not be told apart.
const ANGLES: usize = 5;

/// Draws the page. `source` gives full curves; without it the data are points near the plane of incidence.
///
/// `notes` are lines of text below: parameters, goodness, warnings.
pub fn fit_page(
    data: &Observations,
    source: Option<&dyn Brdf>,
    model: &dyn Brdf,
    title: &str,
    notes: &[String],
) -> Raster {
    let text_width = WIDTH - 2 * MARGIN;
    let lines: Vec<String> = notes.iter().flat_map(|n| Lettering::Small.wrap(n, text_width)).collect();
    let notes_top = HEADER + PANEL.1 + 30;
    let mut raster = Raster::new(WIDTH, notes_top + lines.len() * LINE + MARGIN, WHITE);
    let room = text_width / Lettering::Heading.letter_width();
    let title: String = title.chars().take(room).collect();
    raster.text(&title, MARGIN as f64, 36.0, Align::Start, Lettering::Heading, INK);
    let angles = incident_angles(data);
    let panel = |k: usize| Area { x: MARGIN + k * (PANEL.0 + GAP), y: HEADER, width: PANEL.0, height: PANEL.1 };
    draw_slices(&mut raster, panel(0), data, source, model, &angles);
    draw_residuals(&mut raster, panel(1), data, model, &angles);
    for (k, line) in lines.iter().enumerate() {
        let y = (notes_top + k * LINE + 8) as f64;
        raster.text(line, MARGIN as f64, y, Align::Start, Lettering::Small, INK);
    }
    raster
}

/// Up to [`ANGLES`] of the incident directions, evenly picked: polar angle and azimuth \[rad\].
fn incident_angles(data: &Observations) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = data.list.iter().map(|o| (frame::theta(o.wi), frame::phi(o.wi))).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0)));
    let same = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6;
    all.dedup_by(|a, b| same(a, b));
    let first = all.first().map_or(0.0, |a| a.1);
    all.retain(|a| (a.1 - first).abs() < 1e-6);
    let n = all.len().min(ANGLES);
    (0..n).map(|k| all[if n > 1 { k * (all.len() - 1) / (n - 1) } else { 0 }]).collect()
}

fn label(theta: f64) -> String {
    format!("{:.0}\u{b0}", theta.to_degrees())
}

fn draw_slices(
    raster: &mut Raster,
    area: Area,
    data: &Observations,
    source: Option<&dyn Brdf>,
    model: &dyn Brdf,
    angles: &[(f64, f64)],
) {
    let degrees = |cut: Vec<(f64, f64)>| cut.into_iter().map(|(t, f)| (t.to_degrees(), f)).collect::<Vec<_>>();
    let mut curves = Vec::new();
    let mut points: Vec<(Colour, Vec<(f64, f64)>)> = Vec::new();
    for (k, &(theta, phi)) in angles.iter().enumerate() {
        let ink = series_colour(k);
        let stroke = |width, dashes| Stroke { ink, width, dashes };
        if let Some(source) = source {
            let cut = degrees(slice(source, theta, phi));
            curves.push(Curve { label: label(theta), points: cut, stroke: stroke(2.0, None) });
        } else {
            points.push((ink, in_plane(data, theta, phi)));
        }
        let cut = degrees(slice(model, theta, phi));
        let name = if source.is_none() { label(theta) } else { String::new() };
        curves.push(Curve { label: name, points: cut, stroke: stroke(2.0, Some([9.0, 6.0])) });
    }
    let values = || curves.iter().flat_map(|c| &c.points).chain(points.iter().flat_map(|p| &p.1)).map(|p| p.1);
    let top = values().fold(1e-6, f64::max);
    let bottom = values().filter(|v| *v > 0.0).fold(top, f64::min).max(1e-6 * top);
    // Darkness has no logarithm: it lies on the floor.
    for curve in &mut curves {
        curve.points.iter_mut().for_each(|p| p.1 = p.1.max(0.1 * bottom));
    }
    let drawn = if source.is_some() { "full: data, dashed: model" } else { "crosses: data, dashed: model" };
    let plot = Plot {
        title: format!("Plane of incidence ({drawn})"),
        x: Axis { ticks: (-3..=3).map(|k| 30.0 * f64::from(k)).collect(), ..exact(-90.0, 90.0, 6) },
        y: decades(bottom, top),
        x_label: "theta_r [deg], mirror side positive".to_owned(),
        y_label: "f_r [1/sr]".to_owned(),
        curves,
    };
    plot.draw(raster, area);
    plot.marks(raster, area, &points);
}

/// Data of one incident direction within 3 deg of its plane: signed `theta_r` \[deg\] and `f_r`.
fn in_plane(data: &Observations, theta: f64, phi: f64) -> Vec<(f64, f64)> {
    let along = |o: &&crate::fit::Observation| {
        (frame::theta(o.wi) - theta).abs() < 1e-6 && (frame::phi(o.wi) - phi).abs() < 1e-6
    };
    data.list
        .iter()
        .filter(along)
        .filter_map(|o| {
            let (s, c) = phi.sin_cos();
            let (across, forward) = (s * o.wo.x - c * o.wo.y, -(c * o.wo.x + s * o.wo.y));
            let tilt = frame::theta(o.wo).to_degrees();
            (across.abs() < 0.05).then_some((tilt.copysign(forward), o.f_r.value))
        })
        .collect()
}

fn draw_residuals(raster: &mut Raster, area: Area, data: &Observations, model: &dyn Brdf, angles: &[(f64, f64)]) {
    let peak = data.list.iter().fold(0.0f64, |m, o| m.max(o.f_r.value));
    let mut points: Vec<(Colour, Vec<(f64, f64)>)> = vec![(SOFT_INK, Vec::new())];
    points.extend((0..angles.len()).map(|k| (series_colour(k), Vec::new())));
    for o in data.list.iter().filter(|o| o.f_r.value > 1e-6 * peak) {
        let tilt = frame::theta(half_vector(o.wi, o.wo)).to_degrees().max(0.01);
        let ratio = (model.eval(o.wi, o.wo).max(1e-6 * peak) / o.f_r.value).ln();
        let series = angles.iter().position(|a| (a.0 - frame::theta(o.wi)).abs() < 1e-6).map_or(0, |k| k + 1);
        points[series].1.push((tilt, ratio));
    }
    // All but the wildest hundredth.
    let mut sizes: Vec<f64> = points.iter().flat_map(|p| &p.1).map(|p| p.1.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let reach = sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(1.0).clamp(0.02, 12.0) * 1.2;
    let lowest = points.iter().flat_map(|p| &p.1).fold(90.0f64, |m, p| m.min(p.0));
    let zero = Stroke { ink: INK, width: 1.0, dashes: None };
    let mut curves = vec![Curve { label: String::new(), points: vec![(0.01, 0.0), (90.0, 0.0)], stroke: zero }];
    // The legend of the marks.
    curves.extend(angles.iter().enumerate().map(|(k, a)| Curve {
        label: label(a.0),
        points: Vec::new(),
        stroke: Stroke { ink: series_colour(k), width: 4.0, dashes: None },
    }));
    let plot = Plot {
        title: "Residuals, a mark per direction".to_owned(),
        x: decades(lowest.max(0.01), 90.0),
        y: exact(-reach, reach, 6),
        x_label: "theta_h [deg]".to_owned(),
        y_label: "ln(model / data)".to_owned(),
        curves,
    };
    plot.draw(raster, area);
    plot.marks(raster, area, &points);
}
