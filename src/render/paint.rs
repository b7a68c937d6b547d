//! Two colours in a pattern: what makes an emitter a lit checker, or a floor a chessboard.

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
            Pattern::Bars { count, ratio } => bar_fraction(u, count, ratio) < 0.5,
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
        }
    }

    fn check(self) -> Result<()> {
        let sound = match self {
            Pattern::Plain => true,
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

/// Position within the bar and its gap: pair k is `q^k (1 - q) / (1 - q^n)` wide.
fn bar_fraction(u: f64, count: u32, ratio: f64) -> f64 {
    let total = if ratio == 1.0 { f64::from(count) } else { (1.0 - ratio.powf(f64::from(count))) / (1.0 - ratio) };
    let (mut rest, mut width) = (u.clamp(0.0, 1.0) * total, 1.0);
    for _ in 1..count {
        if rest < width {
            break;
        }
        rest -= width;
        width *= ratio;
    }
    rest / width
}

/// A colour (linear RGB) at each point of a shape: `bright` where the pattern is bright, `dark` elsewhere.
///
/// As a radiance the numbers are W/(m2 sr), as a tint they are factors on the BRDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paint {
    pattern: Pattern,
    bright: DVec3,
    dark: DVec3,
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
        Ok(Paint { pattern, bright, dark })
    }

    /// The colour at plane coordinates `uv`, asked for only if it varies.
    #[inline]
    pub(super) fn colour(&self, uv: impl FnOnce() -> [f64; 2]) -> DVec3 {
        if self.pattern == Pattern::Plain || self.pattern.is_bright(uv()) { self.bright } else { self.dark }
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
