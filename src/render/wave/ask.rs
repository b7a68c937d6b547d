//! Light straight from the lamps at every spot of a wave.

use super::super::integrator::Estimator;
use super::super::rays::{LANES, load};
use super::super::shape::Ray;
use super::Wave;
use crate::math::frame::DVec3;
use fearless_simd::{Simd, f64x8, prelude::*};
use std::f64::consts::FRAC_1_PI;

impl Wave<'_> {
    /// `f_r L cos_theta / (p_light + p_brdf)` of one draw towards the lights from every spot; without `p_brdf` if lights
    /// stand alone.
    #[inline(always)]
    pub(super) fn ask<S: Simd>(&mut self, simd: S) {
        let (scene, count) = (self.scene, self.spots.len());
        let asks = self.options.estimator != Estimator::Brdf;
        for i in 0..count {
            let stream = &mut self.streams[self.now.walkers[self.spots.ray[i] as usize].path];
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
        self.pairs.evaluate(&self.spots);
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
        let walker = &self.now.walkers[self.spots.ray[i] as usize];
        let light = lamp.radiance[i] * (f_r * self.spots.tint[i]) * (cos_theta / (lamp.pdf[i] + rival));
        self.bright.push((walker.path, walker.throughput * light));
        let direction = DVec3::new(lamp.direction[0][i], lamp.direction[1][i], lamp.direction[2][i]);
        let ray = Ray { origin: self.spots.at(i).0, direction };
        let solids = [self.spots.solid[i], lamp.solid[i]];
        self.shadows.push(&ray, self.spots.id[i], lamp.distance[i], lamp.target[i], solids);
    }
}
