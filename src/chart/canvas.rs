//! A sheet to draw on: plotters' SVG back end in finer steps, with dashes, markers and upright or turned text.
//!
//! plotters counts whole pixels and measures no text, so the sheet is drawn four times too large and
//! shown at its size, and text is placed by anchors, never by its measured width.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Drawing units per unit of the sheet.
const SCALE: f64 = 4.0;

/// Width of an average letter of a sans-serif face as a share of the type size, on the safe side.
const LETTER: f64 = 0.58;

/// Width of a marker's outline.
const OUTLINE: f64 = 1.5;

/// A point of the sheet, x to the right and y down.
pub type Point = (f64, f64);

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Triangle,
}

/// Which side of the point a text lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// Type: size, colour, weight.
#[derive(Debug, Clone, Copy)]
pub struct Type {
    pub size: f64,
    pub color: RGBColor,
    pub bold: bool,
}

/// An SVG sheet under construction.
pub struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, plotters::coord::Shift>,
}

/// Draws a sheet of the given size and returns its SVG text.
pub fn sheet(width: f64, height: f64, draw: impl FnOnce(&Canvas)) -> String {
    let mut text = String::new();
    let size = (units(width) as u32, units(height) as u32);
    {
        let canvas = Canvas { area: SVGBackend::with_string(&mut text, size).into_drawing_area() };
        canvas.rectangle((0.0, 0.0), (width, height), WHITE);
        draw(&canvas);
        // Writing to a string cannot fail; the result is plotters' way of supporting files.
        let _ = canvas.area.present();
    }
    let drawn = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    text.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1)
}

/// Estimated width of `text` in sheet units, rather too wide than too narrow.
pub fn text_width(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * LETTER * size
}

fn units(x: f64) -> i32 {
    (x * SCALE).round() as i32
}

fn at((x, y): Point) -> (i32, i32) {
    (units(x), units(y))
}

fn stroke(color: RGBColor, width: f64) -> ShapeStyle {
    color.stroke_width(units(width).max(1) as u32)
}

// Drawing into a string cannot fail, so the results of plotters' calls are let go.
impl Canvas<'_> {
    /// Filled rectangle from its upper left to its lower right corner.
    pub fn rectangle(&self, from: Point, to: Point, color: RGBColor) {
        let _ = self.area.draw(&Rectangle::new([at(from), at(to)], color.filled()));
    }

    /// Open line through `points`.
    pub fn line(&self, points: &[Point], color: RGBColor, width: f64) {
        let points: Vec<_> = points.iter().copied().map(at).collect();
        let _ = self.area.draw(&PathElement::new(points, stroke(color, width)));
    }

    /// Line through `points` with dashes and gaps of the given lengths in turn; an empty pattern is a full line.
    pub fn dashed(&self, points: &[Point], color: RGBColor, width: f64, pattern: &[f64]) {
        if pattern.iter().sum::<f64>() <= 0.0 {
            return self.line(points, color, width);
        }
        let (mut turn, mut left) = (0, pattern[0]);
        let mut dash: Vec<Point> = points.first().copied().into_iter().collect();
        for ends in points.windows(2) {
            let ((x0, y0), (x1, y1)) = (ends[0], ends[1]);
            let length = (x1 - x0).hypot(y1 - y0);
            let mut gone = 0.0;
            while length - gone > left {
                gone += left;
                let here = (x0 + (x1 - x0) * gone / length, y0 + (y1 - y0) * gone / length);
                if turn % 2 == 0 {
                    dash.push(here);
                    self.line(&dash, color, width);
                }
                dash = vec![here];
                turn = (turn + 1) % pattern.len();
                left = pattern[turn];
            }
            left -= length - gone;
            if turn % 2 == 0 {
                dash.push((x1, y1));
            }
        }
        if turn % 2 == 0 && dash.len() > 1 {
            self.line(&dash, color, width);
        }
    }

    /// Marker of half width `size`: filled, or hollow with a white inside.
    pub fn marker(&self, (x, y): Point, marker: Marker, size: f64, color: RGBColor, hollow: bool) {
        let fill = if hollow { WHITE } else { color };
        if marker == Marker::Circle {
            let radius = units(size);
            let _ = self.area.draw(&Circle::new(at((x, y)), radius, fill.filled()));
            let _ = self.area.draw(&Circle::new(at((x, y)), radius, stroke(color, OUTLINE)));
            return;
        }
        let outline: Vec<Point> = match marker {
            // Shares of the size chosen so that all three look equally large.
            Marker::Square => [(-0.88, -0.88), (0.88, -0.88), (0.88, 0.88), (-0.88, 0.88)].to_vec(),
            _ => [(0.0, -1.2), (1.12, 0.8), (-1.12, 0.8)].to_vec(),
        };
        let outline: Vec<Point> = outline.iter().map(|(dx, dy)| (x + dx * size, y + dy * size)).collect();
        let _ = self.area.draw(&Polygon::new(outline.iter().copied().map(at).collect::<Vec<_>>(), fill.filled()));
        let closed: Vec<Point> = outline.iter().chain(&outline[..2]).copied().collect();
        self.line(&closed, color, OUTLINE);
    }

    /// Filled polygon.
    pub fn polygon(&self, points: &[Point], color: RGBColor) {
        let _ = self.area.draw(&Polygon::new(points.iter().copied().map(at).collect::<Vec<_>>(), color.filled()));
    }

    /// Diagonal cross of half width `size`.
    pub fn cross(&self, (x, y): Point, size: f64, color: RGBColor) {
        for turn in [-1.0, 1.0] {
            self.line(&[(x - size, y - turn * size), (x + size, y + turn * size)], color, OUTLINE);
        }
    }

    /// Vertical error bar with caps.
    pub fn error_bar(&self, x: f64, low: f64, high: f64, cap: f64, color: RGBColor) {
        self.line(&[(x, low), (x, high)], color, 1.0);
        for y in [low, high] {
            self.line(&[(x - cap, y), (x + cap, y)], color, 1.0);
        }
    }

    /// Text beside a point, centred on it in height.
    pub fn text(&self, text: &str, at_point: Point, anchor: Anchor, style: Type) {
        self.place(text, at_point, anchor, style, FontTransform::None);
    }

    /// Text that reads upwards, starting at (or centred on) a point.
    pub fn upward_text(&self, text: &str, at_point: Point, anchor: Anchor, style: Type) {
        self.place(text, at_point, anchor, style, FontTransform::Rotate270);
    }

    fn place(&self, text: &str, at_point: Point, anchor: Anchor, style: Type, turn: FontTransform) {
        let horizontal = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let weight = if style.bold { FontStyle::Bold } else { FontStyle::Normal };
        // The back end divides by 1.24.
        let font = FontDesc::new(FontFamily::SansSerif, style.size * SCALE * 1.24, weight).transform(turn);
        let styled = TextStyle::from(font).color(&style.color).pos(Pos::new(horizontal, VPos::Center));
        // A control character in the name of a file would make the sheet unreadable.
        let clean: String = text.chars().filter(|c| !c.is_control()).collect();
        let _ = self.area.draw(&Text::new(clean, at(at_point), styled));
    }
}
