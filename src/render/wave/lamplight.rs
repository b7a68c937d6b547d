//! Draws towards the lights for many points at once.

use super::super::light::{LightSample, Lights};
use super::super::rays::{Column, LANES, WAVE};
use super::super::reach::{Asking, Asks, Pick, Scratch};
use super::super::shape::Sphere;
use crate::math::frame::DVec3;
use fearless_simd::Simd;

/// The points that ask, and what they are given.
pub(super) struct Lamplight {
    asks: Asks,
    /// Of each: number of its spot, place, and the numbers to draw by.
    list: Vec<(usize, DVec3, [f64; 2])>,
    picks: Column<Pick>,
    samples: Vec<Option<LightSample>>,
    scratch: Scratch,
}

impl Default for Lamplight {
    fn default() -> Self {
        Lamplight {
            asks: Asks::default(),
            list: Vec::with_capacity(WAVE),
            picks: [Pick::default(); WAVE],
            samples: Vec::with_capacity(WAVE),
            scratch: Scratch::default(),
        }
    }
}

/// Spheres that shine on [`LANES`] points.
struct Balls {
    centre: [[f64; LANES]; 3],
    radius: [f64; LANES],
    from: [[f64; LANES]; 3],
    u: [[f64; LANES]; 2],
    direction: [[f64; LANES]; 3],
    distance: [f64; LANES],
    pdf: [f64; LANES],
}

impl Balls {
    fn new() -> Self {
        let (zero, zeros) = ([0.0; LANES], [[0.0; LANES]; 3]);
        Balls {
            centre: zeros,
            radius: [1.0; LANES],
            from: zeros,
            u: [zero; 2],
            direction: zeros,
            distance: zero,
            pdf: zero,
        }
    }

    /// [`Sphere::cone`] in all lanes.
    #[inline(always)]
    fn draw(&mut self) {
        for l in 0..LANES {
            let [x, y, z] = &self.centre;
            let sphere = Sphere { centre: DVec3::new(x[l], y[l], z[l]), radius: self.radius[l] };
            let [x, y, z] = &self.from;
            let (direction, distance, pdf) =
                sphere.cone(DVec3::new(x[l], y[l], z[l]), [self.u[0][l], self.u[1][l]]);
            self.direction[0][l] = direction.x;
            self.direction[1][l] = direction.y;
            self.direction[2][l] = direction.z;
            self.distance[l] = distance;
            self.pdf[l] = pdf;
        }
    }
}

impl Lamplight {
    pub fn clear(&mut self) {
        self.asks.clear();
        self.list.clear();
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds the point of spot number `spot`; there must be room.
    #[inline(always)]
    pub fn push(&mut self, spot: usize, at: &Asking, u: [f64; 2]) {
        self.asks.push(at, u[0]);
        self.list.push((spot, at.point, u));
    }

    /// Draws for every point a light by how much it matters there, then a direction towards it.
    #[inline(always)]
    pub fn draw<S: Simd>(&mut self, simd: S, lights: &Lights) {
        lights.reaches.pick(simd, &self.asks, &mut self.scratch, &mut self.picks);
        self.samples.clear();
        let mut balls = Balls::new();
        let (picks, all) = (&self.picks, &self.list);
        for from in (0..all.len()).step_by(LANES) {
            let list = &all[from..all.len().min(from + LANES)];
            // What is left of the number that picked the light.
            let rest = |m: usize| {
                let (pick, u) = (&picks[from + m], list[m].2);
                [((u[0] - pick.start) / pick.chance).clamp(0.0, 1.0 - f64::EPSILON), u[1]]
            };
            let mut round = [None; LANES];
            for (m, (_, point, _)) in list.iter().enumerate() {
                let pick = &picks[from + m];
                if !(pick.chance > 0.0) {
                    continue;
                }
                if let Some(ball) = lights.ball(pick.light) {
                    for axis in 0..3 {
                        balls.centre[axis][m] = ball.0.centre[axis];
                        balls.from[axis][m] = point[axis];
                    }
                    balls.radius[m] = ball.0.radius;
                    [balls.u[0][m], balls.u[1][m]] = rest(m);
                    round[m] = Some(ball);
                }
            }
            if round.iter().any(Option::is_some) {
                balls.draw();
            }
            for (m, (_, point, _)) in list.iter().enumerate() {
                let pick = &picks[from + m];
                let sample = if let Some((sphere, paint, id)) = round[m] {
                    let (pdf, distance) = (balls.pdf[m], balls.distance[m]);
                    let [x, y, z] = &balls.direction;
                    let direction = DVec3::new(x[m], y[m], z[m]);
                    let radiance = paint.colour(|| sphere.uv(*point + distance * direction));
                    (pdf > 0.0).then_some(LightSample { direction, distance, pdf, radiance, id })
                } else if pick.chance > 0.0 {
                    lights.sample(pick.light as usize, *point, rest(m))
                } else {
                    None
                };
                self.samples.push(sample.map(|s| LightSample { pdf: pick.chance * s.pdf, ..s }));
            }
        }
    }

    /// Number of the spot, sum of the weights of the lights there, and the draw.
    #[inline(always)]
    pub fn take(&self, m: usize) -> (usize, f32, Option<&LightSample>) {
        (self.list[m].0, self.picks[m].total, self.samples[m].as_ref())
    }
}
