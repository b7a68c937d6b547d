//! Pictures of lobes: slices in the plane of incidence as polar curves, and each lobe in the round.

mod polar;
mod radius;
mod solid;

use super::raster::{Align, INK, SOFT_INK};
use super::shapes::{Drawing, area};
use super::slices::{series_colour, slice};
use crate::math::direction;
use crate::optics::Brdf;
use crate::render::caption::Lettering;
use radius::Radius;
pub use radius::RadiusScale;

/// One lobe: a BRDF lit from one direction.
pub struct Lobe<'a> {
    pub label: String,
    pub brdf: &'a dyn Brdf,
    /// Direction of the source \[rad\].
    pub theta_i: f64,
    pub phi_i: f64,
}

/// Lobes on one page at most: more colours would not be told apart.
pub const MOST: usize = 7;

const WIDTH: f64 = 1680.0;
const MARGIN: usize = 40;
const TOP: usize = 70;
const POLAR: (usize, usize) = (860, 450);
const LEGEND_LINE: usize = 28;

/// A lobe that still rises beyond this polar angle grows without bound towards the horizon, as several models do.
const GRAZING: f64 = 80.0;
/// Where slices end otherwise \[deg\].
const LAST: f64 = 89.0;

/// Polar angle up to which lobes are shown: [`LAST`], or [`GRAZING`] if beyond it one is higher than all of them before, and
/// that not because its mirror direction lies there.
fn shown(lobes: &[Lobe], cuts: &[Vec<(f64, f64)>]) -> f64 {
    let limit = GRAZING.to_radians();
    let highest = |within: bool| {
        let points = cuts.iter().flatten().filter(|p| !within || p.0.abs() <= limit);
        points.fold(0.0f64, |m, p| m.max(p.1))
    };
    let upright = lobes.iter().all(|l| l.theta_i <= (GRAZING - 15.0).to_radians());
    if upright && highest(false) > 1.05 * highest(true) { limit } else { LAST.to_radians() }
}

/// Draws up to [`MOST`] lobes over each other in the plane of incidence, and each in the round.
///
/// The radius of a curve is `f_r` over the largest of all, or its logarithm over the chosen decades. A specular core is a
/// dashed ray, since its `f_r` has no height. Polar angles end at `up_to` \[rad\], or where lobes begin to grow without
/// bound.
pub fn lobe_page(lobes: &[Lobe], title: &str, scale: RadiusScale, up_to: Option<f64>) -> Drawing {
    let lobes = &lobes[..lobes.len().min(MOST)];
    let whole: Vec<Vec<(f64, f64)>> = lobes.iter().map(|l| slice(l.brdf, l.theta_i, l.phi_i)).collect();
    let limit = up_to.unwrap_or_else(|| shown(lobes, &whole));
    let within = |cut: &Vec<(f64, f64)>| cut.iter().copied().filter(|p| p.0.abs() <= limit + 1e-9).collect();
    let cuts: Vec<Vec<(f64, f64)>> = whole.iter().map(within).collect();
    let radius = Radius::new(scale, &cuts);
    let legend = lobes.len() * LEGEND_LINE;
    let height = (TOP + POLAR.1 + 60 + legend + 40).max(680);
    let mut drawing = Drawing::new(WIDTH, height as f64);
    let room = (WIDTH as usize - 2 * MARGIN) / Lettering::Heading.letter_width();
    let title: String = title.chars().take(room).collect();
    drawing.text(&title, (MARGIN as f64, 36.0), Align::Start, Lettering::Heading, INK);
    polar::draw(&mut drawing, area(MARGIN, TOP, POLAR.0, POLAR.1), lobes, &cuts, &radius);
    let limit = limit.min(LAST.to_radians());
    let legend_top = TOP + POLAR.1 + 66;
    for (k, lobe) in lobes.iter().enumerate() {
        let y = (legend_top + k * LEGEND_LINE) as f64;
        let x = MARGIN as f64;
        drawing.line(vec![(x, y), (x + 34.0, y)], series_colour(k), 3.0);
        drawing.text(&legend_text(lobe, &cuts[k], &whole[k]), (x + 46.0, y), Align::Start, Lettering::Small, INK);
    }
    let left = MARGIN + POLAR.0 + 30;
    let right = area(left, TOP, WIDTH as usize - MARGIN - left, height - TOP - 40);
    draw_solids(&mut drawing, right, lobes, &radius, limit);
    drawing
}

/// Label, peak, what lies beyond the part that is shown, and core if there is one.
fn legend_text(lobe: &Lobe, cut: &[(f64, f64)], whole: &[(f64, f64)]) -> String {
    let highest = cut.iter().fold(0.0f64, |m, p| m.max(p.1));
    let away = |p: &&(f64, f64)| (p.0 - lobe.theta_i).abs();
    // Of a flat top the place nearest to the mirror direction.
    let top = cut.iter().filter(|p| p.1 > 0.0 && p.1 >= 0.999 * highest).min_by(|a, b| away(a).total_cmp(&away(b)));
    let mut text = lobe.label.clone();
    if let Some(top) = top {
        text += &format!(": peak {} 1/sr at {:.1}\u{b0}", radius::digits(highest), top.0.to_degrees());
    }
    let beyond = whole.iter().copied().fold((0.0, 0.0), |m, p| if p.1 > m.1 { p } else { m });
    if beyond.1 > 1.05 * highest {
        let (f, theta) = (radius::digits(beyond.1), beyond.0.abs().to_degrees());
        text += &format!(", not shown: {f} at {theta:.0}\u{b0}");
    }
    let core = lobe.brdf.specular_core(direction(lobe.theta_i, lobe.phi_i));
    if core > 0.0 {
        text += &format!(", specular core {} (dashed ray)", radius::digits(core));
    }
    text
}

/// A grid of views, one per lobe.
fn draw_solids(drawing: &mut Drawing, right: super::raster::Area, lobes: &[Lobe], radius: &Radius, limit: f64) {
    let columns = if lobes.len() > 1 { 2 } else { 1 };
    let rows = lobes.len().div_ceil(columns).max(1);
    let (w, h) = (right.width / columns, right.height / rows);
    for (k, lobe) in lobes.iter().enumerate() {
        let cell = area(right.x + (k % columns) * w, right.y + (k / columns) * h, w, h);
        solid::draw(drawing, cell, lobe, radius, limit, series_colour(k));
    }
    if lobes.is_empty() {
        let at = ((right.x + 20) as f64, (right.y + 40) as f64);
        drawing.text("no lobe", at, Align::Start, Lettering::Medium, SOFT_INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;

    fn page(texts: &[&str], scale: RadiusScale) -> Drawing {
        let brdfs: Vec<_> = texts.iter().map(|t| model::parse(t, 550e-9).unwrap()).collect();
        let lobes: Vec<Lobe> = brdfs
            .iter()
            .zip(texts)
            .map(|(b, t)| Lobe { label: (*t).to_owned(), brdf: b.as_ref(), theta_i: 0.8, phi_i: 0.0 })
            .collect();
        lobe_page(&lobes, "lobes", scale, None)
    }

    /// Every number on the page is finite, whatever the lobe: none, a mirror, the narrowest, a black one.
    #[test]
    fn extreme_lobes_are_drawn() {
        let texts = ["lambert:rho=0", "mirror", "ward:rho_s=1,alpha=0.001", "lambert:rho=1"];
        for scale in [RadiusScale::Auto, RadiusScale::Linear, RadiusScale::Logarithmic { decades: 4.0 }] {
            for some in [&texts[..], &texts[..1], &texts[1..2], &[]] {
                let drawing = page(some, scale);
                for shape in &drawing.shapes {
                    use super::super::shapes::Shape;
                    if let Shape::Line { points, .. } | Shape::Polygon { points, .. } = shape {
                        assert!(points.iter().all(|p| p.0.is_finite() && p.1.is_finite()), "{shape:?}");
                    }
                }
                assert!(drawing.to_svg().len() > 500);
            }
        }
    }

    /// Growth towards the horizon is left out of the picture, and said; a lobe whose mirror direction is there is not.
    #[test]
    fn growth_at_grazing_does_not_flatten_the_lobe() {
        let brdf = model::parse("nef-bm:sigma=0.3,n=1.5,tau=1rad,omega=2rad,rho_D=0.05", 550e-9).unwrap();
        let lobe =
            |deg: f64| Lobe { label: "l".to_owned(), brdf: brdf.as_ref(), theta_i: deg.to_radians(), phi_i: 0.0 };
        let limit = |deg: f64| {
            let lobes = [lobe(deg)];
            let cuts = [slice(lobes[0].brdf, lobes[0].theta_i, 0.0)];
            shown(&lobes, &cuts).to_degrees()
        };
        assert_eq!([limit(45.0).round(), limit(75.0).round()], [80.0, 89.0]);
        let svg = |up_to: Option<f64>| lobe_page(&[lobe(45.0)], "l", RadiusScale::Linear, up_to).to_svg();
        assert!(svg(None).contains("not shown") && !svg(Some(LAST.to_radians())).contains("not shown"));
    }

    /// The curve of Lambert's lobe is a half circle about the foot.
    #[test]
    fn lambert_is_a_half_circle() {
        let drawing = page(&["lambert:rho=0.5"], RadiusScale::Linear);
        use super::super::shapes::Shape;
        let ink = series_colour(0);
        let curve = drawing
            .shapes
            .iter()
            .find_map(|s| match s {
                Shape::Line { points, ink: i, .. } if *i == ink && points.len() > 100 => Some(points),
                _ => None,
            })
            .unwrap();
        let (x0, y0) = polar::foot(area(MARGIN, TOP, POLAR.0, POLAR.1));
        let radii: Vec<f64> = curve.iter().map(|p| (p.0 - x0).hypot(p.1 - y0)).collect();
        assert!(radii.iter().all(|r| (r / radii[0] - 1.0).abs() < 1e-9));
    }
}
