//! The way of a ray from tile to tile of a repeated map.

use super::march::March;
use super::visibility::Fate;
use crate::heightmap::Edges;

/// A ray that crosses this many tiles is as good as horizontal.
const MAX_TILES: u32 = 256;

impl March<'_> {
    #[inline]
    pub(super) fn is_outside(&self) -> bool {
        (0..2).any(|k| self.cell[k] < 0 || self.cell[k] >= self.field.cells[k] as i64)
    }

    /// Whether there is more map where the ray left it; if so the ray is moved into the tile.
    #[cold]
    pub(super) fn enter_next_tile(&mut self, tiles: &mut u32) -> bool {
        *tiles += 1;
        let edges = self.field.map().edges;
        if edges == Edges::Open || *tiles > MAX_TILES {
            return false;
        }
        for k in 0..2 {
            let n = self.field.cells[k] as i64;
            let c = self.cell[k];
            if (0..n).contains(&c) {
                continue;
            }
            if edges == Edges::Periodic {
                let by = if c < 0 { n } else { -n };
                self.cell[k] += by;
                self.o[k] += by as f64;
            } else {
                // Reflects the ray's path instead of the map: x -> -x or x -> 2 n - x.
                self.cell[k] = if c < 0 { 0 } else { n - 1 };
                self.o[k] = if c < 0 { -self.o[k] } else { 2.0 * n as f64 - self.o[k] };
                self.d[k] = -self.d[k];
                self.inverse[k] = -self.inverse[k];
                self.flip[k] = -self.flip[k];
            }
        }
        true
    }

    pub(super) fn fate_beyond(&self, tiles: u32) -> Fate {
        if tiles > MAX_TILES { Fate::Lost } else { Fate::Escaped(self.flip) }
    }
}
