//! A drawing as a list of shapes, put on paper as SVG text or as pixels, so that both look the same.

use super::canvas::{Anchor, Canvas, Type, sheet};
use super::raster::{Align, Area, Colour, Raster, WHITE};
use crate::render::caption::Lettering;
use plotters::style::RGBColor;

/// A point of the sheet, x to the right and y down.
pub type Point = (f64, f64);

/// One shape; later ones cover earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Open line; an empty dash pattern is a full line.
    Line { points: Vec<Point>, ink: Colour, width: f64, dashes: Option<[f64; 2]> },
    /// Filled polygon.
    Polygon { points: Vec<Point>, ink: Colour },
    /// Text centred in height on a point.
    Text { text: String, at: Point, align: Align, lettering: Lettering, ink: Colour },
}

/// A sheet of a given size.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub width: f64,
    pub height: f64,
    pub shapes: Vec<Shape>,
}

impl Drawing {
    pub fn new(width: f64, height: f64) -> Self {
        Drawing { width, height, shapes: Vec::new() }
    }

    /// Full line.
    pub fn line(&mut self, points: Vec<Point>, ink: Colour, width: f64) {
        self.shapes.push(Shape::Line { points, ink, width, dashes: None });
    }

    /// Dashed line.
    pub fn dashed(&mut self, points: Vec<Point>, ink: Colour, width: f64, dashes: [f64; 2]) {
        self.shapes.push(Shape::Line { points, ink, width, dashes: Some(dashes) });
    }

    /// Filled polygon.
    pub fn polygon(&mut self, points: Vec<Point>, ink: Colour) {
        self.shapes.push(Shape::Polygon { points, ink });
    }

    /// Text centred in height on a point.
    pub fn text(&mut self, text: &str, at: Point, align: Align, lettering: Lettering, ink: Colour) {
        self.shapes.push(Shape::Text { text: text.to_owned(), at, align, lettering, ink });
    }

    /// An arrow with its head at `to`.
    pub fn arrow(&mut self, from: Point, to: Point, ink: Colour, width: f64) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        if length < 1e-9 {
            return;
        }
        let (ux, uy) = (dx / length, dy / length);
        let head = 5.0 + 2.5 * width;
        let neck = (to.0 - ux * head, to.1 - uy * head);
        self.line(vec![from, neck], ink, width);
        let side = 0.4 * head;
        let wing = |s: f64| (neck.0 - s * uy * side, neck.1 + s * ux * side);
        self.polygon(vec![to, wing(1.0), wing(-1.0)], ink);
    }

    /// SVG text.
    pub fn to_svg(&self) -> String {
        sheet(self.width, self.height, |canvas| self.shapes.iter().for_each(|s| draw_on_canvas(canvas, s)))
    }

    /// Pixels.
    pub fn to_raster(&self) -> Raster {
        let mut raster = Raster::new(self.width.ceil() as usize, self.height.ceil() as usize, WHITE);
        self.shapes.iter().for_each(|s| draw_on_raster(&mut raster, s));
        raster
    }
}

fn draw_on_canvas(canvas: &Canvas, shape: &Shape) {
    let colour = |c: &Colour| RGBColor(c[0], c[1], c[2]);
    match shape {
        Shape::Line { points, ink, width, dashes: None } => canvas.line(points, colour(ink), *width),
        Shape::Line { points, ink, width, dashes: Some(dashes) } => canvas.dashed(points, colour(ink), *width, dashes),
        Shape::Polygon { points, ink } => canvas.polygon(points, colour(ink)),
        Shape::Text { text, at, align, lettering, ink } => {
            let anchor = match align {
                Align::Start => Anchor::Start,
                Align::Middle => Anchor::Middle,
                Align::End => Anchor::End,
            };
            // Sizes at which a sans-serif face is about as wide as the letters of the pictures.
            let (size, bold) = match lettering {
                Lettering::Small => (14.0, false),
                Lettering::Medium => (17.0, false),
                Lettering::Strong => (17.0, true),
                Lettering::Heading => (21.0, true),
            };
            canvas.text(text, *at, anchor, Type { size, color: colour(ink), bold });
        }
    }
}

fn draw_on_raster(raster: &mut Raster, shape: &Shape) {
    match shape {
        Shape::Line { points, ink, width, dashes: None } => raster.line(points, *ink, *width),
        Shape::Line { points, ink, width, dashes: Some(dashes) } => raster.dashed(points, *ink, *width, *dashes),
        Shape::Polygon { points, ink } => fill_polygon(raster, points, *ink),
        Shape::Text { text, at, align, lettering, ink } => raster.text(text, at.0, at.1, *align, *lettering, *ink),
    }
}

/// Scan lines per pixel row.
const ROWS: usize = 4;

/// Even-odd fill; each pixel is covered by the share of [`ROWS`] scan lines inside it.
fn fill_polygon(raster: &mut Raster, points: &[Point], ink: Colour) {
    if points.len() < 3 || !points.iter().all(|p| p.0.is_finite() && p.1.is_finite()) {
        return;
    }
    let low = points.iter().fold(f64::INFINITY, |m, p| m.min(p.1)).floor().max(-1.0);
    let high = points.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p.1)).ceil().min(raster.height() as f64);
    let width = raster.width();
    let mut cover = vec![0.0f64; width];
    let mut row = low;
    while row <= high {
        let (mut first, mut last) = (width, 0);
        for k in 0..ROWS {
            // Whole numbers are pixel centres.
            let y = row - 0.5 + (k as f64 + 0.5) / ROWS as f64;
            let mut crossings: Vec<f64> = Vec::new();
            for (i, a) in points.iter().enumerate() {
                let b = points[(i + 1) % points.len()];
                if (a.1 <= y) != (b.1 <= y) {
                    crossings.push(a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for span in crossings.chunks_exact(2) {
                let (x0, x1) = (span[0].max(-0.5) + 0.5, (span[1] + 0.5).min(width as f64));
                if x1 <= x0 {
                    continue;
                }
                let (c0, c1) = (x0 as usize, (x1.ceil() as usize).min(width));
                for (c, slot) in cover.iter_mut().enumerate().take(c1).skip(c0) {
                    *slot += (x1.min(c as f64 + 1.0) - x0.max(c as f64)).max(0.0) / ROWS as f64;
                }
                (first, last) = (first.min(c0), last.max(c1));
            }
        }
        for (c, slot) in cover.iter_mut().enumerate().take(last).skip(first.min(last)) {
            raster.blend(c as i64, row as i64, ink, slot.min(1.0));
            *slot = 0.0;
        }
        row += 1.0;
    }
}

/// A rectangle of pixels as the area of a drawing.
pub fn area(x: usize, y: usize, width: usize, height: usize) -> Area {
    Area { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_cover_their_area() {
        let mut drawing = Drawing::new(60.0, 50.0);
        // A triangle that hangs out of the sheet on the left: what is inside counts.
        drawing.polygon(vec![(10.3, 5.2), (50.1, 20.7), (20.4, 44.9)], [0, 0, 0]);
        let raster = drawing.to_raster();
        let dark: f64 = raster.rgb().chunks(3).map(|p| 1.0 - f64::from(p[0]) / 255.0).sum();
        let area = 0.5 * ((50.1f64 - 10.3) * (44.9 - 5.2) - (20.4 - 10.3) * (20.7 - 5.2)).abs();
        assert!((dark / area - 1.0).abs() < 0.01, "{dark} {area}");
        let mut outside = Drawing::new(10.0, 10.0);
        outside.polygon(vec![(-5.0, -5.0), (-1.0, 20.0), (-9.0, 3.0)], [0, 0, 0]);
        outside.polygon(vec![(f64::NAN, 0.0), (1.0, 1.0), (2.0, 0.0)], [0, 0, 0]);
        assert!(outside.to_raster().rgb().iter().all(|b| *b == 255));
    }

    #[test]
    fn both_papers_carry_the_same_shapes() {
        let mut drawing = Drawing::new(80.0, 60.0);
        drawing.arrow((10.0, 10.0), (60.0, 40.0), [200, 0, 0], 2.0);
        drawing.text("45\u{b0}", (40.0, 50.0), Align::Middle, Lettering::Small, [0, 0, 0]);
        let svg = drawing.to_svg();
        assert!(svg.contains("<polygon") && svg.contains("45\u{b0}") && svg.contains("width=\"80\""));
        assert!(drawing.to_raster().rgb().iter().any(|b| *b < 128));
    }
}
