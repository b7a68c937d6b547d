//! Drawing directions: what a lobe mirrors of a bright patch, by alias tables and their rivals.

use super::contests::Subject;
use super::race::{Contest, Method, Outcome, Reference};
use crate::error::Result;
use crate::math::frame::DVec3;
use crate::math::random::CounterRng;
use crate::math::{direction, reflect};
use crate::optics::Brdf;
use crate::sample::TableBrdf;
use crate::sample::rivals::{CosineSampled, CumulativeSampled, UniformSampled};
use std::sync::Arc;

const THETA_I: f64 = std::f64::consts::FRAC_PI_4;
/// Steps of the reference quadrature in polar and in azimuthal angle of the patch.
const STEPS: usize = 600;
/// Radius of the patch in rms widths of the lobe.
const WIDTHS: f64 = 1.5;

/// `integral of f_r cos(theta_r) dw` over the cone of half angle `radius` about the mirror direction, by midpoints.
fn quadrature(brdf: &dyn Brdf, wi: DVec3, radius: f64) -> f64 {
    let z = reflect(wi, DVec3::Z);
    let x = z.any_orthonormal_vector();
    let y = z.cross(x);
    let (dr, dphi) = (radius / STEPS as f64, std::f64::consts::TAU / STEPS as f64);
    let ring = |i: usize| {
        let r = (i as f64 + 0.5) * dr;
        let at = |j: usize| {
            let phi = (j as f64 + 0.5) * dphi;
            let wo = z * r.cos() + (x * phi.cos() + y * phi.sin()) * r.sin();
            brdf.eval(wi, wo) * wo.z.max(0.0)
        };
        (0..STEPS).map(at).sum::<f64>() * r.sin()
    };
    (0..STEPS).map(ring).sum::<f64>() * dr * dphi
}

/// Mean of what draws bring of a patch of radiance 1.
fn drawn(brdf: &dyn Brdf, wi: DVec3, cos: f64, draws: u64, seed: u64) -> f64 {
    let centre = reflect(wi, DVec3::Z);
    let mut rng = CounterRng::new(seed, 11, draws);
    let mut sum = 0.0;
    for _ in 0..draws {
        let sample = brdf.sample(wi, [rng.uniform(), rng.uniform()]);
        sum += sample.map_or(0.0, |s| if s.wo.dot(centre) > cos { s.weight } else { 0.0 });
    }
    sum / draws as f64
}

/// All methods draw from the same table; a draw that is more even about the lobe has less noise.
pub fn contest<'a>(subject: &'a Subject<'a>, table: &'a TableBrdf) -> Result<Contest<'a>> {
    let statistics = crate::facets::SlopeStatistics::measure(subject.map)?;
    let wi = direction(THETA_I, 0.0);
    // Out of the plane of incidence a lobe is 2 cos(theta_i) rms slopes wide, in it 2.
    let radius = (WIDTHS * 2.0 * statistics.core).min(0.5);
    let truth = quadrature(table, wi, radius);
    let cumulative = Arc::new(CumulativeSampled::new(table));
    let ladder = || (2..=7).map(|e| 10f64.powi(e)).collect::<Vec<_>>();
    let cos = radius.cos();
    let by = |name: &str, chosen: Option<f64>, brdf: Arc<dyn Brdf + 'a>| Method {
        name: name.to_owned(),
        ladder: ladder(),
        chosen,
        random: true,
        reference: 0,
        run: Box::new(move |draws: f64, seed| Ok(Outcome::from(vec![drawn(brdf.as_ref(), wi, cos, draws as u64, seed)])))
            as super::race::Run<'a>,
    };
    struct Alias<'a>(&'a TableBrdf);
    impl Brdf for Alias<'_> {
        fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
            self.0.eval(wi, wo)
        }
        fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<crate::optics::brdf::Sample> {
            self.0.sample(wi, u)
        }
        fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
            self.0.pdf(wi, wo)
        }
        fn albedo(&self, theta_i: f64) -> f64 {
            self.0.albedo(theta_i)
        }
    }
    Ok(Contest {
        key: "sampling",
        title: format!("Drawing from a table: a patch of {:.1}\u{b0} in the lobe at 45\u{b0}", radius.to_degrees()),
        error: "relative error of the reflected radiance",
        effort: "draws",
        size: None,
        references: vec![Reference { name: "midpoint quadrature of the table".into(), values: vec![truth], noise: 0.0 }],
        methods: vec![
            by("alias table", None, Arc::new(Alias(table))),
            by("cumulative inversion", None, cumulative),
            by("cosine", None, Arc::new(CosineSampled(table))),
            by("uniform", None, Arc::new(UniformSampled(table))),
        ],
        distance: |a, b| (a[0] / b[0] - 1.0).abs(),
    })
}
