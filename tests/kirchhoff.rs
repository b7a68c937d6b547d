//! The phase integral against closed forms: Parseval, the flat map, Beckmann's series, a tilted mirror.

use asperity::facets::SlopeStatistics;
use asperity::heightmap::{Edges, HeightMap, level, synth};
use asperity::scatter::Wave;
use asperity::scatter::kirchhoff::{Coherent, Spectrum, WaveField, Windows, beckmann_spizzichino};
use std::f64::consts::TAU;

const K: f64 = TAU / 550e-9;

fn gaussian(size: [usize; 2], pitch: [f64; 2], sq: f64, acl: f64, seed: u64, edges: Edges) -> HeightMap {
    let grid = synth::Grid { width: size[0], height: size[1], pitch };
    let raw = synth::gaussian(grid, synth::Gaussian { sq, acl, seed, exact: false }).unwrap();
    level::keep_tilt(&raw, edges)
}

/// All light of every window: incoherent part and mirror beam together are 1, for weighted windows and gaps as well.
#[test]
fn parseval() {
    let mut holed = gaussian([360, 250], [0.5e-6, 0.8e-6], 60e-9, 5e-6, 2, Edges::Open);
    for r in 40..70 {
        for c in 100..180 {
            holed.heights[[r, c]] = f32::NAN;
        }
    }
    let whole = gaussian([256, 250], [0.5e-6, 0.8e-6], 200e-9, 5e-6, 1, Edges::Periodic);
    for map in [&holed, &whole] {
        let windows = Windows::choose(map);
        assert!(windows.periodic || windows.list.len() == 4, "{}", windows.list.len());
        for v_z in [0.2 * K, K, 2.0 * K] {
            for window in &windows.list {
                let all = Spectrum::measure(map, window, v_z, Default::default());
                let sum: f64 = all.energy.iter().map(|&e| f64::from(e)).sum();
                assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            }
        }
    }
    let coherent = Coherent::measure(&whole, K);
    let rest = Spectrum::measure(&whole, &Windows::choose(&whole).list[0], K, coherent.mean);
    let sum: f64 = rest.energy.iter().map(|&e| f64::from(e)).sum();
    assert!((sum + coherent.share() - 1.0).abs() < 1e-6, "{sum} {}", coherent.share());
    // Nothing of the beam is left in its own bin.
    assert!(rest.energy[0] < 1e-10);
}

/// A flat map of 100 um square reflects `f_r = R A / lambda^2 = 33057.851 R` into the mirror direction (TV47) and nothing into
/// any other bin: the first zero lies one bin off, `lambda / L`, 0.335 deg at 20 deg.
#[test]
fn a_flat_map_is_a_rectangular_mirror() {
    let map = gaussian([200, 200], [0.5e-6; 2], 0.0, 5e-6, 1, Edges::Periodic);
    let cos = 20f64.to_radians().cos();
    let window = &Windows::choose(&map).list[0];
    let spectrum = Spectrum::measure(&map, window, 2.0 * K * cos, Default::default());
    let [p, q] = spectrum.bin();
    // f_r = R T / (4 cos_i cos_r cos^4 theta_h), T = energy per slope area.
    let peak = f64::from(spectrum.energy[0]) / (p * q) / (4.0 * cos * cos);
    assert!((peak / 33_057.851 - 1.0).abs() < 1e-6, "{peak}");
    assert!(spectrum.energy[1..].iter().all(|&e| e < 1e-9));
    // One bin in slope is half a bin in direction.
    assert!(((2.0 * p).to_degrees() - 0.335).abs() < 1e-3);
    assert!((Coherent::measure(&map, 2.0 * K * cos).share() - 1.0).abs() < 1e-6);
}

/// A mirror tilted in both directions, sampled unevenly: the light goes where a facet of that slope sends it.
#[test]
fn a_tilted_mirror_reflects_at_its_slope() {
    let grid = synth::Grid { width: 240, height: 150, pitch: [0.7e-6, 1.1e-6] };
    let slope = [0.031, -0.012];
    let map = level::keep_tilt(&synth::ramp(grid, slope).unwrap(), Edges::Open);
    let v_z = 2.0 * K * 0.9;
    for window in &Windows::choose(&map).list {
        let coherent = Coherent::measure(&map, v_z);
        let spectrum = Spectrum::measure(&map, window, v_z, coherent.mean);
        let columns = spectrum.size[0];
        let mut sums = [0.0; 3];
        for (k, &e) in spectrum.energy.iter().enumerate() {
            let (p, q) = spectrum.slope(k / columns, k % columns);
            let e = f64::from(e);
            sums = [sums[0] + e, sums[1] + e * p, sums[2] + e * q];
        }
        let [p, q] = spectrum.bin();
        assert!((sums[1] / sums[0] - slope[0]).abs() < 0.1 * p, "{:?} {p}", sums);
        assert!((sums[2] / sums[0] - slope[1]).abs() < 0.1 * q, "{:?} {q}", sums);
    }
}

/// Ring means of the phase integral over six maps against Beckmann's series, and both against values of f_r / R
/// computed elsewhere (numpy FFT of six other maps of 1024 x 1024 at 0.5 um; 550 nm, 20 deg).
#[test]
fn gaussian_maps_follow_the_series() {
    let cos = 20f64.to_radians().cos();
    let v_z = 2.0 * K * cos;
    let offsets = [0.01, 0.03, 0.06, 0.1];
    let rows = [
        (50e-9, 10e-6, [402.0, 59.6, 1.35, 0.0050], [397.0, 59.3, 1.32, 0.0050]),
        (150e-9, 10e-6, [109.0, 78.8, 30.8, 4.31], [108.0, 78.6, 30.1, 4.25]),
        (800e-9, 20e-6, [12.7, 12.8, 11.4, 8.93], [14.07, 13.57, 12.04, 9.05]),
    ];
    for (sq, acl, fft, series) in rows {
        let mut rings = [[0.0f64; 6]; 4];
        let mut speckles = [0.0; 4];
        for seed in 0..6 {
            let map = gaussian([1024, 1024], [0.5e-6; 2], sq, acl, seed + 1, Edges::Periodic);
            let statistics = SlopeStatistics::measure(&map).unwrap();
            let field = WaveField::new(&map, &statistics, Wave::default());
            let (_, spectra) = field.spectra(v_z);
            let (spectrum, _) = &spectra[0];
            let [p, q] = spectrum.bin();
            let mut counts = [(0.0, 0.0); 4];
            for (k, &e) in spectrum.energy.iter().enumerate() {
                let (p, q) = spectrum.slope(k / 1024, k % 1024);
                let direction = p.hypot(q) * 2.0 * cos;
                for (ring, offset) in offsets.iter().enumerate() {
                    if (direction / offset - 1.0).abs() < 0.05 {
                        counts[ring].0 += f64::from(e);
                        counts[ring].1 += 1.0;
                    }
                }
            }
            for ring in 0..4 {
                let t = counts[ring].0 / counts[ring].1 / (p * q);
                let ch2 = 1.0 / (1.0 + (offsets[ring] / (2.0 * cos)).powi(2));
                rings[ring][seed as usize] = t / (4.0 * cos * cos * ch2 * ch2);
                speckles[ring] += counts[ring].1;
            }
        }
        for ring in 0..4 {
            let mean = rings[ring].iter().sum::<f64>() / 6.0;
            let spread = (rings[ring].iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 30.0).sqrt();
            let g = (v_z * sq).powi(2);
            let ch2 = 1.0 / (1.0 + (offsets[ring] / (2.0 * cos)).powi(2));
            let exact = beckmann_spizzichino(g, acl, offsets[ring] * K) / (550e-9f64.powi(2) * ch2 * ch2);
            println!(
                "Sq {:.0} nm, {}: {mean:.4} +- {spread:.4} ({} bins), series {exact:.4}; elsewhere FFT {}, series {}",
                sq * 1e9,
                offsets[ring],
                speckles[ring],
                fft[ring],
                series[ring]
            );
            // The other program keeps cos_theta_r of the mirror direction in cos(beta) as well: 0.6 % at the last offset.
            assert!((exact / series[ring] - 1.0).abs() < 1e-2, "{exact} {}", series[ring]);
            assert!((mean - exact).abs() < 4.0 * spread + 0.005 * exact, "{mean} +- {spread}, {exact}");
        }
    }
}
