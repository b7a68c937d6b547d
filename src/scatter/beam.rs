//! Parallel light on a map: where its rays start, and the first facet each of them meets.

use super::bounce::Arrival;
use super::selection::Footprint;
use crate::facets::starts::Starts;
use crate::facets::visibility::{Fate, HeightField, Hit, Ray};
use crate::heightmap::Edges;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Light from one direction over the lit part of the mean plane, which is widened so that every lit facet is fully lit.
pub struct Beam<'a> {
    field: &'a HeightField<'a>,
    wi: DVec3,
    footprint: Option<Footprint>,
    /// Samples travelled along the columns and rows per metre of height on the way to the source.
    lean: [f64; 2],
    /// Corner and sides of the rectangle of the mean plane that rays are aimed at, in samples.
    from: [f64; 2],
    extent: [f64; 2],
}

impl<'a> Beam<'a> {
    /// `wi` towards the source; only what meets a facet of `footprint` first is kept.
    pub fn new(field: &'a HeightField<'a>, wi: DVec3, footprint: Option<Footprint>) -> Self {
        let map = field.map();
        let lean = [wi.x / wi.z / map.pitch_x, -wi.y / wi.z / map.pitch_y];
        let [lowest, highest] = field.height_range();
        let lit = footprint.unwrap_or(Footprint::whole(field.cells()));
        let (mut from, mut extent) = ([0.0; 2], [0.0; 2]);
        for (k, range) in [lit.columns, lit.rows].into_iter().enumerate() {
            let (mut first, mut last) = (range[0] as f64, range[1] as f64);
            // The whole of a repeated map is lit evenly already.
            if map.edges == Edges::Open || footprint.is_some() {
                // A facet at height z is met by the ray aimed at its own place minus lean * z.
                first += (-lean[k] * highest).min(-lean[k] * lowest);
                last += (-lean[k] * highest).max(-lean[k] * lowest);
            }
            (from[k], extent[k]) = (first, last - first);
        }
        Beam { field, wi, footprint, lean, from, extent }
    }

    /// Height over width of the rectangle that rays are aimed at, in samples.
    pub fn aspect(&self) -> f64 {
        self.extent[1] / self.extent[0]
    }

    /// The point of the mean plane \[samples\] at place `u` in `[0, 1]^2` of what is aimed at.
    #[inline]
    pub fn aim(&self, u: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.from[k] + self.extent[k] * u[k])
    }

    /// The first facet that the ray aimed at place `u` in `[0, 1]^2` of the mean plane meets, if it is a lit one.
    pub fn strike(&self, u: [f64; 2]) -> Option<Arrival> {
        let aim = self.aim(u);
        let (ray, flip) = self.launch(aim)?;
        let Fate::Hit(hit) = self.field.trace(ray, None) else { return None };
        self.arrive(aim, flip, &hit)
    }

    /// Adds the rays aimed at places in `[0, 1]^2` of the mean plane, each with its place among `aims`. Facets that they meet before
    /// they leave the map are lit if [`Beam::lights`] says so; rays that do not plainly start on the map have no cell.
    pub fn start(&self, level: Level, aims: &[[f64; 2]], starts: &mut Starts) {
        let (n, all) = (starts.n, starts.n + aims.len());
        starts.reserve(aims.len());
        starts.n = all;
        let [_, highest] = self.field.height_range();
        let size = self.field.cells().map(|n| n as f64);
        let inside = dispatch!(level, simd => place(simd, self, highest, size, aims, starts, n));
        let down = (-self.wi).to_array().map(|x| x as f32);
        starts.direction.iter_mut().zip(down).for_each(|(column, x)| column[n..all].fill(x));
        starts.own[n..all].fill(0);
        starts.z[n..all].fill(highest as f32);
        starts.end[n..all].fill(f32::INFINITY);
        starts.id[n..all].iter_mut().zip(n as u32..).for_each(|(id, k)| *id = k);
        if inside {
            return;
        }
        let wraps = self.field.map().edges == Edges::Periodic && self.footprint.is_none();
        for (k, &u) in (n..).zip(aims) {
            let aim = self.aim(u);
            let start = [0, 1].map(|axis| aim[axis] + self.lean[axis] * highest);
            if (0..2).all(|axis| start[axis] >= 0.0 && start[axis] < size[axis]) {
                continue;
            }
            for axis in 0..2 {
                let place = start[axis].rem_euclid(size[axis]);
                starts.cell[axis][k] = if wraps { place as u32 } else { u32::MAX };
                starts.at[axis][k] = (place - place.floor()) as f32;
            }
        }
    }

    /// Whether only a part of the map is lit.
    pub fn is_part(&self) -> bool {
        self.footprint.is_some()
    }

    /// Whether a cell of the map is lit.
    #[inline]
    pub fn lights(&self, cell: [usize; 2]) -> bool {
        self.footprint.is_none_or(|lit| lit.holds(cell))
    }

    /// What a ray launched with these flips finds where it hit; nothing if that facet is not lit.
    fn arrive(&self, aim: [f64; 2], flip: [f64; 2], hit: &Hit) -> Option<Arrival> {
        if let Some(lit) = self.footprint {
            // Of a repeated map only the copy that the rays are aimed at is lit.
            let place = [0, 1].map(|k| aim[k] + self.lean[k] * hit.z);
            let inside = match self.field.map().edges {
                Edges::Open => lit.holds(hit.cell),
                Edges::Mirrored | Edges::Periodic => {
                    place.iter().all(|x| *x >= 0.0) && lit.holds(place.map(|x| x as usize))
                }
            };
            if !inside {
                return None;
            }
        }
        let flip = [flip[0] * hit.flip[0], flip[1] * hit.flip[1]];
        Some(Arrival {
            point: [hit.column, hit.row, hit.z],
            facet: (hit.cell, hit.upper),
            slope: hit.slope,
            back: self.wi * DVec3::new(flip[0], flip[1], 1.0),
            flip,
        })
    }

    /// The ray aimed at a point of the mean plane, started above the highest facet and moved into the map, and the flips of the
    /// mirrored tile it starts in. For an open map it starts where it enters the outline; `None` if it passes by.
    fn launch(&self, aim: [f64; 2]) -> Option<(Ray, [f64; 2])> {
        let [_, highest] = self.field.height_range();
        let size = self.field.cells().map(|n| n as f64);
        let mut start = [0, 1].map(|k| aim[k] + self.lean[k] * highest);
        let mut ray = Ray { column: start[0], row: start[1], z: highest, direction: -self.wi };
        if (0..2).all(|k| start[k] >= 0.0 && start[k] < size[k]) {
            return Some((ray, [1.0; 2]));
        }
        let mut flip = [1.0; 2];
        match self.field.map().edges {
            Edges::Periodic => start = [0, 1].map(|k| start[k].rem_euclid(size[k])),
            Edges::Mirrored => {
                for k in 0..2 {
                    let folded = start[k].rem_euclid(2.0 * size[k]);
                    start[k] = if folded > size[k] { 2.0 * size[k] - folded } else { folded };
                    flip[k] = if folded > size[k] { -1.0 } else { 1.0 };
                }
                ray.direction *= DVec3::new(flip[0], flip[1], 1.0);
            }
            Edges::Open => {
                let drop = |k: usize| {
                    let outside = if start[k] < 0.0 { start[k] } else { (start[k] - size[k]).max(0.0) };
                    if outside == 0.0 { 0.0 } else { outside / self.lean[k] }
                };
                let fall = drop(0).max(drop(1));
                let slack = 1e-9 * size[0].max(size[1]);
                start = [0, 1].map(|k| start[k] - self.lean[k] * fall);
                if (0..2).any(|k| start[k] < -slack || start[k] > size[k] + slack) {
                    return None;
                }
                start = [0, 1].map(|k| start[k].clamp(0.0, size[k]));
                ray.z -= fall;
                // Under the surface's border: this ray passes below the measured sheet.
                if self.field.height_at(start[0], start[1]).is_some_and(|h| ray.z < h) {
                    return None;
                }
            }
        }
        (ray.column, ray.row) = (start[0], start[1]);
        Some((ray, flip))
    }
}

/// 2^52, to whose last places whole numbers can be added as bits.
const TWO_52: f64 = (1u64 << 52) as f64;

/// Cells and places in them of rays that start at `aim + lean highest`; whether all of them lie on the map.
#[simd]
fn place<S: Simd>(
    _: S,
    beam: &Beam,
    highest: f64,
    size: [f64; 2],
    aims: &[[f64; 2]],
    starts: &mut Starts,
    from: usize,
) -> bool {
    let mut outside = 0;
    for axis in 0..2 {
        let (first, extent, drift) = (beam.from[axis], beam.extent[axis], beam.lean[axis] * highest);
        let size = size[axis];
        let cell = &mut starts.cell[axis][from..from + aims.len()];
        let at = &mut starts.at[axis][from..from + aims.len()];
        for k in 0..aims.len() {
            let start = first + extent * aims[k][axis] + drift;
            outside |= u32::from(!((start >= 0.0) & (start < size)));
            let whole = start.floor();
            cell[k] = (whole + TWO_52).to_bits() as u32;
            at[k] = (start - whole) as f32;
        }
    }
    outside == 0
}
