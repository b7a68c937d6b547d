//! First hit of a ray on the height field, by a pyramid of block maxima.

use super::slopes;
use crate::heightmap::{Edges, HeightMap};
use glam::DVec3;

/// A ray over the map: position in samples (column, row, both continuous) and height \[m\], direction in metres
/// in the surface frame (z up, y against the row). The direction need not be unit.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub column: f64,
    pub row: f64,
    pub z: f64,
    pub direction: DVec3,
}

/// Where a ray met the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Cell and triangle; see [`slopes::Facet`].
    pub cell: [usize; 2],
    pub upper: bool,
    /// Point of impact: column and row in samples, height \[m\].
    pub column: f64,
    pub row: f64,
    pub z: f64,
    /// Slopes of the facet `(dh/dx, dh/dy)` in the map's frame.
    pub slope: (f64, f64),
    /// Signs by which mirrored tiles crossed on the way have flipped the ray along x and y.
    pub flip: [f64; 2],
}

/// What became of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fate {
    Hit(Hit),
    /// Left upwards or over an open border, with the flips of the mirrored tiles crossed.
    Escaped([f64; 2]),
    /// Went down through a gap, or wandered over more than 256 tiles of a repeated map.
    Lost,
}

/// A ray that crosses this many tiles is as good as horizontal.
const MAX_TILES: u32 = 256;

struct Level {
    width: usize,
    maxima: Vec<f32>,
}

/// The two-triangle surface over a map with the maxima of its blocks of 1, 2, 4, ... cells.
///
/// A block is skipped when the ray stays above its highest vertex (maximum mipmap, Tevs, Ihrke and Seidel 2008).
/// Cells are walked by integer index; the ray's own facet is skipped by its identity, never by a distance.
pub struct HeightField<'a> {
    map: &'a HeightMap,
    cells: [usize; 2],
    levels: Vec<Level>,
    lowest: f64,
    highest: f64,
}

impl<'a> HeightField<'a> {
    /// Builds the pyramid: one third more than one maximum per cell.
    pub fn new(map: &'a HeightMap) -> Self {
        let (nx, ny) = slopes::cells(map);
        let mut base = Vec::with_capacity(nx * ny);
        for r in 0..ny {
            for c in 0..nx {
                // f32::max ignores a NaN; a cell without any vertex is transparent.
                base.push(corners(map, c, r).into_iter().fold(f32::NEG_INFINITY, f32::max));
            }
        }
        let highest = f64::from(base.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        let mut lowest = f64::from(map.heights.iter().copied().fold(f32::INFINITY, f32::min));
        if lowest == highest {
            // Even a flat map has an above and a below, or no ray would cross it.
            lowest -= 1e-9 * map.pitch_x.min(map.pitch_y);
        }
        let mut levels = vec![Level { width: nx, maxima: base }];
        while levels[levels.len() - 1].maxima.len() > 1 {
            let below = &levels[levels.len() - 1];
            let (w, h) = (below.width, below.maxima.len() / below.width);
            let (w2, h2) = (w.div_ceil(2), h.div_ceil(2));
            let mut maxima = vec![f32::NEG_INFINITY; w2 * h2];
            for (k, &m) in below.maxima.iter().enumerate() {
                let target = &mut maxima[k / w / 2 * w2 + k % w / 2];
                *target = target.max(m);
            }
            levels.push(Level { width: w2, maxima });
        }
        HeightField { map, cells: [nx, ny], levels, lowest, highest }
    }

    /// Lowest and highest measured height \[m\].
    pub fn height_range(&self) -> [f64; 2] {
        [self.lowest, self.highest]
    }

    /// Number of cells along x and y.
    pub fn cells(&self) -> [usize; 2] {
        self.cells
    }

    /// The map under the field.
    pub fn map(&self) -> &HeightMap {
        self.map
    }

    /// Height of the surface at a point inside the grid \[m\]; `None` over a gap.
    pub fn height_at(&self, column: f64, row: f64) -> Option<f64> {
        let c = (column.max(0.0) as usize).min(self.cells[0] - 1);
        let r = (row.max(0.0) as usize).min(self.cells[1] - 1);
        let (u, v) = (column - c as f64, row - r as f64);
        let [g0, gu, gv] = plane(corners(self.map, c, r), u > v);
        let z = g0 + gu * u + gv * v;
        z.is_finite().then_some(z)
    }

    /// Follows `ray` to its first facet other than `own` (cell, upper), which it is leaving.
    pub fn trace(&self, ray: Ray, own: Option<([usize; 2], bool)>) -> Fate {
        let [nx, ny] = self.cells.map(|n| n as i64);
        let (mut ox, mut oy, oz) = (ray.column, ray.row, ray.z);
        let mut dx = ray.direction.x / self.map.pitch_x;
        let mut dy = -ray.direction.y / self.map.pitch_y;
        let dz = ray.direction.z;
        let mut inverse = [1.0 / dx, 1.0 / dy];
        let mut flip = [1.0, 1.0];
        let mut own = own;
        let (mut cx, mut cy) = match own {
            Some((cell, _)) => (cell[0] as i64, cell[1] as i64),
            None => ((ox as i64).clamp(0, nx - 1), (oy as i64).clamp(0, ny - 1)),
        };
        // Beyond this the ray is above everything or below everything.
        let t_end = if dz > 0.0 {
            (self.highest - oz) / dz
        } else if dz < 0.0 {
            (self.lowest - oz - 1e-9 * (self.highest - self.lowest)) / dz
        } else {
            f64::INFINITY
        };
        if t_end < 0.0 {
            return if dz >= 0.0 { Fate::Escaped(flip) } else { Fate::Lost };
        }
        // Rounding of a height, far below any difference a facet could resolve.
        let slack = 1e-9 * (self.highest - self.lowest);
        let top = self.levels.len() - 1;
        let mut level = if own.is_some() { 0 } else { top.min(3) };
        let mut t = 0.0f64;
        let mut tiles = 0;
        loop {
            let edge = |c: i64, d: f64, n: i64| {
                if d > 0.0 { (((c >> level) + 1) << level).min(n) } else { c >> level << level }
            };
            let (ex, ey) = (edge(cx, dx, nx), edge(cy, dy, ny));
            let tx = if dx != 0.0 { (ex as f64 - ox) * inverse[0] } else { f64::INFINITY };
            let ty = if dy != 0.0 { (ey as f64 - oy) * inverse[1] } else { f64::INFINITY };
            let exit = tx.min(ty).min(t_end).max(t);
            let lowest_on_ray = oz + dz * if dz < 0.0 { exit } else { t };
            let grid = &self.levels[level];
            let block_maximum = f64::from(grid.maxima[(cy >> level) as usize * grid.width + (cx >> level) as usize]);
            if lowest_on_ray <= block_maximum {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                let cell = [cx as usize, cy as usize];
                let skip = own.filter(|o| o.0 == cell).map(|o| o.1);
                let local = Local { u: ox - cx as f64, v: oy - cy as f64, z: oz, du: dx, dv: dy, dz };
                if let Some((upper, at)) = local.meet(corners(self.map, cell[0], cell[1]), t, exit, skip, slack) {
                    let slopes = slopes::of_corners(
                        corners(self.map, cell[0], cell[1]).map(f64::from),
                        self.map.pitch_x,
                        self.map.pitch_y,
                    );
                    return Fate::Hit(Hit {
                        cell,
                        upper,
                        column: (ox + dx * at).clamp(cx as f64, (cx + 1) as f64),
                        row: (oy + dy * at).clamp(cy as f64, (cy + 1) as f64),
                        z: oz + dz * at,
                        slope: slopes[usize::from(upper)],
                        flip,
                    });
                }
            }
            if exit >= t_end {
                return if dz > 0.0 { Fate::Escaped(flip) } else { Fate::Lost };
            }
            // Step to the neighbouring block: the crossed edge fixes one index exactly, the other follows the ray
            // but may not leave the block it is in.
            let clamp_inside = |v: f64, c: i64, n: i64| {
                // Positions are not negative, so truncation is the floor, and cheaper.
                (v as i64).clamp(c >> level << level, ((((c >> level) + 1) << level) - 1).min(n - 1))
            };
            if tx <= ty {
                cy = clamp_inside(oy + dy * exit, cy, ny);
                cx = if dx > 0.0 { ex } else { ex - 1 };
            } else {
                cx = clamp_inside(ox + dx * exit, cx, nx);
                cy = if dy > 0.0 { ey } else { ey - 1 };
            }
            t = exit;
            level = (level + 1).min(top);
            if cx < 0 || cx >= nx || cy < 0 || cy >= ny {
                tiles += 1;
                match self.map.edges {
                    Edges::Open => return Fate::Escaped(flip),
                    _ if tiles > MAX_TILES => return Fate::Lost,
                    Edges::Periodic => {
                        wrap(&mut cx, &mut ox, nx);
                        wrap(&mut cy, &mut oy, ny);
                    }
                    Edges::Mirrored => {
                        mirror(&mut cx, &mut ox, &mut dx, &mut flip[0], nx);
                        mirror(&mut cy, &mut oy, &mut dy, &mut flip[1], ny);
                        inverse = [1.0 / dx, 1.0 / dy];
                    }
                }
                // In another tile the facet with the same indices is another facet.
                own = None;
            }
        }
    }
}

fn wrap(c: &mut i64, o: &mut f64, n: i64) {
    if *c < 0 {
        *c += n;
        *o += n as f64;
    } else if *c >= n {
        *c -= n;
        *o -= n as f64;
    }
}

/// Reflects the ray's path instead of the map: `x -> -x` or `x -> 2 n - x`.
fn mirror(c: &mut i64, o: &mut f64, d: &mut f64, sign: &mut f64, n: i64) {
    if *c < 0 {
        *c = 0;
        *o = -*o;
    } else if *c >= n {
        *c = n - 1;
        *o = 2.0 * n as f64 - *o;
    } else {
        return;
    }
    *d = -*d;
    *sign = -*sign;
}

fn corners(map: &HeightMap, c: usize, r: usize) -> [f32; 4] {
    let c1 = if c + 1 == map.width() { 0 } else { c + 1 };
    let r1 = if r + 1 == map.height() { 0 } else { r + 1 };
    [map.heights[[r, c]], map.heights[[r, c1]], map.heights[[r1, c]], map.heights[[r1, c1]]]
}

/// `h = g0 + gu u + gv v` over one triangle of a cell, u along the columns, v along the rows.
fn plane([a, b, c, d]: [f32; 4], upper: bool) -> [f64; 3] {
    let [a, b, c, d] = [a, b, c, d].map(f64::from);
    if upper { [a, b - a, d - b] } else { [a, d - c, c - a] }
}

/// A ray in the coordinates of one cell.
struct Local {
    u: f64,
    v: f64,
    z: f64,
    du: f64,
    dv: f64,
    dz: f64,
}

impl Local {
    /// First triangle entered from above between `t0` and `t1`, and the parameter there.
    fn meet(&self, corners: [f32; 4], t0: f64, t1: f64, skip: Option<bool>, slack: f64) -> Option<(bool, f64)> {
        let (w, dw) = (self.u - self.v, self.du - self.dv);
        let diagonal = if dw != 0.0 { -w / dw } else { f64::INFINITY };
        let parts =
            if diagonal > t0 && diagonal < t1 { [(t0, diagonal), (diagonal, t1)] } else { [(t0, t1), (t1, t1)] };
        for (k, (start, end)) in parts.into_iter().enumerate() {
            if k == 1 && end <= start {
                break;
            }
            let middle = if end.is_finite() { 0.5 * (start + end) } else { start + 1.0 };
            let upper = w + dw * middle > 0.0;
            if skip == Some(upper) {
                continue;
            }
            let [g0, gu, gv] = plane(corners, upper);
            let height = self.z - g0 - gu * self.u - gv * self.v;
            let rate = self.dz - gu * self.du - gv * self.dv;
            // Only a ray going into the surface can hit it; one that starts a rounding error below and comes out
            // must not, nor one that came under the surface through a gap. A NaN vertex fails the comparison:
            // the triangle is a hole.
            if rate < 0.0 && height + rate * end < 0.0 && height + rate * start >= -slack {
                return Some((upper, (-height / rate).clamp(start, end)));
            }
        }
        None
    }
}
