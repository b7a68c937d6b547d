//! Two colours in a pattern: what makes an emitter a lit checker, or a floor a chessboard.

use super::letters::Letters;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;

/// Which points of a shape are bright, in its plane coordinates `u, v` in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pattern {
    /// Bright everywhere.
    Plain,
    /// Alternate cells; the cell at `u = v = 0` is bright.
    Checker { columns: u32, rows: u32 },
    /// Bright lines around dark cells; `line` is the width of a line as a fraction of the cell.
    Grid { columns: u32, rows: u32, line: f64 },
    /// Bright bars along v, each followed by an equal gap and `ratio` times as wide as the one before.
    Bars { count: u32, ratio: f64 },
    /// Bright words; the first line is at `v = 0`, so that they can be read in a mirror at the foot of a quad.
    Text(&'static Letters),
}

impl Pattern {
    /// Whether the point is bright.
    pub fn is_bright(self, [u, v]: [f64; 2]) -> bool {
        match self {
            Pattern::Plain => true,
            Pattern::Checker { columns, rows } => (cell(u, columns).0 + cell(v, rows).0).is_multiple_of(2),
            Pattern::Grid { columns, rows, line } => {
                let near_line = |x: f64| x < line / 2.0 || x > 1.0 - line / 2.0;
                near_line(cell(u, columns).1) || near_line(cell(v, rows).1)
            }
            Pattern::Bars { count, ratio } => {
                let (start, width) = bar(u, count, ratio);
                u - start < 0.5 * width
            }
            Pattern::Text(letters) => letters.is_ink([u, v]),
        }
    }

    /// Share of the unit square that is bright.
    pub fn bright_fraction(self) -> f64 {
        match self {
            Pattern::Plain => 1.0,
            Pattern::Checker { columns, rows } => {
                let cells = f64::from(columns) * f64::from(rows);
                (cells / 2.0).ceil() / cells
            }
            Pattern::Grid { line, .. } => 1.0 - (1.0 - line) * (1.0 - line),
            Pattern::Bars { .. } => 0.5,
            Pattern::Text(letters) => letters.bright_fraction(),
        }
    }

    /// A point uniform over the bright part, or over the dark part, from `u` in `[0, 1)^2`.
    fn point_in(self, bright: bool, [u, v]: [f64; 2]) -> [f64; 2] {
        match self {
            Pattern::Checker { columns, rows } => {
                let dark = u32::from(!bright);
                let count = (columns * rows + 1 - dark) / 2;
                let (k, rest) = cell(u, count.max(1));
                // Cells counted row by row alternate, but for the step between rows if their number is even.
                let index = if columns % 2 == 1 { 2 * k + dark } else { 2 * k + (dark + 2 * k / columns) % 2 };
                let (row, column) = (index / columns, index % columns);
                [(f64::from(column) + rest) / f64::from(columns), (f64::from(row) + v) / f64::from(rows)]
            }
            Pattern::Bars { count, ratio } => {
                // Bar and gap are equally wide, so the pairs divide either part as they divide the whole.
                let (start, width) = bar(u, count, ratio);
                let half = 0.5 * (u - start);
                [if bright { start + half } else { start + 0.5 * width + half }, v]
            }
            Pattern::Plain | Pattern::Grid { .. } | Pattern::Text(_) => [u, v],
        }
    }

    fn check(self) -> Result<()> {
        let sound = match self {
            Pattern::Plain | Pattern::Text(_) => true,
            Pattern::Checker { columns, rows } => columns > 0 && rows > 0,
            Pattern::Grid { columns, rows, line } => columns > 0 && rows > 0 && (0.0..=1.0).contains(&line),
            Pattern::Bars { count, ratio } => count > 0 && ratio > 0.0 && ratio.is_finite(),
        };
        if sound {
            return Ok(());
        }
        Err(Error::parameter(
            format!("the pattern {self:?} cannot be drawn"),
            "use at least one column, row or bar, a line width from 0 to 1 and a ratio above 0",
        ))
    }
}

/// Index of the cell that holds `x` and the position inside it.
fn cell(x: f64, count: u32) -> (u32, f64) {
    let scaled = (x * f64::from(count)).clamp(0.0, f64::from(count));
    let index = (scaled as u32).min(count - 1);
    (index, scaled - f64::from(index))
}

/// Start and width of the pair of bar and gap that holds `u`: pair k is `q^k (1 - q) / (1 - q^n)` wide.
fn bar(u: f64, count: u32, ratio: f64) -> (f64, f64) {
    let mut total = 1.0;
    for _ in 1..count {
        total = 1.0 + total * ratio;
    }
    let (mut start, mut width) = (0.0, 1.0 / total);
    for _ in 1..count {
        if u < start + width {
            break;
        }
        start += width;
        width *= ratio;
    }
    (start, width)
}

/// A colour (linear RGB) at each point of a shape: `bright` where the pattern is bright, `dark` elsewhere.
///
/// As a radiance the numbers are W/(m2 sr), as a tint they are factors on the BRDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paint {
    pattern: Pattern,
    bright: DVec3,
    dark: DVec3,
    /// Chance that [`Self::draw`] takes a bright point: the share of the bright part in the sum of all colours.
    bright_share: f64,
    /// Densities of [`Self::draw`] in the two parts, per unit of the square's area.
    bright_density: f64,
    dark_density: f64,
}

/// A point of a painted square: where, what colour, and how densely [`Paint::draw`] falls there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dab {
    pub uv: [f64; 2],
    pub colour: DVec3,
    pub density: f64,
}

impl Paint {
    /// One colour everywhere.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn plain(colour: DVec3) -> Result<Self> {
        Paint::new(Pattern::Plain, colour, colour)
    }

    /// Two colours in a pattern.
    ///
    /// # Errors
    /// `Error::Parameter` if a colour is negative or not finite, or the pattern has no cells.
    pub fn new(pattern: Pattern, bright: DVec3, dark: DVec3) -> Result<Self> {
        pattern.check()?;
        for colour in [bright, dark] {
            if !(colour.is_finite() && colour.min_element() >= 0.0) {
                return Err(Error::parameter(
                    format!("the colour {colour} is negative or not finite"),
                    "give three finite numbers of at least 0",
                ));
            }
        }
        let fraction = pattern.bright_fraction();
        let (lit, unlit) = (fraction * bright.element_sum(), (1.0 - fraction) * dark.element_sum());
        let divisible = matches!(pattern, Pattern::Checker { .. } | Pattern::Bars { .. }) && lit + unlit > 0.0;
        let bright_share = if divisible { lit / (lit + unlit) } else { fraction };
        // A part without area is never asked for its density.
        let density = |share: f64, area: f64| if area > 0.0 { share / area } else { 0.0 };
        Ok(Paint {
            pattern,
            bright,
            dark,
            bright_share,
            bright_density: density(bright_share, fraction),
            dark_density: density(1.0 - bright_share, 1.0 - fraction),
        })
    }

    /// Where it is bright and where dark.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// The colour at plane coordinates `uv`, asked for only if it varies.
    #[inline]
    pub(super) fn colour(&self, uv: impl FnOnce() -> [f64; 2]) -> DVec3 {
        if self.pattern == Pattern::Plain || self.pattern.is_bright(uv()) { self.bright } else { self.dark }
    }

    /// A point of the unit square, drawn in proportion to the colour where the pattern allows it.
    #[inline]
    pub(super) fn draw(&self, [u, v]: [f64; 2]) -> Dab {
        let share = self.bright_share;
        match self.pattern {
            Pattern::Plain => Dab { uv: [u, v], colour: self.bright, density: 1.0 },
            Pattern::Grid { .. } => self.dab([u, v]),
            pattern if u < share => {
                Dab { uv: pattern.point_in(true, [u / share, v]), colour: self.bright, density: self.bright_density }
            }
            pattern => {
                let uv = pattern.point_in(false, [(u - share) / (1.0 - share), v]);
                Dab { uv, colour: self.dark, density: self.dark_density }
            }
        }
    }

    /// Colour and density of [`Self::draw`] at a point.
    #[inline]
    pub(super) fn dab(&self, uv: [f64; 2]) -> Dab {
        if self.pattern.is_bright(uv) {
            Dab { uv, colour: self.bright, density: self.bright_density }
        } else {
            Dab { uv, colour: self.dark, density: self.dark_density }
        }
    }

    /// Mean over the shape, channel by channel.
    pub fn mean(&self) -> DVec3 {
        self.dark.lerp(self.bright, self.pattern.bright_fraction())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bright_fraction_is_the_area_counted_point_by_point() {
        let patterns = [
            Pattern::Plain,
            Pattern::Checker { columns: 5, rows: 3 },
            Pattern::Grid { columns: 4, rows: 5, line: 0.2 },
            Pattern::Bars { count: 6, ratio: 0.7 },
            Pattern::Bars { count: 4, ratio: 1.0 },
        ];
        let n = 900;
        for pattern in patterns {
            let centre = |i: usize| (i as f64 + 0.5) / n as f64;
            let bright = (0..n * n).filter(|k| pattern.is_bright([centre(k % n), centre(k / n)])).count();
            let fraction = bright as f64 / (n * n) as f64;
            assert!((fraction - pattern.bright_fraction()).abs() < 5e-3, "{pattern:?}: {fraction}");
        }
    }

    fn on_edge(pattern: Pattern, [u, v]: [f64; 2]) -> bool {
        let near = |du: f64, dv: f64| pattern.is_bright([u + du, v + dv]);
        [(1e-9, 0.0), (-1e-9, 0.0), (0.0, 1e-9), (0.0, -1e-9)]
            .iter()
            .any(|d| near(d.0, d.1) != pattern.is_bright([u, v]))
    }

    /// Draws fall where the density says: uniform in each part, in proportion to the colours between the parts.
    #[test]
    fn points_are_drawn_in_proportion_to_the_colour() {
        let patterns = [
            Pattern::Plain,
            Pattern::Checker { columns: 5, rows: 3 },
            Pattern::Checker { columns: 4, rows: 3 },
            Pattern::Checker { columns: 1, rows: 2 },
            Pattern::Checker { columns: 1, rows: 1 },
            Pattern::Grid { columns: 4, rows: 5, line: 0.2 },
            Pattern::Bars { count: 6, ratio: 0.7 },
            Pattern::Bars { count: 1, ratio: 2.0 },
        ];
        for pattern in patterns {
            let paint = Paint::new(pattern, DVec3::splat(3.0), DVec3::splat(1.0)).unwrap();
            let n = 240;
            let (mut mean, mut moments) = (0.0, [0.0; 2]);
            for k in 0..n * n {
                let u = [((k % n) as f64 + 0.5) / n as f64, ((k / n) as f64 + 0.5) / n as f64];
                let Dab { uv, colour, density } = paint.draw(u);
                assert!(uv.iter().all(|x| (0.0..=1.0).contains(x)), "{pattern:?}");
                // Drawn and looked up agree but for points on an edge.
                let seen = paint.dab(uv);
                assert!((seen.colour, seen.density) == (colour, density) || on_edge(pattern, uv), "{pattern:?} {uv:?}");
                let weight = colour.x / density / (n * n) as f64;
                mean += weight;
                moments[0] += weight * uv[0];
                moments[1] += weight * uv[1];
            }
            assert!((mean - paint.mean().x).abs() < 0.03, "{pattern:?}: {mean}");
            // The same moments from points without preference.
            let mut plain = [0.0; 2];
            for k in 0..n * n {
                let uv = [((k % n) as f64 + 0.5) / n as f64, ((k / n) as f64 + 0.5) / n as f64];
                let colour = paint.colour(|| uv).x / (n * n) as f64;
                plain[0] += colour * uv[0];
                plain[1] += colour * uv[1];
            }
            assert!((moments[0] - plain[0]).abs() < 0.03 && (moments[1] - plain[1]).abs() < 0.03, "{pattern:?}");
        }
    }

    #[test]
    fn bars_shrink_by_their_ratio() {
        // Three pairs of width 4, 2, 1 sevenths.
        let bars = Pattern::Bars { count: 3, ratio: 0.5 };
        for (sevenths, bright) in [(1.9, true), (2.1, false), (4.1, true), (5.1, false), (6.4, true), (6.6, false)] {
            assert_eq!(bars.is_bright([sevenths / 7.0, 0.3]), bright, "{sevenths}/7");
        }
        assert!(!bars.is_bright([1.0, 0.0]));
    }

    #[test]
    fn a_checker_starts_bright_and_alternates() {
        let checker = Pattern::Checker { columns: 2, rows: 2 };
        assert!(checker.is_bright([0.1, 0.1]) && checker.is_bright([1.0, 1.0]));
        assert!(!checker.is_bright([0.9, 0.1]) && !checker.is_bright([0.1, 0.9]));
    }

    #[test]
    fn impossible_paints_are_refused() {
        assert!(Paint::plain(DVec3::new(1.0, -1.0, 0.0)).is_err());
        assert!(Paint::plain(DVec3::splat(f64::NAN)).is_err());
        assert!(Paint::new(Pattern::Checker { columns: 0, rows: 1 }, DVec3::ONE, DVec3::ZERO).is_err());
        assert!(Paint::new(Pattern::Bars { count: 1, ratio: -1.0 }, DVec3::ONE, DVec3::ZERO).is_err());
    }
}
