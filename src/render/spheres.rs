//! Many spheres side by side: which of them a ray may meet.

use super::shape::{Ray, Sphere};
use fearless_simd::{Simd, f32x16, prelude::*};

/// Spheres tested at a time.
const LANES: usize = 16;

/// Centres and squared radii of [`LANES`] spheres in f32, where a sphere may look a little larger than it is; unused lanes
/// have a square that no ray meets.
#[derive(Clone, Copy)]
struct Pack {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    r2: [f32; LANES],
    /// Squared distances of the centres from the origin, for the rounding of coordinates.
    away2: [f32; LANES],
}

/// Share of the squares of distances that covers the rounding to f32 of a discriminant.
const SLACK: f32 = 1e-6;

/// A list of spheres that finds the few a ray comes near to in one sweep and asks those exactly.
#[derive(Default)]
pub(super) struct Spheres {
    list: Vec<Sphere>,
    packs: Vec<Pack>,
}

impl Spheres {
    pub(super) fn push(&mut self, sphere: Sphere) {
        let lane = self.list.len() % LANES;
        if lane == 0 {
            let empty = [0.0; LANES];
            self.packs.push(Pack { x: empty, y: empty, z: empty, r2: [f32::NEG_INFINITY; LANES], away2: empty });
        }
        if let Some(pack) = self.packs.last_mut() {
            [pack.x[lane], pack.y[lane], pack.z[lane]] = sphere.centre.as_vec3().to_array();
            pack.r2[lane] = (sphere.radius * sphere.radius) as f32;
            pack.away2[lane] = sphere.centre.length_squared() as f32;
        }
        self.list.push(sphere);
    }

    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> &Sphere {
        &self.list[index]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Sphere> {
        self.list.iter()
    }

    /// First sphere before `t`: distance and index.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        mut t: f64,
        leaving: Option<usize>,
    ) -> Option<(f64, usize)> {
        let mut found = None;
        for (k, pack) in self.packs.iter().enumerate() {
            let mut near = pack.near(simd, ray);
            while near != 0 {
                let index = k * LANES + near.trailing_zeros() as usize;
                near &= near - 1;
                if let Some(nearer) = self.meet(index, ray, t, leaving) {
                    t = nearer;
                    found = Some((t, index));
                }
            }
        }
        found
    }

    /// Whether any sphere but `target` stands before `distance`.
    #[inline(always)]
    pub(super) fn block<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        distance: f64,
        leaving: Option<usize>,
        target: Option<usize>,
    ) -> bool {
        for (k, pack) in self.packs.iter().enumerate() {
            let mut near = pack.near(simd, ray);
            while near != 0 {
                let index = k * LANES + near.trailing_zeros() as usize;
                near &= near - 1;
                let again = leaving == Some(index);
                if (again || target != Some(index)) && self.meet(index, ray, distance, leaving).is_some() {
                    return true;
                }
            }
        }
        false
    }

    #[inline(always)]
    fn meet(&self, index: usize, ray: &Ray, t: f64, leaving: Option<usize>) -> Option<f64> {
        let sphere = &self.list[index];
        if leaving == Some(index) { sphere.intersect_again(ray, t) } else { sphere.intersect(ray, t) }
    }
}

impl Pack {
    /// A bit for each sphere whose surface the ray may meet ahead: a little too many, never too few.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, ray: &Ray) -> u64 {
        let (o, d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
        let wide = |x: f32| f32x16::splat(simd, x);
        let lanes = |v: &[f32; LANES]| f32x16::from_slice(simd, v);
        let (x, y, z) = (wide(o.x) - lanes(&self.x), wide(o.y) - lanes(&self.y), wide(o.z) - lanes(&self.z));
        let b = x * d.x + y * d.y + z * d.z;
        let m2 = x * x + y * y + z * z;
        let slack = (m2 + lanes(&self.away2) + o.length_squared()) * SLACK;
        let c = m2 - lanes(&self.r2) - slack;
        let (b2, zero) = (b * b, wide(0.0));
        let ahead = b.simd_le(zero) | c.simd_le(zero) | b2.simd_le(slack);
        (b2.simd_ge(c) & ahead).to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::DVec3;
    use crate::math::random::CounterRng;
    use fearless_simd::{Level, dispatch};

    fn closest(spheres: &Spheres, ray: &Ray, t: f64, leaving: Option<usize>) -> Option<(f64, usize)> {
        dispatch!(Level::new(), simd => spheres.closest(simd, ray, t, leaving))
    }

    fn block(spheres: &Spheres, ray: &Ray, t: f64, leaving: Option<usize>, target: Option<usize>) -> bool {
        dispatch!(Level::new(), simd => spheres.block(simd, ray, t, leaving, target))
    }

    #[test]
    fn the_sweep_finds_what_one_by_one_finds() {
        let mut rng = CounterRng::new(5, 0, 0);
        let mut point = |scale: f64| scale * (DVec3::new(rng.uniform(), rng.uniform(), rng.uniform()) - 0.5);
        let mut spheres = Spheres::default();
        for k in 0..19 {
            spheres.push(Sphere::new(point(20.0), 0.05 * f64::from(k) + 1e-3).unwrap());
        }
        let mut hits = 0;
        for k in 0..4000 {
            // Every other ray starts on a sphere, as after a reflection.
            let leaving = (k % 2 == 0).then_some(k % 19);
            let mut origin = point(30.0);
            if let Some(index) = leaving {
                let sphere = spheres.get(index);
                origin = sphere.centre + sphere.radius * point(1.0).normalize();
            }
            let ray = Ray { origin, direction: point(1.0).normalize() };
            let one_by_one = (0..19)
                .filter_map(|i| spheres.meet(i, &ray, f64::INFINITY, leaving).map(|t| (t, i)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(closest(&spheres, &ray, f64::INFINITY, leaving), one_by_one);
            if let Some((t, i)) = one_by_one {
                hits += 1;
                assert!(block(&spheres, &ray, 1.001 * t, leaving, None));
                assert!(!block(&spheres, &ray, 0.999 * t, leaving, None));
                let rest = block(&spheres, &ray, 1.001 * t, leaving, Some(i));
                assert!(!rest || leaving == Some(i) || (0..19).any(|j| j != i));
            }
        }
        assert!(hits > 1000);
    }
}
