//! Many rays side by side: long ways in few strides of f32 that are sure, the rest by the march in f64.

use super::ends::Ends;
use super::lanes::Lanes;
use super::starts::{Start, Starts};
use super::trace::Own;
use super::visibility::{Fate, HeightField, Ray};
use fearless_simd::Level;

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
    /// Follows the rays and adds how they ended to `ends`, in any order.
    pub fn follow(&mut self, field: &HeightField, starts: &Starts, ends: &mut Ends) {
        let Strides { level, lanes } = self;
        let ground = field.ground();
        let mut next = lanes.fill(*level, &ground, starts, 0, ends);
        while lanes.n > 0 {
            let ended = lanes.stride(*level, &ground);
            lanes.let_go(*level, ends);
            // Lanes that have ended cost as much as the others, but so does moving those together.
            if 4 * ended >= lanes.n {
                lanes.pack(*level);
                next = lanes.fill(*level, &ground, starts, next, ends);
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
    starts: Starts,
    ends: Ends,
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
        let Packet { strides, rays, starts, ends, fates } = self;
        fates.clear();
        fates.resize(rays.len(), Fate::Escaped([1.0; 2]));
        starts.n = 0;
        for (id, &(ray, own, end)) in rays.iter().enumerate().filter(|(_, ray)| ray.2 > 0.0) {
            let cell = start_cell(&ray, own);
            starts.push(&Start {
                id: id as u32,
                cell: cell.map(|c| c as u32),
                own: own.map_or(0, |own| 1 + u32::from(own.1)),
                at: [(ray.column - cell[0] as f64) as f32, (ray.row - cell[1] as f64) as f32],
                z: ray.z as f32,
                direction: ray.direction.to_array().map(|x| x as f32),
                end: end as f32,
            });
        }
        ends.clear();
        strides.follow(field, starts, ends);
        let hits = &ends.hits;
        for k in 0..hits.n {
            let id = hits.id[k] as usize;
            let (ray, own, _) = rays[id];
            fates[id] = Fate::Hit(field.meet(&ray, start_cell(&ray, own), hits, k));
        }
        for &(id, t) in &ends.unsure {
            let (ray, own, end) = rays[id as usize];
            fates[id as usize] = if t == 0.0 { field.march(ray, own, end) } else { field.march_on(ray, t, end) };
        }
        rays.clear();
        &*fates
    }
}

/// The cell that a ray starts in.
#[inline]
fn start_cell(ray: &Ray, own: Option<Own>) -> [usize; 2] {
    own.map_or([ray.column as usize, ray.row as usize], |own| own.0)
}
