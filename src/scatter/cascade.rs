//! Beams that may meet the surface again, bounce after bounce side by side in f32.

use super::bounce::Walk;
use super::cells::CellLanes;
use super::detectors::Detectors;
use super::glints::{Glints, Light};
use crate::facets::Strides;
use crate::facets::packet::{End, Start, Struck};
use glam::DVec3;

/// Beams under way.
///
/// Each ends free, or unsure where f32 cannot tell or where the beam is lost or has no bounce left: such beams are to be followed
/// again in f64, see [`Flights`](super::flights::Flights).
#[derive(Default)]
pub struct Cascade {
    beams: Vec<Beam>,
    starts: Vec<Start>,
    next: Vec<Start>,
    unsure: Vec<u32>,
    strides: Strides,
    glints: Glints,
}

#[derive(Clone, Copy)]
struct Beam {
    number: u32,
    bounces: u32,
    energy: f32,
    direction: [f32; 3],
}

/// A beam that escaped.
#[derive(Debug, Clone, Copy)]
pub struct Freed {
    pub bounces: u32,
    /// Direction, in the frame of the map.
    pub wo: [f32; 3],
    /// Share of its energy that is left.
    pub energy: f32,
}

impl Cascade {
    /// Adds a beam reflected once at a facet, with the share of its energy that is left; `false` if it is free.
    #[inline]
    pub fn push(&mut self, walk: &Walk, number: u32, facet: &Struck, direction: [f32; 3], energy: f32) -> bool {
        let id = self.beams.len() as u32;
        let Some(start) = start(walk, id, facet, direction) else { return false };
        self.starts.push(start);
        self.beams.push(Beam { number, bounces: 1, energy, direction });
        true
    }

    /// Beams added.
    pub fn len(&self) -> usize {
        self.beams.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// Follows all beams to their ends; `ended` hears `None` of an unsure one.
    pub fn land(&mut self, walk: &Walk, mut ended: impl FnMut(u32, Option<Freed>)) {
        let Cascade { beams, starts, next, unsure, strides, glints } = self;
        let (field, map) = (walk.field, walk.field.map());
        let per_pitch = [map.pitch_x, map.pitch_y].map(|p| (1.0 / p) as f32);
        while !starts.is_empty() {
            glints.clear(None);
            strides.follow(field, starts.drain(..), |id, end| {
                let beam = &beams[id as usize];
                match end {
                    End::Free if beam.direction[2] > 0.0 => ended(beam.number, Some(beam.freed())),
                    End::Hit(struck) if beam.bounces < walk.max_bounces => {
                        let light = Light { wi: beam.direction.map(|x| -x), turn: [1.0, 0.0] };
                        glints.push(id, &light, struck, field.clear_sines(struck.cell));
                    }
                    _ => unsure.push(id),
                }
            });
            glints.shine(per_pitch, &walk.material);
            for (k, (id, struck)) in glints.rays.iter().enumerate() {
                let (glint, beam) = (glints.get(k), &mut beams[*id as usize]);
                beam.bounces += 1;
                beam.energy *= glint.reflectance;
                beam.direction = glint.wo;
                if glint.is_free {
                    ended(beam.number, Some(beam.freed()));
                    continue;
                }
                match start(walk, *id, struck, glint.wo) {
                    Some(start) => next.push(start),
                    None => ended(beam.number, Some(beam.freed())),
                }
            }
            std::mem::swap(starts, next);
        }
        unsure.drain(..).for_each(|id| ended(beams[id as usize].number, None));
        beams.clear();
    }
}

impl Beam {
    fn freed(&self) -> Freed {
        Freed { bounces: self.bounces, wo: self.direction, energy: self.energy }
    }
}

impl Freed {
    /// Detector that the beam reaches, `local` being the direction to the source in the frame of the detectors, `turn` cosine and
    /// sine of the turn into it.
    #[inline]
    pub fn detector<D: Detectors + ?Sized>(
        &self,
        detectors: &D,
        cells: Option<&CellLanes>,
        local: DVec3,
        [cos, sin]: [f32; 2],
    ) -> u32 {
        let [x, y, z] = self.wo;
        let wo = [cos * x + sin * y, cos * y - sin * x, z];
        let Some(cells) = cells else {
            return detectors.index(local, DVec3::from_array(wo.map(f64::from)).normalize()) as u32;
        };
        // The half vector's slope.
        let [x, y, z] = [wo[0] + local.x as f32, wo[1] + local.y as f32, wo[2] + local.z as f32];
        cells.locate(-x / z, -y / z)
    }
}

/// A beam that leaves a facet; `None` if nothing can stand in its way.
#[inline]
fn start(walk: &Walk, id: u32, facet: &Struck, direction: [f32; 3]) -> Option<Start> {
    let end = walk.field.reach_in_lanes(facet.cell, facet.z, direction)?;
    let (cell, own) = (facet.cell.map(|c| c as u32), 1 + u32::from(facet.upper));
    Some(Start { id, cell, own, at: facet.at, z: facet.z, direction, end })
}
