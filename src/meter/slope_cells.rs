//! Facets gathered in small cells of slope, for sums of a smooth function over all of them.
//!
//! Every cell keeps the count and the mean of its facets; the function is taken once, at that mean. The error is of
//! second order in the cell's width and nothing for facets of one and the same slope.

use super::path::Path;
use crate::facets::slopes;
use crate::heightmap::HeightMap;
use crate::math::frame::normal_of_slope;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Sub-areas along each axis of the map.
const ACROSS: usize = 4;

/// Cells per axis of the slopes that one path can see.
const GRID: usize = 96;

/// Squared gradients in f32 lose so many bits to become cells, 16 to an octave. The first cell takes everything below
/// 1e-14, the last everything above 1e4.
const SHIFT: u32 = 19;
const RADIAL: u32 = 1000;

/// Largest step along the circle of azimuths, as a slope: a fifth of the narrowest ramp of a glossmeter's kernel.
const STEP: f64 = 0.0013;

/// Cells being filled: those of one band of sub-areas, or of the whole map.
pub trait Cells: Clone + Send + Sync {
    /// Cell of a facet and its coordinates, whose mean is kept; `None` if the facet does not matter.
    fn locate(&self, p: f64, q: f64) -> Option<(usize, [f64; 2])>;

    /// Number of cells.
    fn len(&self) -> usize;

    /// The function that is summed, at the mean coordinates of a cell.
    fn at(&self, mean: [f64; 2], kernel: &dyn Fn(DVec3) -> f64) -> f64;
}

/// Counts per sub-area and means of the facets of a map.
pub struct Gathered<C> {
    cells: C,
    /// Per sub-area, per cell.
    counts: Vec<Vec<u32>>,
    /// Sums of the coordinates per cell.
    sums: Vec<[f64; 2]>,
    /// Facets of each sub-area, seen or not.
    facets: Vec<u64>,
}

/// Mean of the function over all facets of the map, and over those of each sub-area that has some.
#[derive(Debug, Clone, PartialEq)]
pub struct Means {
    pub whole: f64,
    pub parts: Vec<f64>,
}

impl<C: Cells> Gathered<C> {
    /// One pass over the facets; the same for any number of threads.
    pub fn of(map: &HeightMap, cells: C) -> Self {
        let (nx, ny) = slopes::cells(map);
        let part_of_column: Vec<usize> = (0..nx).map(|column| column * ACROSS / nx).collect();
        let bands: Vec<Gathered<C>> = (0..ACROSS)
            .into_par_iter()
            .map(|band| {
                let mut g = Self::empty(cells.clone(), ACROSS);
                for row in band * ny / ACROSS..(band + 1) * ny / ACROSS {
                    slopes::visit_row(map, row, |f| {
                        let part = part_of_column[f.column];
                        g.facets[part] += 1;
                        if let Some((cell, [x, y])) = g.cells.locate(f.p, f.q) {
                            g.counts[part][cell] += 1;
                            g.sums[cell][0] += x;
                            g.sums[cell][1] += y;
                        }
                    });
                }
                g
            })
            .collect();
        let mut all = Self::empty(cells, 0);
        for band in bands {
            all.counts.extend(band.counts);
            all.facets.extend(band.facets);
            for (a, b) in all.sums.iter_mut().zip(band.sums) {
                *a = [a[0] + b[0], a[1] + b[1]];
            }
        }
        all
    }

    fn empty(cells: C, parts: usize) -> Self {
        let n = cells.len();
        Gathered { cells, counts: vec![vec![0; n]; parts], sums: vec![[0.0; 2]; n], facets: vec![0; parts] }
    }

    /// Facets in each cell, with their mean coordinates; empty cells left out.
    fn filled(&self) -> impl Iterator<Item = (usize, u64, [f64; 2])> + '_ {
        self.sums.iter().enumerate().filter_map(|(k, sum)| {
            let count: u64 = self.counts.iter().map(|c| u64::from(c[k])).sum();
            (count > 0).then(|| (k, count, sum.map(|s| s / count as f64)))
        })
    }

    /// Facets of the map.
    pub fn facets(&self) -> u64 {
        self.facets.iter().sum()
    }

    /// Means of `kernel`, a function of the facet's normal.
    pub fn means(&self, kernel: &dyn Fn(DVec3) -> f64) -> Means {
        let mut whole = 0.0;
        let mut parts = vec![0.0; self.counts.len()];
        for (k, count, mean) in self.filled() {
            let value = self.cells.at(mean, kernel);
            if value != 0.0 {
                whole += count as f64 * value;
                for (part, counts) in parts.iter_mut().zip(&self.counts) {
                    *part += f64::from(counts[k]) * value;
                }
            }
        }
        let parts = parts.iter().zip(&self.facets).filter(|(_, n)| **n > 0).map(|(sum, &n)| sum / n as f64).collect();
        Means { whole: whole / self.facets() as f64, parts }
    }
}

/// Cells of the gradient alone: for averages over all azimuths.
#[derive(Debug, Clone)]
pub struct Radial {
    /// Largest gradient at which the function is not zero.
    pub reach: f64,
}

impl Cells for Radial {
    #[inline]
    fn locate(&self, p: f64, q: f64) -> Option<(usize, [f64; 2])> {
        let squared = p * p + q * q;
        let first = 1e-14f32.to_bits() >> SHIFT;
        let cell = ((squared as f32).to_bits() >> SHIFT).saturating_sub(first).min(RADIAL - 1);
        Some((cell as usize, [squared, 0.0]))
    }

    fn len(&self) -> usize {
        RADIAL as usize
    }

    /// Mean over the circle of normals of one gradient.
    fn at(&self, [squared, _]: [f64; 2], kernel: &dyn Fn(DVec3) -> f64) -> f64 {
        let gradient = squared.sqrt();
        if gradient > self.reach {
            return 0.0;
        }
        let steps = (TAU * gradient / STEP).ceil().clamp(16.0, 8192.0);
        let normal = |k: u32| {
            let (s, c) = (TAU * (f64::from(k) + 0.5) / steps).sin_cos();
            normal_of_slope(gradient * c, gradient * s)
        };
        (0..steps as u32).map(|k| kernel(normal(k))).sum::<f64>() / steps
    }
}

impl Gathered<Radial> {
    /// Gradients with their shares of the facets, rising.
    pub fn gradients(&self) -> Vec<(f64, f64)> {
        let n = self.facets() as f64;
        self.filled().map(|(_, count, [squared, _])| (squared.sqrt(), count as f64 / n)).collect()
    }
}

/// Cells of the slopes that one path can see, in the plane of its half vectors.
#[derive(Debug, Clone)]
pub struct Seen {
    frame: [DVec3; 3],
    low: [f64; 2],
    per_unit: [f64; 2],
}

impl Seen {
    /// Cells of the facets that `path` can see.
    pub fn by(path: &Path) -> Self {
        let [x, y] = path.bounds();
        Seen { frame: path.frame(), low: [x[0], y[0]], per_unit: [x, y].map(|[a, b]| GRID as f64 / (b - a)) }
    }
}

impl Cells for Seen {
    #[inline]
    fn locate(&self, p: f64, q: f64) -> Option<(usize, [f64; 2])> {
        let along = |w: DVec3| w.z - p * w.x - q * w.y;
        let [centre, in_plane, across] = self.frame;
        let z = along(centre);
        if z <= 0.0 {
            return None;
        }
        let (x, y) = (along(in_plane) / z, along(across) / z);
        let (i, j) = ((x - self.low[0]) * self.per_unit[0], (y - self.low[1]) * self.per_unit[1]);
        let within = |t: f64| t >= 0.0 && t < GRID as f64;
        (within(i) && within(j)).then(|| (i as usize * GRID + j as usize, [x, y]))
    }

    fn len(&self) -> usize {
        GRID * GRID
    }

    fn at(&self, [x, y]: [f64; 2], kernel: &dyn Fn(DVec3) -> f64) -> f64 {
        let [centre, in_plane, across] = self.frame;
        kernel((centre + x * in_plane + y * across).normalize())
    }
}
