//! Where the paths of a wave meet something that reflects, in order of materials.

use super::super::material::{Coat, Cover};
use super::super::rays::{Column, WAVE};
use super::super::scene::{Hit, Scene};
use super::super::shape::Ray;
use super::super::spot::Spot;
use crate::math::frame::DVec3;
use std::ops::Range;

/// A place where a ray is reflected.
pub(super) struct Spotted<'a> {
    pub place: Spot,
    pub coat: Coat<'a>,
    /// Number of the ray.
    pub ray: usize,
}

/// The places of all rays of a step. Their numbers count in order of materials, and within one in order of rays.
pub(super) struct Spots<'a> {
    found: Vec<Spotted<'a>>,
    /// Place in `found` of every number.
    order: Vec<u32>,
    /// Where the numbers of each group end, while they are counted: how many there are.
    ends: Vec<usize>,
    /// Directions to the viewer and numbers of the draws, in order.
    pub seen: Vec<DVec3>,
    pub u: Vec<[f64; 2]>,
    /// Sums of the weights of the lights.
    pub totals: Column<f32>,
}

impl Default for Spots<'_> {
    fn default() -> Self {
        Spots {
            found: Vec::with_capacity(WAVE),
            order: Vec::with_capacity(WAVE),
            ends: Vec::new(),
            seen: Vec::with_capacity(WAVE),
            u: Vec::with_capacity(WAVE),
            totals: [0.0; WAVE],
        }
    }
}

impl<'a> Spots<'a> {
    /// Empties the list for materials of so many groups.
    #[inline]
    pub fn clear(&mut self, groups: usize) {
        self.found.clear();
        self.order.clear();
        self.seen.clear();
        self.u.clear();
        self.ends.clear();
        self.ends.resize(groups, 0);
    }

    /// Adds what ray number `j` met, unless it is seen exactly edge-on.
    #[inline(always)]
    pub fn add(&mut self, scene: &Scene, hit: &Hit, ray: &Ray, cover: &Cover<'a>, j: usize) {
        let Some(place) = Spot::new(scene, hit, ray.at(hit.t), -ray.direction) else { return };
        let coat = cover.at(|| scene.uv(hit, place.point), || scene.place_in(hit, place.point));
        self.ends[coat.group()] += 1;
        self.found.push(Spotted { place, coat, ray: j });
    }

    /// Numbers the places.
    #[inline]
    pub fn sort(&mut self) {
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        self.order.resize(self.found.len(), 0);
        for (k, spot) in self.found.iter().enumerate() {
            let end = &mut self.ends[spot.coat.group()];
            self.order[*end] = k as u32;
            *end += 1;
        }
    }

    pub fn len(&self) -> usize {
        self.found.len()
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> &Spotted<'a> {
        &self.found[self.order[i] as usize]
    }

    pub fn groups(&self) -> usize {
        self.ends.len()
    }

    /// The numbers of one group.
    pub fn range(&self, group: usize) -> Range<usize> {
        let start = if group > 0 { self.ends[group - 1] } else { 0 };
        start..self.ends[group]
    }
}
