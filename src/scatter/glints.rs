//! Facets that rays have met, worked out side by side.

use super::cells::CellLanes;
use super::lanes::{Conductor, Dielectric, Glance, Mirror, Reflect, slots};
use crate::facets::ends::Hits;
use crate::facets::starts::{Starts, WIDTH, live, make_room, quadrant_numbers};
use crate::facets::{HeightField, slopes};
use crate::optics::Material;
use fearless_simd::{Level, Simd, SimdBase, SimdMask, dispatch, f32x16, mask32x16, u32x16};
use fearless_simd_macros::simd;

/// What the facets that rays met do with their light, in the order of the [`Hits`]: columns with room for a vector at their ends.
pub struct Glints {
    level: Level,
    /// Direction to the source.
    pub wi: [Vec<f32>; 3],
    /// Cosine and sine of the turn into the frame of the detectors.
    pub turn: [Vec<f32>; 2],
    /// Slopes, turned; mirror directions in the frame of the map.
    slope: [Vec<f32>; 2],
    pub wo: [Vec<f32>; 3],
    pub reflectance: Vec<f32>,
    /// 1 if nothing can stand in the way of the reflected beam.
    pub free: Vec<u32>,
    /// Detectors of the slopes, as [`Glints::locate`] found them.
    pub slot: Vec<u32>,
    outlook: Vec<u32>,
}

/// Where the light of a ray comes from.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub wi: [f32; 3],
    /// Cosine and sine of the turn into the frame of the detectors.
    pub turn: [f32; 2],
}

impl Default for Glints {
    fn default() -> Self {
        let none = Vec::new;
        Glints {
            level: Level::new(),
            wi: [none(), none(), none()],
            turn: [none(), none()],
            slope: [none(), none()],
            wo: [none(), none(), none()],
            reflectance: none(),
            free: Vec::new(),
            slot: Vec::new(),
            outlook: Vec::new(),
        }
    }
}

impl Glints {
    /// Makes room for so many facets; their light is then to be written to `wi` and `turn`.
    pub fn reserve(&mut self, n: usize) {
        if self.free.len() >= n + WIDTH {
            return;
        }
        let Glints { level: _, wi, turn, slope, wo, reflectance, free, slot, outlook } = self;
        wi.iter_mut().chain(turn).chain(slope).chain(wo).for_each(|column| make_room(column, n));
        make_room(reflectance, n);
        [free, slot, outlook].into_iter().for_each(|column| make_room(column, n));
    }

    /// One light for so many facets.
    pub fn light_all(&mut self, light: &Light, n: usize) {
        self.reserve(n);
        for (column, x) in self.wi.iter_mut().chain(&mut self.turn).zip(light.wi.iter().chain(&light.turn)) {
            column[..n].fill(*x);
        }
    }

    /// The light of facet `k`.
    #[inline]
    pub fn light(&mut self, k: usize, light: &Light) {
        for (column, x) in self.wi.iter_mut().chain(&mut self.turn).zip(light.wi.iter().chain(&light.turn)) {
            column[k] = *x;
        }
    }

    /// Works out all facets.
    pub fn shine(&mut self, field: &HeightField, hits: &Hits, material: &Material) {
        let map = field.map();
        let per_pitch = [map.pitch_x, map.pitch_y].map(|p| (1.0 / p) as f32);
        let level = self.level;
        match *material {
            Material::Mirror => dispatch!(level, simd => shine(simd, per_pitch, Mirror, hits, self)),
            Material::Dielectric { n } => {
                dispatch!(level, simd => shine(simd, per_pitch, Dielectric(n as f32), hits, self));
            }
            Material::Conductor { n, k } => {
                dispatch!(level, simd => shine(simd, per_pitch, Conductor(n as f32, k as f32), hits, self));
            }
        }
        let blocks = slopes::cells(map).0.div_ceil(crate::facets::blocks::SIDE);
        dispatch!(level, simd => find_outlooks(simd, blocks as u32, hits, self));
        let sines = field.clear_sine_table();
        let (outlooks, up, free) = (&self.outlook[..hits.n], &self.wo[2][..hits.n], &mut self.free[..hits.n]);
        for k in 0..hits.n {
            free[k] = u32::from(up[k] >= sines[outlooks[k] as usize]);
        }
    }

    /// Finds the slots of all facets among half-vector cells; behind them lies the one of the specular core.
    pub fn locate(&mut self, n: usize, at: &CellLanes, cells: usize) {
        let (level, behind) = (self.level, cells as u32);
        let Glints { slope: [p, q], slot, .. } = self;
        dispatch!(level, simd => slots(simd, &p[..n], &q[..n], |p, q| at.locate(p, q), behind, &mut slot[..n]));
    }

    /// Adds the beams that may meet something to `starts`, with the numbers of their rays.
    pub fn go_on(&self, hits: &Hits, starts: &mut Starts) {
        starts.reserve(hits.n);
        dispatch!(self.level, simd => go_on(simd, self, hits, starts));
    }
}

#[simd]
fn shine<S: Simd, R: Reflect>(_: S, [px, py]: [f32; 2], reflect: R, hits: &Hits, glints: &mut Glints) {
    let n = hits.n;
    let Glints { wi, turn, slope, wo, reflectance, .. } = glints;
    let [gu, gv] = hits.rise.each_ref().map(|x| &x[..n]);
    let [wx, wy, wz] = wi.each_ref().map(|x| &x[..n]);
    let [cos, sin] = turn.each_ref().map(|x| &x[..n]);
    let [slope_p, slope_q] = slope.each_mut().map(|x| &mut x[..n]);
    let [ox, oy, oz] = wo.each_mut().map(|x| &mut x[..n]);
    let reflectance = &mut reflectance[..n];
    for i in 0..n {
        // Rows grow against y.
        let (p, q) = (gu[i] * px, -gv[i] * py);
        let glance = Glance::new([wx[i], wy[i], wz[i]], p, q);
        slope_p[i] = cos[i] * p + sin[i] * q;
        slope_q[i] = cos[i] * q - sin[i] * p;
        [ox[i], oy[i], oz[i]] = glance.wo;
        reflectance[i] = reflect.at(glance.cos_beta);
    }
}

/// Numbers of what may stand in the way of the reflected beams.
#[simd]
fn find_outlooks<S: Simd>(simd: S, blocks: u32, hits: &Hits, glints: &mut Glints) {
    for from in (0..hits.n).step_by(WIDTH) {
        let to = from + WIDTH;
        let cell = hits.cell.each_ref().map(|x| u32x16::from_slice(simd, &x[from..to]));
        let flat = [0, 1].map(|k| f32x16::from_slice(simd, &glints.wo[k][from..to]));
        quadrant_numbers(simd, blocks, cell, flat).store_slice(&mut glints.outlook[from..to]);
    }
}

#[simd]
fn go_on<S: Simd>(simd: S, glints: &Glints, hits: &Hits, starts: &mut Starts) {
    for from in (0..hits.n).step_by(WIDTH) {
        let to = from + WIDTH;
        let word = |x: &[u32]| u32x16::from_slice(simd, &x[from..to]);
        let held = word(&glints.free).simd_eq(0).to_bitmask() & live(hits.n, from);
        if held == 0 {
            continue;
        }
        let mask = mask32x16::from_bitmask(simd, held);
        let at = starts.n;
        let put = |x: u32x16<S>, column: &mut [u32]| {
            simd.compress_u32x16(x, mask).store_slice(&mut column[at..at + WIDTH]);
        };
        let put_real = |x: &[f32], column: &mut [f32]| {
            let packed = simd.compress_f32x16(f32x16::from_slice(simd, &x[from..to]), mask);
            packed.store_slice(&mut column[at..at + WIDTH]);
        };
        put(word(&hits.id), &mut starts.id);
        put(word(&hits.upper) + 1, &mut starts.own);
        for axis in 0..2 {
            put(word(&hits.cell[axis]), &mut starts.cell[axis]);
            put_real(&hits.at[axis], &mut starts.at[axis]);
        }
        put_real(&hits.z, &mut starts.z);
        for axis in 0..3 {
            put_real(&glints.wo[axis], &mut starts.direction[axis]);
        }
        starts.n += held.count_ones() as usize;
    }
}
