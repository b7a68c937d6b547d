//! Facets by the run: what light of one direction does with neighbouring facets, worked out side by side.

use super::cells::HalfVectorCells;
use super::tally::CORE_SLOPE;
use crate::facets::row_sight::{self, RUN, Seen};
use crate::optics::Material;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Weights and energies are counted in steps of `2^-STEP_BITS`.
pub const STEP_BITS: u32 = 24;

/// What weighs more than `2^HEAVIEST_BITS` is left to the slow way, so that sums of steps cannot overflow.
pub const HEAVIEST_BITS: u32 = 4;
const HEAVIEST: f32 = (1u32 << HEAVIEST_BITS) as f32;

/// Where the light comes from, and the size of a cell.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub wi: [f32; 3],
    /// Cosine and sine of the turn into the frame of the detectors.
    pub turn: [f32; 2],
    pub per_pitch: [f32; 2],
}

impl Light {
    /// `wi` towards the source, `turn` \[rad\] into the frame of the detectors, `pitch` \[m\] along x and y.
    pub fn new(wi: DVec3, turn: f64, pitch: [f64; 2]) -> Self {
        let (sin, cos) = turn.sin_cos();
        Light {
            wi: wi.to_array().map(|x| x as f32),
            turn: [cos as f32, sin as f32],
            per_pitch: pitch.map(|p| (1.0 / p) as f32),
        }
    }
}

/// The surface under a run of cells.
pub struct Ground<'a> {
    /// `RUN + 1` vertices along the upper and the lower side of the cells; NaN where missing.
    pub top: &'a [f32],
    pub bottom: &'a [f32],
    /// Sine of the elevation from which a beam escapes towards each quadrant, see `HeightField::outlooks`; `RUN` each.
    pub clear: [&'a [f32]; 4],
    /// Whether each facet sees the source.
    pub seen: &'a [Seen; RUN],
}

/// Open questions about a facet, as words for the lanes.
pub type Doubt = u32;
/// Nothing is open.
pub const NONE: Doubt = 0;
/// It is lit, but its beam may be blocked.
pub const EXIT: Doubt = 1;
/// It may be hidden, or is too heavy to be summed in steps; weight and energy are not set.
pub const ALL: Doubt = 2;

/// What became of the lower or the upper facets of a run.
pub struct Lanes {
    /// Slopes in the frame of the detectors.
    pub p: [f32; RUN],
    pub q: [f32; RUN],
    /// Projected area of lit facets over that of the mean plane in steps.
    pub weight: [u32; RUN],
    /// `weight` times reflectance in steps.
    pub energy: [u32; RUN],
    /// Projected area of hidden facets in steps.
    pub shadow: [u32; RUN],
    /// What is still open about each facet.
    pub doubt: [Doubt; RUN],
    /// Mirror direction in the frame of the map, and height of the centroid \[m\].
    pub wo: [[f32; RUN]; 3],
    pub z: [f32; RUN],
    /// Half-vector cell of the slope; [`Lanes::FLAT`] and [`Lanes::MISSING`] slots lie behind the last cell.
    pub slot: [u32; RUN],
}

impl Default for Lanes {
    fn default() -> Self {
        Lanes {
            p: [0.0; RUN],
            q: [0.0; RUN],
            weight: [0; RUN],
            energy: [0; RUN],
            shadow: [0; RUN],
            doubt: [NONE; RUN],
            wo: [[0.0; RUN]; 3],
            z: [0.0; RUN],
            slot: [0; RUN],
        }
    }
}

impl Lanes {
    /// Slots behind the cells: the specular core, and facets that are not there.
    pub const FLAT: usize = 0;
    pub const MISSING: usize = 1;
    pub const EXTRA_SLOTS: usize = 2;

    /// Works out the facets above (`upper`) or below the diagonals of a run.
    pub fn shine(&mut self, level: Level, light: &Light, ground: &Ground, material: &Material, upper: bool) {
        match *material {
            Material::Mirror => self.shine_on(level, light, ground, Mirror, upper),
            Material::Dielectric { n } => self.shine_on(level, light, ground, Dielectric(n as f32), upper),
            Material::Conductor { n, k } => self.shine_on(level, light, ground, Conductor(n as f32, k as f32), upper),
        }
    }

    fn shine_on<R: Reflect>(&mut self, level: Level, light: &Light, ground: &Ground, reflect: R, upper: bool) {
        if upper {
            dispatch!(level, simd => shine::<_, R, true>(simd, light, ground, reflect, self));
        } else {
            dispatch!(level, simd => shine::<_, R, false>(simd, light, ground, reflect, self));
        }
    }

    /// Finds the slots of the slopes that [`Lanes::shine`] left.
    pub fn locate(&mut self, level: Level, cells: &HalfVectorCells) {
        let (at, behind) = (cells.lanes(), cells.len() as u32);
        dispatch!(level, simd => slots(simd, &self.p, &self.q, |p, q| at.locate(p, q), behind, &mut self.slot));
    }
}

/// Slots of slopes: what `place` says of them; behind the last place one for the specular core and one for missing facets.
#[simd]
pub fn slots<S: Simd, F: Fn(f32, f32) -> u32>(_: S, p: &[f32], q: &[f32], place: F, behind: u32, slots: &mut [u32]) {
    let n = slots.len();
    let (p, q) = (&p[..n], &q[..n]);
    let (flat, missing) = (behind + Lanes::FLAT as u32, behind + Lanes::MISSING as u32);
    for k in 0..n {
        let (p, q) = (p[k], q[k]);
        let slot = place(p, q);
        let steep = (p.abs() >= CORE_SLOPE as f32) | (q.abs() >= CORE_SLOPE as f32);
        let slot = if steep { slot } else { flat };
        slots[k] = if (p + q).is_nan() { missing } else { slot };
    }
}

/// Reflectance at `cos_beta`, as [`Material::reflectance`].
pub trait Reflect: Copy {
    fn at(self, cos_beta: f32) -> f32;
}

#[derive(Clone, Copy)]
pub struct Mirror;
#[derive(Clone, Copy)]
pub struct Dielectric(pub f32);
#[derive(Clone, Copy)]
pub struct Conductor(pub f32, pub f32);

/// What a facet of slope `(p, q)` does with light from `wi`.
pub struct Glance {
    /// `wi.z - p wi.x - q wi.y`: positive for a facet that faces the source.
    pub lean: f32,
    pub cos_beta: f32,
    /// Mirror direction.
    pub wo: [f32; 3],
}

impl Glance {
    /// As [`facing`](super::facing::facing), in f32.
    #[inline(always)]
    pub fn new([wx, wy, wz]: [f32; 3], p: f32, q: f32) -> Self {
        let lean = wz - p * wx - q * wy;
        let per_square = 1.0 / (1.0 + p * p + q * q);
        let cos_beta = lean * per_square.sqrt();
        let along = 2.0 * lean * per_square;
        Glance { lean, cos_beta, wo: [-along * p - wx, -along * q - wy, along - wz] }
    }
}

/// That of the four `clear` sines that counts for a direction, see `HeightField::clear_sines`.
#[inline(always)]
pub fn clear_towards(x: f32, y: f32, clear: [f32; 4]) -> f32 {
    let [c0, c1, c2, c3] = clear;
    let (north, south) = (if x > 0.0 { c3 } else { c2 }, if x > 0.0 { c1 } else { c0 });
    if y > 0.0 { north } else { south }
}

impl Reflect for Mirror {
    #[inline(always)]
    fn at(self, _: f32) -> f32 {
        1.0
    }
}

impl Reflect for Dielectric {
    #[inline(always)]
    fn at(self, c: f32) -> f32 {
        let n = self.0;
        let ct = (1.0 - (1.0 - c * c) / (n * n)).max(0.0).sqrt();
        // Both quotients over one denominator.
        let (s, s_below) = (c - n * ct, c + n * ct);
        let (p, p_below) = (n * c - ct, n * c + ct);
        let (a, b, below) = (s * p_below, p * s_below, s_below * p_below);
        0.5 * (a * a + b * b) / (below * below)
    }
}

impl Reflect for Conductor {
    #[inline(always)]
    fn at(self, c: f32) -> f32 {
        let Conductor(n, k) = self;
        let (er, ei) = (n * n - k * k, 2.0 * n * k);
        let re = er - (1.0 - c * c);
        let modulus = (re * re + ei * ei).sqrt();
        let gr = (0.5 * (modulus + re).max(0.0)).sqrt();
        let gi = (0.5 * (modulus - re).max(0.0)).sqrt();
        let square = |a: f32, b: f32| a * a + b * b;
        let (s, s_below) = (square(c - gr, gi), square(c + gr, gi));
        let (p, p_below) = (square(er * c - gr, ei * c - gi), square(er * c + gr, ei * c + gi));
        0.5 * (s * p_below + p * s_below) / (s_below * p_below)
    }
}

#[simd]
fn shine<S: Simd, R: Reflect, const UPPER: bool>(_: S, light: &Light, ground: &Ground, reflect: R, lanes: &mut Lanes) {
    let (top, bottom) = (&ground.top[..RUN + 1], &ground.bottom[..RUN + 1]);
    let [c0, c1, c2, c3] = ground.clear.map(|c| &c[..RUN]);
    let [cos, sin] = light.turn;
    let [px, py] = light.per_pitch;
    let per_wz = 1.0 / light.wi[2];
    for i in 0..RUN {
        let (a, b, c, d) = (top[i], top[i + 1], bottom[i], bottom[i + 1]);
        let p = if UPPER { b - a } else { d - c } * px;
        let q = if UPPER { b - d } else { a - c } * py;
        let Glance { lean, cos_beta, wo: [x, y, z] } = Glance::new(light.wi, p, q);
        let clear = clear_towards(x, y, [c0[i], c1[i], c2[i], c3[i]]);
        let weight = lean * per_wz;
        let towards = lean > 0.0;
        let seen = ground.seen[i];
        let known = (seen != row_sight::UNKNOWN) & (weight <= HEAVIEST);
        let lit = towards & known & (seen == row_sight::YES);
        let shadow = if towards & known & (seen == row_sight::NO) { weight } else { 0.0 };
        let doubt = if towards & !known { ALL } else { NONE };
        let doubt = if lit & !(z >= clear) { EXIT } else { doubt };
        let weight = if lit { weight } else { 0.0 };
        lanes.p[i] = cos * p + sin * q;
        lanes.q[i] = cos * q - sin * p;
        lanes.weight[i] = steps(weight);
        lanes.energy[i] = steps(weight * reflect.at(cos_beta));
        lanes.shadow[i] = steps(shadow);
        lanes.doubt[i] = doubt;
        lanes.wo[0][i] = x;
        lanes.wo[1][i] = y;
        lanes.wo[2][i] = z;
        lanes.z[i] = (a + d + if UPPER { b } else { c }) * (1.0 / 3.0);
    }
}

/// Rounds to whole steps in a way that works on lanes: a conversion that guards against overflow does not.
#[inline(always)]
pub fn steps(weight: f32) -> u32 {
    const SHIFT: f64 = (1u64 << (52 - STEP_BITS)) as f64;
    (f64::from(weight) + SHIFT).to_bits() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::scatter::facing::facing;

    #[test]
    fn steps_are_rounded_shares() {
        for x in [0.0, 1e-8, 0.3, 1.0, 15.999] {
            assert_eq!(steps(x), (f64::from(x) * f64::from(1u32 << STEP_BITS)).round() as u32);
        }
    }

    /// Against the scalar functions in f64, for every material and both kinds of facets.
    #[test]
    fn lanes_equal_single_facets() {
        let vertex = |k: usize| ((k * 7919 % 101) as f32 - 50.0) * if k / 7 % 2 == 1 { 7e-9 } else { 3.5e-9 };
        let top: Vec<f32> = (0..=RUN).map(vertex).collect();
        let bottom: Vec<f32> = (0..=RUN).map(|k| vertex(k + 1000)).collect();
        let pitch = [0.5e-6, 0.7e-6];
        let clear = vec![0.2; RUN];
        let seen: [Seen; RUN] = std::array::from_fn(|k| [row_sight::YES, row_sight::NO, row_sight::UNKNOWN][k % 3]);
        let ground = Ground { top: &top, bottom: &bottom, clear: [&clear; 4], seen: &seen };
        let wi = direction(1.1, 0.7);
        let light = Light::new(wi, 0.0, pitch);
        let mut count = [0; 4];
        for material in [Material::Mirror, Material::Dielectric { n: 1.5 }, Material::Conductor { n: 1.0, k: 6.6 }] {
            for upper in [false, true] {
                let mut lanes = Lanes::default();
                lanes.shine(Level::new(), &light, &ground, &material, upper);
                for k in 0..RUN {
                    let corners = [top[k], top[k + 1], bottom[k], bottom[k + 1]].map(f64::from);
                    let (p, q) = crate::facets::slopes::of_corners(corners, pitch[0], pitch[1])[usize::from(upper)];
                    let f = facing(p, q, wi);
                    let weight = f.map_or(0.0, |f| f.weight);
                    let energy = f.map_or(0.0, |f| weight * material.reflectance(f.cos_beta));
                    let is = |s: Seen| f64::from(u8::from(seen[k] == s));
                    let close = |steps: u32, x: f64| {
                        (f64::from(steps) / f64::from(1u32 << STEP_BITS) - x).abs() < 1e-6 * (1.0 + x)
                    };
                    assert!(close(lanes.weight[k], weight * is(row_sight::YES)));
                    assert!(close(lanes.energy[k], energy * is(row_sight::YES)));
                    assert!(close(lanes.shadow[k], weight * is(row_sight::NO)));
                    let third = if upper { corners[1] } else { corners[2] };
                    assert!((f64::from(lanes.z[k]) - (corners[0] + corners[3] + third) / 3.0).abs() < 1e-12);
                    let wo = glam::Vec3::from_array(lanes.wo.map(|x| x[k])).as_dvec3();
                    assert!(f.is_none_or(|f| (wo - f.wo).length() < 1e-6));
                    let doubt = match f {
                        Some(_) if seen[k] == row_sight::UNKNOWN => ALL,
                        Some(f) if seen[k] == row_sight::YES && f.wo.z < 0.2 => EXIT,
                        _ => NONE,
                    };
                    assert_eq!(lanes.doubt[k], doubt);
                    count[doubt as usize] += 1;
                    count[3] += usize::from(f.is_none());
                }
            }
        }
        assert!(count.iter().all(|&n| n > 0), "{count:?}");
    }
}
