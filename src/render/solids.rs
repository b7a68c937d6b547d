//! Quads and spheres: which of them each ray of a bundle meets.

use super::rays::{Bundle, Hits, LANES, Rays, Shadows, dot, dot_lanes};
use super::scene::Id;
use super::screens::Screens;
use super::shape::{Quad, Sphere};
use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

/// The shapes that are asked one after the other, each by [`LANES`] rays at a time: few shapes are the rule, and a scene of
/// many parts comes as a mesh with its hierarchy.
#[derive(Default)]
pub(super) struct Solids {
    pub(super) quads: Vec<Quad>,
    /// Those of them that can stand in the way of light.
    pub(super) screens: Screens,
    pub(super) spheres: Vec<Sphere>,
    /// Those of them that shine.
    pub(super) lamps: Vec<Id>,
}

/// 2^52: between this and its double an f64 is a whole number, written in its last bits.
const ONES: f64 = (1u64 << 52) as f64;

/// Distances, and the lanes for which they hold.
struct Met<S: Simd> {
    t: f64x8<S>,
    lanes: mask64x8<S>,
}

impl Id {
    /// A number for each quad and sphere, even and odd; -1 for everything else.
    #[inline(always)]
    pub(super) fn solid(id: Option<Id>) -> f64 {
        match id {
            Some(Id::Quad(i)) => f64::from(2 * i),
            Some(Id::Sphere(i)) => f64::from(2 * i + 1),
            _ => -1.0,
        }
    }
}

impl Solids {
    /// First solid but the one it leaves along each ray from number `from` on: distance, and 1 more than [`Id::solid`].
    #[inline(always)]
    pub(super) fn closest<S: Simd>(&self, simd: S, rays: &Rays, from: usize, hits: &mut Hits) {
        let bundle = rays.bundle(simd, from);
        let wide = |x: f64| f64x8::splat(simd, x);
        let (mut t, mut found) = (wide(f64::INFINITY), wide(-1.0));
        for (i, quad) in self.quads.iter().enumerate() {
            let number = wide((2 * i) as f64);
            let met = meet_quad(simd, &bundle, quad, t);
            let nearer = met.lanes & !bundle.leaving.simd_eq(number);
            (t, found) = (nearer.select(met.t, t), nearer.select(number, found));
        }
        for from in (0..self.spheres.len()).step_by(u64::BITS as usize) {
            // Which of them is met by any ray nobody can foresee: all are asked before one is looked at again.
            let mut left = 0;
            for (k, sphere) in self.spheres[from..].iter().take(u64::BITS as usize).enumerate() {
                left |= u64::from(approach(simd, &bundle, sphere).1.any_true()) << k;
            }
            while left != 0 {
                let i = from + left.trailing_zeros() as usize;
                left &= left - 1;
                let number = wide((2 * i + 1) as f64);
                let met = meet_sphere(simd, &bundle, &self.spheres[i], bundle.leaving.simd_eq(number), t);
                (t, found) = (met.lanes.select(met.t, t), met.lanes.select(number, found));
            }
        }
        t.store_slice(&mut hits.t[from..from + LANES]);
        // The last digits of a number at which they count by ones: no conversion that would have to look for overflow.
        let digits: [f64; LANES] = (found + (ONES + 1.0)).into();
        for (surface, digits) in hits.surface[from..from + LANES].iter_mut().zip(digits) {
            *surface = digits.to_bits() as u32;
        }
    }

    /// A bit for each ray from number `from` on that may meet a lamp: a few too many, never too few.
    #[inline(always)]
    pub(super) fn lamps_ahead<S: Simd>(&self, simd: S, rays: &Rays, from: usize) -> u64 {
        let bundle = rays.bundle(simd, from);
        let far = f64x8::splat(simd, f64::INFINITY);
        let mut ahead = 0;
        for lamp in &self.lamps {
            ahead |= match *lamp {
                Id::Quad(i) => meet_quad(simd, &bundle, &self.quads[i as usize], far).lanes.to_bitmask(),
                Id::Sphere(i) => approach(simd, &bundle, &self.spheres[i as usize]).1.to_bitmask(),
                _ => !0,
            };
        }
        ahead
    }

    /// A bit for each ray from number `from` on before whose end a solid stands that is neither its start nor its target.
    #[inline(always)]
    pub(super) fn block<S: Simd>(&self, simd: S, shadows: &Shadows, from: usize) -> u64 {
        let bundle = shadows.rays.bundle(simd, from);
        let [length, target] = shadows.ends(simd, from);
        let wide = |x: f64| f64x8::splat(simd, x);
        let mut blocked = length.simd_lt(wide(0.0));
        for &i in self.screens.list() {
            let (number, quad) = (wide(f64::from(2 * i)), &self.quads[i as usize]);
            let free = !(bundle.leaving.simd_eq(number) | target.simd_eq(number));
            // Most planes have start and end of all rays on one side: no division.
            if (free & between(simd, &bundle, quad, length)).any_true() {
                blocked |= free & meet_quad(simd, &bundle, quad, length).lanes;
            }
        }
        for (i, sphere) in self.spheres.iter().enumerate() {
            let number = wide((2 * i + 1) as f64);
            let own = bundle.leaving.simd_eq(number);
            // A sphere may hide itself from a ray that starts inside.
            let passed = target.simd_eq(number) & !own;
            blocked |= block_sphere(simd, &bundle, sphere, own, length) & !passed;
        }
        blocked.to_bitmask()
    }
}

/// [`Quad::intersect`] in lanes.
#[inline(always)]
fn meet_quad<S: Simd>(simd: S, rays: &Bundle<S>, quad: &Quad, limit: f64x8<S>) -> Met<S> {
    let (o, d) = (&rays.origin, &rays.direction);
    let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
    let t = (f64x8::splat(simd, quad.offset) - dot(o, quad.normal)) / dot(d, quad.normal);
    let point = [t.mul_add(d[0], o[0]), t.mul_add(d[1], o[1]), t.mul_add(d[2], o[2])];
    let (u, v) = (dot(&point, quad.dual_u) - quad.shift_u, dot(&point, quad.dual_v) - quad.shift_v);
    // A ray in the plane gives an infinity or a NaN: both fail these comparisons.
    let ahead = t.simd_gt(zero) & t.simd_lt(limit);
    Met { t, lanes: ahead & u.simd_ge(zero) & u.simd_le(one) & v.simd_ge(zero) & v.simd_le(one) }
}

/// The rays that change the side of the plane of a quad before their limit, and a few more by rounding.
#[inline(always)]
fn between<S: Simd>(simd: S, rays: &Bundle<S>, quad: &Quad, limit: f64x8<S>) -> mask64x8<S> {
    let height = f64x8::splat(simd, quad.offset) - dot(&rays.origin, quad.normal);
    let way = dot(&rays.direction, quad.normal) * limit * (1.0 + 1e-12);
    (height * way).simd_gt(f64x8::splat(simd, 0.0)) & (height * (height - way)).simd_le(f64x8::splat(simd, 0.0))
}

/// What both questions to a sphere begin with, as [`Sphere::intersect`] does: `b`, `c`, the discriminant, and the lanes whose
/// lines pass through it and that do not leave it behind.
#[inline(always)]
fn approach<S: Simd>(simd: S, rays: &Bundle<S>, sphere: &Sphere) -> ([f64x8<S>; 3], mask64x8<S>) {
    let (o, d) = (&rays.origin, &rays.direction);
    let zero = f64x8::splat(simd, 0.0);
    let r2 = sphere.radius * sphere.radius;
    let m = [o[0] - sphere.centre.x, o[1] - sphere.centre.y, o[2] - sphere.centre.z];
    let b = dot_lanes(&m, d);
    let back = zero - b;
    let across = [back.mul_add(d[0], m[0]), back.mul_add(d[1], m[1]), back.mul_add(d[2], m[2])];
    let discriminant = f64x8::splat(simd, r2) - dot_lanes(&across, &across);
    let c = dot_lanes(&m, &m) - r2;
    let lanes = discriminant.simd_ge(zero) & (c.simd_le(zero) | b.simd_le(zero));
    ([b, c, discriminant], lanes)
}

/// [`Sphere::intersect`] in lanes, and in those of `own` the far end of the chord: rounding must not find the start again.
#[inline(always)]
fn meet_sphere<S: Simd>(simd: S, rays: &Bundle<S>, sphere: &Sphere, own: mask64x8<S>, limit: f64x8<S>) -> Met<S> {
    let ([b, c, discriminant], near) = approach(simd, rays, sphere);
    let zero = f64x8::splat(simd, 0.0);
    let root = discriminant.max(zero).sqrt();
    let outside = c.simd_gt(zero);
    let t = outside.select(c, root - b) / outside.select(root - b, f64x8::splat(simd, 1.0));
    let t = own.select(b * -2.0, t);
    let least = own.select(f64x8::splat(simd, 1e-9 * sphere.radius), zero);
    Met { t, lanes: near & t.simd_gt(least) & t.simd_lt(limit) }
}

/// Whether the sphere is met before `length`, without a root: the end of the ray is beyond the middle of its chord, or inside
/// the sphere; from inside, outside of it.
#[inline(always)]
fn block_sphere<S: Simd>(
    simd: S,
    rays: &Bundle<S>,
    sphere: &Sphere,
    own: mask64x8<S>,
    length: f64x8<S>,
) -> mask64x8<S> {
    let ([b, c, _], near) = approach(simd, rays, sphere);
    let zero = f64x8::splat(simd, 0.0);
    let middle = zero - b;
    let end = length.mul_add(b + b + length, c);
    let from_outside = c.simd_gt(zero) & (middle.simd_le(length) | end.simd_lt(zero));
    let from_inside = c.simd_le(zero) & end.simd_gt(zero);
    let chord = middle + middle;
    let again = chord.simd_gt(f64x8::splat(simd, 1e-9 * sphere.radius)) & chord.simd_lt(length);
    (own & again) | (!own & near & (from_outside | from_inside))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::DVec3;
    use crate::math::random::CounterRng;
    use crate::render::shape::Ray;
    use fearless_simd::{Level, dispatch};

    fn one_by_one(solids: &Solids, ray: &Ray, leaving: Option<Id>) -> Option<(f64, Id)> {
        let quads = (0..solids.quads.len() as u32).filter(|i| leaving != Some(Id::Quad(*i)));
        let quads = quads.filter_map(|i| Some((solids.quads[i as usize].intersect(ray, f64::INFINITY)?, Id::Quad(i))));
        let spheres = (0..solids.spheres.len() as u32).filter_map(|i| {
            let (sphere, id) = (&solids.spheres[i as usize], Id::Sphere(i));
            let t = if leaving == Some(id) {
                sphere.intersect_again(ray, f64::INFINITY)
            } else {
                sphere.intersect(ray, f64::INFINITY)
            };
            t.map(|t| (t, id))
        });
        quads.chain(spheres).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Rays in all directions, some from a quad, from a sphere to its outside or its inside, some in the plane of a quad.
    fn cases() -> (Solids, Vec<(Ray, Option<Id>)>) {
        let mut rng = CounterRng::new(7, 0, 0);
        let mut point = |scale: f64| scale * (DVec3::new(rng.uniform(), rng.uniform(), rng.uniform()) - 0.5);
        let mut solids = Solids::default();
        for k in 0..9 {
            solids.quads.push(Quad::new(point(10.0), point(8.0), point(8.0)).unwrap());
            solids.spheres.push(Sphere::new(point(12.0), 0.2 * f64::from(k) + 1e-3).unwrap());
        }
        solids.quads.iter().for_each(|quad| solids.screens.add(&solids.quads, &(*quad).into()));
        // Rays go anywhere.
        solids.screens.open();
        let mut rays = Vec::new();
        for k in 0..8000 {
            let i = k / 4 % 9;
            let (mut origin, mut leaving) = (point(14.0), None);
            let mut direction = point(1.0).normalize();
            match k % 4 {
                0 => {
                    let quad = &solids.quads[i];
                    origin = quad.corner + 0.3 * quad.edge_u + 0.4 * quad.edge_v;
                    leaving = Some(Id::Quad(i as u32));
                }
                1 => {
                    let sphere = &solids.spheres[i];
                    origin = sphere.centre + sphere.radius * point(1.0).normalize();
                    leaving = Some(Id::Sphere(i as u32));
                }
                2 if k % 3 == 0 => direction = solids.quads[i].tangent,
                _ => {}
            }
            rays.push((Ray { origin, direction }, leaving));
        }
        (solids, rays)
    }

    #[test]
    fn lanes_find_what_one_by_one_finds() {
        let (solids, cases) = cases();
        let mut hits = 0;
        for chunk in cases.chunks(LANES) {
            let mut rays = Rays::default();
            chunk.iter().for_each(|(ray, leaving)| rays.push(ray, *leaving, Id::solid(*leaving)));
            let mut found = Hits::default();
            dispatch!(Level::new(), simd => solids.closest(simd, &rays, 0, &mut found));
            for (j, (ray, leaving)) in chunk.iter().enumerate() {
                let expected = one_by_one(&solids, ray, *leaving);
                assert_eq!(f64::from(found.surface[j]), 1.0 + Id::solid(expected.map(|(_, id)| id)));
                let t = expected.map_or(f64::INFINITY, |(t, _)| t);
                assert!(found.t[j] == t || (found.t[j] / t - 1.0).abs() < 1e-9, "{} {t}", found.t[j]);
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits > 2000, "{hits}");
    }

    #[test]
    fn a_ray_is_blocked_beyond_its_first_solid_and_not_before() {
        let (solids, cases) = cases();
        let mut blocked = 0;
        for (ray, leaving) in &cases {
            let Some((t, id)) = one_by_one(&solids, ray, *leaving) else { continue };
            let start = leaving.unwrap_or(Id::Disc(0));
            let mut shadows = Shadows::default();
            for (length, target) in [(1.001 * t, None), (0.999 * t, None), (f64::INFINITY, None), (1.001 * t, Some(id))]
            {
                shadows.push(ray, start, length, target, [Id::solid(*leaving), Id::solid(target)]);
            }
            let bits = dispatch!(Level::new(), simd => solids.block(simd, &shadows, 0));
            // The solids behind the first within 1/1000 of the way are few: they block as well.
            let others = (0..9u32).flat_map(|i| [Id::Quad(i), Id::Sphere(i)]).filter(|o| *o != id);
            let mut others = others.filter_map(|o| match o {
                Id::Quad(_) if Some(o) == *leaving => None,
                Id::Sphere(i) if Some(o) == *leaving => solids.spheres[i as usize].intersect_again(ray, 1.001 * t),
                Id::Quad(i) => solids.quads[i as usize].intersect(ray, 1.001 * t),
                Id::Sphere(i) => solids.spheres[i as usize].intersect(ray, 1.001 * t),
                _ => None,
            });
            let through = others.next().is_some() || Some(id) == *leaving;
            assert_eq!(bits & 15, 0b0101 | u64::from(through) << 3, "{ray:?} {leaving:?} {t} {id:?}");
            blocked += 1;
        }
        assert!(blocked > 2000, "{blocked}");
    }
}
