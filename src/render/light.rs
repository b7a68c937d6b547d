//! Lamps: which to ask at a point, directions towards them, and their densities per steradian.

use super::disc::Disc;
use super::environment::Environment;
use super::mesh::Mesh;
use super::paint::Paint;
use super::reach::{Reach, Reaches};
use super::scene::{Hit, Id};
use super::shape::{Quad, Ray, Shape, Sphere};
use crate::error::{Error, Result};
use crate::math::frame::{DVec3, sin_cos_turns, tangents};
use crate::sample::AliasTable;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A direction drawn towards a light.
pub(super) struct LightSample {
    pub direction: DVec3,
    pub distance: f64,
    /// Density per steradian: of this light alone, or among all if it was drawn from all.
    pub pdf: f64,
    pub radiance: DVec3,
    /// The surface of the light; none for the surroundings.
    pub id: Option<Id>,
}

/// Radiance of a light that a ray met, and the density of the light's own draws for that direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub radiance: DVec3,
    pub pdf: f64,
}

enum Form {
    Quad(Quad),
    Sphere(Sphere),
    Disc(Disc),
    Mesh(Arc<Mesh>, AliasTable),
    Surroundings(Environment),
}

struct Light {
    form: Form,
    radiance: Paint,
    id: Option<Id>,
}

/// All lights of a scene, the surroundings among them.
#[derive(Default)]
pub(super) struct Lights {
    list: Vec<Light>,
    pub(super) reaches: Reaches,
    surroundings: Option<usize>,
}

impl Lights {
    pub(super) fn add(&mut self, shape: Shape, id: Id, radiance: Paint) -> Result<()> {
        let brightness = radiance.mean().element_sum() / 3.0;
        if brightness <= 0.0 {
            return Err(Error::parameter("an emitter has no radiance", "give it a radiance above 0 or leave it out"));
        }
        let (form, centre, radius, area, front) = match shape {
            Shape::Quad(quad) => {
                let (u, v) = (0.5 * quad.edge_u, 0.5 * quad.edge_v);
                let radius = (u + v).length().max((u - v).length());
                (Form::Quad(quad), quad.corner + u + v, radius, quad.area, quad.normal)
            }
            Shape::Sphere(s) => (Form::Sphere(s), s.centre, s.radius, PI * s.radius * s.radius, DVec3::ZERO),
            Shape::Disc(disc) => (Form::Disc(disc), disc.centre, disc.radius, disc.area(), disc.normal),
            Shape::Mesh(mesh) => {
                let table = mesh.area_table()?;
                let (centre, radius, area) = (mesh.centre(), mesh.radius(), 0.25 * mesh.area());
                (Form::Mesh(mesh, table), centre, radius, area, DVec3::ZERO)
            }
        };
        let reach = Reach { centre, radius, strength: area * brightness, front, everywhere: false };
        self.put(self.list.len(), Light { form, radiance, id: Some(id) }, reach);
        Ok(())
    }

    pub(super) fn surround(&mut self, environment: Environment) {
        let strength = environment.irradiance();
        let everywhere = Reach { centre: DVec3::ZERO, radius: 0.0, strength, front: DVec3::ZERO, everywhere: true };
        let light = Light {
            form: Form::Surroundings(environment),
            radiance: Paint::plain(DVec3::ONE).expect("white is a colour"),
            id: None,
        };
        let index = *self.surroundings.get_or_insert(self.list.len());
        self.put(index, light, everywhere);
    }

    /// Sets light number `index`, or adds it behind the last.
    fn put(&mut self, index: usize, light: Light, reach: Reach) {
        if index == self.list.len() {
            self.list.push(light);
        } else {
            self.list[index] = light;
        }
        self.reaches.put(index, reach);
    }

    #[inline]
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether light comes from all around.
    pub(super) fn surround_all(&self) -> bool {
        self.surroundings.is_some()
    }

    /// Radiance of the surroundings in a direction, with their index and the density of their draws.
    #[inline]
    pub(super) fn surroundings(&self, direction: DVec3) -> Option<(usize, Met)> {
        let k = self.surroundings?;
        let Form::Surroundings(environment) = &self.list[k].form else { return None };
        let (radiance, pdf) = environment.look(direction);
        Some((k, Met { radiance, pdf }))
    }

    /// The sphere that shines as light number `light`, if it is one.
    #[inline(always)]
    pub(super) fn ball(&self, light: u32) -> Option<(&Sphere, &Paint, Option<Id>)> {
        let light = &self.list[light as usize];
        if let Form::Sphere(sphere) = &light.form { Some((sphere, &light.radiance, light.id)) } else { None }
    }

    /// Draws a direction towards the light, in proportion to its paint where that is possible; `None` if it shows its back.
    #[inline(always)]
    pub(super) fn sample(&self, light: usize, from: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let light = &self.list[light];
        let toward = |point: DVec3, normal: DVec3, area: f64| {
            let away = point - from;
            let d2 = away.length_squared();
            let distance = d2.sqrt();
            let direction = away / distance;
            let cos = -direction.dot(normal);
            let pdf = d2 / (area * cos);
            (cos > 0.0 && pdf > 0.0 && pdf.is_finite()).then_some((direction, distance, pdf))
        };
        let mut id = light.id;
        let (direction, distance, pdf, radiance) = match &light.form {
            Form::Quad(quad) => {
                let dab = light.radiance.draw(u);
                let point = quad.corner + dab.uv[0] * quad.edge_u + dab.uv[1] * quad.edge_v;
                let (direction, distance, pdf) = toward(point, quad.normal, quad.area)?;
                (direction, distance, pdf * dab.density, dab.colour)
            }
            Form::Sphere(sphere) => {
                let (direction, distance, pdf) = sphere.sample_direction(from, u)?;
                let uv = || sphere.uv(from + distance * direction);
                (direction, distance, pdf, light.radiance.colour(uv))
            }
            Form::Disc(disc) => {
                let (direction, distance, pdf) = toward(disc.point(u), disc.normal, disc.area())?;
                (direction, distance, pdf, light.radiance.mean())
            }
            Form::Mesh(mesh, table) => {
                let (triangle, left) = table.draw(((u[0] * (1u64 << 53) as f64) as u64) << 11);
                let (point, normal) = mesh.point(triangle as u32, [left, u[1]]);
                if let Some(Id::Triangle { mesh, .. }) = id {
                    id = Some(Id::Triangle { mesh, triangle: triangle as u32 });
                }
                let (direction, distance, pdf) = toward(point, normal, mesh.area())?;
                (direction, distance, pdf, light.radiance.mean())
            }
            Form::Surroundings(environment) => {
                let (direction, radiance, pdf) = environment.sample(u);
                (direction, f64::INFINITY, pdf, radiance)
            }
        };
        (pdf > 0.0).then_some(LightSample { direction, distance, pdf, radiance, id })
    }

    /// Radiance that the light sends back along `ray`, 0 from behind, and the density with which [`Self::sample`] draws this
    /// direction from the origin of the ray.
    #[inline(always)]
    pub(super) fn meet(&self, light: usize, ray: &Ray, hit: &Hit) -> Met {
        let dark = Met { radiance: DVec3::ZERO, pdf: 0.0 };
        let light = &self.list[light];
        let facing = |normal: DVec3, area: f64| {
            let cos = -ray.direction.dot(normal);
            if cos > 0.0 { hit.t * hit.t / (area * cos) } else { 0.0 }
        };
        match &light.form {
            Form::Quad(quad) => {
                let pdf = facing(quad.normal, quad.area);
                if pdf == 0.0 {
                    return dark;
                }
                let dab = light.radiance.dab(quad.uv(ray.at(hit.t)));
                Met { radiance: dab.colour, pdf: pdf * dab.density }
            }
            Form::Sphere(sphere) => {
                // From inside there is no cone of directions, and the back of the surface is seen.
                let pdf = sphere.direction_pdf(ray.origin);
                if pdf == 0.0 {
                    return dark;
                }
                Met { radiance: light.radiance.colour(|| sphere.uv(ray.at(hit.t))), pdf }
            }
            Form::Disc(disc) => match facing(disc.normal, disc.area()) {
                0.0 => dark,
                pdf => Met { radiance: light.radiance.mean(), pdf },
            },
            Form::Mesh(mesh, _) => {
                let Id::Triangle { triangle, .. } = hit.id else { return dark };
                match facing(mesh.normals(triangle, hit.weights).0, mesh.area()) {
                    0.0 => dark,
                    pdf => Met { radiance: light.radiance.mean(), pdf },
                }
            }
            Form::Surroundings(_) => dark,
        }
    }
}

impl Sphere {
    /// A direction uniform in the cone that the sphere fills, its distance \[m\] and density per steradian; `None` from inside.
    #[inline(always)]
    pub(super) fn sample_direction(&self, from: DVec3, u: [f64; 2]) -> Option<(DVec3, f64, f64)> {
        let (direction, distance, pdf) = self.cone(from, u);
        (pdf > 0.0).then_some((direction, distance, pdf))
    }

    /// As [`Self::sample_direction`] with density 0 from inside, and not a branch on the way
    /// (Wang, Graphics Gems III, 1992).
    #[inline(always)]
    pub(super) fn cone(&self, from: DVec3, u: [f64; 2]) -> (DVec3, f64, f64) {
        let away = self.centre - from;
        let d2 = away.length_squared();
        let (height, pdf) = self.cap(d2);
        let d = d2.sqrt();
        let axis = away * (1.0 / d);
        let (x, y) = tangents(axis);
        // cos = 1 - u h; sin^2 = u h (2 - u h) keeps its digits for a small cone.
        let drop = u[0] * height;
        let sin2 = drop * (2.0 - drop);
        let (s, c) = sin_cos_turns(u[1]);
        let direction = sin2.sqrt() * (c * x + s * y) + (1.0 - drop) * axis;
        let half_chord = (self.radius * self.radius - d2 * sin2).max(0.0).sqrt();
        (direction, d * (1.0 - drop) - half_chord, pdf)
    }

    /// `1 / (2 pi (1 - cos a))`, `sin a = r / d` [1/sr] for any direction that meets the sphere; 0 from inside.
    #[inline]
    pub(super) fn direction_pdf(&self, from: DVec3) -> f64 {
        self.cap((self.centre - from).length_squared()).1
    }

    /// `1 - cos a = sin^2 a / (1 + cos a)` of the cone about the sphere seen from the squared distance `d2`, and the density in it.
    #[inline(always)]
    fn cap(&self, d2: f64) -> (f64, f64) {
        let r2 = self.radius * self.radius;
        let sin2 = r2 / d2;
        let beyond = 1.0 + (1.0 - sin2).max(0.0).sqrt();
        // One division for height and density.
        let inverse = 1.0 / (sin2 * beyond);
        let pdf = beyond * beyond * inverse * (1.0 / TAU);
        (sin2 * sin2 * inverse, if r2 < d2 { pdf } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::paint::Pattern;
    use crate::render::rays::{Hits, Rays, WAVE};
    use crate::render::reach::{Asking, Asks, Pick, Scratch};
    use crate::render::{Material, Scene};
    use fearless_simd::{Level, dispatch};

    /// The light asked at a point.
    fn pick(lights: &Lights, at: &Asking, u: f64) -> Pick {
        let wide = |v: DVec3| [v.x, v.y, v.z].map(|x| [x; WAVE]);
        let (point, normal) = (wide(at.point), wide(at.normal));
        let (asks, mut picks) =
            (Asks { len: 1, point: &point, normal: &normal, u: &[u; WAVE] }, [Pick::default(); WAVE]);
        dispatch!(Level::new(), simd => lights.reaches.pick(simd, asks, &mut Scratch::default(), &mut picks));
        picks[0]
    }

    fn chance(lights: &Lights, light: usize, at: &Asking) -> f64 {
        let total = pick(lights, at, 0.5).total;
        dispatch!(Level::new(), simd => lights.reaches.chance(simd, light, at, total))
    }

    fn sample_any(lights: &Lights, at: &Asking, u: [f64; 2]) -> Option<LightSample> {
        let pick = pick(lights, at, u[0]);
        let rest = ((u[0] - pick.start) / pick.chance).clamp(0.0, 1.0 - f64::EPSILON);
        let sample = lights.sample(pick.light as usize, at.point, [rest, u[1]])?;
        Some(LightSample { pdf: pick.chance * sample.pdf, ..sample })
    }

    fn grid(n: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..n * n).map(move |k| [((k % n) as f64 + 0.5) / n as f64, ((k / n) as f64 + 0.5) / n as f64])
    }

    fn white() -> Paint {
        Paint::plain(DVec3::ONE).unwrap()
    }

    /// The mean of 1 / pdf is the solid angle.
    fn solid_angle(shape: impl Into<Shape>, from: DVec3, n: usize) -> f64 {
        let mut lights = Lights::default();
        lights.add(shape.into(), Id::Triangle { mesh: 0, triangle: 0 }, white()).unwrap();
        let sum: f64 = grid(n).filter_map(|u| lights.sample(0, from, u)).map(|s| 1.0 / s.pdf).sum();
        sum / (n * n) as f64
    }

    /// Of a square seen from its axis 4 asin(sin^2) (gnomonic rectangle), of a disc 2 pi (1 - cos).
    #[test]
    fn the_mean_inverse_density_is_the_solid_angle() {
        let quad = Quad::new(DVec3::new(-1.0, -1.0, 2.0), 2.0 * DVec3::Y, 2.0 * DVec3::X).unwrap();
        let full_angle = 2.0 * 0.5f64.atan();
        let expected = crate::math::solid_angle::rectangle(full_angle, full_angle);
        assert!((solid_angle(quad, DVec3::ZERO, 400) / expected - 1.0).abs() < 1e-5);
        assert_eq!(solid_angle(quad, DVec3::new(0.0, 0.0, 3.0), 10), 0.0);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let vertices: Vec<DVec3> = corners.iter().map(|c| DVec3::new(c[0], c[1], 2.0)).collect();
        let mesh = Mesh::new(vertices, None, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
        assert!((solid_angle(mesh, DVec3::ZERO, 400) / expected - 1.0).abs() < 1e-4);
        let disc = Disc::new(2.0 * DVec3::Z, -DVec3::Z, 1.0, 0.0).unwrap();
        let cap = TAU * (1.0 - 2.0 / 5f64.sqrt());
        assert!((solid_angle(disc, DVec3::ZERO, 400) / cap - 1.0).abs() < 1e-5);
    }

    #[test]
    fn directions_to_a_sphere_meet_it_and_agree_on_distance_and_density() {
        let sphere = Sphere::new(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
        let from = DVec3::new(-0.5, 0.3, 0.1);
        for u in grid(50) {
            let (direction, distance, pdf) = sphere.sample_direction(from, u).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let t = sphere.intersect(&Ray { origin: from, direction }, f64::INFINITY).unwrap();
            assert!((t - distance).abs() < 1e-9);
            assert_eq!(pdf, sphere.direction_pdf(from));
        }
        // 2 pi (1 - cos 30) when r / d = 1/2.
        let half = Sphere::new(2.0 * DVec3::Z, 1.0).unwrap();
        let solid_angle = TAU * (1.0 - 0.75f64.sqrt());
        assert!((1.0 / half.direction_pdf(DVec3::ZERO) - solid_angle).abs() < 1e-14);
        assert!(half.sample_direction(2.0 * DVec3::Z, [0.5; 2]).is_none());
    }

    /// What is drawn among all lights is met again with the same density, and each light as often as its chance says.
    #[test]
    fn the_density_of_a_draw_is_the_one_reported_for_its_direction() {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        let checker = Pattern::Checker { columns: 2, rows: 2 };
        let down = Quad::new(DVec3::new(-1.0, -1.0, 2.0), 2.0 * DVec3::Y, 2.0 * DVec3::X).unwrap();
        scene.add_emitter(down, Paint::new(checker, DVec3::ONE, DVec3::ZERO).unwrap()).unwrap();
        let ball = Sphere::new(DVec3::new(3.0, 0.0, 1.0), 0.5).unwrap();
        scene.add_emitter(ball, Paint::plain(5.0 * DVec3::ONE).unwrap()).unwrap();
        let behind = Disc::new(DVec3::new(0.0, 3.0, 1.0), DVec3::Y, 1.0, 0.0).unwrap();
        scene.add_emitter(behind, white()).unwrap();
        let matt = crate::model::Lambert { rho: 0.5 };
        scene.add(Sphere::new(-9.0 * DVec3::X, 1.0).unwrap(), Material { brdf: &matt, tint: white() });
        let at = Asking { point: DVec3::ZERO, normal: DVec3::Z };
        let mut seen = [0.0; 3];
        let n = 2000;
        for k in 0..n {
            let u = [(f64::from(k) + 0.5) / f64::from(n), (f64::from(k) * 0.618) % 1.0];
            let sample = sample_any(&scene.lights, &at, u).unwrap();
            let ray = Ray { origin: DVec3::ZERO, direction: sample.direction };
            let (mut rays, mut hits) = (Rays::default(), Hits::default());
            rays.push(&ray, None, -1.0);
            dispatch!(Level::new(), simd => scene.closest(simd, &rays, &mut hits));
            let hit = scene.hit(&hits, 0).unwrap();
            assert_eq!(Some(hit.id), sample.id);
            let light = if matches!(hit.id, Id::Quad(_)) { 0 } else { 1 };
            seen[light] += 1.0 / f64::from(n);
            let met = scene.meet_light(light, &ray, &hit);
            let pdf = chance(&scene.lights, light, &at) * met.pdf;
            assert!((pdf / sample.pdf - 1.0).abs() < 1e-9 && met.radiance == sample.radiance);
        }
        for light in 0..3 {
            assert!((seen[light] - chance(&scene.lights, light, &at)).abs() < 2e-3, "{seen:?}");
        }
        // The disc shows its back.
        assert_eq!(seen[2], 0.0);
        assert!(scene.add_emitter(down, Paint::plain(DVec3::ZERO).unwrap()).is_err());
    }

    #[test]
    fn a_hundred_lights_are_drawn_by_power() {
        let mut lights = Lights::default();
        for k in 0..100u32 {
            let ball = Sphere::new(DVec3::new(f64::from(k), 0.0, 5.0), 0.3).unwrap();
            lights.add(ball.into(), Id::Sphere(k), Paint::plain(DVec3::splat(1.0 + f64::from(k))).unwrap()).unwrap();
        }
        let at = Asking { point: DVec3::ZERO, normal: DVec3::Z };
        let total: f64 = (0..100).map(|k| chance(&lights, k, &at)).sum();
        assert!((total - 1.0).abs() < 1e-12);
        for k in 0..500 {
            let sample = sample_any(&lights, &at, [(f64::from(k) + 0.5) / 500.0, 0.3]).unwrap();
            let Some(Id::Sphere(i)) = sample.id else { panic!("spheres only") };
            let own = lights.sample(i as usize, DVec3::ZERO, [0.5; 2]).unwrap();
            assert!((sample.pdf / (own.pdf * chance(&lights, i as usize, &at)) - 1.0).abs() < 1e-9);
        }
    }
}
