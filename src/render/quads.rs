//! Many quads side by side: which of them a ray meets.

use super::shape::{Quad, Ray};
use fearless_simd::{Simd, f64x8, prelude::*};

/// Quads tested at a time.
const LANES: usize = 8;
/// So many quads one by one are no slower.
const FEW: usize = 2;

/// What [`Quad::intersect`] needs of [`LANES`] quads; unused lanes are in a plane that no ray meets.
#[derive(Clone, Copy)]
struct Pack {
    normal: [[f64; LANES]; 3],
    offset: [f64; LANES],
    dual_u: [[f64; LANES]; 3],
    dual_v: [[f64; LANES]; 3],
    shift_u: [f64; LANES],
    shift_v: [f64; LANES],
}

/// A list of quads.
#[derive(Default)]
pub(super) struct Quads {
    list: Vec<Quad>,
    packs: Vec<Pack>,
}

impl Quads {
    pub(super) fn push(&mut self, quad: Quad) {
        let lane = self.list.len() % LANES;
        if lane == 0 {
            let zero = [0.0; LANES];
            let zeros = [zero; 3];
            let (normal, dual_u, dual_v) = (zeros, zeros, zeros);
            self.packs.push(Pack { normal, offset: zero, dual_u, dual_v, shift_u: zero, shift_v: zero });
        }
        if let Some(pack) = self.packs.last_mut() {
            for axis in 0..3 {
                pack.normal[axis][lane] = quad.normal[axis];
                pack.dual_u[axis][lane] = quad.dual_u[axis];
                pack.dual_v[axis][lane] = quad.dual_v[axis];
            }
            (pack.offset[lane], pack.shift_u[lane], pack.shift_v[lane]) = (quad.offset, quad.shift_u, quad.shift_v);
        }
        self.list.push(quad);
    }

    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> &Quad {
        &self.list[index]
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// First quad but `leaving` before `t`: distance and index.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        mut t: f64,
        leaving: Option<usize>,
    ) -> Option<(f64, usize)> {
        let mut found = None;
        if self.list.len() <= FEW {
            for (index, quad) in self.list.iter().enumerate() {
                if leaving != Some(index)
                    && let Some(nearer) = quad.intersect(ray, t)
                {
                    t = nearer;
                    found = Some((t, index));
                }
            }
            return found;
        }
        for (k, pack) in self.packs.iter().enumerate() {
            let (distances, mut met) = pack.meet(simd, ray, t);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let index = k * LANES + lane;
                if distances[lane] < t && leaving != Some(index) {
                    t = distances[lane];
                    found = Some((t, index));
                }
            }
        }
        found
    }

    /// Whether any quad but `leaving` and `target` stands before `distance`.
    #[inline(always)]
    pub(super) fn block<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        distance: f64,
        leaving: Option<usize>,
        target: Option<usize>,
    ) -> bool {
        let free = |index: usize| leaving != Some(index) && target != Some(index);
        if self.list.len() <= FEW {
            let mut list = self.list.iter().enumerate();
            return list.any(|(index, quad)| free(index) && quad.intersect(ray, distance).is_some());
        }
        for (k, pack) in self.packs.iter().enumerate() {
            let (_, mut met) = pack.meet(simd, ray, distance);
            while met != 0 {
                let index = k * LANES + met.trailing_zeros() as usize;
                met &= met - 1;
                if free(index) {
                    return true;
                }
            }
        }
        false
    }
}

impl Pack {
    /// [`Quad::intersect`] of every lane, by the same operations: distances, and a bit for each quad that is met.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, ray: &Ray, t_max: f64) -> ([f64; LANES], u64) {
        let (o, d) = (ray.origin, ray.direction);
        let lanes = |v: &[f64; LANES]| f64x8::from_slice(simd, v);
        let [nx, ny, nz] = [0, 1, 2].map(|axis| lanes(&self.normal[axis]));
        let height = lanes(&self.offset) - (nx * o.x + ny * o.y + nz * o.z);
        let t = height / (nx * d.x + ny * d.y + nz * d.z);
        let (x, y, z) = (t * d.x + o.x, t * d.y + o.y, t * d.z + o.z);
        let along = |dual: &[[f64; LANES]; 3], shift: &[f64; LANES]| {
            lanes(&dual[0]) * x + lanes(&dual[1]) * y + lanes(&dual[2]) * z - lanes(shift)
        };
        let (u, v) = (along(&self.dual_u, &self.shift_u), along(&self.dual_v, &self.shift_v));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        // A ray in a plane, and an unused lane, give an infinity or a NaN: both fail the first comparisons.
        let ahead = t.simd_gt(zero) & t.simd_lt(f64x8::splat(simd, t_max));
        let inside = u.simd_ge(zero) & u.simd_le(one) & v.simd_ge(zero) & v.simd_le(one);
        (t.into(), (ahead & inside).to_bitmask())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::DVec3;
    use crate::math::random::CounterRng;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn the_sweep_finds_what_one_by_one_finds() {
        let mut rng = CounterRng::new(7, 0, 0);
        let mut point = |scale: f64| scale * (DVec3::new(rng.uniform(), rng.uniform(), rng.uniform()) - 0.5);
        let mut quads = Quads::default();
        for _ in 0..19 {
            quads.push(Quad::new(point(10.0), point(8.0), point(8.0)).unwrap());
        }
        let mut hits = 0;
        for k in 0..4000 {
            let leaving = (k % 2 == 0).then_some(k % 19);
            let mut origin = point(12.0);
            if let Some(index) = leaving {
                let quad = quads.get(index);
                origin = quad.corner + 0.3 * quad.edge_u + 0.4 * quad.edge_v;
            }
            // Every fourth ray runs in the plane of the first quad.
            let direction = if k % 4 == 1 { quads.get(0).tangent } else { point(1.0).normalize() };
            let ray = Ray { origin, direction };
            let one_by_one = (0..19)
                .filter(|i| leaving != Some(*i))
                .filter_map(|i| quads.get(i).intersect(&ray, f64::INFINITY).map(|t| (t, i)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let found = dispatch!(Level::new(), simd => quads.closest(simd, &ray, f64::INFINITY, leaving));
            assert_eq!(found, one_by_one);
            let Some((t, i)) = found else { continue };
            hits += 1;
            let block = |distance: f64, target: Option<usize>| dispatch!(Level::new(), simd => quads.block(simd, &ray, distance, leaving, target));
            assert!(block(1.001 * t, None) && !block(0.999 * t, None));
            let second = (0..19)
                .filter(|j| *j != i && leaving != Some(*j))
                .any(|j| quads.get(j).intersect(&ray, 1.001 * t).is_some());
            assert_eq!(block(1.001 * t, Some(i)), second);
        }
        assert!(hits > 300, "{hits}");
    }
}
