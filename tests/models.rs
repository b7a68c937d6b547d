//! The models against published values, reference quadratures and their own samplers.

mod reference;

use asperity::math::statistics::chi_square_test;
use asperity::math::{direction, half_vector, random::CounterRng};
use asperity::model::{Beckmann, Ggx, MODELS, parse};
use asperity::optics::{Brdf, Material};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

fn model(text: &str) -> Box<dyn Brdf> {
    parse(text, 550e-9).expect(text)
}

fn at(theta_deg: f64, phi_deg: f64) -> DVec3 {
    direction(theta_deg.to_radians(), phi_deg.to_radians())
}

#[track_caller]
fn near(got: f64, want: f64, relative: f64) {
    assert!((got / want - 1.0).abs() < relative, "{got} instead of {want}");
}

/// TV20-TV23.
#[test]
fn normal_densities_and_lambda() {
    let beckmann = |a: f64| Beckmann::new([a, a], Material::Mirror);
    let ggx = |a: f64| Ggx::new([a, a], Material::Mirror);
    near(beckmann(0.1).normal_density(at(0.0, 0.0)), 31.8309886184, 1e-11);
    near(beckmann(0.1).normal_density(at(10.0, 70.0)), 1.51067294943, 1e-11);
    near(ggx(0.1).normal_density(at(10.0, 70.0)), 2.00422537179, 1e-11);
    for (a, t, b, g) in [
        (0.3, 75.0, 0.0389636157644, 0.25058948346),
        (0.1, 85.0, 0.0419841152891, 0.259351854617),
        (0.5, 60.0, 0.013161894477, 0.161437827766),
    ] {
        assert!((beckmann(a).lambda(at(t, 30.0)) - b).abs() < 1e-11);
        assert!((ggx(a).lambda(at(t, 30.0)) - g).abs() < 1e-11);
    }
}

/// TV24-TV26, TV30.
#[test]
fn brdf_values() {
    near(model("beckmann:alpha=0.1,n=1.5").eval(at(20.0, 0.0), at(30.0, 180.0)), 0.187899529245, 1e-10);
    near(model("ggx:alpha=0.1,n=1.5").eval(at(20.0, 0.0), at(30.0, 180.0)), 0.129461849119, 1e-10);
    near(model("beckmann:alpha=0.3,n=1.5").eval(at(60.0, 0.0), at(70.0, 150.0)), 0.0253343513265, 1e-9);
    near(model("ward:rho_s=1,alpha=0.15").eval(at(45.0, 0.0), at(45.0, 180.0)), 5.00175731198, 1e-10);
    near(model("lambert:rho=0.5").eval(at(20.0, 0.0), at(70.0, 10.0)), 0.5 / PI, 1e-15);
    near(model("phong:rho_s=0.5,exponent=10").eval(at(30.0, 0.0), at(30.0, 180.0)), 0.5 * 12.0 / TAU, 1e-13);
    // The half vector of TV26.
    let wh = half_vector(at(60.0, 0.0), at(70.0, 150.0));
    near(asperity::math::frame::theta(wh).to_degrees(), 29.311410748, 1e-9);
}

/// TV27, TV28, TV57 and the closed forms, through the cached tables.
#[test]
fn directional_albedos() {
    let cases = [
        ("beckmann:alpha=0.1,material=mirror", 60.0, 0.99985),
        ("beckmann:alpha=0.1,material=mirror", 75.0, 0.97506),
        ("beckmann:alpha=0.1,material=mirror", 85.0, 0.91331),
        ("ggx:alpha=0.3,material=mirror", 0.0, 0.87736),
        ("ggx:alpha=0.3,material=mirror", 60.0, 0.82171),
        ("phong:rho_s=1,exponent=100", 0.0, 1.0),
        ("phong:rho_s=1,exponent=100", 60.0, 0.5),
        ("phong:rho_s=0.3,exponent=100,rho_d=0.5", 60.0, 0.65),
        ("lambert:rho=0.3", 80.0, 0.3),
        ("mirror", 45.0, 1.0),
        ("dielectric:n=1.5", 60.0, 0.0891867128022),
        ("conductor:n=1.0152,k=6.6273", 80.0, 0.859759505185),
        ("beckmann:alpha=0,n=1.5", 60.0, 0.0891867128022),
        ("ward:rho_s=0.5,alpha=0", 60.0, 0.25),
    ];
    for (text, angle, want) in cases {
        let got = model(text).albedo(f64::to_radians(angle));
        assert!((got - want).abs() < 2e-5, "{text} at {angle}: {got} instead of {want}");
    }
}

#[test]
fn albedos_against_the_reference_tables() {
    const ANGLES: [u32; 8] = [0, 20, 45, 60, 75, 80, 85, 89];
    if let Some(table) = reference::table("albedo_microfacet_F1.csv") {
        for (line, row) in table.rows().enumerate() {
            if table.text(line, "G") != "corr" {
                continue;
            }
            let brdf = model(&format!("{}:alpha={},material=mirror", table.text(line, "ndf"), row["alpha"]));
            for angle in ANGLES.into_iter().filter(|&a| a != 80) {
                let (got, want) = (brdf.albedo(f64::from(angle).to_radians()), row[&format!("theta{angle}")]);
                // 1e-5 is the rounding of the reference; the rest is interpolation where shadowing turns over at small alpha.
                assert!((got - want).abs() < 2e-5, "{row:?} at {angle}: {got} instead of {want}");
            }
        }
    }
    if let Some(table) = reference::table("albedo_models.csv") {
        for (line, row) in table.rows().enumerate() {
            let brdf = match table.text(line, "model") {
                "ward1992" => model(&format!("ward:rho_s=1,alpha={}", row["param"])),
                "phong_modified" => model(&format!("phong:rho_s=1,exponent={}", row["param"])),
                _ => continue,
            };
            for angle in ANGLES {
                let (got, want) = (brdf.albedo(f64::from(angle).to_radians()), row[&format!("theta{angle}")]);
                assert!((got - want).abs() < 1e-4, "{row:?} at {angle}: {got} instead of {want}");
            }
        }
    }
}

const ROUGH: [&str; 12] = [
    "lambert:rho=0.7",
    "beckmann:alpha=0.3,n=1.5",
    "beckmann:alpha=1.2,material=mirror",
    "beckmann:alpha_x=0.1,alpha_y=0.5,material=al",
    "ggx:alpha=0.3,n=1.5",
    "ggx:alpha_x=0.6,alpha_y=0.15,n=1.0,k=6.6",
    "ggx:alpha=1.5,material=mirror",
    "phong:rho_s=0.5,exponent=20",
    "phong:rho_s=0.3,exponent=60,rho_d=0.4",
    "ward:rho_s=0.5,alpha=0.3",
    "ward:rho_s=0.5,alpha_x=0.1,alpha_y=0.4",
    "ward:rho_s=0.3,alpha=0.15,rho_d=0.6",
];

/// Samples against the pdf integrated over cells of equal cos theta and phi, the lost draws being one more cell; the mean weight
/// against the albedo; and weight = f cos / pdf.
#[test]
fn samplers_draw_what_their_pdfs_say() {
    const RINGS: usize = 24;
    const SECTORS: usize = 36;
    const DRAWS: usize = 200_000;
    let rule = asperity::math::quadrature::gauss_legendre(10);
    for (number, text) in ROUGH.iter().enumerate() {
        let brdf = model(text);
        for (theta, phi) in [(0.0, 0.0), (40.0, 25.0), (75.0, 200.0)] {
            let wi = at(theta, phi);
            let mut rng = CounterRng::new(5, number as u32, theta as u64);
            let mut counts = vec![0.0; RINGS * SECTORS + 1];
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..DRAWS {
                let Some(s) = brdf.sample(wi, [rng.uniform(), rng.uniform()]) else {
                    counts[RINGS * SECTORS] += 1.0;
                    continue;
                };
                assert!(!s.specular && s.wo.z > 0.0 && (s.wo.length() - 1.0).abs() < 1e-12);
                near(s.pdf, brdf.pdf(wi, s.wo), 1e-7);
                near(s.weight * s.pdf, brdf.eval(wi, s.wo) * s.wo.z, 1e-7);
                let ring = ((1.0 - s.wo.z) * RINGS as f64).min(RINGS as f64 - 1.0) as usize;
                let sector = (asperity::math::frame::phi(s.wo) / TAU * SECTORS as f64) as usize;
                counts[ring * SECTORS + sector.min(SECTORS - 1)] += 1.0;
                sum += s.weight;
                squares += s.weight * s.weight;
            }
            let mut expected = Vec::new();
            for ring in 0..RINGS {
                for sector in 0..SECTORS {
                    let mut mass = 0.0;
                    for &(a, wa) in &rule {
                        for &(b, wb) in &rule {
                            let z = 1.0 - (ring as f64 + 0.5 * (a + 1.0)) / RINGS as f64;
                            let angle = (sector as f64 + 0.5 * (b + 1.0)) / SECTORS as f64 * TAU;
                            let r = (1.0 - z * z).sqrt();
                            mass += 0.25 * wa * wb * brdf.pdf(wi, DVec3::new(r * angle.cos(), r * angle.sin(), z));
                        }
                    }
                    expected.push(mass * TAU / (RINGS * SECTORS) as f64 * DRAWS as f64);
                }
            }
            let kept: f64 = expected.iter().sum();
            assert!(kept <= 1.001 * DRAWS as f64, "{text}: pdf integrates to {}", kept / DRAWS as f64);
            expected.push((DRAWS as f64 - kept).max(0.0));
            let (chi2, dof, p) = chi_square_test(&counts, &expected, 20.0);
            assert!(p > 1e-4, "{text} at {theta} deg: chi2 {chi2:.1}, {dof} degrees of freedom, p {p:.1e}");
            // The albedo of a brushed surface is a mean over azimuth.
            if !text.contains("alpha_x") {
                let n = DRAWS as f64;
                let error = ((squares / n - (sum / n).powi(2)) / n).sqrt();
                let albedo = brdf.albedo(wi.z.clamp(-1.0, 1.0).acos());
                assert!((sum / n - albedo).abs() < 4.0 * error + 3e-5, "{text} at {theta}: {} {albedo}", sum / n);
            }
        }
    }
}

#[test]
fn reciprocal_non_negative_and_dark_below_the_horizon() {
    for text in ROUGH {
        let brdf = model(text);
        let mut rng = CounterRng::new(11, 0, 0);
        for _ in 0..2000 {
            let mut draw = || direction(1.57 * rng.uniform(), TAU * rng.uniform());
            let (i, o) = (draw(), draw());
            let (f, g) = (brdf.eval(i, o), brdf.eval(o, i));
            assert!(f >= 0.0 && f.is_finite());
            assert!((f - g).abs() <= 1e-9 * f.abs().max(1e-300), "{text}: {f} {g}");
            let below = DVec3::new(o.x, o.y, -o.z);
            assert_eq!((brdf.eval(i, below), brdf.eval(below, i)), (0.0, 0.0));
            assert_eq!((brdf.pdf(i, below), brdf.pdf(below, i)), (0.0, 0.0));
            assert!(brdf.sample(below, [rng.uniform(), rng.uniform()]).is_none());
        }
        for edge in [DVec3::X, DVec3::Y] {
            assert_eq!(brdf.eval(edge, DVec3::Z), 0.0);
            assert_eq!(brdf.eval(DVec3::Z, edge), 0.0);
        }
    }
}

/// The corners of the unit square and grazing light give numbers, never NaN; microfacet weights never exceed R.
#[test]
fn extreme_draws() {
    let sharp = [
        "beckmann:alpha=0.0001,n=1.5",
        "ggx:alpha=0.0001,n=1.5",
        "phong:rho_s=1,exponent=1e6",
        "ward:rho_s=1,alpha=0.0001",
    ];
    for text in ROUGH.iter().chain(&sharp) {
        let brdf = model(text);
        for theta in [0.0, 1e-9, 45.0, 89.9, 89.9999999] {
            let wi = at(theta, 33.0);
            for u in [0.0, 1e-300, 0.25, 0.5, 1.0 - 1e-10, 1.0 - f64::EPSILON / 2.0] {
                for v in [0.0, 0.5, 1.0 - f64::EPSILON / 2.0] {
                    let Some(s) = brdf.sample(wi, [u, v]) else { continue };
                    assert!(s.weight.is_finite() && s.weight >= 0.0 && s.pdf > 0.0, "{text} {theta} {u} {v}: {s:?}");
                    let bounded = text.starts_with("beckmann") || text.starts_with("ggx");
                    assert!(!bounded || s.weight <= 1.0 + 1e-12, "{text} {theta} {u} {v}: {s:?}");
                }
            }
            let albedo = brdf.albedo(theta.to_radians());
            assert!(albedo.is_finite() && albedo >= 0.0, "{text} {theta}: {albedo}");
            assert!(text.starts_with("ward") || albedo <= 1.0 + 1e-4, "{text} {theta}: {albedo}");
        }
    }
}

#[test]
fn the_specular_core_is_a_branch_of_its_own() {
    for text in [
        "mirror",
        "dielectric:n=1.5",
        "beckmann:alpha=0.00009,n=1.5",
        "ggx:alpha=0,n=1.5",
        "ward:rho_s=0.4,alpha=0,rho_d=0.4",
    ] {
        let (brdf, wi) = (model(text), at(60.0, 20.0));
        let core = brdf.specular_core(wi);
        let s = brdf.sample(wi, [0.9, 0.1]).unwrap();
        assert!(s.specular && (s.wo - at(60.0, 200.0)).length() < 1e-12 && s.pdf.is_infinite());
        if text.contains("rho_d") {
            // Chosen with probability 1/2.
            near(s.weight, 2.0 * core, 1e-12);
            near(brdf.albedo(1.1), 0.4 + 0.4 * 1.1f64.cos(), 1e-12);
        } else {
            near(s.weight, core, 1e-12);
            assert_eq!(brdf.eval(wi, s.wo), 0.0);
        }
    }
}

#[test]
fn the_list_of_models_is_complete() {
    let names: Vec<&str> = MODELS.iter().map(|m| m.name).collect();
    for name in ["lambert", "mirror", "dielectric", "conductor", "beckmann", "ggx", "phong", "ward"] {
        assert!(names.contains(&name), "{name}");
    }
    for entry in MODELS {
        assert!(entry.parameters.iter().all(|p| !p.range().is_empty()));
    }
}
