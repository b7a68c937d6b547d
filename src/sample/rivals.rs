//! Other ways to draw from a table, for comparison: same `f_r`, other densities.

use super::table_brdf::TableBrdf;
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// `pdf = cos_theta_r / pi`, whatever the lobe.
pub struct CosineSampled<'a>(pub &'a dyn Brdf);

/// `pdf = 1 / (2 pi)`.
pub struct UniformSampled<'a>(pub &'a dyn Brdf);

/// The specular core takes this share of the draws when there is one.
const CORE: f64 = 0.5;

/// A draw of the core or of `other`, both with probability 1/2 if there is a core.
fn with_core(brdf: &dyn Brdf, wi: DVec3, u: [f64; 2], other: impl Fn([f64; 2]) -> (DVec3, f64)) -> Option<BrdfSample> {
    if !(wi.z > 0.0) {
        return None;
    }
    let core = brdf.specular_core(wi);
    let (mut u, mut share) = (u, 1.0);
    if core > 0.0 {
        if u[1] < CORE {
            let wo = DVec3::new(-wi.x, -wi.y, wi.z);
            return Some(BrdfSample { wo, weight: core / CORE, pdf: f64::INFINITY, specular: true });
        }
        u[1] = (u[1] - CORE) / (1.0 - CORE);
        share = 1.0 - CORE;
    }
    let (wo, pdf) = other(u);
    let pdf = pdf * share;
    (wo.z > 0.0).then(|| BrdfSample { wo, weight: brdf.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
}

fn share(brdf: &dyn Brdf, wi: DVec3, wo: DVec3) -> f64 {
    match (wi.z > 0.0 && wo.z > 0.0, brdf.specular_core(wi) > 0.0) {
        (false, _) => 0.0,
        (true, true) => 1.0 - CORE,
        (true, false) => 1.0,
    }
}

macro_rules! same_reflection {
    () => {
        fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
            self.0.eval(wi, wo)
        }

        fn albedo(&self, theta_i: f64) -> f64 {
            self.0.albedo(theta_i)
        }

        fn albedo_towards(&self, wi: DVec3) -> f64 {
            self.0.albedo_towards(wi)
        }

        fn specular_core(&self, wi: DVec3) -> f64 {
            self.0.specular_core(wi)
        }
    };
}

impl Brdf for CosineSampled<'_> {
    same_reflection!();

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        with_core(self.0, wi, u, |u| {
            let (sin, cos) = (TAU * u[1]).sin_cos();
            let (r, z) = (u[0].sqrt(), (1.0 - u[0]).sqrt());
            (DVec3::new(r * cos, r * sin, z), z / PI)
        })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        share(self.0, wi, wo) * wo.z / PI
    }
}

impl Brdf for UniformSampled<'_> {
    same_reflection!();

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        with_core(self.0, wi, u, |u| {
            let (sin, cos) = (TAU * u[1]).sin_cos();
            let (z, r) = (1.0 - u[0], (u[0] * (2.0 - u[0])).sqrt());
            (DVec3::new(r * cos, r * sin, z), 1.0 / TAU)
        })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        share(self.0, wi, wo) / TAU
    }
}

/// Inversion of the cumulative weights by binary search, over the same cells and hats as the alias tables: the same
/// density, one node at a time, found in `log2(cells)` steps.
pub struct CumulativeSampled<'a> {
    brdf: &'a TableBrdf,
    /// Cumulative probabilities per node.
    cumulative: Vec<Vec<f64>>,
}

impl<'a> CumulativeSampled<'a> {
    /// The cumulative sums of every node.
    pub fn new(brdf: &'a TableBrdf) -> Self {
        let nodes = brdf.table().theta_i().len() * brdf.table().phi_i().len();
        let cumulative = (0..nodes)
            .map(|node| {
                let mut sum = 0.0;
                let probabilities = brdf.alias(node).map(|alias| alias.probabilities()).unwrap_or_default();
                probabilities
                    .into_iter()
                    .map(|p| {
                        sum += p;
                        sum
                    })
                    .collect()
            })
            .collect();
        CumulativeSampled { brdf, cumulative }
    }
}

impl Brdf for CumulativeSampled<'_> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.brdf.eval(wi, wo)
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.brdf.albedo(theta_i)
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        self.brdf.albedo_towards(wi)
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.brdf.specular_core(wi)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.brdf.pdf(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        self.brdf.sample_by(wi, u, |node, u| {
            let cumulative = &self.cumulative[node];
            let cell = cumulative.partition_point(|&c| c <= u).min(cumulative.len().checked_sub(1)?);
            let below = if cell == 0 { 0.0 } else { cumulative[cell - 1] };
            let left = ((u - below) / (cumulative[cell] - below)).clamp(0.0, 1.0);
            let place = self.brdf.table().cells().column_and_row(cell);
            Some((place.map(|k| k as u16), left as f32))
        })
    }
}
