//! The chart `gloss_vs_roughness.svg`: what the glossmeter reads against the rms height of the surface.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Marker, Point, Type, sheet, text_width};
use crate::math::Estimate;
use crate::meter::Holds;
use plotters::style::RGBColor;

/// One surface on the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct GlossPoint {
    /// Name of the map, written above the plot if there is room for all of them.
    pub name: String,
    /// Root-mean-square height Sq \[m\].
    pub sq: f64,
    /// Gloss at 20, 60 and 85 deg \[gloss units\].
    pub gloss: [Estimate; 3],
    /// Which calculation stands behind each.
    pub holds: [Holds; 3],
    /// What rays alone give \[gloss units\]: shown where the value is not theirs.
    pub ray_gloss: Option<[f64; 3]>,
}

struct Series {
    label: &'static str,
    color: RGBColor,
    marker: Marker,
    dashes: &'static [f64],
}

/// Colours of Okabe and Ito (2008), told apart by every kind of colour vision; marker and dash serve a grey print.
const SERIES: [Series; 3] = [
    Series { label: "20\u{b0}", color: RGBColor(0, 114, 178), marker: Marker::Circle, dashes: &[] },
    Series { label: "60\u{b0}", color: RGBColor(213, 94, 0), marker: Marker::Square, dashes: &[9.0, 4.0] },
    Series { label: "85\u{b0}", color: RGBColor(0, 130, 95), marker: Marker::Triangle, dashes: &[9.0, 3.5, 2.0, 3.5] },
];

const INK: RGBColor = RGBColor(30, 30, 30);
const GRID: RGBColor = RGBColor(222, 222, 222);
const FAINT_GRID: RGBColor = RGBColor(240, 240, 240);
const SOFT_INK: RGBColor = RGBColor(95, 95, 95);

const TITLE: Type = Type { size: 17.0, color: INK, bold: true };
const SMALLEST_TITLE: f64 = 10.0;
const LABEL: Type = Type { size: 14.0, color: INK, bold: false };
const TICK: Type = Type { size: 12.5, color: INK, bold: false };
const NAME: Type = Type { size: 10.5, color: SOFT_INK, bold: false };

const WIDTH: f64 = 860.0;
const PLOT_HEIGHT: f64 = 420.0;
const LEFT: f64 = 78.0;
const RIGHT: f64 = 28.0;
const BELOW: f64 = 124.0;
const MARKER: f64 = 4.5;
/// Half width of the crosses.
const CROSS: f64 = 3.0;
/// Room between the ends of the axis of Sq and the frame, so that a marker at the end is not on the frame.
const INSET: f64 = 14.0;

/// Longest name written above the plot, and the room a turned line of it needs.
const NAME_LETTERS: usize = 24;
const NAME_PITCH: f64 = 13.0;

/// Chart of gloss \[gloss units\] against Sq \[nm\] as SVG text: one line per geometry, bars of one standard error,
/// hollow markers where waves made the value, with a cross at what rays alone give, crossed markers where nothing holds.
///
/// The axis of Sq is logarithmic if every Sq is positive and they span more than a decade. Points whose Sq or gloss
/// is not a finite number are left out. The same input gives the same bytes.
pub fn gloss_vs_roughness(points: &[GlossPoint], title: &str) -> String {
    let mut points: Vec<&GlossPoint> = points.iter().filter(|p| p.sq.is_finite() && p.sq >= 0.0).collect();
    points.sort_by(|a, b| a.sq.total_cmp(&b.sq));
    let frame = Frame::new(&points);
    sheet(WIDTH, frame.bottom + BELOW, |canvas| {
        // A long title is set smaller, a very long one cut. Bold letters are a tenth wider.
        let room = (WIDTH - 40.0) / 1.1;
        let title = shortened(title, (room / text_width("m", SMALLEST_TITLE)) as usize);
        let size = TITLE.size.min(room / text_width(&title, 1.0).max(1.0));
        canvas.text(&title, (WIDTH / 2.0, 24.0), Anchor::Middle, Type { size, ..TITLE });
        frame.draw_grid(canvas);
        frame.draw_outline(canvas);
        frame.draw_names(canvas, &points);
        for (k, series) in SERIES.iter().enumerate() {
            frame.draw_series(canvas, &points, k, series);
        }
        legend(canvas, frame.bottom + 76.0, &points);
        if !points.iter().any(|p| p.gloss.iter().any(shown)) {
            let middle = (0.5 * (LEFT + WIDTH - RIGHT), 0.5 * (frame.top + frame.bottom));
            canvas.text("no surface to show", middle, Anchor::Middle, LABEL);
        }
    })
}

fn shown(gloss: &Estimate) -> bool {
    gloss.value.is_finite()
}

fn error(gloss: &Estimate) -> f64 {
    if gloss.standard_error.is_finite() { gloss.standard_error } else { 0.0 }
}

/// Scales and the rectangle they fill.
struct Frame {
    x: Axis,
    y: Axis,
    top: f64,
    bottom: f64,
    names: bool,
}

impl Frame {
    fn new(points: &[&GlossPoint]) -> Self {
        let lowest = points.first().map_or(0.0, |p| p.sq * 1e9);
        let highest = points.last().map_or(0.0, |p| p.sq * 1e9);
        let x = if lowest > 0.0 && highest > 10.0 * lowest {
            Axis::logarithmic(lowest, highest)
        } else if highest > lowest && highest < 1.5 * lowest {
            // Surfaces so alike would be one column of markers on an axis from zero.
            Axis::linear(lowest, highest, 8)
        } else {
            Axis::from_zero(highest, 8)
        };
        let rays = points.iter().filter_map(|p| p.ray_gloss).flatten().filter(|g| g.is_finite());
        let tops = points.iter().flat_map(|p| &p.gloss).filter(|g| shown(g)).map(|g| g.value + error(g)).chain(rays);
        let y = Axis::from_zero(tops.fold(0.0, f64::max) * 1.01, 6);
        let longest =
            points.iter().map(|p| text_width(&shortened(&p.name, NAME_LETTERS), NAME.size)).fold(0.0, f64::max);
        let names = longest > 0.0 && points.len() as f64 * NAME_PITCH <= 0.5 * (WIDTH - LEFT - RIGHT);
        let top = 50.0 + if names { longest + 22.0 } else { 0.0 };
        Frame { x, y, top, bottom: top + PLOT_HEIGHT, names }
    }

    fn across(&self, value: f64) -> f64 {
        LEFT + INSET + self.x.share(value) * (WIDTH - RIGHT - LEFT - 2.0 * INSET)
    }

    fn up(&self, value: f64) -> f64 {
        self.bottom - self.y.share(value.max(0.0)) * PLOT_HEIGHT
    }

    fn draw_grid(&self, canvas: &Canvas) {
        let vertical = |v: f64, color| {
            let x = self.across(v);
            canvas.line(&[(x, self.top), (x, self.bottom)], color, 1.0);
        };
        self.x.minor.iter().for_each(|&v| vertical(v, FAINT_GRID));
        for (&v, label) in self.x.ticks.iter().zip(self.x.labels()) {
            vertical(v, GRID);
            canvas.text(&label, (self.across(v), self.bottom + 17.0), Anchor::Middle, TICK);
        }
        for (&v, label) in self.y.ticks.iter().zip(self.y.labels()) {
            let y = self.up(v);
            canvas.line(&[(LEFT, y), (WIDTH - RIGHT, y)], GRID, 1.0);
            canvas.text(&label, (LEFT - 9.0, y), Anchor::End, TICK);
        }
        let middle = 0.5 * (LEFT + WIDTH - RIGHT);
        canvas.text("Root-mean-square height Sq / nm", (middle, self.bottom + 43.0), Anchor::Middle, LABEL);
        canvas.upward_text("Specular gloss / GU", (24.0, 0.5 * (self.top + self.bottom)), Anchor::Middle, LABEL);
    }

    fn draw_outline(&self, canvas: &Canvas) {
        let (left, right) = (LEFT, WIDTH - RIGHT);
        let corners =
            [(left, self.top), (right, self.top), (right, self.bottom), (left, self.bottom), (left, self.top)];
        canvas.line(&corners, SOFT_INK, 1.0);
    }

    /// Names above the plot, pushed apart until none touch, each with a leader to its place on the axis.
    fn draw_names(&self, canvas: &Canvas, points: &[&GlossPoint]) {
        if !self.names {
            return;
        }
        let mut places: Vec<f64> = points.iter().map(|p| self.across(p.sq * 1e9)).collect();
        for k in 1..places.len() {
            places[k] = places[k].max(places[k - 1] + NAME_PITCH);
        }
        let mut limit = WIDTH - RIGHT;
        for place in places.iter_mut().rev() {
            *place = place.min(limit);
            limit = *place - NAME_PITCH;
        }
        for (point, place) in points.iter().zip(places) {
            let x = self.across(point.sq * 1e9);
            canvas.line(&[(x, self.top), (place, self.top - 12.0), (place, self.top - 16.0)], SOFT_INK, 0.75);
            canvas.upward_text(&shortened(&point.name, NAME_LETTERS), (place, self.top - 20.0), Anchor::Start, NAME);
        }
    }

    fn draw_series(&self, canvas: &Canvas, points: &[&GlossPoint], k: usize, series: &Series) {
        let place = |p: &GlossPoint| (self.across(p.sq * 1e9), self.up(p.gloss[k].value));
        let visible: Vec<&&GlossPoint> = points.iter().filter(|p| shown(&p.gloss[k])).collect();
        let line: Vec<Point> = visible.iter().map(|p| place(p)).collect();
        if line.len() > 1 {
            canvas.dashed(&line, series.color, 1.5, series.dashes);
        }
        for point in &visible {
            let (g, (x, _)) = (&point.gloss[k], place(point));
            if error(g) > 0.0 {
                canvas.error_bar(x, self.up(g.value - error(g)), self.up(g.value + error(g)), 4.0, series.color);
            }
        }
        for point in &visible {
            let ray = point.ray_gloss.map(|g| g[k]).filter(|g| g.is_finite());
            if let (Holds::Waves, Some(ray)) = (point.holds[k], ray) {
                canvas.cross((place(point).0, self.up(ray)), CROSS, series.color);
            }
        }
        for point in visible {
            draw_marker(canvas, place(point), series, point.holds[k]);
        }
    }
}

fn draw_marker(canvas: &Canvas, place: Point, series: &Series, holds: Holds) {
    canvas.marker(place, series.marker, MARKER, series.color, holds != Holds::Rays);
    if holds == Holds::Neither {
        canvas.cross(place, 0.8 * MARKER, series.color);
    }
}

/// Rows below the plot, where no data can be: the series, then what bars and markers mean.
fn legend(canvas: &Canvas, y: f64, points: &[&GlossPoint]) {
    let bars = points.iter().flat_map(|p| &p.gloss).any(|g| error(g) > 0.0);
    let any = |wanted: Holds| points.iter().flat_map(|p| p.holds).any(|holds| holds == wanted);
    let names = SERIES.map(|s| format!("gloss at {}", s.label));
    let swatches = SERIES.iter().zip(&names).map(|(series, name)| Entry { note: name, sign: Sign::Line(series) });
    let signs = [
        (true, if bars { "bars: \u{b1}1 standard error" } else { "no error bars: exact values" }, Sign::Bar(bars)),
        (any(Holds::Waves), "hollow: by waves, g < 9", Sign::Markers(Holds::Waves)),
        (any(Holds::Waves) && points.iter().any(|p| p.ray_gloss.is_some()), "rays alone", Sign::Cross),
        (any(Holds::Neither), "crossed out: neither holds", Sign::Markers(Holds::Neither)),
    ];
    draw_row(canvas, y, swatches.collect());
    let signs = signs.into_iter().filter(|s| s.0).map(|(_, note, sign)| Entry { note, sign });
    draw_row(canvas, y + 24.0, signs.collect());
}

/// What stands before a note of the legend.
enum Sign<'a> {
    Line(&'a Series),
    Bar(bool),
    Markers(Holds),
    Cross,
}

struct Entry<'a> {
    note: &'a str,
    sign: Sign<'a>,
}

fn draw_row(canvas: &Canvas, y: f64, entries: Vec<Entry>) {
    const SWATCH: f64 = 44.0;
    const GAP: f64 = 20.0;
    let width = |entry: &Entry| SWATCH + text_width(entry.note, TICK.size);
    let total = entries.iter().map(width).sum::<f64>() + GAP * (entries.len() as f64 - 1.0);
    let mut x = 0.5 * (LEFT + WIDTH - RIGHT) - 0.5 * total;
    for entry in entries {
        match entry.sign {
            Sign::Line(series) => {
                canvas.dashed(&[(x, y), (x + 36.0, y)], series.color, 1.5, series.dashes);
                canvas.marker((x + 18.0, y), series.marker, MARKER, series.color, false);
            }
            Sign::Bar(true) => canvas.error_bar(x + 30.0, y - 8.0, y + 8.0, 4.0, INK),
            Sign::Bar(false) => {}
            Sign::Markers(holds) => {
                for (series, dx) in SERIES.iter().zip([6.0, 18.0, 30.0]) {
                    draw_marker(canvas, (x + dx, y), series, holds);
                }
            }
            Sign::Cross => {
                for (series, dx) in SERIES.iter().zip([6.0, 18.0, 30.0]) {
                    canvas.cross((x + dx, y), CROSS, series.color);
                }
            }
        }
        canvas.text(entry.note, (x + SWATCH, y), Anchor::Start, TICK);
        x += width(&entry) + GAP;
    }
}

/// `text` with its middle cut out if it is longer than `letters`: names of maps differ at either end.
fn shortened(text: &str, letters: usize) -> String {
    let all: Vec<char> = text.chars().collect();
    if all.len() <= letters {
        return text.to_owned();
    }
    let head = letters.saturating_sub(1).div_ceil(2);
    let tail = letters.saturating_sub(1) - head;
    all[..head].iter().chain(&['\u{2026}']).chain(&all[all.len() - tail..]).collect()
}
