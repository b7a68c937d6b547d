//! Which facets a run lights.

use crate::error::{Error, Result};
use crate::facets::row_sight::RUN;
use crate::heightmap::crop::Region;
use crate::heightmap::{Edges, HeightMap};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

/// Chance may move this part of a tolerance: the slopes of other maps let it move somewhat more than those it was measured on.
const CHANCE: f64 = 0.5;

/// Light moved by leaving out all but one run of facets, if all light were hidden; by lighting all facets once, from azimuths
/// that differ from run to run, in units of the same.
const MOVED_BY_SHARE: f64 = 0.8;
const MOVED_BY_AZIMUTHS: f64 = 0.2;

/// Azimuths per facet beyond which an average is good enough for any tolerance.
const MOST_AZIMUTHS: f64 = 16.0;

/// Share of the facets to ask about visibility so that chance moves less than half of `tolerance` to another place.
///
/// Only what is `hidden` is a matter of chance, the slopes are those of all facets; and a run of [`RUN`] cells is as good as
/// one sample, since neighbours hide together. m of M runs leave about `0.8 sqrt(hidden / m)` of the light in the wrong one of
/// the patches of Klems, all of them from n azimuths each `0.2 sqrt(hidden / M) / n` (measured on surfaces of Sdq 0.09 to 0.4
/// against 16 azimuths per facet). Above 1, and only when azimuths are averaged: every facet from so many.
pub fn enough(hidden: f64, tolerance: f64, facets: u64, averaged: bool) -> f64 {
    let per_tolerance = hidden.max(0.0).sqrt() / (CHANCE * tolerance);
    let runs = (facets as f64 / (2 * RUN) as f64).max(1.0);
    let some = (MOVED_BY_SHARE * per_tolerance).powi(2);
    if some < runs {
        some / runs
    } else if averaged {
        (MOVED_BY_AZIMUTHS * per_tolerance / runs.sqrt()).ceil().clamp(1.0, MOST_AZIMUTHS)
    } else {
        1.0
    }
}

/// The part of the facets, or of the rays, that one run takes. By default all.
///
/// Facets left out are not lit, but they hide and reflect like the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// Share of the facets, evenly chosen; 1 takes all. More than 1, when azimuths are averaged, lights every facet so many
    /// times, from another azimuth each time. Rays do not use it.
    pub share: f64,
    /// One of several runs whose sums are to be merged.
    pub part: Part,
    /// Lit cells: columns from, to and rows from, to; the ends are not lit. `None` lights the whole map.
    pub footprint: Option<Footprint>,
}

impl Default for Selection {
    fn default() -> Self {
        Selection { share: 1.0, part: Part::default(), footprint: None }
    }
}

impl Selection {
    /// So many facets of the whole map, evenly chosen.
    pub fn share(share: f64) -> Self {
        Selection { share, ..Selection::default() }
    }

    /// The lit cells of a map of `cells` columns and rows.
    pub fn lit(&self, cells: [usize; 2]) -> Footprint {
        self.footprint.unwrap_or(Footprint::whole(cells))
    }
}

/// A rectangle of cells, half open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Footprint {
    pub columns: [usize; 2],
    pub rows: [usize; 2],
}

impl Footprint {
    /// All of a map of so many columns and rows of cells.
    pub fn whole(cells: [usize; 2]) -> Footprint {
        Footprint { columns: [0, cells[0]], rows: [0, cells[1]] }
    }

    /// Cells `floor(x0 n) <= column < floor(x1 n)` of the n columns of a map, rows likewise, for a region in fractions; for one in
    /// lengths, those from `floor(x0 / pitch)`.
    ///
    /// # Errors
    /// `Error::Parameter` if the region reaches beyond the map or holds no cell.
    pub fn of(region: Region, map: &HeightMap) -> Result<Footprint> {
        let (nx, ny) = crate::facets::slopes::cells(map);
        let (corners, scale) = match region {
            Region::Fraction(corners) => (corners, [nx as f64, ny as f64]),
            Region::Length(corners) => (corners, [1.0 / map.pitch_x, 1.0 / map.pitch_y]),
        };
        let at = |k: usize| (corners[k] * scale[k % 2]).floor();
        let inside = |from: f64, to: f64, n: usize| from >= 0.0 && to <= n as f64 && to - from >= 1.0;
        if !(inside(at(0), at(2), nx) && inside(at(1), at(3), ny)) {
            return Err(Error::parameter(
                format!("the footprint holds no cell, or reaches beyond the {nx} x {ny} cells of the map"),
                "give X0,Y0,X1,Y1 from the top left with X0 < X1 and Y0 < Y1, such as 0.15,0.15,0.85,0.85",
            ));
        }
        Ok(Footprint { columns: [at(0) as usize, at(2) as usize], rows: [at(1) as usize, at(3) as usize] })
    }

    /// Piece `(i, j)` when both sides are cut into `across` pieces; together the pieces hold every cell once.
    pub fn piece(self, i: usize, j: usize, across: usize) -> Footprint {
        let cut =
            |[from, to]: [usize; 2], k: usize| [from + k * (to - from) / across, from + (k + 1) * (to - from) / across];
        Footprint { columns: cut(self.columns, i), rows: cut(self.rows, j) }
    }

    /// The cells as a map of their own, without their surroundings.
    pub fn cut(self, map: &HeightMap) -> HeightMap {
        let (rows, columns) = map.heights.dim();
        let [height, width] = [self.rows, self.columns].map(|[from, to]| to - from + 1);
        let heights = Array2::from_shape_fn((height, width), |(r, c)| {
            // The last vertices of a periodic map are its first.
            map.heights[[(self.rows[0] + r) % rows, (self.columns[0] + c) % columns]]
        });
        HeightMap { heights, edges: Edges::Open, ..*map }
    }

    /// Whether it holds the cell `[column, row]`.
    #[inline]
    pub fn holds(self, cell: [usize; 2]) -> bool {
        (self.columns[0]..self.columns[1]).contains(&cell[0]) && (self.rows[0]..self.rows[1]).contains(&cell[1])
    }

    /// Whether it holds no cell.
    pub fn is_empty(self) -> bool {
        self.columns[0] >= self.columns[1] || self.rows[0] >= self.rows[1]
    }
}

/// Part `number` (from 0) of `of` disjoint parts that together are the whole run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    number: u64,
    of: u64,
}

impl Default for Part {
    fn default() -> Self {
        Part { number: 0, of: 1 }
    }
}

impl Part {
    /// Part `k` of `n`, `k` from 1 to `n`.
    ///
    /// # Errors
    /// `Error::Parameter` if `k` is not among them.
    pub fn new(k: u64, n: u64) -> Result<Self> {
        if k == 0 || k > n {
            return Err(Error::parameter(format!("there is no part {k} of {n}"), "give K/N with K from 1 to N"));
        }
        Ok(Part { number: k - 1, of: n })
    }

    /// Number of this part, from 0.
    pub fn number(self) -> u64 {
        self.number
    }

    /// Number of parts.
    pub fn of(self) -> u64 {
        self.of
    }

    /// Reads `K/N`.
    ///
    /// # Errors
    /// `Error::Parameter` if it is not two numbers, or K is not from 1 to N.
    pub fn parse(text: &str) -> Result<Self> {
        let numbers = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
        let (k, n) = numbers.ok_or_else(|| Error::parameter(format!("`{text}` is not a part"), "write K/N, as 1/4"))?;
        Part::new(k, n)
    }

    /// Whether the item belongs to this part.
    #[inline]
    pub fn has(self, item: u64) -> bool {
        item % self.of == self.number
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number + 1, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_asked_for_less_tolerance_and_where_more_is_hidden() {
        let facets = 2 << 20;
        assert_eq!(enough(0.0, 0.01, facets, true), 0.0);
        // 0.8 sqrt(0.04 / m) = 0.005 for m = 1024 of 16384 runs.
        assert!((enough(0.04, 0.01, facets, true) - 1024.0 / 16384.0).abs() < 1e-12);
        assert_eq!(enough(0.04, 1e-4, facets, false), 1.0);
        // 0.2 sqrt(0.04 / 16384) / n = 0.00005 for n = 6.25.
        assert_eq!(enough(0.04, 1e-4, facets, true), 7.0);
        assert_eq!(enough(0.5, 1e-9, facets, true), MOST_AZIMUTHS);
    }
}
