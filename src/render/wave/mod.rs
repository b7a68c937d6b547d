//! Paths by the wave: all of them meet their next surface, ask for light and turn together.
//!
//! One path after the other waits for every root and every lookup of its own. A wave takes each step for all of its paths
//! before the next one: rays against shapes and lamps in lanes, draws and BRDFs by the run, material by material.

mod lamplight;
#[cfg(test)]
mod one_by_one;
mod spots;

use super::integrator::{Estimator, RenderOptions};
use super::material::Coat;
use super::rays::{Column, LANES, Rays, Shadows, WAVE, load};
use super::reach::Asking;
use super::scene::{Finish, Hit, Scene};
use super::shape::Ray;
use super::spectral::ColourDraw;
use super::stream::PathStream;
use crate::math::frame::{DVec3, sin_cos_turns};
use crate::model::lambert::cosine_direction;
use crate::optics::BrdfSample;
use fearless_simd::{Simd, f64x8, prelude::*};
use lamplight::Lamplight;
use spots::Spots;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

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
    pairs: Pairs,
    /// Numbers of the draws in the BRDFs.
    u: Vec<[f64; 2]>,
    draws: Vec<Option<BrdfSample>>,
    turns: Turns,
    /// Radiance that each shadow ray stands for, and its path.
    bright: Vec<(usize, DVec3)>,
}

/// The next directions in the frames of the spots.
struct Turns {
    wo: [Column<f64>; 3],
    /// `f_r cos_theta / pdf` without tint; 0 where nothing goes on.
    weight: Column<DVec3>,
    /// Infinite for the specular core.
    pdf: Column<f64>,
}

impl Turns {
    #[inline(always)]
    fn set(&mut self, i: usize, draw: &ColourDraw) {
        for axis in 0..3 {
            self.wo[axis][i] = draw.wo[axis];
        }
        self.weight[i] = draw.weight;
        self.pdf[i] = if draw.specular { f64::INFINITY } else { draw.pdf };
    }

    #[inline(always)]
    fn wo(&self, i: usize) -> DVec3 {
        DVec3::new(self.wo[0][i], self.wo[1][i], self.wo[2][i])
    }
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
            pairs: Pairs::default(),
            u: vec![[0.0; 2]; WAVE],
            draws: Vec::with_capacity(WAVE),
            turns: Turns { wo: [[0.0; WAVE]; 3], weight: [DVec3::ZERO; WAVE], pdf: [0.0; WAVE] },
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
                    self.next.rays.push(&self.now.rays.get(j), self.now.rays.leaving(j));
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
                Finish::Reflects(cover) if go_on => {
                    let point = || ray.at(hit.t);
                    let (coat, tint) =
                        scene.cover(cover).at(|| scene.uv(hit, point()), || scene.place_in(hit, point()));
                    self.spots.add(j, coat, tint);
                }
                Finish::Reflects(_) => {}
            }
        }
        self.spots.arrange(simd, scene, &self.now.rays, &self.hits);
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
        let (scene, count) = (self.scene, self.spots.len());
        let asks = self.options.estimator != Estimator::Brdf;
        for i in 0..count {
            let stream = &mut self.streams[self.now.walkers[self.spots.ray[i]].path];
            self.u[i] = stream.pair();
            let asks = asks && !self.spots.coat[i].is_delta();
            self.lamplight.set(i, asks.then(|| stream.pair()));
        }
        if !asks || count == 0 {
            return;
        }
        self.lamplight.draw(simd, &scene.lights, &self.spots.point, &self.spots.z, count);
        self.shadows.rays.clear();
        self.pairs.clear();
        self.bright.clear();
        for from in (0..count).step_by(LANES) {
            let direction = load(simd, &self.lamplight.direction, from);
            let wo = self.spots.to_local(simd, from, &direction);
            let pdf = f64x8::from_slice(simd, &self.lamplight.pdf[from..from + LANES]);
            let zero = f64x8::splat(simd, 0.0);
            let lit = (pdf.simd_gt(zero) & wo[2].simd_gt(zero)).to_bitmask();
            let wo = wo.map(<[f64; LANES]>::from);
            let mut lit = lit & self.spots.leaving(simd, from, &direction);
            while lit != 0 {
                let lane = lit.trailing_zeros() as usize;
                lit &= lit - 1;
                let i = from + lane;
                let (wo, seen) = (DVec3::new(wo[0][lane], wo[1][lane], wo[2][lane]), self.spots.seen[i]);
                // Where the light is dark nothing need be asked, nor whether it is hidden.
                if self.lamplight.radiance[i] == DVec3::ZERO {
                    continue;
                }
                match self.spots.coat[i].matt() {
                    Some(rho) if seen.z > 0.0 => {
                        self.send(i, DVec3::splat(rho * FRAC_1_PI), wo.z, wo.z * FRAC_1_PI);
                    }
                    _ => self.pairs.push(i, seen, wo),
                }
            }
        }
        evaluate(&self.spots, &mut self.pairs);
        for k in 0..self.pairs.spots.len() {
            let (f_r, pdf) = self.pairs.found[k];
            self.send(self.pairs.spots[k], f_r, self.pairs.wo[k].z, pdf);
        }
        scene.block(simd, &self.shadows, &mut self.blocked);
        for (&(path, light), blocked) in self.bright.iter().zip(&self.blocked) {
            if !blocked {
                self.radiance[path] += light;
            }
        }
    }

    /// Sends a shadow ray for the light drawn at a spot, of which the BRDF reflects `f_r` and which it would draw itself
    /// with density `pdf`.
    #[inline(always)]
    fn send(&mut self, i: usize, f_r: DVec3, cos_theta: f64, pdf: f64) {
        // The BRDF is cheaper than the shadow ray, and a narrow lobe is 0 almost everywhere.
        if f_r == DVec3::ZERO {
            return;
        }
        let rival = match self.options.estimator {
            Estimator::Lights => 0.0,
            Estimator::Uniform => self.spots.coat[i].uniform_pdf(),
            _ => pdf,
        };
        let lamp = &self.lamplight;
        let walker = &self.now.walkers[self.spots.ray[i]];
        let light = lamp.radiance[i] * (f_r * self.spots.tint[i]) * (cos_theta / (lamp.pdf[i] + rival));
        self.bright.push((walker.path, walker.throughput * light));
        let direction = DVec3::new(lamp.direction[0][i], lamp.direction[1][i], lamp.direction[2][i]);
        let ray = Ray { origin: self.spots.at(i).0, direction };
        self.shadows.push(&ray, self.spots.id[i], lamp.distance[i], lamp.target[i]);
    }

    /// Draws the next direction at every spot.
    #[inline(always)]
    fn turn<S: Simd>(&mut self, simd: S) {
        let count = self.spots.len();
        let uniform = self.options.estimator == Estimator::Uniform;
        if uniform || self.spots.coat.iter().any(|coat| coat.matt().is_some()) {
            for from in (0..count).step_by(LANES) {
                self.hemisphere(simd, from, uniform);
            }
        }
        self.pairs.clear();
        for group in 0..self.spots.groups() {
            let range = self.spots.range(group);
            if range.is_empty() {
                continue;
            }
            let coat = self.spots.coat[range.start];
            if uniform {
                self.turn_uniformly(coat, range);
            } else if let Some(rho) = coat.matt() {
                for i in range {
                    let lives = self.spots.seen[i].z > 0.0 && self.turns.wo[2][i] > 0.0;
                    self.turns.weight[i] = DVec3::splat(if lives { rho } else { 0.0 });
                    self.turns.pdf[i] = self.turns.wo[2][i] * FRAC_1_PI;
                }
            } else if let Some(brdf) = coat.grey() {
                self.draws.clear();
                self.draws.resize(range.len(), None);
                brdf.sample_many(&self.spots.seen[range.clone()], &self.u[range.clone()], &mut self.draws);
                for (draw, i) in self.draws.iter().zip(range) {
                    match draw {
                        Some(draw) => self.turns.set(i, &(*draw).into()),
                        None => self.turns.weight[i] = DVec3::ZERO,
                    }
                }
            } else {
                for i in range {
                    match coat.sample(self.spots.seen[i], self.u[i]) {
                        Some(draw) => self.turns.set(i, &draw),
                        None => self.turns.weight[i] = DVec3::ZERO,
                    }
                }
            }
        }
        evaluate(&self.spots, &mut self.pairs);
        for k in 0..self.pairs.spots.len() {
            let i = self.pairs.spots[k];
            self.turns.weight[i] = self.pairs.found[k].0 * (self.pairs.wo[k].z / self.turns.pdf[i]);
        }
    }

    /// Directions by the cosine, as [`cosine_direction`] has them, or uniform over the hemisphere beside a share for the core.
    #[inline(always)]
    fn hemisphere<S: Simd>(&mut self, _: S, from: usize, uniform: bool) {
        let (mut first, mut second, mut share) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            [first[l], second[l]] = self.u[from + l];
        }
        if uniform {
            for (share, coat) in share.iter_mut().zip(&self.spots.coat[from..]) {
                *share = coat.core_share();
            }
        }
        let mut wo = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let direction = if uniform {
                let z = ((first[l] - share[l]) / (1.0 - share[l])).max(0.0);
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let (s, c) = sin_cos_turns(second[l]);
                DVec3::new(radius * c, radius * s, z)
            } else {
                cosine_direction([first[l], second[l]])
            };
            (wo[0][l], wo[1][l], wo[2][l]) = (direction.x, direction.y, direction.z);
        }
        for axis in 0..3 {
            self.turns.wo[axis][from..from + LANES].copy_from_slice(&wo[axis]);
        }
    }

    /// Weights of directions uniform over the hemisphere, for one material.
    #[inline(always)]
    fn turn_uniformly(&mut self, coat: &Coat, range: Range<usize>) {
        let (share, pdf) = (coat.core_share(), coat.uniform_pdf());
        for i in range {
            let seen = self.spots.seen[i];
            self.turns.pdf[i] = pdf;
            if self.u[i][0] < share {
                self.turns.set(i, &coat.core_draw(seen));
            } else if let Some(rho) = coat.matt() {
                let lives = seen.z > 0.0;
                let f_r = if lives { rho * FRAC_1_PI } else { 0.0 };
                self.turns.weight[i] = DVec3::splat(f_r * (self.turns.wo[2][i] / pdf));
            } else {
                self.pairs.push(i, seen, self.turns.wo(i));
            }
        }
    }

    /// Sends the paths on of which there is anything left.
    #[inline(always)]
    fn go_on<S: Simd>(&mut self, simd: S, reflection: u32) {
        self.next.rays.clear();
        self.next.walkers.clear();
        for from in (0..self.spots.len()).step_by(LANES) {
            let wo = load(simd, &self.turns.wo, from);
            let direction = self.spots.to_world(simd, from, &wo);
            let mut leaving = self.spots.leaving(simd, from, &direction);
            let direction = direction.map(<[f64; LANES]>::from);
            while leaving != 0 {
                let lane = leaving.trailing_zeros() as usize;
                leaving &= leaving - 1;
                let direction = DVec3::new(direction[0][lane], direction[1][lane], direction[2][lane]);
                self.follow(from + lane, direction, reflection);
            }
        }
    }

    #[inline(always)]
    fn follow(&mut self, i: usize, direction: DVec3, reflection: u32) {
        let walker = &self.now.walkers[self.spots.ray[i]];
        let mut throughput = walker.throughput * (self.turns.weight[i] * self.spots.tint[i]);
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
        let (point, normal) = self.spots.at(i);
        let pdf = self.turns.pdf[i];
        let drawn = Drawn { pdf, normal, total: self.lamplight.picks[i].total };
        self.next.rays.push(&Ray { origin: point, direction }, Some(self.spots.id[i]));
        let drawn = (pdf < f64::INFINITY).then_some(drawn);
        self.next.walkers.push(Walker { path: walker.path, throughput, first_weight, drawn });
    }
}

/// Asks the reflectors of the spots, which are in order of materials, for `f_r` without tint and the density of their draws.
#[inline(always)]
fn evaluate(spots: &Spots, pairs: &mut Pairs) {
    pairs.found.clear();
    pairs.found.resize(pairs.wi.len(), (DVec3::ZERO, 0.0));
    let mut from = 0;
    for run in pairs.spots.chunk_by(|&a, &b| spots.coat[a].group() == spots.coat[b].group()) {
        let range = from..from + run.len();
        let coat = spots.coat[run[0]];
        coat.evaluate(&pairs.wi[range.clone()], &pairs.wo[range.clone()], &mut pairs.found[range.clone()]);
        from = range.end;
    }
}
