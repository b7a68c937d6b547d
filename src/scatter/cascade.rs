//! Beams that may meet the surface again, bounce after bounce side by side in f32.

use super::bounce::Walk;
use super::glints::Glints;
use crate::facets::Strides;
use crate::facets::ends::{Ends, Hits};
use crate::facets::starts::{Starts, WIDTH, make_room};
use fearless_simd::Level;

/// Beams that have been reflected once or more, in columns with room for a vector at their ends.
///
/// After [`Cascade::land`] each is what it is when it escapes; those that bounced 0 times are unsure: f32 cannot tell, or they are lost
/// or have no bounce left. They are to be followed again in f64, see [`Flights`](super::flights::Flights).
pub struct Cascade {
    /// Number of beams.
    pub n: usize,
    pub bounces: Vec<u32>,
    pub energy: Vec<f32>,
    /// Direction, in the frame of the map.
    pub direction: [Vec<f32>; 3],
    /// Those that may meet something, with their numbers.
    pub starts: Starts,
    level: Level,
    ends: Ends,
    strides: Strides,
    glints: Glints,
}

impl Default for Cascade {
    fn default() -> Self {
        Cascade {
            n: 0,
            bounces: Vec::new(),
            energy: Vec::new(),
            direction: [Vec::new(), Vec::new(), Vec::new()],
            starts: Starts::default(),
            level: Level::new(),
            ends: Ends::default(),
            strides: Strides::default(),
            glints: Glints::default(),
        }
    }
}

impl Cascade {
    /// Takes all beams away.
    pub fn clear(&mut self) {
        (self.n, self.starts.n) = (0, 0);
    }

    /// Makes room for so many more beams.
    pub fn reserve(&mut self, more: usize) {
        let n = self.n + more;
        self.starts.reserve(more);
        if self.bounces.len() < n + WIDTH {
            make_room(&mut self.bounces, n);
            make_room(&mut self.energy, n);
            self.direction.iter_mut().for_each(|column| make_room(column, n));
        }
    }

    /// Takes the beams of facets that rays met, instead of those that were there: beam number `k` is that of facet `k`.
    pub fn begin(&mut self, hits: &mut Hits, glints: &Glints) {
        self.clear();
        let n = hits.n;
        self.reserve(n);
        self.n = n;
        self.bounces[..n].fill(1);
        self.energy[..n].copy_from_slice(&glints.reflectance[..n]);
        for axis in 0..3 {
            self.direction[axis][..n].copy_from_slice(&glints.wo[axis][..n]);
        }
        hits.id[..n].iter_mut().zip(0..).for_each(|(id, k)| *id = k);
        glints.go_on(hits, &mut self.starts);
    }

    /// Follows all beams to their ends.
    pub fn land(&mut self, walk: &Walk) {
        let field = walk.field;
        loop {
            self.starts.keep_doubtful(self.level, field);
            if self.starts.n == 0 {
                return;
            }
            self.ends.clear();
            self.strides.follow(field, &self.starts, &mut self.ends);
            self.starts.n = 0;
            let Cascade { bounces, energy, direction, starts, ends, glints, .. } = self;
            for (id, _) in &ends.unsure {
                bounces[*id as usize] = 0;
            }
            let hits = &mut ends.hits;
            if hits.id[..hits.n].iter().any(|&id| bounces[id as usize] >= walk.max_bounces) {
                hits.retain(|hits, k| {
                    let bounces = &mut bounces[hits.id[k] as usize];
                    let is_left = *bounces < walk.max_bounces;
                    *bounces = if is_left { *bounces } else { 0 };
                    is_left
                });
            }
            glints.reserve(hits.n);
            let ids = &hits.id[..hits.n];
            for (back, direction) in glints.wi.iter_mut().zip(&*direction) {
                back.iter_mut().zip(ids).for_each(|(back, &id)| *back = -direction[id as usize]);
            }
            glints.shine(field, hits, &walk.material);
            for (&id, reflectance) in ids.iter().zip(&glints.reflectance) {
                energy[id as usize] *= reflectance;
                bounces[id as usize] += 1;
            }
            for (direction, wo) in direction.iter_mut().zip(&glints.wo) {
                ids.iter().zip(wo).for_each(|(&id, wo)| direction[id as usize] = *wo);
            }
            glints.go_on(hits, starts);
        }
    }
}
