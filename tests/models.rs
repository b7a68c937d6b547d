//! The models against published values, reference quadratures and their own samplers.

mod reference;

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

/// Every row of both tables. 2e-3 is what a user may count on; most models are right to the tables' five digits.
#[test]
fn albedos_against_the_reference_tables() {
    const ANGLES: [u32; 8] = [0, 20, 45, 60, 75, 80, 85, 89];
    if let Some(table) = reference::table("albedo_microfacet_F1.csv") {
        let mut rows = 0;
        for (line, row) in table.rows().enumerate() {
            let (shadowing, tolerance) = match table.text(line, "G") {
                "corr" => ("correlated", 2e-5),
                "sep" => ("separable", 2e-4),
                "vcav" => ("v-cavity", 2e-3),
                other => panic!("{other}"),
            };
            let (name, alpha) = (table.text(line, "ndf"), row["alpha"]);
            let brdf = model(&format!("{name}:alpha={alpha},material=mirror,shadowing={shadowing}"));
            for angle in ANGLES.into_iter().filter(|&a| a != 80) {
                let (got, want) = (brdf.albedo(f64::from(angle).to_radians()), row[&format!("theta{angle}")]);
                assert!(
                    (got - want).abs() < tolerance,
                    "{name} {shadowing} {row:?} at {angle}: {got} instead of {want}"
                );
            }
            rows += 1;
        }
        assert_eq!(rows, 48);
    }
    if let Some(table) = reference::table("albedo_models.csv") {
        let mut worst = (0.0, String::new());
        for (line, row) in table.rows().enumerate() {
            let p = row["param"];
            let (text, scale) = match table.text(line, "model") {
                "ward1992" => (format!("ward:rho_s=1,alpha={p}"), 1.0),
                "ward-duer2005" => (format!("ward:rho_s=1,alpha={p},form=duer"), 1.0),
                "wgmd2010" => (format!("ward:rho_s=1,alpha={p},form=bounded"), 1.0),
                "phong_modified" => (format!("phong:rho_s=1,exponent={p}"), 1.0),
                "phong_original*(n+1)/2pi" => (format!("phong:rho_s=1,exponent={p},form=original"), 1.0),
                "minnaert" => (format!("minnaert:rho=1,k={p}"), 1.0),
                "orennayar_full_rho1" => (format!("oren-nayar:rho=1,sigma={p}deg"), 1.0),
                "orennayar_qual_rho1" => (format!("oren-nayar:rho=1,sigma={p}deg,form=qualitative"), 1.0),
                // Four times too bright as printed; we are right.
                "cooktorrance1982_printed_F1" => (format!("cook-torrance:alpha={p},material=mirror"), 4.0),
                other => panic!("{other}"),
            };
            let brdf = model(&text);
            for angle in ANGLES {
                let (got, want) = (brdf.albedo(f64::from(angle).to_radians()) * scale, row[&format!("theta{angle}")]);
                let error = (got - want).abs() / scale;
                assert!(error < 2e-3, "{text} at {angle}: {got} instead of {want}");
                if error > worst.0 {
                    worst = (error, format!("{text} at {angle}"));
                }
            }
        }
        println!("largest error {:.1e}: {}", worst.0, worst.1);
    }
}

/// NIST SCATMECH's facet model, without shadowing and with its own Smith function.
#[test]
fn facets_against_scatmech() {
    let Some(table) = reference::table("scatmech_facet.csv") else { return };
    let mut worst = [0.0f64; 2];
    let mut rows = 0;
    for (line, row) in table.rows().enumerate() {
        let interface = match table.text(line, "substrate") {
            "n1.5" => "n=1.5",
            "Al_1.015_6.627" => "n=1.015,k=6.627",
            other => panic!("{other}"),
        };
        let (kind, shadowing) = match table.text(line, "model") {
            "facet" => (0, "none"),
            "facet_smith" => (1, "unconditional"),
            other => panic!("{other}"),
        };
        let brdf = model(&format!("beckmann:alpha={},{interface},shadowing={shadowing}", row["s"]));
        let (theta_r, phi_s) = (row["theta_r_deg"].abs(), row["phi_s_deg"]);
        // Their phi is 0 on the specular side.
        let got = brdf.eval(at(row["theta_i_deg"], 0.0), at(theta_r, 180.0 - phi_s));
        let want = row["brdf_unpol"];
        if want > 1e-200 {
            worst[kind] = worst[kind].max((got / want - 1.0).abs());
            rows += 1;
        }
    }
    println!("{rows} rows, largest relative error {:.1e} unshadowed, {:.1e} shadowed", worst[0], worst[1]);
    assert!(rows > 1000 && worst[0] < 1e-9 && worst[1] < 1e-6, "{worst:?}");
}

/// TV31: as printed in 1982 the lobe reflects four times what it receives.
#[test]
fn cook_torrance_reflects_what_it_receives() {
    let brdf = model("cook-torrance:alpha=0.1,material=mirror");
    assert!((brdf.albedo(0.0) - 1.0).abs() < 1e-4);
    // And is Beckmann where nothing is hidden.
    let beckmann = model("beckmann:alpha=0.1,material=mirror");
    near(brdf.eval(at(20.0, 0.0), at(30.0, 180.0)), beckmann.eval(at(20.0, 0.0), at(30.0, 180.0)), 1e-12);
    // Colour shift: copper is redder at normal incidence than near grazing.
    let ratio = |angle: f64| {
        let f = |nm: u32| {
            parse("cook-torrance:alpha=0.1,material=cu", f64::from(nm) * 1e-9)
                .unwrap()
                .eval(at(angle, 0.0), at(angle, 180.0))
        };
        f(611) / f(464)
    };
    assert!((ratio(0.0) - 0.874 / 0.549).abs() < 5e-3 && ratio(85.0) < 1.2);
}

/// TV29 and TV30 of the bounded Ward, and Walter's identity `weight = f cos / pdf` with the closed weights of all forms.
#[test]
fn ward_forms_and_weights() {
    for (alpha, albedo) in [(0.1f64, 0.99), (0.3, 0.91000134508), (0.5, 0.754578909722)] {
        let exact = 1.0 - alpha * alpha * (1.0 - (-1.0 / (alpha * alpha)).exp());
        assert!((exact - albedo).abs() < 1e-10);
        let got = model(&format!("ward:rho_s=1,alpha={alpha},form=bounded")).albedo(0.0);
        assert!((got - albedo).abs() < 1e-7, "{alpha}: {got} instead of {albedo}");
    }
    near(model("ward:rho_s=1,alpha=0.15,form=bounded").eval(at(45.0, 0.0), at(45.0, 180.0)), 7.07355302631, 1e-9);
    let wi = at(55.0, 20.0);
    for (form, weight) in [
        (
            "1992",
            (|b: f64, h: f64, i: f64, o: f64| 0.6 * b * h.powi(3) * (o / i).sqrt()) as fn(f64, f64, f64, f64) -> f64,
        ),
        ("duer", |b, h, i, _| 0.6 * b * h.powi(3) / i),
        ("bounded", |_, _, i, o| 0.6 * 2.0 / (1.0 + i / o)),
    ] {
        let brdf = model(&format!("ward:rho_s=0.6,alpha_x=0.2,alpha_y=0.35,form={form}"));
        let mut spread = [f64::MAX, 0.0f64];
        for k in 0..200 {
            let u = [f64::from(k) / 200.0, (f64::from(k) * 0.618).fract()];
            let Some(s) = brdf.sample(wi, u) else { continue };
            let wh = half_vector(wi, s.wo);
            near(s.weight, weight(wi.dot(wh), wh.z, wi.z, s.wo.z), 1e-12);
            near(s.weight, brdf.eval(wi, s.wo) * s.wo.z / brdf.pdf(wi, s.wo), 1e-12);
            spread = [spread[0].min(s.weight), spread[1].max(s.weight)];
        }
        // The paper of 1992 takes the weight for a constant.
        assert!(spread[1] > 1.3 * spread[0], "{form}: {spread:?}");
    }
    // Each form's core is what the lobe tends to.
    for form in ["1992", "duer", "bounded"] {
        let albedo = |alpha: f64| model(&format!("ward:rho_s=0.5,alpha={alpha},form={form}")).albedo(1.0);
        assert!((albedo(0.0) - albedo(0.002)).abs() < 1e-4, "{form}");
    }
}

/// TV41.
#[test]
fn oren_nayar_looks_back_at_the_light() {
    let [a, b] = asperity::model::oren_nayar::OrenNayar::new(1.0, 30f64.to_radians(), false).a_b();
    assert!((a - 0.773108415696).abs() < 1e-10 && (b - 0.338783829367).abs() < 1e-10);
    let brdf = model("oren-nayar:rho=0.8,sigma=30deg");
    let f = |phi: f64| brdf.eval(at(45.0, 10.0), at(45.0, 10.0 + phi));
    assert!((f(0.0) - 0.2755).abs() < 5e-5 && (f(180.0) - 0.1760).abs() < 5e-5, "{} {}", f(0.0), f(180.0));
    near(model("oren-nayar:rho=0.8,sigma=0").eval(at(80.0, 0.0), at(70.0, 3.0)), 0.8 / PI, 1e-14);
}

/// A base below zero is no reflection, whatever the exponent; published lobes are as published.
#[test]
fn lafortune_bases_below_zero_are_dark() {
    let brdf = model("lafortune:c_xy=-1,c_z=0.5,exponent=2.5");
    let f = brdf.eval(at(60.0, 0.0), at(60.0, 0.0));
    assert_eq!(f, 0.0, "the lobe's base is -0.625 in that direction");
    near(brdf.eval(at(60.0, 0.0), at(60.0, 180.0)), (0.75f64 + 0.125).powf(2.5), 1e-13);
    // Albedo of one lobe at normal incidence: 2 pi C_z^n / (n + 2).
    let got = model("lafortune:c_xy=-0.9,c_z=0.9,exponent=20").albedo(0.0);
    near(got, TAU * 0.9f64.powi(20) / 22.0, 1e-3);
    // Brushed metal, green, Lafortune et al. 1997.
    let metal = model(
        "lafortune:c_xy=-1.11845,c_z=1.01469,exponent=15.6489,c_xy2=-1.06409,c_z2=0.662178,exponent2=88.9222,\
         c_xy3=-1.01635,c_z3=1.00112,exponent3=184.152",
    );
    assert!((metal.albedo(0.0) - 0.49).abs() < 5e-3 && (metal.albedo(80f64.to_radians()) - 1.38).abs() < 5e-3);
    let error = parse("lafortune:c_xy=-1.2,c_z=1,exponent=500", 550e-9).err().unwrap().to_string();
    assert!(error.contains("peak") && error.contains("exponent"), "{error}");
}

/// TV32, TV48, TV49, and the exponential that a circulating version of the shadowing lacks.
#[test]
fn he_torrance_factors() {
    use asperity::model::HeTorrance;
    let glass = Material::Dielectric { n: 1.5 };
    let lobe = HeTorrance::new(0.2e-6, 3e-6, glass, 550e-9).unwrap();
    let f = lobe.factors(at(20.0, 0.0), at(30.0, 180.0));
    for (got, want) in [(f.g, 17.0214), (f.d, 2.83376), (f.geometry, 3.31072)] {
        near(got, want, 1e-5);
    }
    near(lobe.eval(at(20.0, 0.0), at(30.0, 180.0)), 0.149303, 1e-4);
    let f = lobe.factors(at(75.0, 0.0), at(75.0, 180.0));
    near(f.sigma_effective, 0.199996e-6, 1e-5);
    near(f.g, 1.39871, 1e-5);
    near(f.shadowing, 0.99506, 1e-5);
    near(lobe.eval(at(75.0, 0.0), at(75.0, 180.0)), 12.1501, 1e-4);
    // Shadowing of one direction, sigma/tau 0.067: 1.000 at 20 deg and 0.995 at 75 deg; without the exponential 0.973 and 0.77.
    let one = |angle: f64| lobe.factors(at(angle, 0.0), at(angle, 180.0)).shadowing.sqrt();
    assert!((one(20.0) - 1.0).abs() < 1e-9 && one(75.0) > 0.99);
    // TV32: coherent share exp(-g).
    let lobe = HeTorrance::new(0.201e-6, 30e-6, glass, 550e-9).unwrap();
    for (angle, share) in [(20.0, 8.16538e-9), (60.0, 0.00513015), (85.0, 0.851968)] {
        let r = glass.reflectance(f64::to_radians(angle).cos());
        assert!((lobe.specular_core(at(angle, 0.0)) / r - share).abs() < 1e-5, "{angle}");
    }
}

/// From a mirror to Beckmann facets of alpha = 2 sigma / tau.
#[test]
fn he_torrance_limits() {
    let smooth = model("he-torrance:sigma=0,tau=5um,n=1.5");
    near(smooth.specular_core(at(60.0, 0.0)), 0.0891867128022, 1e-9);
    assert_eq!(smooth.eval(at(60.0, 0.0), at(60.0, 180.0)), 0.0);
    // Albedos are read linearly from a table in the cosine: 1e-5 of their value.
    near(smooth.albedo(60f64.to_radians()), 0.0891867128022, 1e-5);
    let rough = model("he-torrance:sigma=3um,tau=60um,n=1.5");
    let facets = model("beckmann:alpha=0.1,n=1.5");
    for (i, o, phi) in [(0.0, 5.0, 40.0), (30.0, 35.0, 180.0), (50.0, 45.0, 170.0)] {
        near(rough.eval(at(i, 0.0), at(o, phi)), facets.eval(at(i, 0.0), at(o, phi)), 2e-3);
    }
    // The core and the rest share the light: at 30 deg nothing is hidden and R varies little.
    let albedo = model("he-torrance:sigma=0.05um,tau=20um,n=1.5").albedo(30f64.to_radians());
    near(albedo, asperity::optics::fresnel::dielectric(30f64.to_radians().cos(), 1.5), 3e-3);
    let error = parse("he-torrance:sigma=2um,tau=3um,n=1.5", 550e-9).err().unwrap().to_string();
    assert!(error.contains("tau=3um") && error.contains("sigma=2um"), "{error}");
}

/// Smooth glass over white: what enters leaves only as far as Fresnel lets it, `R + (1 - R)(1 - mean R)` (TV07).
#[test]
fn a_coat_over_a_diffuser() {
    let brdf = model("layered:dielectric:n=1.5,over=lambert:rho=1");
    for angle in [0.0f64, 60.0, 80.0] {
        let r = asperity::optics::fresnel::dielectric(angle.to_radians().cos(), 1.5);
        let want = r + (1.0 - r) * (1.0 - 0.0917779593424);
        assert!((brdf.albedo(angle.to_radians()) - want).abs() < 5e-4, "{angle}");
        let (wi, wo) = (at(angle, 0.0), at(40.0, 77.0));
        let ro = asperity::optics::fresnel::dielectric(40f64.to_radians().cos(), 1.5);
        near(brdf.eval(wi, wo), (1.0 - r) * (1.0 - ro) / PI, 1e-6);
        near(brdf.specular_core(wi), r, 1e-6);
    }
    // Three layers, a base with a core, and the mean of all draws.
    let stack = model("layered:ggx:alpha=0.2,n=1.5,over=layered:dielectric:n=1.3,over=conductor:material=al");
    let wi = at(50.0, 0.0);
    let mut rng = CounterRng::new(1, 0, 0);
    let draws = 200_000;
    let mean: f64 =
        (0..draws).filter_map(|_| stack.sample(wi, [rng.uniform(), rng.uniform()])).map(|s| s.weight).sum::<f64>()
            / f64::from(draws);
    assert!((mean - stack.albedo(50f64.to_radians())).abs() < 3e-3, "{mean}");
    for (text, what) in [
        ("layered:ggx:alpha=0.1,n=1.5", "no base"),
        ("layered:,over=mirror", "no coat"),
        ("layered:ggx:alpha=0.1,n=1.5,over=glue", "not a model"),
    ] {
        let error = parse(text, 550e-9).err().expect(text).to_string();
        assert!(error.contains(what), "{error}");
    }
}

/// TV58, and single scattering of Lommel and Seeliger: `(w/2)(1 - c ln(1 + 1/c))`.
#[test]
fn minnaert_and_dust_in_closed_form() {
    near(model("minnaert:rho=1,k=0.5").albedo(60f64.to_radians()), std::f64::consts::SQRT_2, 1e-9);
    let dust = model("blinn-dusty:w=0.8,g=0,tau=1000");
    for angle in [0.0f64, 45.0, 80.0] {
        let c = angle.to_radians().cos();
        let want = 0.4 * (1.0 - c * (1.0 + 1.0 / c).ln());
        assert!((dust.albedo(angle.to_radians()) - want).abs() < 3e-4, "{angle}");
    }
    near(dust.eval(at(30.0, 0.0), at(60.0, 50.0)), 0.8 / (2.0 * TAU * (0.75f64.sqrt() + 0.5)), 1e-12);
    near(model("blinn-dusty:w=1,tau=0,rho_d=0.5").eval(at(30.0, 0.0), at(60.0, 50.0)), 0.5 / PI, 1e-12);
}

/// White cylinders by a second method: the profile is cut into facets and every shadow is found by walking along it.
#[test]
fn cylinders_against_a_cut_profile() {
    let (d, h) = (3.0, 0.4);
    let brdf = model("poulin-fournier:d=3,h=0.4,rho_d=0.6");
    let arc = f64::acos(h);
    let height = |x: f64| {
        let x = x - d * (x / d).round();
        if x.abs() < arc.sin() { (1.0 - x * x).sqrt() } else { h }
    };
    for (i, o) in [(at(50.0, 0.0), at(30.0, 180.0)), (at(70.0, 20.0), at(65.0, 150.0)), (at(80.0, 5.0), at(70.0, 20.0))]
    {
        let n = 6000;
        let mut sum = 0.0;
        for k in 0..n {
            let x = d * ((f64::from(k) + 0.5) / f64::from(n) - 0.5);
            let z = height(x);
            let slope = if x.abs() < arc.sin() { -x / z } else { 0.0 };
            let normal = DVec3::new(-slope, 0.0, 1.0);
            let free = |w: DVec3| {
                let t = w.z / w.x.abs();
                let mut s = 0.002;
                while z + s * t < 1.0 {
                    if height(x + s * w.x.signum()) > z + s * t + 1e-9 {
                        return false;
                    }
                    s += 0.002;
                }
                true
            };
            let (a, b) = (normal.dot(i), normal.dot(o));
            if a > 0.0 && b > 0.0 && free(i) && free(o) {
                // Facet area over plan area is |normal|, and both cosines carry one.
                sum += a * b / normal.length();
            }
        }
        let want = 0.6 / PI * sum / f64::from(n) / (i.z * o.z);
        let got = brdf.eval(i, o);
        assert!((got / want - 1.0).abs() < 1e-2, "{got} {want}");
    }
}

/// `f / max(1, E_i, E_o)`: untouched where the model conserves energy.
#[test]
fn bounding_is_symmetric_and_only_where_needed() {
    let (free, bounded) = (model("minnaert:rho=0.8,k=0.5"), model("minnaert:rho=0.8,k=0.5,bounded=true"));
    let (flat, steep) = (at(20.0, 0.0), at(85.0, 40.0));
    assert_eq!(free.eval(flat, at(30.0, 9.0)), bounded.eval(flat, at(30.0, 9.0)));
    let e = free.albedo(85f64.to_radians());
    assert!(e > 2.0);
    near(bounded.eval(flat, steep), free.eval(flat, steep) / e, 1e-6);
    near(bounded.eval(flat, steep), bounded.eval(steep, flat), 1e-12);
    assert!(bounded.albedo(85f64.to_radians()) <= 1.0);
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
    for name in [
        "lambert",
        "minnaert",
        "oren-nayar",
        "phong",
        "lafortune",
        "ward",
        "cook-torrance",
        "beckmann",
        "ggx",
        "he-torrance",
        "poulin-fournier",
        "blinn-dusty",
        "beard-maxwell",
        "nef-bm",
        "metallic",
        "mirror",
        "dielectric",
        "conductor",
    ] {
        assert!(names.contains(&name), "{name}");
    }
}
