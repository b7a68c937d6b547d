//! Where the paths of a wave meet something that reflects, in order of materials.

use super::super::material::{Coat, Cover, odd_cell};
use super::super::paint::Paint;
use super::super::rays::{Column, Hits, LANES, Lanes3, Rays, WAVE, cross, dot_lanes, load, store};
use super::super::scene::{Finish, Hit, Id, Scene};
use super::super::spot::Spot;
use crate::math::frame::DVec3;
use fearless_simd::{Simd, f64x8, prelude::*};
use std::ops::Range;

/// Rays that meet one coat on one surface.
struct Patch<'a> {
    id: Id,
    coat: &'a Coat<'a>,
    paint: Option<&'a Paint>,
    /// The range of their numbers in the list of rays.
    rays: Range<usize>,
}

/// The places of all rays of a step with the frames of their materials, in columns. Their numbers count in order of
/// materials, and within one in order of surfaces.
pub(super) struct Spots<'a> {
    patches: Vec<Patch<'a>>,
    /// Where the numbers of each group end, while they are counted: how many there are.
    ends: Vec<usize>,
    len: usize,
    /// Numbers of the rays.
    pub ray: Column<u32>,
    pub id: Column<Id>,
    /// [`Id::solid`] of it.
    pub solid: Column<f64>,
    pub point: [Column<f64>; 3],
    /// Axes x and z of the frame: z is the normal on the side that is seen.
    x: [Column<f64>; 3],
    pub z: [Column<f64>; 3],
    /// Unit normal of the surface as rays meet it, on the side that is seen.
    plane: [Column<f64>; 3],
    /// Directions to the viewer: in space, and in the frame.
    view: [Column<f64>; 3],
    pub seen: Vec<DVec3>,
    pub coat: Vec<&'a Coat<'a>>,
    pub tint: Vec<DVec3>,
    /// Radii of spheres, 0 of everything else.
    radius: Column<f64>,
    /// Numbers of the places on meshes.
    on_mesh: Vec<usize>,
}

impl Default for Spots<'_> {
    fn default() -> Self {
        let zeros = [[0.0; WAVE]; 3];
        Spots {
            patches: Vec::with_capacity(WAVE),
            ends: Vec::new(),
            len: 0,
            ray: [0; WAVE],
            id: [Id::Disc(0); WAVE],
            solid: [-1.0; WAVE],
            point: zeros,
            x: zeros,
            z: zeros,
            plane: zeros,
            view: zeros,
            seen: vec![DVec3::Z; WAVE],
            coat: Vec::with_capacity(WAVE),
            tint: vec![DVec3::ONE; WAVE],
            radius: [0.0; WAVE],
            on_mesh: Vec::new(),
        }
    }
}

impl<'a> Spots<'a> {
    /// Empties the list for materials of so many groups.
    #[inline]
    pub fn clear(&mut self, groups: usize) {
        self.patches.clear();
        self.ends.clear();
        self.ends.resize(groups, 0);
        self.len = 0;
    }

    /// Adds the rays in the range `run` of the list `order`, all of which met the surface `id`.
    #[inline(always)]
    pub fn add(
        &mut self,
        scene: &'a Scene<'a>,
        id: Id,
        run: Range<usize>,
        rays: &Rays,
        hits: &Hits,
        order: &mut [u32],
    ) {
        let Finish::Reflects(cover) = scene.finish(id) else { return };
        match scene.cover(cover) {
            Cover::Plain(coat) => self.lay(Patch { id, coat, paint: None, rays: run }),
            Cover::Painted(coat, paint) => self.lay(Patch { id, coat, paint: Some(paint), rays: run }),
            Cover::Checker(coats, size) => {
                let (inverse, mut odd) = (1.0 / size, [false; WAVE]);
                for (odd, &ray) in odd.iter_mut().zip(&order[run.clone()]) {
                    let point = rays.get(ray as usize).at(hits.t[ray as usize]);
                    *odd = odd_cell(scene.place_in(id, point), inverse);
                }
                let middle = run.start + part(&mut order[run.clone()], &odd);
                self.lay(Patch { id, coat: &coats[0], paint: None, rays: run.start..middle });
                self.lay(Patch { id, coat: &coats[1], paint: None, rays: middle..run.end });
            }
        }
    }

    #[inline(always)]
    fn lay(&mut self, patch: Patch<'a>) {
        self.ends[patch.coat.group()] += patch.rays.len();
        self.len += patch.rays.len();
        self.patches.push(patch);
    }

    /// Numbers the places and finds their frames.
    #[inline(always)]
    pub fn arrange<S: Simd>(&mut self, simd: S, scene: &Scene, rays: &Rays, hits: &Hits, order: &[u32]) {
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        self.on_mesh.clear();
        self.coat.clear();
        if let Some(first) = self.patches.first() {
            self.coat.resize(self.len, first.coat);
        }
        for patch in &self.patches {
            let end = &mut self.ends[patch.coat.group()];
            let places = *end..*end + patch.rays.len();
            *end = places.end;
            let (normal, along, radius) = scene.shape(patch.id);
            for axis in 0..3 {
                self.z[axis][places.clone()].fill(normal[axis]);
                self.x[axis][places.clone()].fill(along[axis]);
            }
            self.radius[places.clone()].fill(radius);
            self.coat[places.clone()].fill(patch.coat);
            self.tint[places.clone()].fill(patch.coat.tint());
            self.id[places.clone()].fill(patch.id);
            self.solid[places.clone()].fill(Id::solid(Some(patch.id)));
            self.ray[places.clone()].copy_from_slice(&order[patch.rays.clone()]);
            for i in places.clone() {
                let number = self.ray[i] as usize;
                let ray = rays.get(number);
                let point = ray.at(hits.t[number]);
                for axis in 0..3 {
                    self.point[axis][i] = point[axis];
                    self.view[axis][i] = -ray.direction[axis];
                }
            }
            if let Id::Triangle { mesh, .. } = patch.id {
                for i in places.clone() {
                    self.id[i] = Id::Triangle { mesh, triangle: hits.triangle[self.ray[i] as usize] };
                }
                self.on_mesh.extend(places.clone());
            }
            if let Some(paint) = patch.paint {
                for i in places {
                    let weights = hits.weights[self.ray[i] as usize];
                    let point = DVec3::new(self.point[0][i], self.point[1][i], self.point[2][i]);
                    self.tint[i] = patch.coat.tint() * paint.colour(|| scene.uv(patch.id, weights, point));
                }
            }
        }
        for from in (0..self.len).step_by(LANES) {
            self.frames(simd, from);
        }
        for k in 0..self.on_mesh.len() {
            let i = self.on_mesh[k];
            if let Some(hit) = scene.hit(hits, self.ray[i] as usize) {
                self.frame_on_mesh(scene, &hit, i);
            }
        }
    }

    /// From the shapes to the frames of their spots, as [`Spot::new`] does it.
    #[inline(always)]
    fn frames<S: Simd>(&mut self, simd: S, from: usize) {
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let (point, shape, along) =
            (load(simd, &self.point, from), load(simd, &self.z, from), load(simd, &self.x, from));
        let view = load(simd, &self.view, from);
        let radius = f64x8::from_slice(simd, &self.radius[from..from + LANES]);
        let round = radius.simd_gt(zero);
        let inverse = one / round.select(radius, one);
        let normal = [0, 1, 2].map(|k| round.select((point[k] - shape[k]) * inverse, shape[k]));
        // Along the parallels of latitude; any direction will do at the poles.
        let across2 = normal[0] * normal[0] + normal[1] * normal[1];
        let off_pole = across2.simd_gt(f64x8::splat(simd, 1e-18));
        let inverse = one / off_pole.select(across2, one).sqrt();
        let x = [
            round.select(off_pole.select(zero - normal[1] * inverse, one), along[0]),
            round.select(off_pole.select(normal[0] * inverse, zero), along[1]),
            round.select(zero, along[2]),
        ];
        let side = dot_lanes(&normal, &view).simd_lt(zero).select(zero - one, one);
        let z = normal.map(|n| n * side);
        let y = cross(&z, &x);
        store(&x, &mut self.x, from);
        store(&z, &mut self.z, from);
        store(&z, &mut self.plane, from);
        let seen = [dot_lanes(&view, &x), dot_lanes(&view, &y), dot_lanes(&view, &z)].map(<[f64; LANES]>::from);
        for (lane, place) in self.seen[from..from + LANES].iter_mut().enumerate() {
            *place = DVec3::new(seen[0][lane], seen[1][lane], seen[2][lane]);
        }
    }

    /// The same on a mesh, whose normals are interpolated.
    fn frame_on_mesh(&mut self, scene: &Scene, hit: &Hit, i: usize) {
        let at = |columns: &[Column<f64>; 3]| DVec3::new(columns[0][i], columns[1][i], columns[2][i]);
        let spot = Spot::new(scene, hit, at(&self.point), at(&self.view));
        // Seen exactly edge-on nothing is reflected.
        self.seen[i] = spot.as_ref().map_or(DVec3::X, |s| s.seen);
        let Some(spot) = spot else { return };
        for axis in 0..3 {
            self.x[axis][i] = spot.x[axis];
            self.z[axis][i] = spot.z[axis];
            self.plane[axis][i] = spot.plane[axis];
        }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn groups(&self) -> usize {
        self.ends.len()
    }

    /// The numbers of one group.
    pub fn range(&self, group: usize) -> Range<usize> {
        let start = if group > 0 { self.ends[group - 1] } else { 0 };
        start..self.ends[group]
    }

    /// The point, and the normal on the side that is seen.
    #[inline(always)]
    pub fn at(&self, i: usize) -> (DVec3, DVec3) {
        let at = |columns: &[Column<f64>; 3]| DVec3::new(columns[0][i], columns[1][i], columns[2][i]);
        (at(&self.point), at(&self.z))
    }

    /// Directions in the frames of the spots from number `from` on.
    #[inline(always)]
    pub fn to_local<S: Simd>(&self, simd: S, from: usize, w: &Lanes3<S>) -> Lanes3<S> {
        let (x, z) = (load(simd, &self.x, from), load(simd, &self.z, from));
        let y = cross(&z, &x);
        [dot_lanes(w, &x), dot_lanes(w, &y), dot_lanes(w, &z)]
    }

    /// Directions in space.
    #[inline(always)]
    pub fn to_world<S: Simd>(&self, simd: S, from: usize, w: &Lanes3<S>) -> Lanes3<S> {
        let (x, z) = (load(simd, &self.x, from), load(simd, &self.z, from));
        let y = cross(&z, &x);
        let along = |k: usize| w[0].mul_add(x[k], w[1].mul_add(y[k], w[2] * z[k]));
        [along(0), along(1), along(2)]
    }

    /// A bit for each direction in space that leaves the surface on the side that is seen: past an interpolated normal it may
    /// not.
    #[inline(always)]
    pub fn leaving<S: Simd>(&self, simd: S, from: usize, w: &Lanes3<S>) -> u64 {
        let above = dot_lanes(&load(simd, &self.plane, from), w).simd_gt(f64x8::splat(simd, 0.0));
        above.to_bitmask() & lanes_of(self.len - from)
    }
}

/// A bit for each of the first lanes.
#[inline(always)]
fn lanes_of(count: usize) -> u64 {
    (1 << count.min(LANES)) - 1
}

/// Puts the numbers that are not marked before those that are; how many they are. Without a branch: marks are as good as
/// random.
#[inline(always)]
fn part(numbers: &mut [u32], marks: &[bool; WAVE]) -> usize {
    let (mut marked, mut first, mut second) = ([0; WAVE], 0, 0);
    for k in 0..numbers.len() {
        let (number, mark) = (numbers[k], usize::from(marks[k]));
        (numbers[first], marked[second]) = (number, number);
        first += 1 - mark;
        second += mark;
    }
    numbers[first..].copy_from_slice(&marked[..second]);
    first
}
