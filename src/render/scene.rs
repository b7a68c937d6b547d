//! Shapes with what covers them: something that reflects, or a lamp.

use super::disc::Disc;
use super::environment::Environment;
use super::light::{Lights, Met};
use super::material::{Cover, Reflector};
use super::mesh::Mesh;
use super::paint::Paint;
use super::rays::{Column, Hits, LANES, Rays, Shadows};
use super::shape::{Ray, Shape};
use super::solids::Solids;
use crate::error::Result;
use crate::math::frame::DVec3;
use fearless_simd::Simd;
use std::sync::Arc;

#[derive(Debug, Clone, Copy)]
pub(super) enum Finish {
    /// Index of the cover.
    Reflects(usize),
    /// Index of the light.
    Emits(usize),
}

/// A surface: of a mesh a single triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Id {
    Quad(u32),
    Sphere(u32),
    Disc(u32),
    Triangle { mesh: u32, triangle: u32 },
}

/// The nearest surface along a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub t: f64,
    pub id: Id,
    /// Weights of the second and third corner of a triangle.
    pub weights: [f64; 2],
}

/// Directions at a point of a surface, on its front.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Unit normal of the surface as rays meet it.
    pub plane: DVec3,
    /// Unit normal of the surface as light sees it, interpolated on smooth meshes.
    pub normal: DVec3,
    /// Unit vector along x of the material; on a mesh neither of unit length nor at right angles to `normal`.
    pub along: DVec3,
}

/// What a ray can meet, under a sky.
///
/// Lengths in metres, radiance in W/(m2 sr) per linear RGB channel. Nothing refracts: shapes are opaque.
pub struct Scene<'a> {
    pub(super) sky: DVec3,
    pub(super) lights: Lights,
    pub(super) solids: Solids,
    quad_finishes: Vec<Finish>,
    sphere_finishes: Vec<Finish>,
    discs: Vec<(Disc, Finish)>,
    meshes: Vec<(Arc<Mesh>, Finish)>,
    covers: Vec<Cover<'a>>,
    /// The reflectors of all covers, each once.
    reflectors: Vec<Reflector<'a>>,
    /// Whether a disc or a mesh shines.
    other_lamps: bool,
}

impl<'a> Scene<'a> {
    /// An empty scene under a sky of the given radiance [W/(m2 sr)].
    ///
    /// # Errors
    /// `Error::Parameter` if the radiance is negative or not finite.
    pub fn new(sky: DVec3) -> Result<Self> {
        Ok(Scene {
            sky: Paint::plain(sky)?.mean(),
            lights: Lights::default(),
            solids: Solids::default(),
            quad_finishes: Vec::new(),
            sphere_finishes: Vec::new(),
            discs: Vec::new(),
            meshes: Vec::new(),
            covers: Vec::new(),
            reflectors: Vec::new(),
            other_lamps: false,
        })
    }

    /// Adds a shape that reflects.
    pub fn add(&mut self, shape: impl Into<Shape>, cover: impl Into<Cover<'a>>) {
        let mut cover = cover.into();
        cover.join(&mut self.reflectors);
        self.covers.push(cover);
        self.place(shape.into(), Finish::Reflects(self.covers.len() - 1));
    }

    /// Adds a black shape whose front emits `radiance` [W/(m2 sr)] equally in all directions. Patterns are for quads and
    /// spheres; a disc or a mesh emits the mean everywhere.
    ///
    /// # Errors
    /// `Error::Parameter` if the emitter is dark everywhere.
    pub fn add_emitter(&mut self, shape: impl Into<Shape>, radiance: Paint) -> Result<()> {
        let shape = shape.into();
        let id = self.place(shape.clone(), Finish::Emits(self.lights.len()));
        match id {
            Id::Quad(_) | Id::Sphere(_) => self.solids.lamps.push(id),
            Id::Disc(_) | Id::Triangle { .. } => self.other_lamps = true,
        }
        self.lights.add(shape, id, radiance)
    }

    /// Surrounds the scene, on top of the radiance of the sky.
    pub fn surround(&mut self, environment: Environment) {
        self.lights.surround(environment);
        self.solids.screens.open();
    }

    fn place(&mut self, shape: Shape, finish: Finish) -> Id {
        if let Shape::Quad(quad) = shape {
            self.solids.quads.push(quad);
        }
        self.solids.screens.add(&self.solids.quads, &shape);
        match shape {
            Shape::Quad(_) => {
                self.quad_finishes.push(finish);
                Id::Quad(self.solids.quads.len() as u32 - 1)
            }
            Shape::Disc(disc) => {
                self.discs.push((disc, finish));
                Id::Disc(self.discs.len() as u32 - 1)
            }
            Shape::Sphere(sphere) => {
                self.solids.spheres.push(sphere);
                self.sphere_finishes.push(finish);
                Id::Sphere(self.sphere_finishes.len() as u32 - 1)
            }
            Shape::Mesh(mesh) => {
                self.meshes.push((mesh, finish));
                Id::Triangle { mesh: self.meshes.len() as u32 - 1, triangle: 0 }
            }
        }
    }

    /// First surface along each ray but the one it leaves.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(&self, simd: S, rays: &Rays, hits: &mut Hits) {
        for from in (0..rays.len()).step_by(LANES) {
            self.solids.closest(simd, rays, from, hits);
        }
        if self.discs.is_empty() && self.meshes.is_empty() {
            return;
        }
        for j in 0..rays.len() {
            let Some(hit) = self.nearer(&rays.get(j), rays.leaving(j), hits.t[j]) else { continue };
            (hits.t[j], hits.weights[j]) = (hit.t, hit.weights);
            (hits.surface[j], hits.triangle[j]) = match hit.id {
                Id::Disc(i) => (self.first_disc() + i, 0),
                Id::Triangle { mesh, triangle } => (self.first_disc() + self.discs.len() as u32 + mesh, triangle),
                Id::Quad(_) | Id::Sphere(_) => (hits.surface[j], 0),
            };
        }
    }

    /// The surface of a number in [`Hits`], of a mesh its first triangle: quads and spheres by turns from 1 on, then the discs,
    /// then the meshes.
    #[inline]
    pub(super) fn surface(&self, number: u32) -> Option<Id> {
        let others = self.first_disc();
        if number >= others {
            let (disc, discs) = (number - others, self.discs.len() as u32);
            return Some(if disc < discs { Id::Disc(disc) } else { Id::Triangle { mesh: disc - discs, triangle: 0 } });
        }
        let index = number.checked_sub(1)?;
        Some(if index & 1 == 0 { Id::Quad(index >> 1) } else { Id::Sphere(index >> 1) })
    }

    /// What ray number `j` meets.
    #[inline]
    pub(super) fn hit(&self, hits: &Hits, j: usize) -> Option<Hit> {
        let mut id = self.surface(hits.surface[j])?;
        if let Id::Triangle { triangle, .. } = &mut id {
            *triangle = hits.triangle[j];
        }
        Some(Hit { t: hits.t[j], id, weights: hits.weights[j] })
    }

    fn first_disc(&self) -> u32 {
        1 + 2 * self.solids.quads.len().max(self.solids.spheres.len()) as u32
    }

    /// One more than the largest number of a surface.
    pub(super) fn surfaces(&self) -> usize {
        self.first_disc() as usize + self.discs.len() + self.meshes.len()
    }

    /// The first disc or triangle along a ray before `t`.
    #[inline]
    pub(super) fn nearer(&self, ray: &Ray, leaving: Option<Id>, mut t: f64) -> Option<Hit> {
        let mut hit = None;
        for (i, (disc, _)) in self.discs.iter().enumerate() {
            let id = Id::Disc(i as u32);
            if leaving != Some(id)
                && let Some(nearer) = disc.intersect(ray, t)
            {
                t = nearer;
                hit = Some(Hit { t, id, weights: [0.0; 2] });
            }
        }
        for (i, (mesh, _)) in self.meshes.iter().enumerate() {
            if let Some(found) = mesh.closest(ray, t, triangle_of(leaving, i)) {
                t = found.t;
                let id = Id::Triangle { mesh: i as u32, triangle: found.triangle };
                hit = Some(Hit { t, id, weights: found.weights });
            }
        }
        hit
    }

    /// Whether anything but its start and its target stands before the end of each ray.
    #[inline(always)]
    pub(super) fn block<S: Simd>(&self, simd: S, shadows: &Shadows, blocked: &mut Column<bool>) {
        for from in (0..shadows.rays.len()).step_by(LANES) {
            let bits = self.solids.block(simd, shadows, from);
            for (lane, blocked) in blocked[from..from + LANES].iter_mut().enumerate() {
                *blocked = bits >> lane & 1 == 1;
            }
        }
        if self.discs.is_empty() && self.meshes.is_empty() {
            return;
        }
        for j in 0..shadows.rays.len() {
            let (distance, target) = shadows.end(j);
            blocked[j] = blocked[j] || self.hides(&shadows.rays.get(j), distance, shadows.rays.leaving(j), target);
        }
    }

    /// Whether a disc or a mesh stands before `distance`.
    #[inline]
    pub(super) fn hides(&self, ray: &Ray, distance: f64, leaving: Option<Id>, target: Option<Id>) -> bool {
        let disc_hides = |(i, (disc, _)): (usize, &(Disc, Finish))| {
            let id = Some(Id::Disc(i as u32));
            leaving != id && target != id && disc.intersect(ray, distance).is_some()
        };
        self.discs.iter().enumerate().any(disc_hides)
            || self
                .meshes
                .iter()
                .enumerate()
                .any(|(i, (mesh, _))| mesh.blocks(ray, distance, triangle_of(leaving, i), triangle_of(target, i)))
    }

    /// Whether a ray that does not meet a quad or a sphere that shines brings no light at all.
    pub(super) fn only_lamps_shine(&self) -> bool {
        self.sky == DVec3::ZERO && !self.lights.surround_all() && !self.other_lamps
    }

    /// How many reflectors there are.
    pub(super) fn groups(&self) -> usize {
        self.reflectors.len()
    }

    #[inline]
    pub(super) fn finish(&self, id: Id) -> Finish {
        match id {
            Id::Quad(i) => self.quad_finishes[i as usize],
            Id::Sphere(i) => self.sphere_finishes[i as usize],
            Id::Disc(i) => self.discs[i as usize].1,
            Id::Triangle { mesh, .. } => self.meshes[mesh as usize].1,
        }
    }

    #[inline]
    pub(super) fn cover(&self, index: usize) -> &Cover<'a> {
        &self.covers[index]
    }

    /// What a frame is made of: normal and tangent of a flat shape with radius 0, or centre of a sphere, nothing, and radius.
    /// Of a triangle nothing at all.
    #[inline(always)]
    pub(super) fn shape(&self, id: Id) -> (DVec3, DVec3, f64) {
        match id {
            Id::Quad(i) => (self.solids.quads[i as usize].normal, self.solids.quads[i as usize].tangent, 0.0),
            Id::Sphere(i) => {
                (self.solids.spheres[i as usize].centre, DVec3::ZERO, self.solids.spheres[i as usize].radius)
            }
            Id::Disc(i) => (self.discs[i as usize].0.normal, self.discs[i as usize].0.tangent, 0.0),
            Id::Triangle { .. } => (DVec3::Z, DVec3::X, 0.0),
        }
    }

    /// The front of the surface at a point of it.
    #[inline(always)]
    pub(super) fn frame(&self, hit: &Hit, point: DVec3) -> Frame {
        let (plane, normal, along) = match hit.id {
            Id::Quad(i) => {
                let quad = &self.solids.quads[i as usize];
                (quad.normal, quad.normal, quad.tangent)
            }
            Id::Disc(i) => {
                let disc = &self.discs[i as usize].0;
                (disc.normal, disc.normal, disc.tangent)
            }
            Id::Sphere(i) => {
                let sphere = &self.solids.spheres[i as usize];
                let normal = (point - sphere.centre) / sphere.radius;
                // Along the parallels of latitude; any direction will do at the poles.
                let across2 = normal.x * normal.x + normal.y * normal.y;
                let along =
                    if across2 > 1e-18 { DVec3::new(-normal.y, normal.x, 0.0) / across2.sqrt() } else { DVec3::X };
                (normal, normal, along)
            }
            Id::Triangle { mesh, triangle } => {
                let mesh = &self.meshes[mesh as usize].0;
                let (plane, normal) = mesh.normals(triangle, hit.weights);
                (plane, normal, mesh.axis().cross(normal))
            }
        };
        Frame { plane, normal, along }
    }

    /// Plane or sphere coordinates of a point of the shape; weights of the corners on a mesh.
    #[inline]
    pub(super) fn uv(&self, id: Id, weights: [f64; 2], point: DVec3) -> [f64; 2] {
        match id {
            Id::Quad(i) => self.solids.quads[i as usize].uv(point),
            Id::Sphere(i) => self.solids.spheres[i as usize].uv(point),
            Id::Disc(_) | Id::Triangle { .. } => weights,
        }
    }

    /// The point in metres from the corner of a quad along its sides, or as it is. Never exactly on a plane of the solid
    /// checker by being on the surface of a flat shape.
    #[inline(always)]
    pub(super) fn place_in(&self, id: Id, point: DVec3) -> DVec3 {
        match id {
            Id::Quad(i) => {
                let quad = &self.solids.quads[i as usize];
                let away = point - quad.corner;
                DVec3::new(away.dot(quad.tangent), away.dot(quad.bitangent), 0.0)
            }
            Id::Disc(i) => {
                let disc = &self.discs[i as usize].0;
                let away = point - disc.centre;
                DVec3::new(away.dot(disc.tangent), away.dot(disc.normal.cross(disc.tangent)), 0.0)
            }
            _ => point,
        }
    }

    /// Radiance that the light sends back along `ray`, 0 from behind, and the density of its own draws for the direction.
    #[inline]
    pub(super) fn meet_light(&self, light: usize, ray: &Ray, hit: &Hit) -> Met {
        self.lights.meet(light, ray, hit)
    }

    /// Names of closed shapes that hold a point.
    pub(super) fn around(&self, point: DVec3) -> Vec<String> {
        let sphere = |(k, s): (usize, &super::shape::Sphere)| {
            ((point - s.centre).length() < s.radius).then(|| format!("sphere {}", k + 1))
        };
        let mut names: Vec<String> = self.solids.spheres.iter().enumerate().filter_map(sphere).collect();
        names.extend(
            self.meshes.iter().enumerate().filter(|(_, m)| m.0.holds(point)).map(|(k, _)| format!("mesh {}", k + 1)),
        );
        names
    }
}

#[inline(always)]
fn triangle_of(id: Option<Id>, of: usize) -> Option<u32> {
    match id {
        Some(Id::Triangle { mesh, triangle }) if mesh as usize == of => Some(triangle),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Lambert;
    use crate::render::material::Material;
    use crate::render::rays::WAVE;
    use crate::render::shape::{Quad, Sphere};
    use fearless_simd::{Level, dispatch};

    fn closest(scene: &Scene, ray: &Ray, leaving: Option<Id>) -> Option<Hit> {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        rays.push(ray, leaving, Id::solid(leaving));
        dispatch!(Level::new(), simd => scene.closest(simd, &rays, &mut hits));
        scene.hit(&hits, 0)
    }

    fn blocked(scene: &Scene, ray: &Ray, distance: f64, leaving: Id, target: Option<Id>) -> bool {
        let (mut shadows, mut blocked) = (Shadows::default(), [false; WAVE]);
        shadows.push(ray, leaving, distance, target, [Id::solid(Some(leaving)), Id::solid(target)]);
        dispatch!(Level::new(), simd => scene.block(simd, &shadows, &mut blocked));
        blocked[0]
    }

    fn square(z: f64) -> Quad {
        Quad::new(DVec3::new(-1.0, -1.0, z), 2.0 * DVec3::X, 2.0 * DVec3::Y).unwrap()
    }

    #[test]
    fn the_nearest_shape_wins_and_the_one_left_is_skipped() {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        let matt = Lambert { rho: 0.5 };
        let material = Material { brdf: &matt, tint: Paint::plain(DVec3::ONE).unwrap() };
        scene.add(square(0.0), material);
        scene.add(square(1.0), material);
        scene.add(Sphere::new(3.0 * DVec3::Z, 1.0).unwrap(), material);
        scene.add(Disc::new(1.5 * DVec3::Z, DVec3::Z, 0.5, 0.1).unwrap(), material);
        let vertices = vec![DVec3::new(-1.0, -1.0, 0.5), DVec3::new(1.0, -1.0, 0.5), DVec3::new(0.0, 1.0, 0.5)];
        scene.add(Mesh::new(vertices, None, vec![[0, 1, 2]]).unwrap(), material);
        let up = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
        let triangle = Id::Triangle { mesh: 0, triangle: 0 };
        let mut order = vec![];
        let mut ray = Ray { origin: DVec3::new(0.2, 0.0, 0.0), ..up };
        let mut leaving = Some(Id::Quad(0));
        while let Some(hit) = closest(&scene, &ray, leaving) {
            order.push(hit.id);
            (ray.origin, leaving) = (ray.at(hit.t), Some(hit.id));
        }
        assert_eq!(order, [triangle, Id::Quad(1), Id::Disc(0), Id::Sphere(0), Id::Sphere(0)]);
        let on = Ray { origin: DVec3::Z, direction: DVec3::Z };
        // Through the hole of the ring.
        let hit = closest(&scene, &on, Some(Id::Quad(1))).unwrap();
        assert_eq!((hit.id, hit.t), (Id::Sphere(0), 1.0));
        assert!(blocked(&scene, &up, 4.0, Id::Quad(0), Some(Id::Sphere(0))));
        assert!(!blocked(&scene, &on, 4.0, Id::Quad(1), Some(Id::Sphere(0))));
        assert!(!blocked(&scene, &up, 0.9, Id::Quad(0), Some(triangle)));
        assert_eq!(scene.around(DVec3::new(0.0, 0.0, 3.5)), ["sphere 1"]);
    }
}
