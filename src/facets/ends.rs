//! How the ways of rays ended, column by column.

use super::starts::{WIDTH, make_room};

/// Rays that met something or about which f32 cannot tell; those that are not here are above everything ahead.
#[derive(Debug, Default)]
pub struct Ends {
    pub hits: Hits,
    /// Number of the ray, and how many times its direction it is known to be above the surface.
    pub unsure: Vec<(u32, f64)>,
}

impl Ends {
    /// None.
    pub fn clear(&mut self) {
        self.hits.n = 0;
        self.unsure.clear();
    }
}

/// Facets that rays met, which no earlier ones hide, in f32: the first `n` values of each column, behind which there is room for a
/// vector.
#[derive(Debug, Default)]
pub struct Hits {
    pub n: usize,
    /// Number of the ray.
    pub id: Vec<u32>,
    pub cell: [Vec<u32>; 2],
    /// 1 for the facet above the diagonal.
    pub upper: Vec<u32>,
    /// Place in the cell \[samples\], height \[m\].
    pub at: [Vec<f32>; 2],
    pub z: Vec<f32>,
    /// Rise of the facet per sample along the columns and the rows \[m\].
    pub rise: [Vec<f32>; 2],
    /// The cell that the ray started in, counted from the tile of a periodic map in which it meets the facet.
    pub start: [Vec<i32>; 2],
}

impl Hits {
    /// Makes room for so many more.
    #[inline]
    pub fn reserve(&mut self, more: usize) {
        let n = self.n + more;
        if self.id.len() >= n + WIDTH {
            return;
        }
        let Hits { n: _, id, cell: [column, row], upper, at: [u, v], z, rise: [gu, gv], start } = self;
        [id, column, row, upper].into_iter().for_each(|words| make_room(words, n));
        [u, v, z, gu, gv].into_iter().for_each(|reals| make_room(reals, n));
        start.iter_mut().for_each(|words| make_room(words, n));
    }

    /// Keeps those for which `is_kept` says so, given their numbers here.
    pub fn retain(&mut self, mut is_kept: impl FnMut(&Hits, usize) -> bool) {
        let mut kept = 0;
        for k in 0..self.n {
            if is_kept(self, k) {
                let Hits { n: _, id, cell: [column, row], upper, at: [u, v], z, rise: [gu, gv], start } = self;
                [id, column, row, upper].into_iter().for_each(|words| words[kept] = words[k]);
                [u, v, z, gu, gv].into_iter().for_each(|reals| reals[kept] = reals[k]);
                start.iter_mut().for_each(|words| words[kept] = words[k]);
                kept += 1;
            }
        }
        self.n = kept;
    }
}
