//! Numbers, texture and diagnosis of surfaces whose properties are known in closed form.

use asperity::heightmap::sampling::{MapAxis, Warning};
use asperity::heightmap::synth::{Brushed, Decay, Defects, Gaussian, Grid, Rough};
use asperity::heightmap::synth::{add_defects, brushed, gaussian, rough, sinusoid};
use asperity::heightmap::{Edges, HeightMap, RawMap, Survey, level};
use asperity::math::Estimate;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

const GRID: Grid = Grid { width: 512, height: 400, pitch: [0.5e-6, 0.75e-6] };

fn smooth(seed: u64, exact: bool) -> RawMap {
    gaussian(GRID, Gaussian { sq: 1e-7, acl: 6e-6, seed, exact }).unwrap()
}

fn survey(raw: &RawMap, edges: Edges) -> Survey {
    Survey::of(&level::keep_tilt(raw, edges))
}

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < relative, "{what}: {found} instead of {expected}");
}

#[test]
fn a_sinusoid_meets_its_closed_forms() {
    // 2000 samples a period, so that means over samples are those over the curve within 1e-6.
    let grid = Grid { width: 2000, height: 16, pitch: [20e-9, 1e-6] };
    let (sq, period) = (1e-7, 40e-6);
    let s = survey(&sinusoid(grid, sq, period, 0.0).unwrap(), Edges::Periodic);
    let amplitude = sq * SQRT_2;
    close(s.heights.sq, sq, 1e-6, "Sq");
    close(s.heights.sa, 2.0 * amplitude / PI, 1e-6, "Sa");
    close(s.heights.sku, 1.5, 1e-6, "Sku");
    close(s.heights.sz(), 2.0 * amplitude, 1e-6, "Sz");
    assert!(s.heights.ssk.abs() < 1e-6);
    close(s.gradient.sdq, TAU * sq / period, 1e-6, "Sdq");
    // Shallow: the area exceeds the plan by half the mean squared slope, less an eighth of the fourth power.
    let k = TAU * amplitude / period;
    close(s.gradient.sdr, k * k / 4.0 - 3.0 * k.powi(4) / 64.0, 1e-6, "Sdr");
}

/// A wave folded upwards, `A |sin|`: a surface of deep valleys, so that the sign and size of Ssk are tested as well.
/// Its raw moments are 2/pi, 1/2, 4/(3 pi) and 3/8; turned over, Ssk changes sign and Sp and Sv change places.
#[test]
fn a_folded_sinusoid_meets_its_closed_forms() {
    let (columns, amplitude) = (40_000, 2e-7);
    let fold = |c: usize| amplitude * (TAU * (c as f64 + 0.5) / columns as f64).sin().abs();
    let m = 2.0 / PI;
    let (m2, m3) = (0.5 - m * m, 4.0 / (3.0 * PI) - 1.5 * m + 2.0 * m.powi(3));
    let m4 = 0.375 - 16.0 * m / (3.0 * PI) + 3.0 * m * m - 3.0 * m.powi(4);
    let above = m.asin();
    for sign in [1.0, -1.0] {
        let heights = ndarray::Array2::from_shape_fn((4, columns), |(_, c)| sign * fold(c));
        let raw = RawMap { heights, pitch_x: 1e-9, pitch_y: 1e-6, format: "test", notes: vec![] };
        let h = survey(&raw, Edges::Periodic).heights;
        close(h.sq, amplitude * m2.sqrt(), 1e-6, "Sq");
        close(h.sa, amplitude * 4.0 / PI * (above.cos() - m * (FRAC_PI_2 - above)), 1e-6, "Sa");
        close(h.ssk, sign * m3 / m2.powf(1.5), 1e-6, "Ssk");
        close(h.sku, m4 / (m2 * m2), 1e-6, "Sku");
        let (up, down) = (amplitude * (1.0 - m), amplitude * m);
        let [peak, pit] = if sign > 0.0 { [up, down] } else { [down, up] };
        // The lowest sample lies half a step beside the fold.
        close(h.sp, peak, 2e-4, "Sp");
        close(h.sv, pit, 2e-4, "Sv");
    }
}

/// `Sal = acl sqrt(ln 5)`, `Str = 1`: exactly but for the wave that a map cannot hold, if amplitudes are fixed.
#[test]
fn sal_and_str_of_an_ideal_gaussian_surface() {
    let s = survey(&smooth(1, true), Edges::Periodic);
    // The left-out wave lowers the autocorrelation to (D - f) / (1 - f), which meets 0.2 at D = 0.2 + 0.8 f.
    let f = PI * 6e-6f64.powi(2) / (256e-6 * 300e-6);
    let sal = 6e-6 * (-(0.2 + 0.8 * f).ln()).sqrt();
    close(s.texture.sal.unwrap(), sal, 1e-3, "Sal");
    close(s.texture.str.unwrap(), 1.0, 2e-3, "Str");
    assert!(!s.texture.str_is_upper_bound && s.warnings.is_empty(), "{:?}", s.warnings);
}

/// Of true Gaussian processes, cut out of their surroundings, with and without gaps: within three standard errors of one
/// map, which is known to a few per cent. What remains is no chance: Sal is the smallest of all directions and Str the
/// smallest over the largest, so that even an isotropic surface has a Str somewhat below 1.
#[test]
fn sal_and_str_of_gaussian_surfaces() {
    const ACROSS: f64 = 4e-6;
    for (along, dropouts) in [(4e-6, 0.0), (4e-6, 0.3), (12e-6, 0.0), (12e-6, 0.3)] {
        let textures: Vec<_> = (0..8)
            .map(|seed| {
                let acl = [along, ACROSS];
                let surface = Rough { sq: 1e-7, acl, angle: 0.5, decay: Decay::Gaussian, seed, exact: false };
                let mut raw = rough(GRID, surface).unwrap();
                add_defects(&mut raw, &Defects { dropouts, seed, ..Defects::default() }).unwrap();
                survey(&raw, Edges::Open).texture
            })
            .collect();
        let sals: Vec<f64> = textures.iter().map(|t| t.sal.unwrap()).collect();
        let strs: Vec<f64> = textures.iter().map(|t| t.str.unwrap()).collect();
        for (what, values, expected) in [("Sal", sals, ACROSS * 5f64.ln().sqrt()), ("Str", strs, ACROSS / along)] {
            let e = Estimate::from_repeats(&values);
            let single = e.standard_error * (values.len() as f64).sqrt();
            eprintln!(
                "{what} along {along} dropouts {dropouts}: {:.4e} +- {single:.1e}, expected {expected:.4e}",
                e.value
            );
            assert!((e.value - expected).abs() < 3.0 * single, "{what}: {e:?} {expected}");
            assert!(single < 0.1 * expected, "{what}");
        }
    }
}

/// `Sal` across, `Str` the ratio of the lengths, `Std` the direction of the longer one.
#[test]
fn texture_of_an_anisotropic_surface() {
    for degrees in [0.0, 30.0, 90.0, -60.0f64] {
        let surface = Rough {
            sq: 1e-7,
            acl: [24e-6, 4e-6],
            angle: degrees.to_radians(),
            decay: Decay::Gaussian,
            seed: 2,
            exact: true,
        };
        let s = survey(&rough(GRID, surface).unwrap(), Edges::Periodic);
        close(s.texture.sal.unwrap(), 4e-6 * 5f64.ln().sqrt(), 0.02, "Sal");
        close(s.texture.str.unwrap(), 4.0 / 24.0, 0.03, "Str");
        let off = (s.texture.std.unwrap() - surface.angle + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2;
        assert!(off.to_degrees().abs() < 2.0, "{degrees}: {off}");
    }
    let lay = Brushed { sq: 1e-7, acl: [60e-6, 3e-6], lay: 0.4, overlap: 20.0, seed: 1, exact: true };
    let s = survey(&brushed(GRID, lay).unwrap(), Edges::Open);
    assert!((s.texture.std.unwrap() - 0.4).abs() < 0.05 && s.texture.str.unwrap() < 0.1, "{:?}", s.texture);
}

fn kinds(s: &Survey) -> Vec<std::mem::Discriminant<Warning>> {
    s.warnings.iter().map(std::mem::discriminant).collect()
}

#[test]
fn every_fault_is_diagnosed_and_nothing_else() {
    let with = |defects: Defects| {
        let mut raw = smooth(1, true);
        add_defects(&mut raw, &Defects { seed: 4, ..defects }).unwrap();
        survey(&raw, Edges::Open)
    };
    assert_eq!(with(Defects::default()).warnings, []);

    // Noise: sigma and share as added, along the axis of the finer pitch at least.
    let sigma = 3e-9;
    let s = with(Defects { noise: sigma, ..Defects::default() });
    let signal = |d: f64| 2e-14 * (1.0 - (-(d / 6e-6f64).powi(2)).exp());
    let share = 2.0 * sigma * sigma / (2.0 * sigma * sigma + signal(0.5e-6));
    let found = s.warnings.iter().find_map(|w| match *w {
        Warning::Noise { axis: MapAxis::X, share, sigma, .. } => Some((share, sigma)),
        _ => None,
    });
    let (found_share, found_sigma) = found.unwrap_or_else(|| panic!("{:?}", s.warnings));
    close(found_share, share, 0.1, "share of the noise");
    close(found_sigma, sigma, 0.1, "noise");

    let s = with(Defects { quantum: 20e-9, ..Defects::default() });
    let step = s.sampling.quantum.unwrap_or_else(|| panic!("{:?}", s.warnings)).step;
    close(step, 20e-9, 1e-3, "quantum");

    let s = with(Defects { spikes: 1e-4, spike_height: 1e-6, ..Defects::default() });
    let spikes = s.sampling.spikes.unwrap();
    assert!((18..=20).contains(&spikes.count) && spikes.slope_share > 0.02, "{spikes:?}");
    assert!(s.warnings.iter().any(|w| matches!(w, Warning::Spikes { .. })));

    let s = with(Defects { dropouts: 0.1, ..Defects::default() });
    assert_eq!(kinds(&s), [std::mem::discriminant(&Warning::MissingPoints { fraction: 0.1 })]);
}

#[test]
fn sampling_too_coarse_and_surfaces_without_slope() {
    let coarse = Grid { width: 400, height: 400, pitch: [1e-6; 2] };
    let raw = gaussian(coarse, Gaussian { sq: 1e-7, acl: 2e-6, seed: 3, exact: true }).unwrap();
    let s = survey(&raw, Edges::Periodic);
    let unresolved = s.warnings.iter().filter(|w| matches!(w, Warning::Unresolved { .. })).count();
    assert!(unresolved == 2 && s.warnings.len() == 2, "{:?}", s.warnings);

    let acl = [30e-6, 30e-6];
    let surface = Rough { sq: 1e-7, acl, angle: 0.0, decay: Decay::Exponential, seed: 3, exact: true };
    let s = survey(&rough(GRID, surface).unwrap(), Edges::Periodic);
    let exponents: Vec<f64> = s
        .warnings
        .iter()
        .filter_map(|w| match *w {
            Warning::NoRmsSlope { exponent, .. } => Some(exponent),
            _ => None,
        })
        .collect();
    assert!(exponents.len() == 2 && exponents.iter().all(|e| (e - 0.5).abs() < 0.1), "{:?}", s.warnings);
}

/// 10 um of form on 0.1 um of roughness: no texture to speak of, and the page says so.
#[test]
fn form_is_recognised_as_form() {
    let mut raw = smooth(1, true);
    raw.heights.indexed_iter_mut().for_each(|((r, c), h)| {
        *h += 1e-5 * ((c as f64 - 256.0) / 256.0).powi(2) + 1e-5 * ((r as f64 - 200.0) / 200.0).powi(2);
    });
    let s = survey(&raw, Edges::Open);
    assert!(s.warnings.iter().any(|w| matches!(w, Warning::FewPatches { .. } | Warning::FormLeft)), "{:?}", s.warnings);
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let mut raw = smooth(5, false);
    add_defects(&mut raw, &Defects { noise: 1e-9, dropouts: 0.05, ..Defects::default() }).unwrap();
    let found = [1, 3].map(|n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        format!("{:?}", pool.install(|| survey(&raw, Edges::Open)))
    });
    assert_eq!(found[0], found[1]);
}

#[test]
fn odd_maps_are_described_without_complaint() {
    let maps = [(2, 2, 0.0), (2, 300, 1e-9), (300, 2, 1e-9), (3, 3, f32::NAN), (64, 64, 0.0)];
    for (rows, columns, scale) in maps {
        let heights = ndarray::Array2::from_shape_fn((rows, columns), |(r, c)| scale * ((r * 7 + c * 3) % 5) as f32);
        for edges in [Edges::Open, Edges::Periodic, Edges::Mirrored] {
            let map =
                HeightMap { heights: heights.clone(), pitch_x: 1e-6, pitch_y: 2e-6, edges, removed_slopes: [0.0; 2] };
            let s = Survey::of(&map);
            assert!(s.heights.sq.is_finite() && s.gradient.sdr.is_finite() && s.spectrum.integral().is_finite());
            s.warnings.iter().for_each(|w| assert!(w.to_string().ends_with('.')));
        }
    }
}
