//! The verbs fit, protocol and lobe on the command line: what they print and write, and how they refuse.

use std::path::Path;
use std::process::{Command, Output};

fn asperity(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let out = asperity(arguments);
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

/// Exit code and message of a refusal, which writes nothing to stdout.
fn refusal(arguments: &[&str]) -> (i32, String) {
    let out = asperity(arguments);
    assert!(!out.status.success() && out.stdout.is_empty(), "{arguments:?}");
    (out.status.code().unwrap(), String::from_utf8(out.stderr).unwrap())
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_list_of_values_is_fitted_and_its_residuals_written() {
    let dir = tempfile::tempdir().unwrap();
    let list = dir.path().join("measured.csv");
    // Ward's formula written out, 2 % too high and too low in turn.
    let mut rows = "theta_i_deg,phi_i_deg,theta_r_deg,phi_r_deg,f_r_per_sr,standard_error\n".to_owned();
    let (rho_s, alpha, rho_d) = (0.1f64, 0.1f64, 0.3f64);
    for (k, (ti, tr)) in
        [10.0, 30.0, 50.0].iter().flat_map(|ti| (0..60).map(move |j| (*ti, 1.4 * f64::from(j)))).enumerate()
    {
        let (i, r) = (f64::to_radians(ti), f64::to_radians(tr));
        let tilt = ((r - i) / 2.0).tan();
        let lobe = rho_s * (-(tilt / alpha).powi(2)).exp()
            / (4.0 * std::f64::consts::PI * alpha * alpha * (i.cos() * r.cos()).sqrt());
        let f = (rho_d / std::f64::consts::PI + lobe) * if k % 2 == 0 { 1.02 } else { 0.98 };
        rows += &format!("{ti},0,{tr},180,{f:e},{:e}\n", 0.02 * f);
    }
    std::fs::write(&list, rows).unwrap();
    let residuals = dir.path().join("residuals.csv");
    let found = json(&["fit", text(&list), "--model", "ward", "--json", "-o", text(&residuals)]);
    for (p, truth) in found["parameters"].as_array().unwrap().iter().zip([rho_s, alpha, rho_d]) {
        let (v, e) = (p["value"].as_f64().unwrap(), p["standard_error"].as_f64().unwrap());
        assert!((v - truth).abs() < 3.0 * e && e < 0.02 * truth, "{p}");
    }
    assert!((found["rms_log_error"].as_f64().unwrap() - 0.02).abs() < 0.001);
    let written = std::fs::read_to_string(&residuals).unwrap();
    assert_eq!(written.lines().count(), 181);
    assert!(written.starts_with("theta_i_deg,") && written.contains("ln_model_over_data"));
    let page = dir.path().join("page.png");
    assert!(asperity(&["fit", text(&list), "--model", "ward", "-o", text(&page)]).status.success());
    assert!(image::open(&page).unwrap().width() > 1000);
}

/// Roughness that physics.md-independent quadrature gives for black glass: 20 deg gloss of Beckmann (reference table
/// `gloss_vs_alpha.csv`, interpolated): .00754, .01108, .01607, .02596 for 80, 60, 40, 20.
#[test]
fn gloss_to_be_reached_gives_the_known_roughness() {
    let found = json(&["fit", "--model", "beckmann", "--gloss", "80,60,40,20", "--json"]);
    for (target, alpha) in found["targets"].as_array().unwrap().iter().zip([0.00754, 0.01108, 0.01607, 0.02596]) {
        let solutions = target["solutions"].as_array().unwrap();
        assert_eq!(solutions.len(), 1);
        let got = solutions[0]["values"]["alpha"].as_f64().unwrap();
        assert!((got / alpha - 1.0).abs() < 2e-3, "{got} {alpha}");
    }
    let (code, message) = refusal(&["fit", "--model", "ward:rho_s=0.02", "--gloss", "80"]);
    assert!(code == 2 && message.contains("nearest found"), "{message}");
}

#[test]
fn the_protocol_reads_what_it_simulated() {
    let dir = tempfile::tempdir().unwrap();
    let planted = "nef-bm:sigma=0.08,n=1.52,tau=17deg,omega=34deg,rho_D=0.04,rho_V=0.015";
    let made = json(&["protocol", "--simulate", planted, "-o", text(dir.path()), "--json"]);
    let files: Vec<&str> = made["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    let residuals = dir.path().join("residuals.csv");
    let found = json(&["protocol", files[0], files[1], files[2], "--json", "-o", text(&residuals)]);
    let n = found["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "n").unwrap();
    assert!((n["value"].as_f64().unwrap() - 1.52).abs() < 3.0 * n["standard_error"].as_f64().unwrap());
    assert_eq!(found["steps"].as_array().unwrap().len(), 4);
    assert!(std::fs::read_to_string(&residuals).unwrap().lines().count() > 300);
    // The model it prints is one that can be used.
    assert!(asperity(&["gloss", found["model"].as_str().unwrap()]).status.success());
    // With the reflectance of a sphere: a material for the library, a band per wavelength.
    let (dhr, own) = (dir.path().join("dhr.csv"), dir.path().join("deck-paint.toml"));
    std::fs::write(&dhr, "wavelength_nm,dhr,dhr_error\n500,0.1,0.001\n700,0.3,0.003\n").unwrap();
    let scaled = ["protocol", files[0], files[1], files[2], "--dhr", text(&dhr), "--wavelength", "600nm", "--json"];
    let found = json(&[&scaled[..], &["--material", text(&own)]].concat());
    let scales: Vec<f64> = found["bands"].as_array().unwrap().iter().map(|b| b["scale"].as_f64().unwrap()).collect();
    assert!((scales[1] / scales[0] / 3.0 - 1.0).abs() < 1e-9, "{scales:?}");
    let seen = Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(["models", "material:deck-paint", "--wavelength", "700nm", "--json"])
        .env("ASPERITY_MATERIALS", dir.path())
        .output()
        .unwrap();
    let page: serde_json::Value = serde_json::from_slice(&seen.stdout).unwrap();
    // 20 deg is the second angle of the page.
    assert!((page["albedo"][1].as_f64().unwrap() - 0.3).abs() < 1e-3, "{page}");
    std::fs::write(&dhr, "wavelength_nm,dhr\n500,1.5\n").unwrap();
    let (_, message) = refusal(&scaled);
    assert!(message.contains("dhr.csv") && message.contains("line 2"), "{message}");
    let (_, message) = refusal(&["protocol", files[0], files[2], files[1]]);
    assert!(message.contains("bistatic.csv") && message.contains("no column"), "{message}");
}

#[test]
fn lobes_are_drawn_as_svg_and_png() {
    let dir = tempfile::tempdir().unwrap();
    let (svg, png) = (dir.path().join("lobe.svg"), dir.path().join("lobe.png"));
    let sources = ["lobe", "lambert:rho=0.5", "ggx:alpha=0.2,material=cu", "mirror"];
    for path in [&svg, &png] {
        let out = asperity(&[&sources[..], &["-o", text(path)]].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }
    let drawn = std::fs::read_to_string(&svg).unwrap();
    assert!(drawn.contains("ggx:alpha=0.2,material=cu") && drawn.contains("specular core"));
    assert!(image::open(&png).unwrap().width() > 1000);
}

#[test]
fn refusals_say_what_to_do() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("a.gif");
    let cases: [(&[&str], &str); 8] = [
        (&["fit", "lambert:rho=0.5", "--model", "plastic"], "not a model"),
        (&["fit", "lambert:rho=0.5", "--model", "lambert:rho=0.5"], "nothing to find"),
        (&["fit", "mirror", "--model", "ward"], "no lobe to fit"),
        (&["fit", "no-such.npz", "--model", "ward"], "no-such.npz"),
        (&["fit", "lambert:rho=0.5", "--model", "ward", "--free", "beta"], "no parameter `beta`"),
        (&["fit", "lambert:rho=0.5", "--model", "ward", "--gloss", "80"], "two different fits"),
        (&["fit", "--model", "ward", "--gloss", "80,60", "--haze", "1,2,3"], "--gloss has 2 values"),
        (&["lobe", "lambert:rho=0.5", "-o", text(&out)], ".svg or .png"),
    ];
    for (arguments, what) in cases {
        let (_, message) = refusal(arguments);
        assert!(message.contains(what), "{arguments:?}: {message}");
    }
    assert!(!out.exists());
}
