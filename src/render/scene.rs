//! Shapes with what covers them: a material that reflects, or an emitter.

use super::light;
use super::paint::Paint;
use super::shape::{Quad, Ray, Shape, Sphere};
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use crate::optics::brdf::Brdf;

/// A surface that reflects: `f_r(wi, wo) tint(u, v)`, the same on both sides of a quad.
#[derive(Clone, Copy)]
pub struct Material<'a> {
    /// In the local frame z is the normal on the side that is seen and x runs along `edge_u` of a quad.
    pub brdf: &'a dyn Brdf,
    /// Linear RGB factor, to be kept at or below 1.
    pub tint: Paint,
}

#[derive(Clone, Copy)]
pub(super) enum Finish<'a> {
    Reflects(Material<'a>),
    /// Index of the light.
    Emits(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Id {
    Quad(usize),
    Sphere(usize),
}

/// The nearest surface along a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub t: f64,
    pub id: Id,
}

struct Light {
    id: Id,
    radiance: Paint,
    intensity: f64,
    /// Chance to be drawn, and the sum of the chances up to and including this light.
    probability: f64,
    cumulative: f64,
}

/// A direction drawn towards a light.
pub(super) struct LightSample {
    pub direction: DVec3,
    pub distance: f64,
    /// Density per steradian: of this light alone, or among all if it was drawn from all.
    pub pdf: f64,
    pub radiance: DVec3,
    pub id: Id,
}

/// What a ray can meet, under a sky of uniform radiance.
///
/// Lengths in metres, radiance in W/(m2 sr) per linear RGB channel. Nothing refracts: shapes are opaque.
pub struct Scene<'a> {
    pub(super) sky: DVec3,
    quads: Vec<Quad>,
    quad_finishes: Vec<Finish<'a>>,
    spheres: Vec<Sphere>,
    sphere_finishes: Vec<Finish<'a>>,
    lights: Vec<Light>,
}

impl<'a> Scene<'a> {
    /// An empty scene under a sky of the given radiance [W/(m2 sr)].
    ///
    /// # Errors
    /// `Error::Parameter` if the radiance is negative or not finite.
    pub fn new(sky: DVec3) -> Result<Self> {
        Ok(Scene {
            sky: Paint::plain(sky)?.mean(),
            quads: Vec::new(),
            quad_finishes: Vec::new(),
            spheres: Vec::new(),
            sphere_finishes: Vec::new(),
            lights: Vec::new(),
        })
    }

    /// Adds a shape that reflects.
    pub fn add(&mut self, shape: impl Into<Shape>, material: Material<'a>) {
        self.place(shape.into(), Finish::Reflects(material));
    }

    /// Adds a black shape whose front emits `radiance` [W/(m2 sr)] equally in all directions.
    ///
    /// # Errors
    /// `Error::Parameter` if the emitter is dark everywhere.
    pub fn add_emitter(&mut self, shape: impl Into<Shape>, radiance: Paint) -> Result<()> {
        let shape = shape.into();
        let intensity = light::intensity(&shape, radiance.mean());
        if intensity <= 0.0 {
            return Err(Error::parameter("an emitter has no radiance", "give it a radiance above 0 or leave it out"));
        }
        let id = self.place(shape, Finish::Emits(self.lights.len()));
        self.lights.push(Light { id, radiance, intensity, probability: 0.0, cumulative: 0.0 });
        let (count, total) = (self.lights.len() as f64, self.lights.iter().map(|l| l.intensity).sum::<f64>());
        let mut cumulative = 0.0;
        for light in &mut self.lights {
            // Half by intensity, half evenly: a small bright lamp matters more in a mirror than its power tells.
            light.probability = 0.5 * light.intensity / total + 0.5 / count;
            cumulative += light.probability;
            light.cumulative = cumulative;
        }
        Ok(())
    }

    fn place(&mut self, shape: Shape, finish: Finish<'a>) -> Id {
        match shape {
            Shape::Quad(quad) => {
                self.quads.push(quad);
                self.quad_finishes.push(finish);
                Id::Quad(self.quads.len() - 1)
            }
            Shape::Sphere(sphere) => {
                self.spheres.push(sphere);
                self.sphere_finishes.push(finish);
                Id::Sphere(self.spheres.len() - 1)
            }
        }
    }

    /// First surface along the ray. `leaving` is the surface the ray starts on: excluding it by name instead of by
    /// a small distance keeps contacts exact.
    #[inline]
    pub(super) fn closest(&self, ray: &Ray, leaving: Option<Id>) -> Option<Hit> {
        let mut t = f64::INFINITY;
        let mut id = None;
        for (i, quad) in self.quads.iter().enumerate() {
            if let Some(nearer) = quad.intersect(ray, t)
                && leaving != Some(Id::Quad(i))
            {
                (t, id) = (nearer, Some(Id::Quad(i)));
            }
        }
        for (i, sphere) in self.spheres.iter().enumerate() {
            let found =
                if leaving == Some(Id::Sphere(i)) { sphere.intersect_again(ray, t) } else { sphere.intersect(ray, t) };
            if let Some(nearer) = found {
                (t, id) = (nearer, Some(Id::Sphere(i)));
            }
        }
        id.map(|id| Hit { t, id })
    }

    /// Whether anything but `leaving` and `target` stands before `distance`.
    #[inline]
    pub(super) fn is_blocked(&self, ray: &Ray, distance: f64, leaving: Id, target: Id) -> bool {
        let quad = |(i, quad): (usize, &Quad)| {
            quad.intersect(ray, distance).is_some() && leaving != Id::Quad(i) && target != Id::Quad(i)
        };
        let sphere = |(i, sphere): (usize, &Sphere)| {
            if leaving == Id::Sphere(i) {
                sphere.intersect_again(ray, distance).is_some()
            } else {
                sphere.intersect(ray, distance).is_some() && target != Id::Sphere(i)
            }
        };
        self.quads.iter().enumerate().any(quad) || self.spheres.iter().enumerate().any(sphere)
    }

    #[inline]
    pub(super) fn finish(&self, id: Id) -> &Finish<'a> {
        match id {
            Id::Quad(i) => &self.quad_finishes[i],
            Id::Sphere(i) => &self.sphere_finishes[i],
        }
    }

    /// Unit normal of the front and a unit tangent at a point of the shape.
    #[inline]
    pub(super) fn frame(&self, id: Id, point: DVec3) -> (DVec3, DVec3) {
        match id {
            Id::Quad(i) => (self.quads[i].normal, self.quads[i].tangent),
            Id::Sphere(i) => {
                let normal = (point - self.spheres[i].centre).normalize();
                // Along the parallels of latitude; any direction will do at the poles.
                (normal, DVec3::new(-normal.y, normal.x, 0.0).try_normalize().unwrap_or(DVec3::X))
            }
        }
    }

    /// Plane or sphere coordinates of a point of the shape.
    #[inline]
    pub(super) fn uv(&self, id: Id, point: DVec3) -> [f64; 2] {
        match id {
            Id::Quad(i) => self.quads[i].uv(point),
            Id::Sphere(i) => self.spheres[i].uv(point),
        }
    }

    /// Radiance that the light sends back along `ray` [W/(m2 sr)], 0 from behind, and the density per steradian with
    /// which [`Self::sample_light`] draws this direction from the origin of the ray.
    #[inline]
    pub(super) fn meet_light(&self, light: usize, ray: &Ray, t: f64) -> (DVec3, f64) {
        let light = &self.lights[light];
        match light.id {
            Id::Quad(i) => {
                let pdf = self.quads[i].direction_pdf(ray.direction, t);
                if pdf == 0.0 {
                    return (DVec3::ZERO, 0.0);
                }
                let dab = light.radiance.dab(self.quads[i].uv(ray.at(t)));
                (dab.colour, pdf * dab.density)
            }
            Id::Sphere(i) => {
                let pdf = self.spheres[i].direction_pdf(ray.origin);
                // From inside there is no cone of directions, and the back of the surface is seen.
                let colour = || light.radiance.colour(|| self.spheres[i].uv(ray.at(t)));
                (if pdf > 0.0 { colour() } else { DVec3::ZERO }, pdf)
            }
        }
    }

    /// Number of lights.
    #[inline]
    pub(super) fn light_count(&self) -> usize {
        self.lights.len()
    }

    /// Draws a light, then a direction towards it; `None` if there is no light or it shows its back.
    #[inline]
    pub(super) fn sample_any_light(&self, from: DVec3, mut u: [f64; 2]) -> Option<LightSample> {
        let last = self.lights.len().checked_sub(1)?;
        let index = self.lights.iter().position(|l| u[0] < l.cumulative).unwrap_or(last);
        let light = &self.lights[index];
        let start = light.cumulative - light.probability;
        u[0] = ((u[0] - start) / light.probability).clamp(0.0, 1.0);
        let sample = self.sample_light(index, from, u)?;
        Some(LightSample { pdf: light.probability * sample.pdf, ..sample })
    }

    /// Draws a direction towards the light, in proportion to its paint where that is possible.
    #[inline]
    pub(super) fn sample_light(&self, light: usize, from: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let light = &self.lights[light];
        let (toward, radiance, density) = match light.id {
            Id::Quad(i) => {
                let dab = light.radiance.draw(u);
                (self.quads[i].sample_direction(from, dab.uv)?, dab.colour, dab.density)
            }
            Id::Sphere(i) => {
                let toward = self.spheres[i].sample_direction(from, u)?;
                let uv = || self.spheres[i].uv(from + toward.distance * toward.direction);
                (toward, light.radiance.colour(uv), 1.0)
            }
        };
        let pdf = toward.pdf * density;
        (pdf > 0.0).then_some(LightSample {
            direction: toward.direction,
            distance: toward.distance,
            pdf,
            radiance,
            id: light.id,
        })
    }

    /// Chance of a light in [`Self::sample_any_light`].
    #[inline]
    pub(super) fn light_probability(&self, light: usize) -> f64 {
        self.lights[light].probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::paint::Pattern;

    struct Black;

    impl Brdf for Black {
        fn eval(&self, _: DVec3, _: DVec3) -> f64 {
            0.0
        }
        fn sample(&self, _: DVec3, _: [f64; 2]) -> Option<crate::optics::brdf::BrdfSample> {
            None
        }
        fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
            0.0
        }
        fn albedo(&self, _: f64) -> f64 {
            0.0
        }
    }

    fn square(z: f64) -> Quad {
        Quad::new(DVec3::new(-1.0, -1.0, z), 2.0 * DVec3::X, 2.0 * DVec3::Y).unwrap()
    }

    #[test]
    fn the_nearest_shape_wins_and_the_one_left_is_skipped() {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        let material = Material { brdf: &Black, tint: Paint::plain(DVec3::ONE).unwrap() };
        scene.add(square(0.0), material);
        scene.add(square(1.0), material);
        scene.add(Sphere::new(3.0 * DVec3::Z, 1.0).unwrap(), material);
        let up = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
        assert_eq!(scene.closest(&up, None).unwrap().id, Id::Quad(1));
        let on = Ray { origin: DVec3::Z, direction: DVec3::Z };
        let hit = scene.closest(&on, Some(Id::Quad(1))).unwrap();
        assert_eq!((hit.id, hit.t), (Id::Sphere(0), 1.0));
        assert!(scene.is_blocked(&up, 4.0, Id::Quad(0), Id::Sphere(0)));
        assert!(!scene.is_blocked(&on, 4.0, Id::Quad(1), Id::Sphere(0)));
        assert!(scene.sample_any_light(DVec3::ZERO, [0.5; 2]).is_none());
    }

    /// Integral of the density over all draws is 1: the mean of q / p is 1 for any other density q on the lights.
    #[test]
    fn the_density_of_a_draw_is_the_one_reported_for_its_direction() {
        let mut scene = Scene::new(DVec3::ZERO).unwrap();
        let checker = Pattern::Checker { columns: 2, rows: 2 };
        let down = Quad::new(DVec3::new(-1.0, -1.0, 2.0), 2.0 * DVec3::Y, 2.0 * DVec3::X).unwrap();
        scene.add_emitter(down, Paint::new(checker, DVec3::ONE, DVec3::ZERO).unwrap()).unwrap();
        let ball = Sphere::new(DVec3::new(3.0, 0.0, 1.0), 0.5).unwrap();
        scene.add_emitter(ball, Paint::plain(5.0 * DVec3::ONE).unwrap()).unwrap();
        let mut seen = [0, 0];
        for k in 0..1000 {
            let u = [(f64::from(k) + 0.5) / 1000.0, (f64::from(k) * 0.618) % 1.0];
            let sample = scene.sample_any_light(DVec3::ZERO, u).unwrap();
            let light = match sample.id {
                Id::Quad(_) => 0,
                Id::Sphere(_) => 1,
            };
            seen[light] += 1;
            let ray = Ray { origin: DVec3::ZERO, direction: sample.direction };
            let pdf = scene.light_probability(light) * scene.meet_light(light, &ray, sample.distance).1;
            assert!((pdf / sample.pdf - 1.0).abs() < 1e-12);
        }
        // Intensities 4 m2 * 0.5 and pi 0.25 m2 * 5; half of the draws go evenly.
        let expected = 250.0 + 500.0 * 2.0 / (2.0 + 1.25 * std::f64::consts::PI);
        assert!((f64::from(seen[0]) - expected).abs() <= 1.0, "{seen:?}");
        assert!(scene.add_emitter(square(1.0), Paint::plain(DVec3::ZERO).unwrap()).is_err());
    }
}
