//! The next directions of the paths of a wave.

use super::super::integrator::Estimator;
use super::super::material::Coat;
use super::super::rays::{Column, LANES, WAVE, load};
use super::super::shape::Ray;
use super::super::spectral::ColourDraw;
use super::{Drawn, Walker, Wave};
use crate::math::frame::{DVec3, sin_cos_turns};
use crate::model::lambert::cosine_direction;
use fearless_simd::Simd;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

/// Reflections before Russian roulette may end a path.
pub(super) const SURE_REFLECTIONS: u32 = 3;

/// The next directions in the frames of the spots.
pub(super) struct Turns {
    wo: [Column<f64>; 3],
    /// `f_r cos_theta / pdf` without tint; 0 where nothing goes on.
    weight: Column<DVec3>,
    /// Infinite for the specular core.
    pdf: Column<f64>,
}

impl Default for Turns {
    fn default() -> Self {
        Turns { wo: [[0.0; WAVE]; 3], weight: [DVec3::ZERO; WAVE], pdf: [0.0; WAVE] }
    }
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

impl Wave<'_> {
    /// Draws the next direction at every spot.
    #[inline(always)]
    pub(super) fn turn<S: Simd>(&mut self, simd: S) {
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
        self.pairs.evaluate(&self.spots);
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
    pub(super) fn go_on<S: Simd>(&mut self, simd: S, reflection: u32) {
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
        let walker = &self.now.walkers[self.spots.ray[i] as usize];
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
        self.next.rays.push(&Ray { origin: point, direction }, Some(self.spots.id[i]), self.spots.solid[i]);
        let drawn = (pdf < f64::INFINITY).then_some(drawn);
        self.next.walkers.push(Walker { path: walker.path, throughput, first_weight, drawn });
    }
}
