//! A panel of the page: axes, grid and curves in a rectangle of pixels.

use super::axis::Axis;
use super::raster::{Align, Area, Colour, FAINT_GRID, GRID, INK, Raster, SOFT_INK, WHITE};
use crate::render::caption::Lettering;

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub ink: Colour,
    pub width: f64,
    /// Lengths of dash and gap.
    pub dashes: Option<[f64; 2]>,
}

/// A curve; without a label it is not in the legend. Points that are not finite break it.
#[derive(Debug, Clone)]
pub struct Curve {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    pub stroke: Stroke,
}

/// A panel with its title on top, the legend below the title, then the plot.
#[derive(Debug, Clone)]
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub x_label: String,
    pub y_label: String,
    pub curves: Vec<Curve>,
}

const TITLE_ROOM: usize = 32;
const LEGEND_ROOM: usize = 26;
const BELOW: usize = 62;
const SWATCH: usize = 34;
const LEGEND_GAP: usize = 26;
/// Half the width of a cross.
const MARK: f64 = 2.5;

/// Axis over at least `low` to `high` that ends at powers of ten, each of them labelled as such.
pub fn decades(low: f64, high: f64) -> Axis {
    let first = low.log10().floor() as i32;
    let last = (high.log10().ceil() as i32).max(first + 1);
    let minor = (first..last).flat_map(|e| (2..10).map(move |m| f64::from(m) * 10f64.powi(e)));
    // Many decades leave room for every second or third label only.
    let every = 1 + (last - first) / 9;
    let ticks = (first..=last).filter(|e| (e - first) % every == 0).map(|e| 10f64.powi(e)).collect();
    let minor = if every > 1 { (first..=last).map(|e| 10f64.powi(e)).collect() } else { minor.collect() };
    Axis { low: 10f64.powi(first), high: 10f64.powi(last), logarithmic: true, ticks, minor }
}

/// Linear axis over exactly `low` to `high`, with ticks at round numbers inside: about `wanted`, but at least three.
pub fn exact(low: f64, high: f64, wanted: usize) -> Axis {
    let slack = 1e-9 * (high - low);
    let inside = |wanted: usize| -> Vec<f64> {
        let round = Axis::linear(low, high, wanted);
        round.ticks.into_iter().filter(|t| *t >= low - slack && *t <= high + slack).collect()
    };
    let mut ticks = inside(wanted);
    for more in wanted + 1..wanted + 6 {
        if ticks.len() < 3 {
            ticks = inside(more);
        }
    }
    Axis { low, high, logarithmic: false, ticks, minor: Vec::new() }
}

impl Plot {
    /// The rectangle of the plot itself inside `area`.
    fn frame(&self, area: Area) -> Area {
        let widest = tick_labels(&self.y).iter().map(Label::width).max().unwrap_or(0);
        let left = 30 + widest + 10;
        let top = TITLE_ROOM + LEGEND_ROOM;
        Area {
            x: area.x + left,
            y: area.y + top,
            width: area.width.saturating_sub(left + 18).max(20),
            height: area.height.saturating_sub(top + BELOW).max(20),
        }
    }

    /// Crosses at points, over a panel that was drawn into the same `area`.
    pub fn marks(&self, raster: &mut Raster, area: Area, series: &[(Colour, Vec<(f64, f64)>)]) {
        let frame = self.frame(area);
        raster.clipped(frame, |raster| {
            for (ink, points) in series {
                for &p in points {
                    let (x, y) = self.place(frame, p);
                    raster.line(&[(x - MARK, y), (x + MARK, y)], *ink, 1.2);
                    raster.line(&[(x, y - MARK), (x, y + MARK)], *ink, 1.2);
                }
            }
        });
    }

    /// Draws the panel into `area`.
    pub fn draw(&self, raster: &mut Raster, area: Area) {
        let labels = tick_labels(&self.y);
        let frame = self.frame(area);
        raster.text(&self.title, frame.x as f64, area.y as f64 + 14.0, Align::Start, Lettering::Strong, INK);
        self.legend(raster, frame.x, area.y + TITLE_ROOM + 8);
        self.grid(raster, frame, &labels);
        raster.clipped(frame, |raster| {
            for curve in &self.curves {
                let points: Vec<_> = curve.points.iter().map(|&p| self.place(frame, p)).collect();
                let Stroke { ink, width, dashes } = curve.stroke;
                match dashes {
                    Some(pattern) => raster.dashed(&points, ink, width, pattern),
                    None => raster.line(&points, ink, width),
                }
            }
        });
        raster.frame(frame, SOFT_INK);
        let middle = frame.x as f64 + 0.5 * frame.width as f64;
        raster.text(&self.x_label, middle, frame.bottom() as f64 + 46.0, Align::Middle, Lettering::Medium, INK);
        let middle = frame.y as f64 + 0.5 * frame.height as f64;
        raster.upward_text(&self.y_label, area.x as f64 + 14.0, middle, Align::Middle, Lettering::Medium, INK);
    }

    fn place(&self, frame: Area, (x, y): (f64, f64)) -> (f64, f64) {
        // Far outside is as good as anywhere outside.
        let share = |axis: &Axis, v: f64| axis.share(v).clamp(-3.0, 4.0);
        (
            frame.x as f64 + share(&self.x, x) * (frame.width - 1) as f64,
            frame.y as f64 + (1.0 - share(&self.y, y)) * (frame.height - 1) as f64,
        )
    }

    fn grid(&self, raster: &mut Raster, frame: Area, y_labels: &[Label]) {
        raster.fill(frame, WHITE);
        raster.clipped(frame, |raster| {
            for (ticks, ink) in [(&self.x.minor, FAINT_GRID), (&self.x.ticks, GRID)] {
                for &v in ticks {
                    let x = self.place(frame, (v, self.y.low)).0.round();
                    raster.line(&[(x, frame.y as f64), (x, frame.bottom() as f64)], ink, 1.0);
                }
            }
            for (ticks, ink) in [(&self.y.minor, FAINT_GRID), (&self.y.ticks, GRID)] {
                for &v in ticks {
                    let y = self.place(frame, (self.x.low, v)).1.round();
                    raster.line(&[(frame.x as f64, y), (frame.right() as f64, y)], ink, 1.0);
                }
            }
        });
        let mut taken = f64::NEG_INFINITY;
        for (&v, label) in self.x.ticks.iter().zip(tick_labels(&self.x)) {
            let x = self.place(frame, (v, self.y.low)).0;
            let half = 0.5 * label.width() as f64;
            // A label that would touch the one before is left out.
            if x - half > taken + 8.0 {
                label.draw(raster, x, frame.bottom() as f64 + 16.0, Align::Middle);
                taken = x + half;
            }
        }
        for (&v, label) in self.y.ticks.iter().zip(y_labels) {
            let y = self.place(frame, (self.x.low, v)).1;
            label.draw(raster, frame.x as f64 - 8.0, y, Align::End);
        }
    }

    fn legend(&self, raster: &mut Raster, left: usize, y: usize) {
        let mut x = left;
        for curve in self.curves.iter().filter(|c| !c.label.is_empty()) {
            let y = y as f64;
            let ends = [(x as f64, y), ((x + SWATCH - 8) as f64, y)];
            match curve.stroke.dashes {
                Some(pattern) => raster.dashed(&ends, curve.stroke.ink, curve.stroke.width, pattern),
                None => raster.line(&ends, curve.stroke.ink, curve.stroke.width),
            }
            x += SWATCH;
            raster.text(&curve.label, x as f64, y, Align::Start, Lettering::Small, INK);
            x += Lettering::Small.text_width(&curve.label) + LEGEND_GAP;
        }
    }
}

/// What stands at a tick.
enum Label {
    Number(String),
    Power(i32),
}

impl Label {
    fn width(&self) -> usize {
        match self {
            Label::Number(text) => Lettering::Small.text_width(text),
            Label::Power(e) => Lettering::Medium.text_width("10") + Lettering::Small.text_width(&e.to_string()),
        }
    }

    fn draw(&self, raster: &mut Raster, x: f64, y: f64, align: Align) {
        match self {
            Label::Number(text) => raster.text(text, x, y, align, Lettering::Small, INK),
            Label::Power(e) => raster.power_of_ten(*e, x, y, align, INK),
        }
    }
}

fn tick_labels(axis: &Axis) -> Vec<Label> {
    if axis.logarithmic {
        return axis.ticks.iter().map(|t| Label::Power(t.log10().round() as i32)).collect();
    }
    axis.labels().into_iter().map(Label::Number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_enclose_and_thin_out() {
        let axis = decades(0.02, 30.0);
        assert_eq!((axis.low, axis.high, axis.ticks.len()), (0.01, 100.0, 5));
        assert!(decades(1e-12, 1e9).ticks.len() <= 9);
        assert_eq!(decades(1.0, 1.0).high, 10.0);
    }

    #[test]
    fn exact_axes_keep_their_ends() {
        let axis = exact(-0.37, 1.02, 6);
        assert_eq!((axis.low, axis.high), (-0.37, 1.02));
        // Six steps over 1.39 ask for 0.23; the next round step is 0.5, and its multiples inside are these.
        assert_eq!(axis.ticks, [0.0, 0.5, 1.0]);
    }
}
