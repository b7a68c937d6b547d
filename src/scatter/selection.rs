//! Which facets a run lights.

use crate::error::{Error, Result};

/// The part of the facets, or of the rays, that one run takes. By default all.
///
/// Facets left out are not lit, but they hide and reflect like the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// Share of the facets, evenly chosen; 1 takes all. Rays do not use it.
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

    /// Piece `(i, j)` when both sides are cut into `across` pieces; together the pieces hold every cell once.
    pub fn piece(self, i: usize, j: usize, across: usize) -> Footprint {
        let cut =
            |[from, to]: [usize; 2], k: usize| [from + k * (to - from) / across, from + (k + 1) * (to - from) / across];
        Footprint { columns: cut(self.columns, i), rows: cut(self.rows, j) }
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

    /// Whether the item belongs to this part.
    #[inline]
    pub fn has(self, item: u64) -> bool {
        item % self.of == self.number
    }

    /// Whether this is the whole run.
    pub fn is_whole(self) -> bool {
        self.of == 1
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number + 1, self.of)
    }
}
