//! Gaussian surfaces against `F D G / (4 cos cos)` with Smith's height-correlated masking and shadowing (Heitz 2014).

use super::{gaussian, rescale, with_walk};
use asperity::heightmap::HeightMap;
use asperity::math::{Estimate, direction, half_vector};
use asperity::optics::{Material, fresnel};
use asperity::scatter::detectors::{Bounds, Rings};
use asperity::scatter::facet_sum::{Azimuth, facet_sum};
use asperity::scatter::{Detectors, Selection};
use glam::DVec3;
use std::f64::consts::PI;

const MAPS: u64 = 6;
const N: f64 = 1.5;

fn lambda(cos: f64, alpha: f64) -> f64 {
    let v = cos / (1.0 - cos * cos).max(1e-30).sqrt() / alpha;
    (libm::erf(v) - 1.0) / 2.0 + (-v * v).exp() / (2.0 * v * PI.sqrt())
}

fn formula(wi: DVec3, wo: DVec3, alpha: f64) -> f64 {
    let wh = half_vector(wi, wo);
    let tan2 = (1.0 - wh.z * wh.z) / (wh.z * wh.z);
    let d = (-tan2 / (alpha * alpha)).exp() / (PI * alpha * alpha * wh.z.powi(4));
    let g = 1.0 / (1.0 + lambda(wi.z, alpha) + lambda(wo.z, alpha));
    fresnel::dielectric(wh.dot(wi), N) * d * g / (4.0 * wi.z * wo.z)
}

/// The formula's mean over a detector, weighted by the cosine as the detector weighs it.
fn over_detector(b: Bounds, wi: DVec3, alpha: f64) -> f64 {
    const N: usize = 12;
    let (mut energy, mut omega) = (0.0, 0.0);
    for i in 0..N {
        // Midpoints of equal projected solid angle.
        let sine2 = b.theta.map(|t| t.sin().powi(2));
        let theta_r = (sine2[0] + (i as f64 + 0.5) / N as f64 * (sine2[1] - sine2[0])).sqrt().asin();
        for j in 0..N {
            let phi_r = b.phi[0] + (j as f64 + 0.5) / N as f64 * (b.phi[1] - b.phi[0]);
            energy += formula(wi, direction(theta_r, phi_r), alpha);
            omega += 1.0;
        }
    }
    energy / omega
}

/// Within 2 % of the lobe's peak. At alpha 0.3 Smith's formula itself is off where light leaves at 75 deg in the plane of
/// incidence: 2.5 % at 45 deg and 2.7 % at 60 deg here, 2.2 +- 0.5 % and 1.9 +- 0.4 % on maps with three times finer pitch.
#[test]
fn gaussian_surfaces_follow_the_microfacet_formula() {
    let mut maps: Vec<HeightMap> = (0..MAPS).map(|seed| gaussian(768, 8.0, 0.1, 60 + seed)).collect();
    let mut deviations = Vec::new();
    // Detectors about half a lobe deviation wide: in direction cosines the lobe has twice the slope's.
    for (alpha, count) in [(0.05f64, 2500), (0.14, 400), (0.3, 150)] {
        let slope = alpha / 2f64.sqrt();
        maps.iter_mut().for_each(|map| rescale(map, slope));
        let detectors = Rings::equal_area(count).unwrap();
        for theta_i in [20.0f64, 45.0, 60.0, 75.0] {
            let wi = direction(theta_i.to_radians(), 0.0);
            let per_map: Vec<Vec<f64>> = maps
                .iter()
                .map(|map| {
                    with_walk(map, Material::Dielectric { n: N }, 8, |walk| {
                        let lit = Selection::default();
                        let tally = facet_sum(walk, &detectors, theta_i.to_radians(), Azimuth::Averaged, &lit).tally();
                        // The formula knows single bounces only.
                        tally.by_bounce.iter().map(|e| e[0] / tally.incident).collect()
                    })
                })
                .collect();
            let (mut peak, mut noise) = (0.0f64, 0.0f64);
            let mut worst = (0.0f64, 0.0, 0.0);
            for k in 0..count {
                let b = detectors.bounds(k);
                // Both sides of the plane of incidence are alike.
                let middle = direction(0.5 * (b.theta[0] + b.theta[1]), -0.5 * (b.phi[0] + b.phi[1]));
                let twin = detectors.index(wi, middle);
                let omega = detectors.projected_solid_angle(k, wi);
                let values: Vec<f64> = per_map.iter().map(|m| 0.5 * (m[k] + m[twin]) / omega).collect();
                let (measured, expected) = (Estimate::from_repeats(&values), over_detector(b, wi, alpha));
                peak = peak.max(expected);
                noise = noise.max(measured.standard_error);
                let off = measured.value - expected;
                if off.abs() > worst.0.abs() {
                    worst = (off, middle.z.acos().to_degrees(), asperity::math::frame::phi(middle).to_degrees());
                }
            }
            println!(
                "alpha {alpha} at {theta_i} deg: peak {peak:.4} /sr, largest deviation {:.2} % of it at theta_r {:.1}, phi_r {:.1} \
                 deg; map-to-map error up to {:.2} %",
                100.0 * worst.0 / peak,
                worst.1,
                worst.2,
                100.0 * noise / peak
            );
            deviations.push((worst.0.abs() / peak, format!("alpha {alpha} at {theta_i} deg")));
        }
    }
    for (share, what) in deviations {
        let tolerance = if what.starts_with("alpha 0.3") { 0.03 } else { 0.02 };
        assert!(share < tolerance, "{what}: {share} of the peak");
    }
}
