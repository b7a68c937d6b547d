//! A zero-bistatic scan: `f_r` \[1/sr\] of the first surface with source and detector in one direction, against the angle
//! of that direction to the normal.
//!
//! Between measured angles `ln f` is linear in the angle (`f` where an end is 0); before the first and beyond the last it
//! stays.

use crate::columns::Columns;
use crate::error::{Error, Result};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

/// A scan ready to be read and drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroBistatic {
    /// Angle \[rad\], rising, and `f_r` [1/sr].
    points: Vec<(f64, f64)>,
    /// From each measured angle to the next; the first reaches down to 0, the last up to 90 deg.
    pieces: Vec<Piece>,
    /// The piece in which each of as many equal steps from 0 to 90 deg begins.
    first: Vec<u32>,
    /// Edges of the cells of the draws, cosines falling from 1 to 0.
    edges: Vec<f64>,
    /// Share of the draws before each edge, 0 to 1.
    share: Vec<f64>,
    integral: f64,
}

/// Cells of the draws between two measured angles.
const CELLS: usize = 8;

/// Steps that lead to a piece.
const STEPS: usize = 256;

/// `f` from `start` on: `exp(value + slope (theta - start))`, or without the exponential.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: f64,
    value: f64,
    slope: f64,
    logarithmic: bool,
}

impl Piece {
    fn between((t0, f0): (f64, f64), (t1, f1): (f64, f64)) -> Self {
        let logarithmic = f0 > 0.0 && f1 > 0.0;
        let [value, end] = if logarithmic { [f0.ln(), f1.ln()] } else { [f0, f1] };
        Piece { start: t0, value, slope: (end - value) / (t1 - t0), logarithmic }
    }

    fn level(start: f64, value: f64) -> Self {
        Piece { start, value, slope: 0.0, logarithmic: false }
    }
}

impl ZeroBistatic {
    /// Points of angle \[rad\] and `f_r` [1/sr], in any order.
    ///
    /// # Errors
    /// `Error::Parameter` if there are fewer than two, an angle is outside 0 to 90 deg or twice there, a value is negative
    /// or not finite, or all are 0.
    pub fn new(points: &[(f64, f64)]) -> Result<Self> {
        let bad = |what: String| {
            Err(Error::parameter(
                format!("zero-bistatic scan: {what}"),
                "give at least two rows of an angle from 0 to 90 deg and f_r in 1/sr, not all 0",
            ))
        };
        let mut points = points.to_vec();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(p) = points.iter().find(|p| !(p.0 >= 0.0 && p.0 <= FRAC_PI_2 && p.1 >= 0.0 && p.1.is_finite())) {
            return bad(format!("{} 1/sr at {} deg is out of range", p.1, p.0.to_degrees()));
        }
        if let Some(p) = points.windows(2).find(|p| p[0].0 == p[1].0) {
            return bad(format!("the angle {} deg is there twice", p[0].0.to_degrees()));
        }
        if points.len() < 2 || points.iter().all(|p| p.1 == 0.0) {
            return bad("there is nothing to interpolate".to_owned());
        }
        let mut pieces = vec![Piece::level(0.0, points[0].1)];
        pieces.extend(points.windows(2).map(|p| Piece::between(p[0], p[1])));
        pieces.push(Piece::level(points[points.len() - 1].0, points[points.len() - 1].1));
        let before = |k: usize| pieces.partition_point(|p| p.start <= k as f64 * FRAC_PI_2 / STEPS as f64) - 1;
        let first = (0..=STEPS).map(|k| before(k) as u32).collect();
        let mut angles: Vec<f64> = points.iter().map(|p| p.0).collect();
        if angles[0] > 0.0 {
            angles.insert(0, 0.0);
        }
        if angles[angles.len() - 1] < FRAC_PI_2 {
            angles.push(FRAC_PI_2);
        }
        let fine = |pair: &[f64]| -> Vec<f64> {
            (0..CELLS).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / CELLS as f64).collect()
        };
        let mut thetas: Vec<f64> = angles.windows(2).flat_map(fine).collect();
        thetas.push(FRAC_PI_2);
        let edges: Vec<f64> = thetas.iter().map(|t| t.cos().max(0.0)).collect();
        let mut scan = ZeroBistatic { points, pieces, first, edges, share: vec![0.0], integral: 0.0 };
        // Weight of a cell: f c^3 at its middle, and at least a trace, so that nowhere with light lacks draws.
        let peak = scan.points.iter().fold(0.0f64, |m, p| m.max(p.1));
        for t in thetas.windows(2) {
            let middle = 0.5 * (t[0] + t[1]);
            let solid = TAU * (t[0].cos() - t[1].cos());
            scan.integral += scan.at(middle) * middle.cos().powi(3) * solid;
            let weight = (scan.at(middle) * middle.cos().powi(3)).max(1e-6 * peak) * solid;
            scan.share.push(scan.share[scan.share.len() - 1] + weight);
        }
        let whole = scan.share[scan.share.len() - 1];
        scan.share.iter_mut().for_each(|s| *s /= whole);
        Ok(scan)
    }

    /// Reads `0:9.5;10:2.1;...` (degrees and 1/sr), else a CSV file with columns `theta_deg` and either `f_r_per_sr`, or
    /// `co_per_sr` and `cross_per_sr` whose difference is the first surface.
    ///
    /// # Errors
    /// `Error::Content` about the file, `Error::Parameter` about the numbers.
    pub fn parse(text: &str) -> Result<Self> {
        let pair = |item: &str| {
            let (angle, value) = item.split_once(':')?;
            Some((angle.trim().parse::<f64>().ok()?.to_radians(), value.trim().parse::<f64>().ok()?))
        };
        let inline: Option<Vec<(f64, f64)>> =
            text.split(';').map(str::trim).filter(|s| !s.is_empty()).map(pair).collect();
        if let Some(points) = inline.filter(|p| !p.is_empty()) {
            return ZeroBistatic::new(&points);
        }
        let columns = Columns::read(Path::new(text))?;
        let theta = columns.numbers_within("theta_deg", 0.0, 90.0)?;
        let f = if columns.has("co_per_sr") {
            let (co, cross) = (columns.numbers("co_per_sr")?, columns.numbers("cross_per_sr")?);
            // Noise may leave a little below nothing.
            co.iter().zip(cross).map(|(co, cross)| (co - cross).max(0.0)).collect()
        } else {
            columns.numbers("f_r_per_sr")?
        };
        let points: Vec<(f64, f64)> = theta.iter().map(|t| t.to_radians()).zip(f).collect();
        ZeroBistatic::new(&points).map_err(|e| Error::content(columns.path(), e.to_string(), "correct the scan"))
    }

    /// The scan times `s`.
    ///
    /// # Errors
    /// As [`ZeroBistatic::new`], if `s` is no number above 0.
    pub fn scaled(&self, s: f64) -> Result<Self> {
        let points: Vec<(f64, f64)> = self.points.iter().map(|&(theta, f)| (theta, s * f)).collect();
        ZeroBistatic::new(&points)
    }

    /// The measured points, angle \[rad\] and `f_r` [1/sr].
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// `f_r` \[1/sr\] at `theta` \[rad\], 0 to a right angle.
    #[inline]
    pub fn at(&self, theta: f64) -> f64 {
        let step = ((theta * (STEPS as f64 / FRAC_PI_2)) as usize).min(STEPS);
        let mut k = self.first[step] as usize;
        while self.pieces.get(k + 1).is_some_and(|next| next.start <= theta) {
            k += 1;
        }
        let piece = self.pieces[k];
        let value = piece.value + piece.slope * (theta - piece.start);
        if piece.logarithmic { value.exp() } else { value }
    }

    /// Tangent of the angle where the scan has fallen to half of its largest value, within 0.01 and 1.
    pub fn half_width(&self) -> f64 {
        let peak = self.points.iter().fold(0.0f64, |m, p| m.max(p.1));
        let half = (0..900).map(|k| f64::from(k) * FRAC_PI_2 / 900.0).rfind(|t| self.at(*t) > 0.5 * peak);
        half.unwrap_or(0.0).tan().clamp(0.01, 1.0)
    }

    /// About `int f cos^3 theta dw` over the hemisphere.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Cosine of the angle of the draw `u` in `[0, 1)`.
    pub fn draw(&self, u: f64) -> f64 {
        let cell = (self.share.partition_point(|s| *s <= u).max(1) - 1).min(self.edges.len() - 2);
        let within = (u - self.share[cell]) / (self.share[cell + 1] - self.share[cell]);
        let c = self.edges[cell] + within * (self.edges[cell + 1] - self.edges[cell]);
        c.max(f64::MIN_POSITIVE)
    }

    /// Share of the draws with a cosine of at least `cos_theta`.
    pub fn distribution(&self, cos_theta: f64) -> f64 {
        let cell = self.cell(cos_theta);
        let within = (cos_theta - self.edges[cell]) / (self.edges[cell + 1] - self.edges[cell]);
        self.share[cell] + within * (self.share[cell + 1] - self.share[cell])
    }

    /// Density of the draws per steradian: constant over each cell.
    pub fn density(&self, cos_theta: f64) -> f64 {
        let cell = self.cell(cos_theta);
        (self.share[cell + 1] - self.share[cell]) / (TAU * (self.edges[cell] - self.edges[cell + 1]))
    }

    fn cell(&self, cos_theta: f64) -> usize {
        (self.edges.partition_point(|e| *e >= cos_theta).max(1) - 1).min(self.edges.len() - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_ratios_and_holds_the_ends() {
        let scan = ZeroBistatic::parse("10:4; 0:16 ;30:0").unwrap();
        let at = |deg: f64| scan.at(deg.to_radians());
        assert!((at(5.0) - 8.0).abs() < 1e-12 && (at(20.0) - 2.0).abs() < 1e-12);
        assert_eq!([at(0.0), at(30.0), at(80.0)].map(|v| (v * 1e9).round() / 1e9), [16.0, 0.0, 0.0]);
        let held = ZeroBistatic::parse("10:4;20:2").unwrap();
        assert_eq!([held.at(0.0), held.at(1.5)], [4.0, 2.0]);
    }

    #[test]
    fn refuses_what_is_no_scan() {
        for text in ["0:1", "0:1;0:2", "0:-1;10:1", "0:0;10:0", "0:1;95:1", "no-such-file.csv", "0:inf;10:1"] {
            assert!(ZeroBistatic::parse(text).is_err(), "{text}");
        }
    }
}
