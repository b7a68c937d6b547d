//! Facets that rays have met, worked out side by side.

use super::cells::CellLanes;
use super::lanes::{Conductor, Dielectric, Glance, Light, Mirror, Reflect, clear_towards, slots, steps};
use crate::facets::packet::Struck;
use crate::optics::Material;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;

/// Rays at a time.
pub const MANY: usize = 512;

type Lane<T> = [T; MANY];

/// What the facets that rays met do with their light.
pub struct Glints {
    n: usize,
    /// Numbers of the rays and the facets they met, in the order in which they were added.
    pub rays: Vec<(u32, Struck)>,
    rise: [Lane<f32>; 2],
    wi: [Lane<f32>; 3],
    turn: [Lane<f32>; 2],
    clear: [Lane<f32>; 4],
    /// Slopes in the frame of the detectors.
    p: Lane<f32>,
    q: Lane<f32>,
    /// Mirror directions in the frame of the map.
    pub wo: [Lane<f32>; 3],
    /// Reflectance in steps.
    pub energy: Lane<u32>,
    /// Half-vector cell; behind the last cell one for the specular core.
    pub slot: Lane<u32>,
    /// 1 if nothing can stand in the way of the reflected beam.
    pub free: Lane<u32>,
}

impl Default for Glints {
    fn default() -> Self {
        let f = [0.0; MANY];
        Glints {
            n: 0,
            rays: Vec::with_capacity(MANY),
            rise: [f; 2],
            wi: [f; 3],
            turn: [f; 2],
            clear: [f; 4],
            p: f,
            q: f,
            wo: [f; 3],
            energy: [0; MANY],
            slot: [0; MANY],
            free: [0; MANY],
        }
    }
}

impl Glints {
    /// Takes all away.
    pub fn clear(&mut self) {
        self.n = 0;
        self.rays.clear();
    }

    /// Adds ray `number` of `light`, which met a facet of a block with these `HeightField::clear_sines`.
    #[inline]
    pub fn push(&mut self, number: u32, light: &Light, struck: Struck, clear: &[f32; 4]) {
        let k = self.n % MANY;
        self.n += 1;
        for axis in 0..2 {
            self.rise[axis][k] = struck.rise[axis];
            self.turn[axis][k] = light.turn[axis];
        }
        for axis in 0..3 {
            self.wi[axis][k] = light.wi[axis];
        }
        for quadrant in 0..4 {
            self.clear[quadrant][k] = clear[quadrant];
        }
        self.rays.push((number, struck));
    }

    /// Works out all facets.
    pub fn shine(&mut self, level: Level, per_pitch: [f32; 2], material: &Material) {
        match *material {
            Material::Mirror => dispatch!(level, simd => shine(simd, per_pitch, Mirror, self)),
            Material::Dielectric { n } => dispatch!(level, simd => shine(simd, per_pitch, Dielectric(n as f32), self)),
            Material::Conductor { n, k } => {
                dispatch!(level, simd => shine(simd, per_pitch, Conductor(n as f32, k as f32), self));
            }
        }
    }

    /// Finds the slots of all facets among half-vector cells.
    pub fn locate(&mut self, level: Level, at: &CellLanes, cells: usize) {
        let behind = cells as u32;
        dispatch!(level, simd => slots(simd, &self.p, &self.q, |p, q| at.locate(p, q), behind, &mut self.slot));
    }
}

#[simd]
fn shine<S: Simd, R: Reflect>(_: S, [px, py]: [f32; 2], reflect: R, glints: &mut Glints) {
    for i in 0..MANY {
        // Rows grow against y.
        let (p, q) = (glints.rise[0][i] * px, -glints.rise[1][i] * py);
        let glance = Glance::new([glints.wi[0][i], glints.wi[1][i], glints.wi[2][i]], p, q);
        let [x, y, z] = glance.wo;
        let [c0, c1, c2, c3] = [glints.clear[0][i], glints.clear[1][i], glints.clear[2][i], glints.clear[3][i]];
        let [cos, sin] = [glints.turn[0][i], glints.turn[1][i]];
        glints.p[i] = cos * p + sin * q;
        glints.q[i] = cos * q - sin * p;
        glints.wo[0][i] = x;
        glints.wo[1][i] = y;
        glints.wo[2][i] = z;
        glints.energy[i] = steps(reflect.at(glance.cos_beta));
        glints.free[i] = u32::from(z >= clear_towards(x, y, [c0, c1, c2, c3]));
    }
}
