//! How much each lamp matters at a point, and which one is asked there.

use super::rays::Column;
use crate::math::frame::DVec3;
use fearless_simd::{Simd, f32x16, f64x8, prelude::*};

/// Up to this many lights are weighed at every point; more are drawn by their power alone.
const WEIGHED: usize = 64;

/// Least share of a lamp's weight that a grazing view of it leaves: parts of it may be seen better.
const GRAZING: f32 = 0.1;

/// Points weighed at a time. In f32: a weight is a chance, not a radiance.
const LANES: usize = 16;

/// What decides how much a light matters at a point.
pub(super) struct Reach {
    pub centre: DVec3,
    pub radius: f64,
    /// Area times mean radiance [W/sr]; irradiance [W/m2] of the surroundings.
    pub strength: f64,
    /// Normal of a flat lamp; zero of one that shines all around.
    pub front: DVec3,
    pub everywhere: bool,
}

/// A point that asks for light, with the normal on its bright side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asking {
    pub point: DVec3,
    pub normal: DVec3,
}

/// The points that ask together, in columns, with the numbers that pick their lights.
#[derive(Clone, Copy)]
pub(super) struct Asks<'c> {
    pub len: usize,
    pub point: &'c [Column<f64>; 3],
    pub normal: &'c [Column<f64>; 3],
    pub u: &'c Column<f64>,
}

/// The light picked at a point: its number and chance, and where its share of the unit interval starts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pick {
    pub light: u32,
    /// 0 if no light shines here.
    pub chance: f64,
    pub start: f64,
    /// Sum of the weights of all lights.
    pub total: f32,
}

/// Weights of all lights at [`LANES`] points, and their sums up to and including each.
pub(super) struct Scratch {
    weights: [[f32; LANES]; WEIGHED],
    up_to: [[f32; LANES]; WEIGHED],
}

impl Default for Scratch {
    fn default() -> Self {
        Scratch { weights: [[0.0; LANES]; WEIGHED], up_to: [[0.0; LANES]; WEIGHED] }
    }
}

/// A list of lights by their reach.
#[derive(Default)]
pub(super) struct Reaches {
    list: Vec<Reach>,
    /// Sums of the chances by strength up to and including each light.
    cumulative: Vec<f64>,
}

impl Reaches {
    /// Sets light number `index`, or adds it behind the last.
    pub(super) fn put(&mut self, index: usize, reach: Reach) {
        if index == self.list.len() {
            self.list.push(reach);
        } else {
            self.list[index] = reach;
        }
        let total: f64 = self.list.iter().map(|r| r.strength).sum();
        let count = self.list.len() as f64;
        let mut sum = 0.0;
        self.cumulative.clear();
        for reach in &self.list {
            // Half evenly: a small lamp close by matters more than its power tells.
            sum += 0.5 * reach.strength / total + 0.5 / count;
            self.cumulative.push(sum);
        }
    }

    fn share(&self, light: usize) -> (f64, f64) {
        let start = if light > 0 { self.cumulative[light - 1] } else { 0.0 };
        (start, self.cumulative[light] - start)
    }

    /// Chance of a light at a point where the weights of all lights add up to `total`.
    #[inline(always)]
    pub(super) fn chance<S: Simd>(&self, simd: S, light: usize, at: &Asking, total: f32) -> f64 {
        if self.list.len() > WEIGHED {
            return self.share(light).1;
        }
        let wide = |v: DVec3| [v.x, v.y, v.z].map(|x| f32x16::splat(simd, x as f32));
        let weights: [f32; LANES] = self.list[light].weights(simd, &wide(at.point), &wide(at.normal)).into();
        if total > 0.0 { f64::from(weights[0] / total) } else { 0.0 }
    }

    /// Picks a light for every point by how much it matters there.
    #[inline(always)]
    pub(super) fn pick<S: Simd>(&self, simd: S, asks: Asks, scratch: &mut Scratch, picks: &mut Column<Pick>) {
        let count = self.list.len();
        if count == 0 {
            return picks[..asks.len].fill(Pick::default());
        }
        if count > WEIGHED {
            for (pick, &u) in picks.iter_mut().zip(asks.u).take(asks.len) {
                let light = self.cumulative.partition_point(|&c| c <= u).min(count - 1);
                let (start, chance) = self.share(light);
                *pick = Pick { light: light as u32, chance, start, total: 1.0 };
            }
            return;
        }
        for from in (0..asks.len).step_by(LANES) {
            let half = |column: &Column<f64>, at: usize| f64x8::from_slice(simd, &column[at..at + LANES / 2]);
            let load = |column: &Column<f64>| simd.narrow_f64x8(half(column, from), half(column, from + LANES / 2));
            let all = |columns: &[Column<f64>; 3]| [load(&columns[0]), load(&columns[1]), load(&columns[2])];
            let (point, normal) = (all(asks.point), all(asks.normal));
            let mut total = f32x16::splat(simd, 0.0);
            for (k, reach) in self.list.iter().enumerate() {
                let weights = reach.weights(simd, &point, &normal);
                total += weights;
                scratch.weights[k] = weights.into();
                scratch.up_to[k] = total.into();
            }
            let target = total * load(asks.u);
            let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
            let mut index = zero;
            for up_to in &scratch.up_to[..count - 1] {
                index += f32x16::from_slice(simd, up_to).simd_le(target).select(one, zero);
            }
            let (index, total): ([f32; LANES], [f32; LANES]) = (index.into(), total.into());
            for lane in 0..LANES.min(asks.len - from) {
                let light = index[lane] as usize;
                let (weight, sum) = (scratch.weights[light][lane], total[lane]);
                // Rounding may lead to a light that is out of sight, once in 10^7 draws.
                let (chance, before) =
                    if weight > 0.0 { (weight / sum, (scratch.up_to[light][lane] - weight) / sum) } else { (0.0, 0.0) };
                picks[from + lane] =
                    Pick { light: light as u32, chance: f64::from(chance), start: f64::from(before), total: sum };
            }
        }
    }
}

impl Reach {
    /// Irradiance at the points if nothing stands between, to a factor of order 1; 0 only where the lamp is out of sight. The
    /// angle to the surface counts by the part of the lamp that stands highest.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, p: &[f32x16<S>; 3], n: &[f32x16<S>; 3]) -> f32x16<S> {
        let wide = |x: f32| f32x16::splat(simd, x);
        let strength = self.strength as f32;
        if self.everywhere {
            return wide(strength);
        }
        let (centre, front, radius) = (self.centre.as_vec3(), self.front.as_vec3(), self.radius as f32);
        let [x, y, z] = [wide(centre.x) - p[0], wide(centre.y) - p[1], wide(centre.z) - p[2]];
        let dot = |a: f32x16<S>, b: f32x16<S>, c: f32x16<S>| x.mul_add(a, y.mul_add(b, z * c));
        let d2 = dot(x, y, z);
        let d = d2.sqrt();
        let (zero, r) = (wide(0.0), wide(radius));
        // A hair of room for the rounding of a lamp that just touches the horizon.
        let height = dot(n[0], n[1], n[2]) + radius * 1.0001 + d * 1e-5;
        // The cosine, from 0 to 1, over the squared distance.
        let reach = d.max(r);
        let near = height.max(zero).min(reach) * strength / (reach * reach * reach);
        if self.front == DVec3::ZERO {
            return near;
        }
        let side = d * 1e-5 - dot(wide(front.x), wide(front.y), wide(front.z));
        near * side.simd_gt(zero).select((side / d).max(wide(GRAZING)), zero)
    }
}
