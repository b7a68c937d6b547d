//! Paths by the wave: all of them meet their next surface, ask for light and turn together.
//!
//! One path after the other waits for every root and every lookup of its own. A wave takes each step for all of its paths
//! before the next one: rays against shapes and lamps in lanes, draws and BRDFs by the run, material by material.

mod ask;
mod lamplight;
#[cfg(test)]
mod one_by_one;
mod order;
mod pairs;
mod spots;
mod turn;

use super::integrator::{Estimator, RenderOptions};
use super::rays::{Column, Hits, LANES, Rays, Shadows, WAVE};
use super::reach::Asking;
use super::scene::{Finish, Scene};
use super::shape::Ray;
use super::stream::PathStream;
use crate::math::frame::DVec3;
use crate::optics::BrdfSample;
use fearless_simd::Simd;
use lamplight::Lamplight;
use order::Order;
use pairs::Pairs;
use spots::Spots;
use turn::Turns;

/// A path under way.
#[derive(Clone, Copy)]
struct Walker {
    path: usize,
    throughput: DVec3,
    /// Largest channel of the throughput after the first reflection.
    first_weight: f64,
    /// None for a camera ray or a mirror, which no light sample rivals.
    drawn: Option<Drawn>,
}

/// How the ray that is followed was drawn: what the light samples at its start must be weighed against.
#[derive(Clone, Copy)]
struct Drawn {
    pdf: f64,
    normal: DVec3,
    /// Sum of the weights of the lights at its start.
    total: f32,
}

/// Up to [`WAVE`] paths.
pub(super) struct Wave<'w> {
    scene: &'w Scene<'w>,
    options: &'w RenderOptions,
    streams: Vec<PathStream<'w>>,
    /// Radiance that came in by each path so far.
    radiance: Vec<DVec3>,
    /// Straight pieces of the longest path.
    pub(super) longest: u32,
    now: Steps,
    next: Steps,
    hits: Hits,
    order: Order,
    spots: Spots<'w>,
    lamplight: Lamplight,
    shadows: Shadows,
    blocked: Column<bool>,
    pairs: Pairs,
    /// Numbers of the draws in the BRDFs.
    u: Vec<[f64; 2]>,
    draws: Vec<Option<BrdfSample>>,
    turns: Turns,
    /// Radiance that each shadow ray stands for, and its path.
    bright: Vec<(usize, DVec3)>,
}

/// Rays with their paths.
#[derive(Default)]
struct Steps {
    /// In a box, so that two lists can change places.
    rays: Box<Rays>,
    walkers: Vec<Walker>,
}

impl<'w> Wave<'w> {
    pub(super) fn new(scene: &'w Scene<'w>, options: &'w RenderOptions) -> Self {
        Wave {
            scene,
            options,
            streams: Vec::with_capacity(WAVE),
            radiance: Vec::with_capacity(WAVE),
            longest: 0,
            now: Steps::default(),
            next: Steps::default(),
            hits: Hits::default(),
            order: Order::default(),
            spots: Spots::default(),
            lamplight: Lamplight::default(),
            shadows: Shadows::default(),
            blocked: [false; WAVE],
            pairs: Pairs::default(),
            u: vec![[0.0; 2]; WAVE],
            draws: Vec::with_capacity(WAVE),
            turns: Turns::default(),
            bright: Vec::with_capacity(WAVE),
        }
    }

    /// Adds a path that starts along `ray`, a direction of any length, and draws from `stream`; `true` if that was the last there is room for.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, stream: PathStream<'w>) -> bool {
        let path = self.streams.len();
        self.streams.push(stream);
        self.now.rays.push(ray, None, -1.0);
        self.now.walkers.push(Walker { path, throughput: DVec3::ONE, first_weight: 1.0, drawn: None });
        path + 1 == WAVE
    }

    /// Follows all paths to their ends: the radiance that arrives against each first ray [W/(m2 sr)].
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S) -> &[DVec3] {
        self.radiance.clear();
        self.radiance.resize(self.streams.len(), DVec3::ZERO);
        let last = if self.options.estimator == Estimator::Direct { 1 } else { self.options.max_reflections };
        self.now.rays.normalise(simd);
        let mut reflection = 0;
        while self.now.rays.len() > 0 {
            self.longest = self.longest.max(reflection + 1);
            if reflection == last && self.scene.only_lamps_shine() {
                self.keep_towards_lamps(simd);
            }
            self.meet(simd, reflection < last);
            self.ask(simd);
            self.turn(simd);
            self.go_on(simd, reflection);
            std::mem::swap(&mut self.now, &mut self.next);
            reflection += 1;
        }
        self.streams.clear();
        &self.radiance
    }

    /// Lets the rays go that pass by all lamps.
    #[inline(always)]
    fn keep_towards_lamps<S: Simd>(&mut self, simd: S) {
        self.next.rays.clear();
        self.next.walkers.clear();
        for from in (0..self.now.rays.len()).step_by(LANES) {
            let mut kept = self.scene.solids.lamps_ahead(simd, &self.now.rays, from);
            while kept != 0 {
                let j = from + kept.trailing_zeros() as usize;
                kept &= kept - 1;
                if j < self.now.rays.len() {
                    self.next.rays.push_from(&self.now.rays, j);
                    self.next.walkers.push(self.now.walkers[j]);
                }
            }
        }
        std::mem::swap(&mut self.now, &mut self.next);
    }

    /// Takes in the lamps that were met, and if the paths go on, the spots where something reflects.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, go_on: bool) {
        let scene = self.scene;
        scene.closest(simd, &self.now.rays, &mut self.hits);
        self.order.sort(&self.hits.surface[..self.now.rays.len()], scene.surfaces());
        self.spots.clear(scene.groups());
        for number in 0..scene.surfaces() {
            let run = self.order.run(number);
            if run.is_empty() {
                continue;
            }
            let Some(id) = scene.surface(number as u32) else {
                for k in run {
                    self.leave(simd, self.order.list[k] as usize);
                }
                continue;
            };
            match scene.finish(id) {
                Finish::Emits(light) => {
                    for k in run {
                        self.meet_lamp(simd, light, self.order.list[k] as usize);
                    }
                }
                Finish::Reflects(_) if go_on => {
                    self.spots.add(scene, id, run, &self.now.rays, &self.hits, &mut self.order.list);
                }
                Finish::Reflects(_) => {}
            }
        }
        self.spots.arrange(simd, scene, &self.now.rays, &self.hits, &self.order.list);
    }

    /// Takes in what surrounds the scene.
    #[inline(always)]
    fn leave<S: Simd>(&mut self, simd: S, j: usize) {
        let (scene, walker, ray) = (self.scene, &self.now.walkers[j], self.now.rays.get(j));
        let mut light = scene.sky;
        if let Some((surroundings, met)) = scene.lights.surroundings(ray.direction) {
            light += self.emitter_weight(simd, walker, ray.origin, surroundings, met.pdf) * met.radiance;
        }
        self.radiance[walker.path] += walker.throughput * light;
    }

    #[inline(always)]
    fn meet_lamp<S: Simd>(&mut self, simd: S, light: usize, j: usize) {
        let (scene, walker, ray) = (self.scene, &self.now.walkers[j], self.now.rays.get(j));
        let Some(hit) = scene.hit(&self.hits, j) else { return };
        let met = scene.meet_light(light, &ray, &hit);
        let weight = self.emitter_weight(simd, walker, ray.origin, light, met.pdf);
        self.radiance[walker.path] += weight * walker.throughput * met.radiance;
    }

    /// Share of the BRDF draw in an emitter that both strategies find: `p_brdf / (p_brdf + p_light)`.
    #[inline(always)]
    fn emitter_weight<S: Simd>(&self, simd: S, walker: &Walker, from: DVec3, light: usize, own: f64) -> f64 {
        let Some(drawn) = walker.drawn else { return 1.0 };
        if self.options.estimator == Estimator::Brdf {
            return 1.0;
        }
        let at = Asking { point: from, normal: drawn.normal };
        let rival = self.scene.lights.reaches.chance(simd, light, &at, drawn.total) * own;
        match self.options.estimator {
            // From inside a sphere no light sample is drawn: the BRDF must find it alone.
            Estimator::Lights => f64::from(rival <= 0.0),
            _ => 1.0 / (1.0 + rival / drawn.pdf),
        }
    }
}
