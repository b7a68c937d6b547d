//! Paths by the wave: all of them meet their next surface, ask for light and turn together.
//!
//! One path after the other waits for every root and every lookup of its own. A wave takes each step for all of its paths
//! before the next one: rays against shapes and lamps in lanes, draws and BRDFs by the run, material by material.

mod lamplight;
mod spots;

use super::integrator::{Estimator, RenderOptions};
use super::material::Coat;
use super::rays::{Column, Rays, Shadows, WAVE};
use super::reach::Asking;
use super::scene::{Finish, Hit, Scene};
use super::shape::Ray;
use super::spectral::ColourDraw;
use super::stream::PathStream;
use crate::math::frame::DVec3;
use crate::optics::BrdfSample;
use fearless_simd::Simd;
use lamplight::Lamplight;
use spots::Spots;

/// Reflections before Russian roulette may end a path.
const SURE_REFLECTIONS: u32 = 3;

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

/// A draw towards a lamp that may arrive: its number, and the cosine at the spot.
struct Lit {
    ask: usize,
    cos_theta: f64,
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
    hits: Column<Option<Hit>>,
    spots: Spots<'w>,
    lamplight: Lamplight,
    shadows: Shadows,
    blocked: Column<bool>,
    lit: Vec<Lit>,
    pairs: Pairs,
    draws: Vec<Option<BrdfSample>>,
    /// Radiance that each shadow ray stands for, and its path.
    bright: Vec<(usize, DVec3)>,
}

/// Rays with their paths.
#[derive(Default)]
struct Steps {
    rays: Rays,
    walkers: Vec<Walker>,
}

/// Pairs of directions that a BRDF is asked for, and its answers.
#[derive(Default)]
struct Pairs {
    wi: Vec<DVec3>,
    wo: Vec<DVec3>,
    found: Vec<(DVec3, f64)>,
    spots: Vec<usize>,
}

impl Pairs {
    fn clear(&mut self) {
        self.wi.clear();
        self.wo.clear();
        self.spots.clear();
    }

    #[inline(always)]
    fn push(&mut self, spot: usize, wi: DVec3, wo: DVec3) {
        self.wi.push(wi);
        self.wo.push(wo);
        self.spots.push(spot);
    }
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
            hits: [None; WAVE],
            spots: Spots::default(),
            lamplight: Lamplight::default(),
            shadows: Shadows::default(),
            blocked: [false; WAVE],
            lit: Vec::with_capacity(WAVE),
            pairs: Pairs::default(),
            draws: Vec::with_capacity(WAVE),
            bright: Vec::with_capacity(WAVE),
        }
    }

    /// Adds a path that starts with `ray` and draws from `stream`; `true` if that was the last there is room for.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, stream: PathStream<'w>) -> bool {
        let path = self.streams.len();
        self.streams.push(stream);
        self.now.rays.push(ray, None);
        self.now.walkers.push(Walker { path, throughput: DVec3::ONE, first_weight: 1.0, drawn: None });
        path + 1 == WAVE
    }

    /// Follows all paths to their ends: the radiance that arrives against each first ray [W/(m2 sr)].
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S) -> &[DVec3] {
        self.radiance.clear();
        self.radiance.resize(self.streams.len(), DVec3::ZERO);
        let last = if self.options.estimator == Estimator::Direct { 1 } else { self.options.max_reflections };
        let mut reflection = 0;
        while self.now.rays.len() > 0 {
            self.longest = self.longest.max(reflection + 1);
            self.meet(simd, reflection < last);
            self.ask(simd);
            self.turn(reflection);
            std::mem::swap(&mut self.now, &mut self.next);
            reflection += 1;
        }
        self.streams.clear();
        &self.radiance
    }

    /// Takes in the lamps that were met, and if the paths go on, the spots where something reflects.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, go_on: bool) {
        let scene = self.scene;
        scene.closest(simd, &self.now.rays, &mut self.hits);
        self.spots.clear(scene.groups());
        for j in 0..self.now.rays.len() {
            let (walker, ray) = (&self.now.walkers[j], self.now.rays.get(j));
            let Some(hit) = &self.hits[j] else {
                let mut light = scene.sky;
                if let Some((surroundings, met)) = scene.lights.surroundings(ray.direction) {
                    light += self.emitter_weight(simd, walker, ray.origin, surroundings, met.pdf) * met.radiance;
                }
                self.radiance[walker.path] += walker.throughput * light;
                continue;
            };
            match scene.finish(hit.id) {
                Finish::Emits(light) => {
                    let met = scene.meet_light(light, &ray, hit);
                    let weight = self.emitter_weight(simd, walker, ray.origin, light, met.pdf);
                    self.radiance[walker.path] += weight * walker.throughput * met.radiance;
                }
                Finish::Reflects(cover) if go_on => self.spots.add(scene, hit, &ray, scene.cover(cover), j),
                Finish::Reflects(_) => {}
            }
        }
        self.spots.sort();
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

    /// `f_r L cos_theta / (p_light + p_brdf)` of one draw towards the lights from every spot; without `p_brdf` if lights
    /// stand alone.
    #[inline(always)]
    fn ask<S: Simd>(&mut self, simd: S) {
        let (scene, estimator) = (self.scene, self.options.estimator);
        self.lamplight.clear();
        let asks = estimator != Estimator::Brdf;
        for i in 0..self.spots.len() {
            let spot = self.spots.get(i);
            let stream = &mut self.streams[self.now.walkers[spot.ray].path];
            let (seen, u) = (spot.place.seen, stream.pair());
            if asks && !spot.coat.is_delta() {
                let at = Asking { point: spot.place.point, normal: spot.place.z };
                self.lamplight.push(i, &at, stream.pair());
            }
            self.spots.seen.push(seen);
            self.spots.u.push(u);
        }
        self.lamplight.draw(simd, &scene.lights);
        self.shadows.rays.clear();
        self.pairs.clear();
        self.lit.clear();
        for m in 0..self.lamplight.len() {
            let (i, total, sample) = self.lamplight.take(m);
            self.spots.totals[i] = total;
            let Some(light) = sample else { continue };
            let place = &self.spots.get(i).place;
            let wo = place.to_local(light.direction);
            // A lamp whose light is dark here is not asked for its shadow.
            if wo.z <= 0.0 || light.radiance == DVec3::ZERO || !place.leaves(light.direction) {
                continue;
            }
            self.pairs.push(i, place.seen, wo);
            self.lit.push(Lit { ask: m, cos_theta: wo.z });
        }
        evaluate(&self.spots, &mut self.pairs);
        self.bright.clear();
        for (lit, (&i, &(f_r, pdf))) in self.lit.iter().zip(self.pairs.spots.iter().zip(&self.pairs.found)) {
            // The BRDF is cheaper than the shadow ray, and a narrow lobe is 0 almost everywhere.
            if f_r == DVec3::ZERO {
                continue;
            }
            let spot = self.spots.get(i);
            let rival = match estimator {
                Estimator::Lights => 0.0,
                Estimator::Uniform => spot.coat.uniform_pdf(),
                _ => pdf,
            };
            let walker = &self.now.walkers[spot.ray];
            let Some(sample) = self.lamplight.take(lit.ask).2 else { continue };
            let light = sample.radiance * (f_r * spot.coat.tint()) * (lit.cos_theta / (sample.pdf + rival));
            self.bright.push((walker.path, walker.throughput * light));
            let ray = Ray { origin: spot.place.point, direction: sample.direction };
            self.shadows.push(&ray, spot.place.id, sample.distance, sample.id);
        }
        scene.block(simd, &self.shadows, &mut self.blocked);
        for (&(path, light), blocked) in self.bright.iter().zip(&self.blocked) {
            if !blocked {
                self.radiance[path] += light;
            }
        }
    }

    /// Draws the next direction at every spot.
    #[inline(always)]
    fn turn(&mut self, reflection: u32) {
        self.next.rays.clear();
        self.next.walkers.clear();
        self.draws.clear();
        self.draws.resize(self.spots.len(), None);
        self.pairs.clear();
        for group in 0..self.spots.groups() {
            let range = self.spots.range(group);
            if range.is_empty() {
                continue;
            }
            let coat = self.spots.get(range.start).coat;
            if self.options.estimator == Estimator::Uniform {
                for i in range {
                    let seen = self.spots.seen[i];
                    match coat.uniform_direction(self.spots.u[i]) {
                        Some(wo) => self.pairs.push(i, seen, wo),
                        None => self.follow(i, coat.core_draw(seen), reflection),
                    }
                }
            } else if let Some(brdf) = coat.grey() {
                let (seen, u) = (&self.spots.seen[range.clone()], &self.spots.u[range.clone()]);
                brdf.sample_many(seen, u, &mut self.draws[range.clone()]);
                for i in range {
                    if let Some(draw) = self.draws[i] {
                        self.follow(i, draw.into(), reflection);
                    }
                }
            } else {
                for i in range {
                    if let Some(draw) = coat.sample(self.spots.seen[i], self.spots.u[i]) {
                        self.follow(i, draw, reflection);
                    }
                }
            }
        }
        evaluate(&self.spots, &mut self.pairs);
        for k in 0..self.pairs.spots.len() {
            let (i, (f_r, _), wo) = (self.pairs.spots[k], self.pairs.found[k], self.pairs.wo[k]);
            let pdf = self.spots.get(i).coat.uniform_pdf();
            self.follow(i, ColourDraw { wo, weight: f_r * (wo.z / pdf), pdf, specular: false }, reflection);
        }
    }

    /// Sends a path on along `draw`, whose weight is without tint, if there is anything left of it.
    #[inline(always)]
    fn follow(&mut self, i: usize, draw: ColourDraw, reflection: u32) {
        let spot = self.spots.get(i);
        let walker = &self.now.walkers[spot.ray];
        let mut throughput = walker.throughput * (draw.weight * spot.coat.tint());
        if throughput == DVec3::ZERO {
            return;
        }
        let first_weight = if reflection == 0 { throughput.max_element() } else { walker.first_weight };
        if reflection >= SURE_REFLECTIONS {
            // Measured by what was left after the first reflection: dim surfaces deserve long paths too.
            let survival = (throughput.max_element() / first_weight).min(1.0);
            if self.streams[walker.path].lonely() >= survival {
                return;
            }
            throughput /= survival;
        }
        let direction = spot.place.to_world(draw.wo);
        if !spot.place.leaves(direction) {
            return;
        }
        let drawn = Drawn { pdf: draw.pdf, normal: spot.place.z, total: self.spots.totals[i] };
        self.next.rays.push(&Ray { origin: spot.place.point, direction }, Some(spot.place.id));
        let drawn = (!draw.specular).then_some(drawn);
        self.next.walkers.push(Walker { path: walker.path, throughput, first_weight, drawn });
    }
}

/// Asks the reflectors of the spots, which are in order of materials, for `f_r` without tint and the density of their draws.
#[inline(always)]
fn evaluate(spots: &Spots, pairs: &mut Pairs) {
    pairs.found.clear();
    pairs.found.resize(pairs.wi.len(), (DVec3::ZERO, 0.0));
    let group = |i: usize| spots.get(i).coat.group();
    let mut from = 0;
    for run in pairs.spots.chunk_by(|&a, &b| group(a) == group(b)) {
        let range = from..from + run.len();
        let coat: &Coat = &spots.get(run[0]).coat;
        coat.evaluate(&pairs.wi[range.clone()], &pairs.wo[range.clone()], &mut pairs.found[range.clone()]);
        from = range.end;
    }
}
