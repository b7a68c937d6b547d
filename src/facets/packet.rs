//! Many rays side by side: long ways in few strides of f32 that are sure, the rest by the march in f64.

use super::march::Own;
use super::stride::Lanes;
use super::visibility::{Fate, HeightField, Ray};
use fearless_simd::Level;

pub use super::stride::{End, Start, Struck};

/// Rays in f32, side by side.
///
/// A ray strides as far as the bends of the surface allow it to stay above, see [`Bends`](super::bends::Bends), until it is above
/// everything ahead, or crosses a facet well inside. What it says of a ray is sure: differences too small for f32, the
/// neighbourhood of a gap and the border of the map end a ray as unsure.
pub struct Strides {
    level: Level,
    lanes: Box<Lanes>,
}

impl Default for Strides {
    fn default() -> Self {
        Strides { level: Level::new(), lanes: Box::new(Lanes::default()) }
    }
}

impl Strides {
    /// Follows the rays; `ended` hears how each of them ended, in any order.
    #[inline]
    pub fn follow(
        &mut self,
        field: &HeightField,
        starts: impl Iterator<Item = Start>,
        mut ended: impl FnMut(u32, End),
    ) {
        let Strides { level, lanes } = self;
        let ground = field.ground();
        let mut starts = starts.fuse();
        loop {
            lanes.clear();
            while !lanes.is_full()
                && let Some(start) = starts.next()
            {
                if !lanes.push(&ground, &start) {
                    ended(start.id, End::Unsure(0.0));
                }
            }
            if lanes.all_ended() {
                return;
            }
            while !lanes.all_ended() {
                lanes.stride(*level, &ground, &mut ended);
            }
        }
    }
}

/// Rays to be followed together, and what became of them: for each what [`HeightField::trace`] gives, in a fraction of the time.
/// What f32 cannot tell is marched in f64 from the last place known to be above the surface.
#[derive(Default)]
pub struct Packet {
    strides: Strides,
    rays: Vec<(Ray, Option<Own>, f64)>,
    fates: Vec<Fate>,
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
        let Packet { strides, rays, fates } = self;
        fates.clear();
        fates.resize(rays.len(), Fate::Escaped([1.0; 2]));
        let starts = rays.iter().enumerate().filter(|(_, ray)| ray.2 > 0.0).map(|(id, &(ray, own, end))| {
            let cell = start_cell(&ray, own);
            Start {
                id: id as u32,
                cell: cell.map(|c| c as u32),
                own: own.map_or(0, |own| 1 + u32::from(own.1)),
                at: [(ray.column - cell[0] as f64) as f32, (ray.row - cell[1] as f64) as f32],
                z: ray.z as f32,
                direction: ray.direction.to_array().map(|x| x as f32),
                end: end as f32,
            }
        });
        strides.follow(field, starts, |id, end_of_ray| {
            let (ray, own, end) = rays[id as usize];
            fates[id as usize] = match end_of_ray {
                End::Free => return,
                End::Hit(struck) => Fate::Hit(field.meet(&ray, start_cell(&ray, own), &struck)),
                End::Unsure(0.0) => field.march(ray, own, end),
                End::Unsure(t) => field.march_on(ray, t, end),
            };
        });
        rays.clear();
        &*fates
    }
}

/// The cell that a ray starts in.
#[inline]
fn start_cell(ray: &Ray, own: Option<Own>) -> [usize; 2] {
    own.map_or([ray.column as usize, ray.row as usize], |own| own.0)
}
