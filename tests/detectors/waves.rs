//! Waves counted into detectors: against Beckmann's series, against the table's way to the same detectors.

use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::math::{Estimate, direction, half_vector, reflect};
use asperity::optics::Material;
use asperity::scatter::detectors::{Bounds, Rings};
use asperity::scatter::kirchhoff::{beckmann_spizzichino, rayleigh_parameter};
use asperity::scatter::spread::spread;
use asperity::scatter::{
    Counting, Counts, Detectors, Footprint, Method, Options, Partition, Run, Symmetry, Wave, count, scatter,
};
use glam::DVec3;
use std::f64::consts::TAU;

const WAVELENGTH: f64 = 550e-9;
const GLASS: Material = Material::Dielectric { n: 1.5 };

fn gaussian(sq: f64, acl: f64, size: [usize; 2], seed: u64, edges: Edges) -> HeightMap {
    let grid = synth::Grid { width: size[0], height: size[1], pitch: [0.4e-6, 0.5e-6] };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: false }).unwrap();
    level::keep_tilt(&raw, edges)
}

fn waves(theta_i: f64, phi_i: f64) -> Options {
    Options {
        method: Method::Kirchhoff,
        material: GLASS,
        theta_i: vec![theta_i.to_radians()],
        phi_i: vec![phi_i],
        ..Options::default()
    }
}

fn counted(map: &HeightMap, options: &Options, partition: Partition, averaged: bool) -> Counts {
    let counts = count(map, options, &Counting { partition, averaged }, &mut Run::Whole, &|_| ()).unwrap();
    for d in &counts.directions {
        let book = d.tally.book();
        assert!((book.escaped + book.absorbed + book.lost - 1.0).abs() < 1e-9, "{book:?}");
        assert!(d.share.iter().all(|e| e.value >= 0.0 && e.value.is_finite() && e.standard_error.is_finite()));
        assert!((d.albedo.value - book.escaped).abs() < 1e-12);
    }
    counts
}

/// `integral over a detector of R cos^2(beta) S / (lambda^2 cos^2(theta_h) cos_theta_i) dw`, S Beckmann's series.
fn series(b: Bounds, wi: DVec3, sq: f64, acl: f64) -> f64 {
    const N: usize = 16;
    let k = TAU / WAVELENGTH;
    let sine2 = b.theta.map(|t| t.sin().powi(2));
    let mut sum = 0.0;
    for i in 0..N {
        let theta_r = (sine2[0] + (i as f64 + 0.5) / N as f64 * (sine2[1] - sine2[0])).sqrt().asin();
        for j in 0..N {
            let wo = direction(theta_r, b.phi[0] + (j as f64 + 0.5) / N as f64 * (b.phi[1] - b.phi[0]));
            let wh = half_vector(wi, wo);
            let v = k * (wi + wo);
            let s = beckmann_spizzichino((v.z * sq).powi(2), acl, v.x.hypot(v.y));
            let cos_beta = wh.dot(wi);
            sum += GLASS.reflectance(cos_beta) * cos_beta * cos_beta * s
                / (WAVELENGTH * WAVELENGTH * wh.z * wh.z * wi.z * wo.z);
        }
    }
    // Midpoints of equal projected solid angle: f_r times their share of it.
    sum / (N * N) as f64 * 0.5 * (sine2[1] - sine2[0]) * (b.phi[1] - b.phi[0])
}

/// Smooth, in between and rough, periodic and open; six maps each. Every detector within 4 standard errors of the maps, and
/// the error that one map claims is the scatter of the maps.
#[test]
fn gaussian_maps_fill_detectors_as_the_series_says() {
    let partition = Partition::EqualAngle { theta: 3f64.to_radians(), phi: 15f64.to_radians() };
    let rings = Rings::equal_angle(3f64.to_radians(), 15f64.to_radians()).unwrap();
    let mut ratios = Vec::new();
    for (sq, acl, theta_i, edges) in [
        (20e-9, 3e-6, 20.0f64, Edges::Periodic),
        (70e-9, 4e-6, 45.0, Edges::Open),
        (70e-9, 4e-6, 60.0, Edges::Periodic),
        (150e-9, 3e-6, 30.0, Edges::Open),
    ] {
        let wi = direction(theta_i.to_radians(), 0.0);
        let counts: Vec<Counts> = (0..6)
            .map(|seed| {
                let map = gaussian(sq, acl, [300, 256], seed + 1, edges);
                counted(&map, &waves(theta_i, 0.0), partition, false)
            })
            .collect();
        let beam = (-rayleigh_parameter(sq, theta_i.to_radians(), WAVELENGTH)).exp() * GLASS.reflectance(wi.z);
        let specular = rings.index(wi, reflect(wi, DVec3::Z));
        let (mut worst, mut total, mut claimed, mut found, mut tested) = (0.0f64, 0.0, 0.0, 0.0, 0);
        for k in 0..rings.len() {
            let e: Vec<Estimate> = counts.iter().map(|c| c.directions[0].share[k]).collect();
            let mean = Estimate::from_repeats(&e.iter().map(|e| e.value).collect::<Vec<_>>());
            let lobe = series(rings.bounds(k), wi, sq, acl);
            let wanted = lobe + if k == specular { beam } else { 0.0 };
            total += (mean.value - wanted).abs() / 2.0;
            if lobe < 1e-3 * GLASS.reflectance(wi.z) {
                continue;
            }
            tested += 1;
            // A window widens the lobe, at most by a hundredth.
            let off = (mean.value - wanted).abs() / (5.0 * mean.standard_error + 0.02 * wanted);
            worst = worst.max(off);
            assert!(off < 1.0, "{sq:e} at {theta_i} deg, {edges:?}, detector {k}: {mean:?}, series {wanted}");
            if k != specular {
                found += (mean.standard_error / lobe).powi(2) * 6.0;
                claimed += e.iter().map(|e| (e.standard_error / lobe).powi(2)).sum::<f64>() / 6.0;
            }
        }
        let ratio = (claimed / found).sqrt();
        println!(
            "Sq {:.0} nm at {theta_i} deg, {edges:?}: {tested} detectors, worst at {worst:.2} of the tolerance, total variation \
             {:.4} of the light, claimed errors {ratio:.2} times the scatter of the maps",
            sq * 1e9,
            total / GLASS.reflectance(wi.z)
        );
        assert!(tested >= 8 && total < 0.02 * GLASS.reflectance(wi.z), "{tested} {total}");
        ratios.push(ratio);
    }
    assert!(ratios.iter().all(|r| (0.7..1.5).contains(r)), "errors claimed are {ratios:?} times those found");
}

/// Through cells in the plane of the half vector, as a table goes, to the same detectors.
#[test]
fn detectors_agree_with_the_table() {
    let mut worst = [0.0f64; 2];
    for (sq, theta_i, phi_i, edges) in [(40e-9, 20.0, 0.6, Edges::Open), (150e-9, 65.0, 3.9, Edges::Periodic)] {
        let map = gaussian(sq, 4e-6, [320, 300], 3, edges);
        let options = Options { symmetry: Symmetry::Anisotropic, ..waves(theta_i, phi_i) };
        // A table of a wave has one azimuth, since nothing is traced.
        let table = scatter(&map, &Options { tolerance: 1e-3, ..options.clone() }, &|_| ()).unwrap();
        let wi = direction(theta_i.to_radians(), phi_i);
        let wave = table.wave.as_ref().unwrap();
        let mirror = table.tallies[0][0].core / GLASS.reflectance(wi.z);
        let hiding = table.statistics.hiding();
        let tally = wave.tally(&table.cells, wi, mirror / hiding.visible(wi.z, wi.z), &GLASS, &hiding);
        for partition in [
            Partition::Klems,
            Partition::EqualArea { count: 600 },
            Partition::EqualAngle { theta: 5f64.to_radians(), phi: 10f64.to_radians() },
            Partition::ShirleyChiu { k: 4 },
        ] {
            let counts = counted(&map, &options, partition, false);
            let d = &counts.directions[0];
            let by_table = spread(&tally.energy, tally.core, &table.cells, counts.detectors.as_ref(), wi, &GLASS);
            let all = d.albedo.value;
            let distance: f64 =
                0.5 * d.share.iter().zip(&by_table).map(|(a, b)| (a.value - b).abs()).sum::<f64>() / all;
            let albedo = by_table.iter().sum::<f64>() / all;
            println!("{:.0} nm at {theta_i} deg, {partition:?}: distance {distance:.5}, albedo {albedo:.5}", sq * 1e9);
            worst = [worst[0].max(distance), worst[1].max((albedo - 1.0).abs())];
        }
    }
    assert!(worst[0] < 0.005 && worst[1] < 3e-4, "{worst:?}");
}

/// A mean over azimuths of the source is what `averaged` gives in one go.
#[test]
fn averaged_is_the_mean_over_azimuths() {
    let map = gaussian(60e-9, 5e-6, [200, 260], 8, Edges::Open);
    let partition = Partition::EqualAngle { theta: 5f64.to_radians(), phi: 15f64.to_radians() };
    let turns = 24;
    let options =
        Options { phi_i: (0..turns).map(|k| TAU * f64::from(k) / f64::from(turns)).collect(), ..waves(35.0, 0.0) };
    let apart = counted(&map, &options, partition, false);
    let mut mean = vec![0.0; apart.detectors.len()];
    for d in &apart.directions {
        for (k, share) in d.share.iter().enumerate().filter(|s| s.1.value > 0.0) {
            // Detectors turn with the source: 15 deg is their step.
            let b = apart.detectors.bounds(k);
            let middle = direction(0.5 * (b.theta[0] + b.theta[1]), 0.5 * (b.phi[0] + b.phi[1]) - d.phi_i);
            mean[apart.detectors.index(DVec3::Z, middle)] += share.value / f64::from(turns);
        }
    }
    let together = counted(&map, &waves(35.0, 0.0), partition, true);
    let d = &together.directions[0];
    let distance: f64 = 0.5 * d.share.iter().zip(&mean).map(|(a, b)| (a.value - b).abs()).sum::<f64>() / d.albedo.value;
    assert!(distance < 0.01, "{distance}");
}

/// Detectors narrower than a bin, a wide source, a band of wavelengths: the light stays, and the beam follows the source.
#[test]
fn light_stays_whatever_the_detectors() {
    let map = gaussian(50e-9, 5e-6, [200, 160], 8, Edges::Open);
    let want = counted(&map, &waves(40.0, 0.0), Partition::EqualArea { count: 1 }, false).directions[0].albedo.value;
    for (partition, averaged) in [
        (Partition::EqualAngle { theta: 0.5f64.to_radians(), phi: 0.5f64.to_radians() }, false),
        (Partition::ShirleyChiu { k: 8 }, true),
        (Partition::HalfVector, false),
        (Partition::HalfVector, true),
    ] {
        let got = counted(&map, &waves(40.0, 0.0), partition, averaged).directions[0].albedo.value;
        assert!((got / want - 1.0).abs() < 2e-3, "{partition:?} {averaged}: {got} {want}");
    }
    let wave = Wave { band: 60e-9, source: 2f64.to_radians(), ..Wave::default() };
    let partition = Partition::EqualAngle { theta: 0.5f64.to_radians(), phi: 1f64.to_radians() };
    let point = counted(&map, &waves(40.0, 0.0), partition, false);
    let wide = counted(&map, &Options { wave, ..waves(40.0, 0.0) }, partition, false);
    let (a, b) = (&point.directions[0], &wide.directions[0]);
    assert!((a.albedo.value / b.albedo.value - 1.0).abs() < 0.01, "{:?} {:?}", a.albedo, b.albedo);
    let brightest = |c: &Counts| c.directions[0].share.iter().map(|e| e.value).fold(0.0, f64::max);
    // A quarter of the source's weight lies in its middle.
    assert!(brightest(&wide) < 0.3 * brightest(&point), "{} {}", brightest(&wide), brightest(&point));
}

/// A footprint is the middle of the map by itself, and the whole map as a footprint is the whole map but for its edges.
#[test]
fn a_footprint_lights_its_own_part() {
    let map = gaussian(60e-9, 5e-6, [260, 240], 2, Edges::Open);
    let footprint = Footprint { columns: [30, 200], rows: [40, 190] };
    let lit = Options { footprint: Some(footprint), ..waves(20.0, 0.3) };
    let cut = footprint.cut(&map);
    assert_eq!(cut.heights.dim(), (151, 171));
    assert_eq!(cut.heights[[3, 5]], map.heights[[43, 35]]);
    let [a, b] = [(&map, &lit), (&cut, &waves(20.0, 0.3))]
        .map(|(map, options)| counted(map, options, Partition::Klems, false).directions.remove(0));
    assert_eq!(a.share, b.share);
}

/// By default waves serve where rays do not hold, and each angle says why.
#[test]
fn auto_takes_waves_below_nine() {
    let map = gaussian(200e-9, 6e-6, [200, 160], 5, Edges::Open);
    let options = Options {
        theta_i: [20.0f64, 40.0, 60.0].map(f64::to_radians).to_vec(),
        phi_i: vec![0.0, 1.0],
        ..Options::default()
    };
    let counts = counted(&map, &options, Partition::Klems, false);
    assert_eq!(counts.decisions.iter().map(|d| d.wave).collect::<Vec<_>>(), [false, false, true]);
    let at: Vec<(f64, f64)> = counts.directions.iter().map(|d| (d.theta_i.to_degrees().round(), d.phi_i)).collect();
    assert_eq!(at, [(20.0, 0.0), (20.0, 1.0), (40.0, 0.0), (40.0, 1.0), (60.0, 0.0), (60.0, 1.0)]);
    let reasons: Vec<String> = counts.decisions.iter().map(ToString::to_string).collect();
    assert!(reasons[0].starts_with("rays, visibility traced") && reasons[2].contains("is below 9"), "{reasons:#?}");
    assert!(counts.directions[4].tally.hits.is_empty() && counts.directions[3].tally.beams > 0);
    // Both calculations see the same surface: at the border the lobes agree to the speckle of the map.
    let by = |method| {
        let options = Options { method, theta_i: vec![47f64.to_radians()], phi_i: vec![0.0], ..Options::default() };
        counted(&map, &options, Partition::Klems, false).directions.remove(0)
    };
    let (rays, waves) = (by(Method::Facets), by(Method::Kirchhoff));
    let distance: f64 = 0.5 * rays.share.iter().zip(&waves.share).map(|(a, b)| (a.value - b.value).abs()).sum::<f64>();
    assert!(distance < 0.1 * rays.albedo.value, "{distance}");
}
