//! Draws towards the lights for many points at once.

use super::super::light::Lights;
use super::super::rays::{Column, LANES, WAVE};
use super::super::reach::{Asks, Pick, Scratch};
use super::super::scene::Id;
use super::super::shape::Sphere;
use crate::math::frame::DVec3;
use fearless_simd::Simd;

/// What the lights send to each spot: a direction, its density among all draws (0 for none), and what shines there.
pub(super) struct Lamplight {
    u: [Column<f64>; 2],
    scratch: Scratch,
    pub picks: Column<Pick>,
    /// Where a sphere was picked.
    balls: Balls,
    pub direction: [Column<f64>; 3],
    pub distance: Column<f64>,
    pub pdf: Column<f64>,
    pub radiance: Column<DVec3>,
    pub target: Column<Option<Id>>,
    /// [`Id::solid`] of it.
    pub solid: Column<f64>,
}

/// Spheres, and densities of the draws in their cones.
struct Balls {
    centre: [Column<f64>; 3],
    radius: Column<f64>,
    pdf: Column<f64>,
}

impl Default for Lamplight {
    fn default() -> Self {
        let zeros = [0.0; WAVE];
        Lamplight {
            u: [zeros; 2],
            scratch: Scratch::default(),
            picks: [Pick::default(); WAVE],
            balls: Balls { centre: [zeros; 3], radius: [1.0; WAVE], pdf: zeros },
            direction: [zeros; 3],
            distance: zeros,
            pdf: zeros,
            radiance: [DVec3::ZERO; WAVE],
            target: [None; WAVE],
            solid: [-1.0; WAVE],
        }
    }
}

impl Lamplight {
    /// The numbers by which spot number `i` draws; the first is below 0 if it does not ask.
    #[inline(always)]
    pub fn set(&mut self, i: usize, u: Option<[f64; 2]>) {
        [self.u[0][i], self.u[1][i]] = u.unwrap_or([-1.0, 0.0]);
    }

    /// Draws for each of the first `count` points, with their normals, a light by how much it matters there, then a direction
    /// towards it.
    #[inline(always)]
    pub fn draw<S: Simd>(
        &mut self,
        simd: S,
        lights: &Lights,
        point: &[Column<f64>; 3],
        normal: &[Column<f64>; 3],
        count: usize,
    ) {
        let asks = Asks { len: count, point, normal, u: &self.u[0] };
        lights.reaches.pick(simd, asks, &mut self.scratch, &mut self.picks);
        let mut round = false;
        for i in 0..count {
            let (pick, u) = (&self.picks[i], self.u[0][i]);
            let asks = u >= 0.0 && pick.chance > 0.0;
            self.pdf[i] = if asks { pick.chance } else { 0.0 };
            if !asks {
                continue;
            }
            // What is left of the number that picked the light.
            self.u[0][i] = ((u - pick.start) / pick.chance).clamp(0.0, 1.0 - f64::EPSILON);
            if let Some((sphere, ..)) = lights.ball(pick.light) {
                for axis in 0..3 {
                    self.balls.centre[axis][i] = sphere.centre[axis];
                }
                self.balls.radius[i] = sphere.radius;
                round = true;
            }
        }
        if round {
            for from in (0..count).step_by(LANES) {
                self.cones(point, from);
            }
        }
        for i in 0..count {
            if !(self.pdf[i] > 0.0) {
                continue;
            }
            let at = |columns: &[Column<f64>; 3]| DVec3::new(columns[0][i], columns[1][i], columns[2][i]);
            let light = self.picks[i].light;
            if let Some((sphere, paint, id)) = lights.ball(light) {
                self.pdf[i] *= self.balls.pdf[i];
                self.radiance[i] = paint.colour(|| sphere.uv(at(point) + self.distance[i] * at(&self.direction)));
                (self.target[i], self.solid[i]) = (id, Id::solid(id));
                continue;
            }
            let Some(sample) = lights.sample(light as usize, at(point), [self.u[0][i], self.u[1][i]]) else {
                self.pdf[i] = 0.0;
                continue;
            };
            for axis in 0..3 {
                self.direction[axis][i] = sample.direction[axis];
            }
            self.pdf[i] *= sample.pdf;
            (self.distance[i], self.radiance[i]) = (sample.distance, sample.radiance);
            (self.target[i], self.solid[i]) = (sample.id, Id::solid(sample.id));
        }
    }

    /// [`Sphere::cone`] for all rows of a bundle.
    #[inline(always)]
    fn cones(&mut self, point: &[Column<f64>; 3], from: usize) {
        fn rows(column: &Column<f64>, from: usize) -> [f64; LANES] {
            std::array::from_fn(|lane| column[from + lane])
        }
        let (mut direction, mut distance, mut pdf) = ([[0.0; LANES]; 3], [0.0; LANES], [0.0; LANES]);
        let [x, y, z] = [0, 1, 2].map(|axis| rows(&point[axis], from));
        let [cx, cy, cz] = [0, 1, 2].map(|axis| rows(&self.balls.centre[axis], from));
        let radius = rows(&self.balls.radius, from);
        let [u, v] = [0, 1].map(|k| rows(&self.u[k], from));
        for l in 0..LANES {
            let sphere = Sphere { centre: DVec3::new(cx[l], cy[l], cz[l]), radius: radius[l] };
            let drawn = sphere.cone(DVec3::new(x[l], y[l], z[l]), [u[l], v[l]]);
            (direction[0][l], direction[1][l], direction[2][l]) = (drawn.0.x, drawn.0.y, drawn.0.z);
            (distance[l], pdf[l]) = (drawn.1, drawn.2);
        }
        for axis in 0..3 {
            self.direction[axis][from..from + LANES].copy_from_slice(&direction[axis]);
        }
        self.distance[from..from + LANES].copy_from_slice(&distance);
        self.balls.pdf[from..from + LANES].copy_from_slice(&pdf);
    }
}
