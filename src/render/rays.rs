//! Rays in columns, to be followed side by side.

use super::scene::Id;
use super::shape::Ray;
use crate::math::frame::DVec3;
use fearless_simd::{Simd, f64x8, prelude::*};

/// Most rays under way together: enough to share every step and to bring several to each material, few enough for their
/// columns to stay in the second cache.
pub(super) const WAVE: usize = 256;
/// Rays that one vector holds.
pub(super) const LANES: usize = 8;

pub(super) type Column<T> = [T; WAVE];

/// Up to [`WAVE`] rays with the surface each of them starts on: excluding it by name instead of by a small distance keeps
/// contacts exact.
pub(super) struct Rays {
    len: usize,
    origin: [Column<f64>; 3],
    direction: [Column<f64>; 3],
    leaving: Column<Option<Id>>,
    /// [`Id::solid`] of it.
    solid: Column<f64>,
}

/// [`LANES`] rays.
#[derive(Clone, Copy)]
pub(super) struct Bundle<S: Simd> {
    pub origin: Lanes3<S>,
    pub direction: Lanes3<S>,
    pub leaving: f64x8<S>,
}

impl Default for Rays {
    fn default() -> Self {
        let zeros = [[0.0; WAVE]; 3];
        // Lanes that were never filled have no direction and meet nothing.
        Rays { len: 0, origin: zeros, direction: zeros, leaving: [None; WAVE], solid: [-1.0; WAVE] }
    }
}

impl Rays {
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds one; there must be room. `solid` is [`Id::solid`] of the surface it leaves.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, leaving: Option<Id>, solid: f64) {
        let j = self.len;
        for axis in 0..3 {
            self.origin[axis][j] = ray.origin[axis];
            self.direction[axis][j] = ray.direction[axis];
        }
        (self.leaving[j], self.solid[j]) = (leaving, solid);
        self.len = j + 1;
    }

    /// Adds ray number `j` of another list.
    #[inline(always)]
    pub(super) fn push_from(&mut self, others: &Rays, j: usize) {
        self.push(&others.get(j), others.leaving[j], others.solid[j]);
    }

    #[inline(always)]
    pub(super) fn get(&self, j: usize) -> Ray {
        let at = |columns: &[Column<f64>; 3]| DVec3::new(columns[0][j], columns[1][j], columns[2][j]);
        Ray { origin: at(&self.origin), direction: at(&self.direction) }
    }

    /// Makes every direction a unit vector.
    #[inline(always)]
    pub(super) fn normalise<S: Simd>(&mut self, simd: S) {
        let (one, least) = (f64x8::splat(simd, 1.0), f64x8::splat(simd, f64::MIN_POSITIVE));
        for from in (0..self.len).step_by(LANES) {
            let [x, y, z] = load(simd, &self.direction, from);
            // The root first, then its inverse, as for a single vector. Lanes without a direction keep none.
            let inverse = one / (x * x + y * y + z * z).max(least).sqrt();
            store(&[x * inverse, y * inverse, z * inverse], &mut self.direction, from);
        }
    }

    #[inline(always)]
    pub(super) fn leaving(&self, j: usize) -> Option<Id> {
        self.leaving[j]
    }

    /// The rays from number `from` on.
    #[inline(always)]
    pub(super) fn bundle<S: Simd>(&self, simd: S, from: usize) -> Bundle<S> {
        let leaving = f64x8::from_slice(simd, &self.solid[from..from + LANES]);
        Bundle { origin: load(simd, &self.origin, from), direction: load(simd, &self.direction, from), leaving }
    }
}

/// What each of the rays meets first, in columns.
pub(super) struct Hits {
    /// Infinite where nothing is met.
    pub t: Column<f64>,
    /// Number of the surface, see [`super::scene::Scene::surface`]; 0 for none.
    pub surface: Column<u32>,
    /// Of a mesh.
    pub triangle: Column<u32>,
    /// Weights of the second and third corner of a triangle.
    pub weights: Column<[f64; 2]>,
}

impl Default for Hits {
    fn default() -> Self {
        Hits { t: [f64::INFINITY; WAVE], surface: [0; WAVE], triangle: [0; WAVE], weights: [[0.0; 2]; WAVE] }
    }
}

/// Rays towards lamps: where each of them ends.
#[derive(Default)]
pub(super) struct Shadows {
    pub rays: Rays,
    distance: Ends,
}

/// Lengths and targets of rays.
struct Ends {
    length: Column<f64>,
    target: Column<Option<Id>>,
    solid: Column<f64>,
}

impl Default for Ends {
    fn default() -> Self {
        Ends { length: [0.0; WAVE], target: [None; WAVE], solid: [-1.0; WAVE] }
    }
}

impl Shadows {
    /// Adds one; there must be room. `solids` are [`Id::solid`] of start and target.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, leaving: Id, length: f64, target: Option<Id>, solids: [f64; 2]) {
        let j = self.rays.len;
        self.distance.length[j] = length;
        self.distance.target[j] = target;
        self.distance.solid[j] = solids[1];
        self.rays.push(ray, Some(leaving), solids[0]);
    }

    /// Length and target of a ray.
    #[inline(always)]
    pub(super) fn end(&self, j: usize) -> (f64, Option<Id>) {
        (self.distance.length[j], self.distance.target[j])
    }

    /// Lengths of the rays from number `from` on, and the numbers of the solids they go to.
    #[inline(always)]
    pub(super) fn ends<S: Simd>(&self, simd: S, from: usize) -> [f64x8<S>; 2] {
        [&self.distance.length, &self.distance.solid].map(|c| f64x8::from_slice(simd, &c[from..from + LANES]))
    }
}

/// Three coordinates of every lane by one vector.
#[inline(always)]
pub(super) fn dot<S: Simd>(lanes: &Lanes3<S>, v: DVec3) -> f64x8<S> {
    let simd = lanes[0].simd;
    dot_lanes(lanes, &[f64x8::splat(simd, v.x), f64x8::splat(simd, v.y), f64x8::splat(simd, v.z)])
}

/// Three coordinates in lanes.
pub(super) type Lanes3<S> = [f64x8<S>; 3];

/// The product of two vectors in lanes; sums of products are rounded once where the machine can.
#[inline(always)]
pub(super) fn dot_lanes<S: Simd>(a: &Lanes3<S>, b: &Lanes3<S>) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub(super) fn cross<S: Simd>(a: &Lanes3<S>, b: &Lanes3<S>) -> Lanes3<S> {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}

/// Three columns from row `from` on.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, columns: &[Column<f64>; 3], from: usize) -> Lanes3<S> {
    [0, 1, 2].map(|axis| f64x8::from_slice(simd, &columns[axis][from..from + LANES]))
}

#[inline(always)]
pub(super) fn store<S: Simd>(lanes: &Lanes3<S>, columns: &mut [Column<f64>; 3], from: usize) {
    for axis in 0..3 {
        lanes[axis].store_slice(&mut columns[axis][from..from + LANES]);
    }
}
