//! Many spheres side by side: which of them a ray may meet.

use super::shape::{Ray, Sphere};

/// Spheres tested at a time.
const LANES: usize = 8;

/// Centres and squared radii of [`LANES`] spheres; unused lanes have a negative square, which no ray meets.
#[derive(Clone, Copy)]
struct Pack {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    r2: [f64; LANES],
}

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
            self.packs.push(Pack { x: empty, y: empty, z: empty, r2: [-1.0; LANES] });
        }
        if let Some(pack) = self.packs.last_mut() {
            (pack.x[lane], pack.y[lane], pack.z[lane]) = (sphere.centre.x, sphere.centre.y, sphere.centre.z);
            pack.r2[lane] = sphere.radius * sphere.radius;
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
    pub(super) fn closest(&self, ray: &Ray, mut t: f64, leaving: Option<usize>) -> Option<(f64, usize)> {
        let mut found = None;
        for (k, pack) in self.packs.iter().enumerate() {
            let mut near = pack.near(ray);
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
    pub(super) fn block(&self, ray: &Ray, distance: f64, leaving: Option<usize>, target: Option<usize>) -> bool {
        for (k, pack) in self.packs.iter().enumerate() {
            let mut near = pack.near(ray);
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
    /// Bit by bit, the spheres whose surface the ray may meet ahead: a little too many, never too few.
    #[inline(always)]
    fn near(&self, ray: &Ray) -> u32 {
        let (o, d) = (ray.origin, ray.direction);
        let mut near = [0u64; LANES];
        for i in 0..LANES {
            let (x, y, z) = (o.x - self.x[i], o.y - self.y[i], o.z - self.z[i]);
            let b = x * d.x + y * d.y + z * d.z;
            let m2 = x * x + y * y + z * z;
            let c = m2 - self.r2[i];
            // The slack covers the rounding of this shorter form; the exact test decides.
            let touches = b * b - c + 1e-12 * m2 >= 0.0;
            let ahead = (b <= 0.0) | (c <= 1e-12 * m2);
            near[i] = u64::from(touches & ahead & (self.r2[i] > 0.0)) << i;
        }
        near.iter().fold(0, |bits, bit| bits | bit) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::DVec3;
    use crate::math::random::CounterRng;

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
            assert_eq!(spheres.closest(&ray, f64::INFINITY, leaving), one_by_one);
            if let Some((t, i)) = one_by_one {
                hits += 1;
                assert!(spheres.block(&ray, 1.001 * t, leaving, None));
                assert!(!spheres.block(&ray, 0.999 * t, leaving, None));
                let rest = spheres.block(&ray, 1.001 * t, leaving, Some(i));
                assert!(!rest || leaving == Some(i) || (0..19).any(|j| j != i));
            }
        }
        assert!(hits > 1000);
    }
}
