//! Where rays fail: gloss by waves less gloss by rays over Sq and autocorrelation length, a panel per angle.

use super::raster::{Align, Colour, INK, SOFT_INK};
use super::shapes::{Drawing, Point};
use crate::meter::ray_wave::Reading;
use crate::meter::validity::SMALLEST_FOR_RAYS;
use crate::render::caption::Lettering;

const PANEL: f64 = 500.0;
const GAP: f64 = 64.0;
const LEFT: f64 = 110.0;
const TOP: f64 = 110.0;
const ROW: f64 = 40.0;
const BELOW: f64 = 150.0;

/// Largest difference \[GU\] of each class, and its colour: light where rays serve, dark where they mislead.
const CLASSES: [(f64, Colour); 5] = [
    (0.5, [237, 244, 240]),
    (2.0, [253, 226, 176]),
    (10.0, [247, 178, 103]),
    (50.0, [217, 105, 55]),
    (f64::INFINITY, [140, 45, 25]),
];

/// Panels of cells, the Sq upwards and the autocorrelation length to the right, both in the steps that were computed; each
/// cell tells `wave - ray` in gloss units, with a star where the wave calculation is in doubt. The line is `g = 9`.
pub fn ray_wave_chart(readings: &[Reading], wavelength: f64, title: &str) -> Drawing {
    let rising = |of: fn(&Reading) -> f64| {
        let mut values: Vec<f64> = readings.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (sq, acl, angles) = (rising(|r| r.sq), rising(|r| r.acl), rising(|r| r.theta_i));
    let panels = angles.len().max(1) as f64;
    let height = ROW * sq.len().max(1) as f64;
    let width = LEFT + panels * PANEL + (panels - 1.0) * GAP + 70.0;
    let mut drawing = Drawing::new(width, TOP + height + BELOW);
    drawing.text(title, (40.0, 36.0), Align::Start, Lettering::Heading, INK);
    for (k, &theta) in angles.iter().enumerate() {
        let panel = Panel { left: LEFT + k as f64 * (PANEL + GAP), height, sq: &sq, acl: &acl };
        let here: Vec<&Reading> = readings.iter().filter(|r| r.theta_i == theta).collect();
        panel.cells(&mut drawing, &here);
        panel.limit(&mut drawing, SMALLEST_FOR_RAYS.sqrt() * wavelength / (4.0 * std::f64::consts::PI * theta.cos()));
        panel.numbers(&mut drawing, &here);
        panel.labels(&mut drawing, theta, k == 0);
    }
    legend(&mut drawing, TOP + height + 106.0);
    drawing
}

struct Panel<'a> {
    left: f64,
    height: f64,
    sq: &'a [f64],
    acl: &'a [f64],
}

impl Panel<'_> {
    fn column(&self) -> f64 {
        PANEL / self.acl.len() as f64
    }

    /// Middle of the cell of that number.
    fn middle(&self, across: usize, up: usize) -> Point {
        (self.left + (across as f64 + 0.5) * self.column(), TOP + self.height - (up as f64 + 0.5) * ROW)
    }

    /// Middle of the cell of a reading.
    fn place(&self, r: &Reading) -> Point {
        let number = |list: &[f64], v: f64| list.iter().position(|x| *x == v).unwrap_or(0);
        self.middle(number(self.acl, r.acl), number(self.sq, r.sq))
    }

    fn cells(&self, drawing: &mut Drawing, readings: &[&Reading]) {
        for r in readings {
            let (x, y) = self.place(r);
            let (w, h) = (0.5 * self.column() - 0.5, 0.5 * ROW - 0.5);
            let corners = vec![(x - w, y - h), (x + w, y - h), (x + w, y + h), (x - w, y + h)];
            drawing.polygon(corners, CLASSES[class(r)].1);
        }
    }

    fn numbers(&self, drawing: &mut Drawing, readings: &[&Reading]) {
        for r in readings {
            let ink = if class(r) >= 3 { [255, 255, 255] } else { INK };
            let star = if r.doubt { "*" } else { "" };
            let text = format!("{}{star}", signed(r.wave.value - r.ray.value));
            drawing.text(&text, self.place(r), Align::Middle, Lettering::Small, ink);
        }
    }

    /// The Sq at which g is 9, between the rows by the logarithm.
    fn limit(&self, drawing: &mut Drawing, sq: f64) {
        let above = self.sq.iter().position(|v| *v >= sq);
        let row = match above {
            Some(0) | None => return,
            Some(k) => (k - 1) as f64 + (sq / self.sq[k - 1]).ln() / (self.sq[k] / self.sq[k - 1]).ln(),
        };
        let y = TOP + self.height - (row + 0.5) * ROW;
        drawing.line(vec![(self.left, y), (self.left + PANEL, y)], [90, 160, 215], 3.0);
        let text = format!("g = {SMALLEST_FOR_RAYS:.0}");
        drawing.text(&text, (self.left + PANEL + 3.0, y), Align::Start, Lettering::Small, [0, 84, 140]);
    }

    fn labels(&self, drawing: &mut Drawing, theta: f64, first: bool) {
        let title = format!("{:.0}\u{b0}", theta.to_degrees());
        drawing.text(&title, (self.left + 0.5 * PANEL, TOP - 26.0), Align::Middle, Lettering::Strong, INK);
        for (k, acl) in self.acl.iter().enumerate() {
            let (x, _) = self.middle(k, 0);
            drawing.text(&short(acl * 1e6), (x, TOP + self.height + 18.0), Align::Middle, Lettering::Small, INK);
        }
        let below = (self.left + 0.5 * PANEL, TOP + self.height + 46.0);
        drawing.text("autocorrelation length / um", below, Align::Middle, Lettering::Small, SOFT_INK);
        if first {
            for (k, sq) in self.sq.iter().enumerate() {
                let (_, y) = self.middle(0, k);
                drawing.text(&short(sq * 1e9), (self.left - 10.0, y), Align::End, Lettering::Small, INK);
            }
            drawing.text("Sq / nm", (self.left - 10.0, TOP - 26.0), Align::End, Lettering::Small, SOFT_INK);
        }
    }
}

/// Number of the class of a reading.
fn class(r: &Reading) -> usize {
    let difference = (r.wave.value - r.ray.value).abs();
    CLASSES.iter().position(|c| difference < c.0).unwrap_or(CLASSES.len() - 1)
}

fn legend(drawing: &mut Drawing, y: f64) {
    let mut x = 40.0;
    let mut note = |drawing: &mut Drawing, text: &str, paper: Option<Colour>| {
        if let Some(paper) = paper {
            drawing.polygon(vec![(x, y - 9.0), (x + 26.0, y - 9.0), (x + 26.0, y + 9.0), (x, y + 9.0)], paper);
            x += 34.0;
        }
        drawing.text(text, (x, y), Align::Start, Lettering::Small, INK);
        x += Lettering::Small.text_width(text) as f64 + 24.0;
    };
    note(drawing, "wave - ray, GU:", None);
    let mut from = 0.0;
    for (to, paper) in CLASSES {
        let text = if to.is_finite() { format!("{from} to {to}") } else { format!("above {from}") };
        note(drawing, &text, Some(paper));
        from = to;
    }
    note(drawing, "*: second bounces or sharp curvature, waves doubtful too", None);
}

/// Three digits at most, with the sign of a difference.
fn signed(v: f64) -> String {
    let text = if v.abs() < 9.95 { format!("{v:+.1}") } else { format!("{v:+.0}") };
    if text == "-0.0" || text == "+0.0" { "0".to_owned() } else { text }
}

fn short(v: f64) -> String {
    if v < 9.95 { format!("{v:.1}") } else { format!("{v:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Estimate;

    #[test]
    fn differences_are_short_and_classed() {
        assert_eq!([0.04, -0.04, 0.26, -12.4, 99.6].map(signed), ["0", "0", "+0.3", "-12", "+100"]);
        let reading = |sq: f64, wave: f64, doubt: bool| Reading {
            sq,
            acl: 1e-5,
            theta_i: 1.0,
            g: 1.0,
            ray: Estimate::exact(0.0),
            wave: Estimate::exact(wave),
            doubt,
        };
        let some = [reading(1e-7, 60.0, false), reading(1e-6, 0.1, true)];
        let svg = ray_wave_chart(&some, 550e-9, "t").to_svg();
        for text in ["+60", "+0.1*", "g = 9", "above 50"] {
            assert!(svg.contains(text), "{text}");
        }
        // Nothing to show is no fault.
        assert!(ray_wave_chart(&[], 550e-9, "t").to_svg().contains("GU"));
    }
}
