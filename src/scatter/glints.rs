//! Facets that rays have met, worked out side by side.

use super::cells::CellLanes;
use super::lanes::{Conductor, Dielectric, Glance, Mirror, Reflect, clear_towards, slots};
use crate::facets::packet::Struck;
use crate::optics::Material;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;

/// Facets of one round of the lanes.
const ROUND: usize = 64;

type Lane<T> = [T; ROUND];

/// What the facets that rays met do with their light.
pub struct Glints {
    level: Level,
    n: usize,
    rounds: Vec<Round>,
    /// The light of all rays, if they have one.
    common: Option<Light>,
    /// Numbers of the rays and the facets they met, in the order in which they were added.
    pub rays: Vec<(u32, Struck)>,
}

struct Round {
    rise: [Lane<f32>; 2],
    wi: [Lane<f32>; 3],
    clear: [Lane<f32>; 4],
    turn: [Lane<f32>; 2],
    /// Slopes, turned; mirror directions in the frame of the map.
    slope: [Lane<f32>; 2],
    wo: [Lane<f32>; 3],
    reflectance: Lane<f32>,
    /// 1 if nothing can stand in the way of the reflected beam.
    free: Lane<u32>,
    slot: Lane<u32>,
}

/// What one facet does.
#[derive(Debug, Clone, Copy)]
pub struct Glint {
    pub wo: [f32; 3],
    pub reflectance: f32,
    /// Whether nothing can stand in the way of the reflected beam.
    pub is_free: bool,
    /// As [`Glints::locate`] found it.
    pub slot: u32,
}

/// Where the light of a ray comes from.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub wi: [f32; 3],
    /// Cosine and sine of the turn into the frame of the detectors.
    pub turn: [f32; 2],
}

impl Default for Round {
    fn default() -> Self {
        let f = [0.0; ROUND];
        let (rise, wi, clear, turn, slope, wo) = ([f; 2], [f; 3], [f; 4], [f; 2], [f; 2], [f; 3]);
        Round { rise, wi, clear, turn, slope, wo, reflectance: f, free: [0; ROUND], slot: [0; ROUND] }
    }
}

impl Round {
    fn fill(&mut self, light: &Light) {
        self.wi = light.wi.map(|x| [x; ROUND]);
        self.turn = light.turn.map(|x| [x; ROUND]);
    }
}

impl Default for Glints {
    fn default() -> Self {
        Glints { level: Level::new(), n: 0, rounds: Vec::new(), common: None, rays: Vec::new() }
    }
}

impl Glints {
    /// Takes all away. If the next rays all have one light, it need not be given with each.
    pub fn clear(&mut self, common: Option<Light>) {
        self.n = 0;
        self.rays.clear();
        self.common = common;
        if let Some(light) = common {
            self.rounds.iter_mut().for_each(|round| round.fill(&light));
        }
    }

    /// Adds ray `number` which met a facet of a block with these `HeightField::clear_sines`; `light` is where it comes from.
    #[inline]
    pub fn push(&mut self, number: u32, light: &Light, struck: Struck, clear: &[f32; 4]) {
        let k = self.n % ROUND;
        if self.n / ROUND == self.rounds.len() {
            self.rounds.push(Round::default());
            if let Some(light) = &self.common {
                self.rounds[self.n / ROUND].fill(light);
            }
        }
        let round = &mut self.rounds[self.n / ROUND];
        self.n += 1;
        for axis in 0..2 {
            round.rise[axis][k] = struck.rise[axis];
        }
        if self.common.is_none() {
            for axis in 0..2 {
                round.turn[axis][k] = light.turn[axis];
            }
            for axis in 0..3 {
                round.wi[axis][k] = light.wi[axis];
            }
        }
        for quadrant in 0..4 {
            round.clear[quadrant][k] = clear[quadrant];
        }
        self.rays.push((number, struck));
    }

    /// Works out all facets.
    pub fn shine(&mut self, per_pitch: [f32; 2], material: &Material) {
        let level = self.level;
        for round in &mut self.rounds[..self.n.div_ceil(ROUND)] {
            match *material {
                Material::Mirror => dispatch!(level, simd => shine(simd, per_pitch, Mirror, round)),
                Material::Dielectric { n } => {
                    dispatch!(level, simd => shine(simd, per_pitch, Dielectric(n as f32), round));
                }
                Material::Conductor { n, k } => {
                    dispatch!(level, simd => shine(simd, per_pitch, Conductor(n as f32, k as f32), round));
                }
            }
        }
    }

    /// Finds the slots of all facets among half-vector cells; behind them lies the one of the specular core.
    pub fn locate(&mut self, at: &CellLanes, cells: usize) {
        let (level, behind) = (self.level, cells as u32);
        for Round { slope: [p, q], slot, .. } in &mut self.rounds[..self.n.div_ceil(ROUND)] {
            dispatch!(level, simd => slots(simd, p, q, |p, q| at.locate(p, q), behind, slot));
        }
    }

    /// What facet number `k` does.
    #[inline]
    pub fn get(&self, k: usize) -> Glint {
        let (round, k) = (&self.rounds[k / ROUND], k % ROUND);
        Glint {
            wo: [round.wo[0][k], round.wo[1][k], round.wo[2][k]],
            reflectance: round.reflectance[k],
            is_free: round.free[k] == 1,
            slot: round.slot[k],
        }
    }
}

#[simd]
fn shine<S: Simd, R: Reflect>(_: S, [px, py]: [f32; 2], reflect: R, round: &mut Round) {
    for i in 0..ROUND {
        // Rows grow against y.
        let (p, q) = (round.rise[0][i] * px, -round.rise[1][i] * py);
        let glance = Glance::new([round.wi[0][i], round.wi[1][i], round.wi[2][i]], p, q);
        let [x, y, z] = glance.wo;
        let [c0, c1, c2, c3] = [round.clear[0][i], round.clear[1][i], round.clear[2][i], round.clear[3][i]];
        let [cos, sin] = [round.turn[0][i], round.turn[1][i]];
        round.slope[0][i] = cos * p + sin * q;
        round.slope[1][i] = cos * q - sin * p;
        round.wo[0][i] = x;
        round.wo[1][i] = y;
        round.wo[2][i] = z;
        round.reflectance[i] = reflect.at(glance.cos_beta);
        round.free[i] = u32::from(z >= clear_towards(x, y, [c0, c1, c2, c3]));
    }
}
