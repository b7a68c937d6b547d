//! Slopes of the two triangles of every cell.

use crate::heightmap::{Edges, HeightMap};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;

/// One triangle of a cell. The diagonal runs from (row, col) to (row+1, col+1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// Column of the cell.
    pub column: usize,
    /// Row of the cell.
    pub row: usize,
    /// `false`: the triangle below the diagonal (towards -y), `true`: the one above it.
    pub upper: bool,
    /// `dh/dx`.
    pub p: f64,
    /// `dh/dy`.
    pub q: f64,
}

/// Number of cells along x and y: one less than the samples, or as many if the map is periodic.
pub fn cells(map: &HeightMap) -> (usize, usize) {
    match map.edges {
        Edges::Periodic => (map.width(), map.height()),
        Edges::Open | Edges::Mirrored => (map.width() - 1, map.height() - 1),
    }
}

/// The vertices of the cells below `row`, one more than cells: what follows the last column of a periodic map is the first.
/// `row` may be one past the last of a periodic map.
pub fn vertices(map: &HeightMap, row: usize, out: &mut Vec<f32>) {
    let line = map.heights.row(row % map.height());
    out.clear();
    match line.to_slice() {
        Some(line) => out.extend_from_slice(line),
        None => out.extend(line.iter()),
    }
    if map.edges == Edges::Periodic {
        out.push(out[0]);
    }
}

/// `p = dh/dx`, `q = dh/dy` of the lower and upper triangle from the heights of the four corners:
/// `a` (row, col), `b` (row, col+1), `c` (row+1, col), `d` (row+1, col+1); row grows with -y.
#[inline]
pub fn of_corners([a, b, c, d]: [f64; 4], pitch_x: f64, pitch_y: f64) -> [(f64, f64); 2] {
    [((d - c) / pitch_x, (a - c) / pitch_y), ((b - a) / pitch_x, (b - d) / pitch_y)]
}

/// Calls `visit` for every facet of cell row `row` whose three vertices are measured.
#[inline]
pub fn visit_row(map: &HeightMap, row: usize, mut visit: impl FnMut(Facet)) {
    let (nx, _) = cells(map);
    let width = map.width();
    let top = map.heights.row(row);
    let bottom = map.heights.row((row + 1) % map.height());
    for column in 0..nx {
        let next = if column + 1 == width { 0 } else { column + 1 };
        let corners = [top[column], top[next], bottom[column], bottom[next]].map(f64::from);
        for (k, (p, q)) in of_corners(corners, map.pitch_x, map.pitch_y).into_iter().enumerate() {
            // A missing vertex makes a NaN slope in exactly the triangles it belongs to.
            if (p + q).is_finite() {
                visit(Facet { column, row, upper: k == 1, p, q });
            }
        }
    }
}

/// Calls `visit` with the slopes `p` and `q` of all lower, then of all upper facets of each cell row, in f32; NaN where a
/// facet is missing.
pub fn visit_lanes(map: &HeightMap, rows: std::ops::Range<usize>, mut visit: impl FnMut(&[f32], &[f32])) {
    let level = Level::new();
    let (nx, _) = cells(map);
    let (mut top, mut bottom) = (Vec::new(), Vec::new());
    let (mut p, mut q) = (vec![0.0; nx], vec![0.0; nx]);
    let per_pitch = [(1.0 / map.pitch_x) as f32, (1.0 / map.pitch_y) as f32];
    vertices(map, rows.start, &mut bottom);
    for row in rows {
        std::mem::swap(&mut top, &mut bottom);
        vertices(map, row + 1, &mut bottom);
        for upper in [false, true] {
            // The lower facets rise along the lower side of their cells and across at the left, the upper ones the other way.
            let (along, across) = if upper { (&top, 1) } else { (&bottom, 0) };
            dispatch!(level, simd => differences(simd, &along[1..], along, per_pitch[0], &mut p));
            dispatch!(level, simd => differences(simd, &top[across..], &bottom[across..], per_pitch[1], &mut q));
            visit(&p, &q);
        }
    }
}

#[simd]
fn differences<S: Simd>(_: S, high: &[f32], low: &[f32], per_pitch: f32, out: &mut [f32]) {
    let n = out.len();
    let (high, low) = (&high[..n], &low[..n]);
    for k in 0..n {
        out[k] = (high[k] - low[k]) * per_pitch;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn map(heights: Array2<f32>, edges: Edges) -> HeightMap {
        HeightMap { heights, pitch_x: 2.0, pitch_y: 5.0, edges, removed_slopes: [0.0; 2] }
    }

    #[test]
    fn a_ramp_has_one_slope_everywhere_and_y_points_up() {
        let m = map(Array2::from_shape_fn((4, 6), |(r, c)| 0.3 * 2.0 * c as f32 - 0.1 * 5.0 * r as f32), Edges::Open);
        let mut count = 0;
        for row in 0..cells(&m).1 {
            visit_row(&m, row, |f| {
                assert!((f.p - 0.3).abs() < 1e-6 && (f.q - 0.1).abs() < 1e-6);
                count += 1;
            });
        }
        assert_eq!(count, 2 * 3 * 5);
    }

    #[test]
    fn a_missing_vertex_removes_its_six_triangles_only() {
        let mut heights = Array2::zeros((5, 5));
        heights[[2, 2]] = f32::NAN;
        let m = map(heights, Edges::Open);
        let mut count = 0;
        (0..4).for_each(|row| visit_row(&m, row, |_| count += 1));
        assert_eq!(count, 2 * 16 - 6);
    }

    #[test]
    fn lanes_are_the_facets_in_f32() {
        for edges in [Edges::Open, Edges::Periodic] {
            let mut heights = Array2::from_shape_fn((7, 9), |(r, c)| ((r * r + 3 * c) % 5) as f32);
            heights[[3, 4]] = f32::NAN;
            let m = map(heights, edges);
            for row in 0..cells(&m).1 {
                let mut facets = Vec::new();
                visit_row(&m, row, |f| facets.push((f.upper, f.column, f.p as f32, f.q as f32)));
                let mut lanes = Vec::new();
                let mut upper = false;
                visit_lanes(&m, row..row + 1, |p, q| {
                    let all = p.iter().zip(q).enumerate().map(|(c, (&p, &q))| (upper, c, p, q));
                    lanes.extend(all.filter(|f| !(f.2 + f.3).is_nan()));
                    upper = true;
                });
                facets.sort_by_key(|f| (f.0, f.1));
                assert_eq!(lanes, facets);
            }
        }
    }

    #[test]
    fn slopes_of_a_periodic_map_sum_to_zero() {
        let m = map(Array2::from_shape_fn((7, 9), |(r, c)| ((r * r + 3 * c) % 5) as f32), Edges::Periodic);
        let (mut p, mut q, mut n) = (0.0, 0.0, 0);
        (0..7).for_each(|row| {
            visit_row(&m, row, |f| {
                p += f.p;
                q += f.q;
                n += 1;
            })
        });
        assert_eq!(n, 2 * 63);
        assert!(p.abs() < 1e-12 && q.abs() < 1e-12);
    }
}
