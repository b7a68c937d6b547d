//! Many rays side by side: long ways in few strides of f32 that are sure, the rest by the march in f64.

use super::march::Own;
use super::stride::{LANES, Lanes, State};
use super::visibility::{Fate, HeightField, Ray};
use fearless_simd::Level;

/// Rays to be followed together, and what became of them.
///
/// [`Packet::trace`] gives for each ray what [`HeightField::trace`] gives, in a fraction of the time. In f32 and side by side a
/// ray strides as far as the bends of the surface allow it to stay above, see [`Bends`](super::bends::Bends), until it is above
/// everything ahead, or crosses a facet well inside. What f32 cannot tell is marched in f64 from the last place known to be
/// above the surface, and so is what crosses the border of the map or comes near a gap.
pub struct Packet {
    level: Level,
    rays: Vec<(Ray, Option<Own>, f64)>,
    fates: Vec<Fate>,
    lanes: Box<Lanes>,
}

impl Default for Packet {
    fn default() -> Self {
        Packet { level: Level::new(), rays: Vec::new(), fates: Vec::new(), lanes: Box::new(Lanes::default()) }
    }
}

impl Packet {
    /// Adds a ray with the facet that it is leaving, if it does.
    #[inline]
    pub fn push(&mut self, field: &HeightField, ray: Ray, own: Option<Own>) {
        // What is above everything has escaped already.
        let end = field.end_of_doubt(&ray, own).unwrap_or(f64::NEG_INFINITY);
        self.rays.push((ray, own, end));
    }

    /// The fates of all rays in the order in which they were added; the packet is empty afterwards.
    pub fn trace(&mut self, field: &HeightField) -> &[Fate] {
        let Packet { level, rays, fates, lanes } = self;
        fates.clear();
        fates.resize(rays.len(), Fate::Escaped([1.0; 2]));
        let ground = field.ground();
        let mut rest = rays.iter().enumerate();
        loop {
            lanes.clear();
            while lanes.len() < LANES
                && let Some((id, (ray, own, end))) = rest.next()
            {
                if *end > 0.0 && !lanes.push(&ground, ray, *own, *end, id) {
                    fates[id] = field.march(*ray, *own, *end);
                }
            }
            if lanes.all_ended() {
                break;
            }
            while !lanes.all_ended() {
                lanes.stride(*level, &ground, |id, state, s| {
                    let (ray, own, end) = rays[id];
                    fates[id] = match state {
                        State::Free => return,
                        State::Hit { cell, upper } => Fate::Hit(field.meet(&ray, cell, upper)),
                        State::Unsure if s == 0.0 => field.march(ray, own, end),
                        State::Unsure => field.march_on(ray, s * ground.unit(&ray).1, end),
                    };
                });
            }
        }
        rays.clear();
        &*fates
    }
}
