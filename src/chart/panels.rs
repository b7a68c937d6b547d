//! Panels of measured points with error bars on two logarithmic axes: error against time, cost against size.

use super::axis::Axis;
use super::colours::{BLUE, GREEN, ORANGE};
use super::raster::{Align, Colour, FAINT_GRID, GRID, INK, SOFT_INK, WHITE};
use super::shapes::{Drawing, Point};
use crate::render::caption::Lettering;

/// A measured point: low end, value and high end along each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    pub x: [f64; 3],
    pub y: [f64; 3],
}

/// The points of one method in rising order of effort.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub label: String,
    pub marks: Vec<Mark>,
    /// Which of them the program takes by itself; it gets a ring.
    pub chosen: Option<usize>,
}

/// What the numbers of an axis count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Shown as us, ms, s.
    Seconds,
    /// Shown in percent.
    Share,
    /// Shown with k, M, G.
    Count,
    /// Shown as kB, MB, GB.
    Bytes,
    /// Shown as it is.
    Number,
}

/// A panel; everything on it must be above zero, what is not is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    pub title: String,
    /// What the panel rests on, under the title: wrapped as needed.
    pub note: String,
    pub x: (Quantity, String),
    pub y: (Quantity, String),
    pub series: Vec<Series>,
    /// Exponent of a straight line drawn for comparison, and its name.
    pub guide: Option<(f64, String)>,
    /// A level below which nothing can be told, and its name.
    pub floor: Option<(f64, String)>,
}

const COLUMN: f64 = 640.0;
const PLOT_HEIGHT: f64 = 330.0;
const LEFT: f64 = 104.0;
const RIGHT: f64 = 26.0;
const LINE: f64 = 21.0;
const MARKER: f64 = 4.2;
const RING: f64 = 9.0;
const COLOURS: [Colour; 7] = [BLUE, ORANGE, GREEN, [170, 60, 140], [90, 90, 90], [150, 105, 0], [60, 160, 215]];

/// Panels two abreast under one heading; `footer` says on what machine and how. The same input gives the same bytes.
pub fn panels(heading: &str, panels: &[Panel], footer: &[String]) -> Drawing {
    let columns = panels.len().clamp(1, 2);
    let width = COLUMN * columns as f64;
    let wrap = |text: &str, room: f64| Lettering::Small.wrap(text, room as usize);
    let notes: Vec<Vec<String>> = panels.iter().map(|p| wrap(&p.note, COLUMN - LEFT - RIGHT)).collect();
    let note_lines = notes.iter().map(Vec::len).max().unwrap_or(0) as f64;
    let legend_lines = panels.iter().map(legend_rows).max().unwrap_or(0) as f64;
    let row_height = 62.0 + LINE * note_lines + PLOT_HEIGHT + 64.0 + LINE * legend_lines + 26.0;
    let rows = panels.len().div_ceil(columns) as f64;
    let footer: Vec<String> = footer.iter().flat_map(|line| wrap(line, width - 40.0)).collect();
    let top = 56.0;
    let height = top + rows * row_height + LINE * footer.len() as f64 + 14.0;
    let mut drawing = Drawing::new(width, height);
    drawing.text(heading, (0.5 * width, 28.0), Align::Middle, Lettering::Heading, INK);
    for (k, panel) in panels.iter().enumerate() {
        let corner = (COLUMN * (k % columns) as f64, top + row_height * (k / columns) as f64);
        draw(&mut drawing, panel, &notes[k], corner, note_lines);
    }
    for (k, line) in footer.iter().enumerate() {
        let y = top + rows * row_height + LINE * (k as f64 + 0.3);
        drawing.text(line, (20.0, y), Align::Start, Lettering::Small, SOFT_INK);
    }
    drawing
}

/// Legend entries: series, guide, floor, ring.
fn legend_rows(panel: &Panel) -> usize {
    let ring = usize::from(panel.series.iter().any(|s| s.chosen.is_some()));
    let extra = usize::from(panel.guide.is_some()) + usize::from(panel.floor.is_some()) + ring;
    (panel.series.len() + extra).div_ceil(2)
}

struct Frame {
    x: Axis,
    y: Axis,
    left: f64,
    top: f64,
    width: f64,
}

impl Frame {
    fn place(&self, x: f64, y: f64) -> Point {
        (self.across(x), self.up(y))
    }

    /// Clamped to the frame: a bar that goes to zero ends there.
    fn across(&self, x: f64) -> f64 {
        let share = if x > 0.0 { self.x.share(x).clamp(0.0, 1.0) } else { 0.0 };
        self.left + share * self.width
    }

    fn up(&self, y: f64) -> f64 {
        let share = if y > 0.0 { self.y.share(y).clamp(0.0, 1.0) } else { 0.0 };
        self.top + (1.0 - share) * PLOT_HEIGHT
    }
}

fn usable(mark: &Mark) -> bool {
    [mark.x[1], mark.y[1]].iter().all(|v| v.is_finite() && *v > 0.0)
}

/// Axis over the values, at least a third of a decade.
fn axis(values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    if high > 0.0 { Axis::logarithmic(low.min(high / 2.0), high.max(low * 2.0)) } else { Axis::logarithmic(1.0, 10.0) }
}

fn draw(drawing: &mut Drawing, panel: &Panel, note: &[String], (x0, y0): Point, note_lines: f64) {
    let marks = || panel.series.iter().flat_map(|s| &s.marks).filter(|m| usable(m));
    let floor = panel.floor.as_ref().map(|f| f.0).filter(|f| *f > 0.0);
    let frame = Frame {
        x: axis(marks().map(|m| m.x[1])),
        y: axis(marks().map(|m| m.y[1]).chain(floor)),
        left: x0 + LEFT,
        top: y0 + 56.0 + LINE * note_lines,
        width: COLUMN - LEFT - RIGHT,
    };
    drawing.text(&panel.title, (frame.left, y0 + 12.0), Align::Start, Lettering::Strong, INK);
    for (k, line) in note.iter().enumerate() {
        drawing.text(line, (frame.left, y0 + 36.0 + LINE * k as f64), Align::Start, Lettering::Small, SOFT_INK);
    }
    grid(drawing, panel, &frame);
    if let Some(floor) = floor {
        let y = frame.up(floor);
        drawing.dashed(vec![(frame.left, y), (frame.left + frame.width, y)], SOFT_INK, 1.2, [2.0, 4.0]);
    }
    if let Some((slope, _)) = panel.guide {
        guide(drawing, &frame, slope, marks());
    }
    for (k, series) in panel.series.iter().enumerate() {
        draw_series(drawing, &frame, series, COLOURS[k % COLOURS.len()], k);
    }
    let corners = [(0.0, 0.0), (frame.width, 0.0), (frame.width, PLOT_HEIGHT), (0.0, PLOT_HEIGHT), (0.0, 0.0)];
    drawing.line(corners.map(|(x, y)| (frame.left + x, frame.top + y)).to_vec(), SOFT_INK, 1.0);
    legend(drawing, panel, x0 + 40.0, frame.top + PLOT_HEIGHT + 74.0);
}

fn grid(drawing: &mut Drawing, panel: &Panel, frame: &Frame) {
    let bottom = frame.top + PLOT_HEIGHT;
    for (ticks, ink) in [(&frame.x.minor, FAINT_GRID), (&frame.x.ticks, GRID)] {
        for &v in ticks {
            drawing.line(vec![(frame.across(v), frame.top), (frame.across(v), bottom)], ink, 1.0);
        }
    }
    for (ticks, ink) in [(&frame.y.minor, FAINT_GRID), (&frame.y.ticks, GRID)] {
        for &v in ticks {
            drawing.line(vec![(frame.left, frame.up(v)), (frame.left + frame.width, frame.up(v))], ink, 1.0);
        }
    }
    let mut taken = f64::NEG_INFINITY;
    for &v in &frame.x.ticks {
        let text = label(panel.x.0, v);
        let half = 0.5 * Lettering::Small.text_width(&text) as f64;
        let x = frame.across(v);
        // A label that would touch the one before is left out.
        if x - half > taken + 6.0 {
            drawing.text(&text, (x, bottom + 17.0), Align::Middle, Lettering::Small, INK);
            taken = x + half;
        }
    }
    let mut taken = f64::INFINITY;
    for &v in &frame.y.ticks {
        let y = frame.up(v);
        if y < taken - 17.0 {
            drawing.text(&label(panel.y.0, v), (frame.left - 8.0, y), Align::End, Lettering::Small, INK);
            taken = y;
        }
    }
    let middle = frame.left + 0.5 * frame.width;
    drawing.text(&panel.x.1, (middle, bottom + 44.0), Align::Middle, Lettering::Small, INK);
    // Above the axis: upright letters are read more easily than turned ones.
    drawing.text(&panel.y.1, (frame.left - 60.0, frame.top - 15.0), Align::Start, Lettering::Small, INK);
}

/// A line of the given slope through the middle of the marks.
fn guide<'a>(drawing: &mut Drawing, frame: &Frame, slope: f64, marks: impl Iterator<Item = &'a Mark>) {
    let logs: Vec<(f64, f64)> = marks.map(|m| (m.x[1].ln(), m.y[1].ln())).collect();
    if logs.is_empty() {
        return;
    }
    let n = logs.len() as f64;
    let (x, y) = logs.iter().fold((0.0, 0.0), |a, p| (a.0 + p.0 / n, a.1 + p.1 / n));
    let at = |log_x: f64| y + slope * (log_x - x);
    // Cut where the line leaves the frame.
    let (low, high) = (frame.y.low.ln(), frame.y.high.ln());
    let ends = [low, high].map(|end| x + (end - y) / slope);
    let (from, to) = (ends[0].min(ends[1]).max(frame.x.low.ln()), ends[0].max(ends[1]).min(frame.x.high.ln()));
    if from < to {
        let points = [from, to].map(|log_x| frame.place(log_x.exp(), at(log_x).exp()));
        drawing.dashed(points.to_vec(), SOFT_INK, 1.0, [7.0, 5.0]);
    }
}

fn draw_series(drawing: &mut Drawing, frame: &Frame, series: &Series, ink: Colour, shape: usize) {
    let visible: Vec<(usize, &Mark)> = series.marks.iter().enumerate().filter(|m| usable(m.1)).collect();
    let places: Vec<Point> = visible.iter().map(|(_, m)| frame.place(m.x[1], m.y[1])).collect();
    if places.len() > 1 {
        drawing.line(places.clone(), ink, 1.8);
    }
    for ((_, m), &(x, y)) in visible.iter().zip(&places) {
        bar(drawing, [(frame.across(m.x[0]), y), (frame.across(m.x[2]), y)], ink);
        bar(drawing, [(x, frame.up(m.y[0])), (x, frame.up(m.y[2]))], ink);
    }
    for ((k, _), &place) in visible.iter().zip(&places) {
        marker(drawing, place, shape, ink);
        if series.chosen == Some(*k) {
            ring(drawing, place);
        }
    }
}

/// An error bar with caps, if it is longer than the marker is wide.
fn bar(drawing: &mut Drawing, [a, b]: [Point; 2], ink: Colour) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    if dx.hypot(dy) < 2.0 * MARKER {
        return;
    }
    let (cx, cy) = if dx.abs() > dy.abs() { (0.0, 3.0) } else { (3.0, 0.0) };
    drawing.line(vec![a, b], ink, 1.0);
    for end in [a, b] {
        drawing.line(vec![(end.0 - cx, end.1 - cy), (end.0 + cx, end.1 + cy)], ink, 1.0);
    }
}

/// Outlines that a grey print can tell apart.
fn marker(drawing: &mut Drawing, (x, y): Point, shape: usize, ink: Colour) {
    let corners = |n: usize, turn: f64, size: f64| -> Vec<Point> {
        let corner = |k: usize| std::f64::consts::TAU * (k as f64 + turn) / n as f64;
        (0..n).map(|k| (x + size * corner(k).cos(), y + size * corner(k).sin())).collect()
    };
    let outline = match shape % 7 {
        0 => corners(16, 0.0, MARKER),
        1 => corners(4, 0.5, 1.25 * MARKER),
        2 => corners(3, 0.25, 1.4 * MARKER),
        3 => corners(4, 0.0, 1.35 * MARKER),
        4 => corners(3, 0.75, 1.4 * MARKER),
        5 => corners(5, 0.75, 1.25 * MARKER),
        _ => corners(6, 0.0, 1.2 * MARKER),
    };
    drawing.polygon(outline, ink);
}

fn ring(drawing: &mut Drawing, (x, y): Point) {
    let at = |k: usize| std::f64::consts::TAU * k as f64 / 24.0;
    drawing.line((0..=24).map(|k| (x + RING * at(k).cos(), y + RING * at(k).sin())).collect(), INK, 1.6);
}

fn legend(drawing: &mut Drawing, panel: &Panel, left: f64, top: f64) {
    let place = |k: usize| (left + 0.5 * (COLUMN - 50.0) * (k % 2) as f64, top + LINE * (k / 2) as f64);
    let mut next = 0;
    let mut entry = |drawing: &mut Drawing, text: &str, swatch: &dyn Fn(&mut Drawing, Point)| {
        let (x, y) = place(next);
        swatch(drawing, (x, y));
        drawing.text(text, (x + 40.0, y), Align::Start, Lettering::Small, INK);
        next += 1;
    };
    for (k, series) in panel.series.iter().enumerate() {
        let ink = COLOURS[k % COLOURS.len()];
        entry(drawing, &series.label, &|d, (x, y)| {
            d.line(vec![(x, y), (x + 30.0, y)], ink, 1.8);
            marker(d, (x + 15.0, y), k, ink);
        });
    }
    if let Some((_, name)) = &panel.guide {
        entry(drawing, name, &|d, (x, y)| d.dashed(vec![(x, y), (x + 30.0, y)], SOFT_INK, 1.0, [7.0, 5.0]));
    }
    if let Some((_, name)) = &panel.floor {
        entry(drawing, name, &|d, (x, y)| d.dashed(vec![(x, y), (x + 30.0, y)], SOFT_INK, 1.2, [2.0, 4.0]));
    }
    if panel.series.iter().any(|s| s.chosen.is_some()) {
        entry(drawing, "ring: what the program takes", &|d, (x, y)| {
            d.polygon(vec![(x, y), (x, y)], WHITE);
            ring(d, (x + 15.0, y));
        });
    }
}

/// A tick in the unit that suits it.
fn label(quantity: Quantity, value: f64) -> String {
    let with = |steps: &[(f64, &str)], value: f64| {
        let at = steps.iter().rposition(|s| value >= s.0 * (1.0 - 1e-9)).unwrap_or(0);
        let (size, unit) = steps[at];
        format!("{}{unit}", plain(value / size))
    };
    match quantity {
        Quantity::Seconds => with(&[(1e-9, " ns"), (1e-6, " \u{b5}s"), (1e-3, " ms"), (1.0, " s")], value),
        Quantity::Share => format!("{} %", plain(100.0 * value)),
        Quantity::Count => with(&[(1.0, ""), (1e3, " k"), (1e6, " M"), (1e9, " G")], value),
        Quantity::Bytes => with(&[(1.0, " B"), (1e3, " kB"), (1e6, " MB"), (1e9, " GB")], value),
        Quantity::Number => plain(value),
    }
}

/// As many decimals as a number of one digit needs; powers of ten where that would be long.
fn plain(value: f64) -> String {
    let exponent = (value * (1.0 + 1e-9)).log10().floor() as i32;
    match exponent {
        -5..=-1 => format!("{value:.*}", -exponent as usize),
        0..=5 => format!("{value:.0}"),
        _ => format!("{value:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_carry_units_that_suit_them() {
        for (quantity, value, text) in [
            (Quantity::Seconds, 2e-5, "20 \u{b5}s"),
            (Quantity::Seconds, 1e-3, "1 ms"),
            (Quantity::Seconds, 10.0, "10 s"),
            (Quantity::Share, 1e-4, "0.01 %"),
            (Quantity::Share, 0.5, "50 %"),
            (Quantity::Count, 1e5, "100 k"),
            (Quantity::Bytes, 2e9, "2 GB"),
            (Quantity::Number, 0.02, "0.02"),
            (Quantity::Number, 1e-7, "1e-7"),
        ] {
            assert_eq!(label(quantity, value), text);
        }
    }

    #[test]
    fn what_has_no_logarithm_is_left_out() {
        let mark = |x: f64, y: f64| Mark { x: [x; 3], y: [0.0, y, 2.0 * y] };
        let panel = |marks: Vec<Mark>| Panel {
            title: "t".into(),
            note: "n".into(),
            x: (Quantity::Seconds, "time".into()),
            y: (Quantity::Share, "error".into()),
            series: vec![Series { label: "method".into(), marks, chosen: Some(0) }],
            guide: Some((-0.5, "slope -1/2".into())),
            floor: Some((0.0, "nothing".into())),
        };
        let odd = vec![mark(1.0, 0.1), mark(f64::NAN, 0.1), mark(2.0, 0.0), mark(-1.0, 0.1), mark(3.0, f64::INFINITY)];
        let found = panels("h", &[panel(odd)], &["made here".into()]);
        let alone = panels("h", &[panel(vec![mark(1.0, 0.1)])], &["made here".into()]);
        assert_eq!(found, alone);
        assert!(panels("h", &[panel(Vec::new())], &[]).to_svg().contains("method"));
        assert!(found.to_svg().contains("made here"));
    }
}
