//! The audit passes what is sound and finds what was planted.

use asperity::heightmap::{Edges, HeightMap, level, read, synth};
use asperity::math::frame::DVec3;
use asperity::model;
use asperity::optics::{Brdf, BrdfSample, Material};
use asperity::report::{Settings, predict};
use asperity::sample::audit::{Audit, Options, Statement, audit};
use asperity::sample::rivals::{CosineSampled, CumulativeSampled, UniformSampled};
use asperity::sample::{Reciprocal, TableBrdf};
use asperity::scatter::{self, Method, Symmetry, scatter};
use asperity::table::{Provenance, Table};

fn quick() -> Options {
    let degrees = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect();
    Options {
        theta_i: degrees(&[0.0, 20.0, 47.0, 60.0, 75.0]),
        phi_i: degrees(&[0.0, 37.0]),
        draws: 100_000,
        ..Options::default()
    }
}

fn gaussian(sq: f64, pitch: [f64; 2]) -> HeightMap {
    let grid = synth::Grid { width: 256, height: 256, pitch: [1e-6; 2] };
    let mut raw = synth::gaussian(grid, synth::Gaussian { sq, acl: 8e-6, seed: 2, exact: true }).unwrap();
    (raw.pitch_x, raw.pitch_y) = (pitch[0], pitch[1]);
    level::keep_tilt(&raw, Edges::Periodic)
}

fn table(map: &HeightMap, symmetry: Symmetry, material: Material) -> TableBrdf {
    let options = scatter::Options { method: Method::Geometric, symmetry, material, ..scatter::Options::default() };
    let scattered = scatter(map, &options, &|_| ()).unwrap();
    TableBrdf::new(Table::from_scatter(&scattered, Provenance::default())).unwrap()
}

fn of_table(brdf: &TableBrdf, options: &Options) -> Audit {
    let estimate = |wi, wo| brdf.table().estimate(wi, wo);
    audit(brdf, Some(&estimate), options)
}

fn sound(name: &str, found: &Audit) {
    for row in &found.rows {
        println!(
            "{name}: {:.0} deg: albedo {:.5} integral {:.5} weight {:.5}, asymmetry {:.4}, chi-square {:.0} / {:.0}, p {:.4}",
            row.theta_i_deg,
            row.albedo,
            row.integral,
            row.mean_weight.value,
            row.asymmetry,
            row.chi_square,
            row.degrees_of_freedom,
            row.p_value
        );
    }
    assert!(found.passed, "{name}: {:#?}", found.findings);
}

#[test]
fn models_are_sound() {
    for text in
        ["lambert:rho=0.5", "beckmann:alpha=0.02,n=1.5", "beckmann:alpha=0.3,n=1.5", "ggx:alpha=0.1,n=1.5", "mirror"]
    {
        sound(text, &audit(model::parse(text, 550e-9).unwrap().as_ref(), None, &quick()));
    }
}

#[test]
fn an_isotropic_table_is_sound_whatever_draws_from_it() {
    let brdf = table(&gaussian(0.4e-6, [1e-6; 2]), Symmetry::Isotropic, Material::Dielectric { n: 1.5 });
    sound("table", &of_table(&brdf, &quick()));
    let estimate = |wi, wo| brdf.table().estimate(wi, wo);
    let rivals: [(&str, &dyn Brdf); 3] = [
        ("cumulative", &CumulativeSampled::new(&brdf)),
        ("cosine", &CosineSampled(&brdf)),
        ("uniform", &UniformSampled(&brdf)),
    ];
    for (name, rival) in rivals {
        sound(name, &audit(rival, Some(&estimate), &quick()));
    }
}

/// The seven bundled maps as the program tabulates them, waves where rays do not hold.
#[test]
fn tables_of_all_bundled_maps_are_sound() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("heightmaps");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|e| e != "x3p") {
            continue;
        }
        let map = level::level(&read::read(&path, &read::ReadOptions::default()).unwrap(), Edges::Open).unwrap();
        let settings = Settings { fewest_angles: true, ..Settings::default() };
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let prediction = predict(&map, &name, &settings, &|_| ()).unwrap();
        let table = prediction.brdf.table();
        println!("{name}: {} cells x {} x {}", table.cells().len(), table.theta_i().len(), table.phi_i().len());
        let phi_i = [0.0, 37f64.to_radians()].to_vec();
        let phi_i =
            if prediction.isotropic { phi_i } else { [0.0f64, 37.0, 110.0, 250.0].map(f64::to_radians).to_vec() };
        sound(&name, &of_table(&prediction.brdf, &Options { phi_i, ..quick() }));
        seen += 1;
    }
    assert!(seen >= 7, "{seen}");
}

#[test]
fn an_anisotropic_table_is_sound_at_four_azimuths() {
    let brdf = table(&gaussian(0.3e-6, [1e-6, 3e-6]), Symmetry::Anisotropic, Material::Mirror);
    let phi_i = [0.0f64, 37.0, 110.0, 250.0].map(f64::to_radians).to_vec();
    sound("anisotropic", &of_table(&brdf, &Options { phi_i, ..quick() }));
}

/// A flat map of which one facet in a hundred is a bump: core and haze.
#[test]
fn a_mirror_with_one_per_cent_haze_is_sound() {
    let grid = synth::Grid { width: 301, height: 301, pitch: [1e-6; 2] };
    let mut raw = synth::ramp(grid, [0.0; 2]).unwrap();
    let mut rng = asperity::math::random::CounterRng::new(4, 0, 0);
    for r in (5..300).step_by(20) {
        for c in (5..300).step_by(20) {
            raw.heights[[r, c]] += 2e-7 * rng.normal_pair()[0];
        }
    }
    let brdf = table(&level::keep_tilt(&raw, Edges::Open), Symmetry::Isotropic, Material::Dielectric { n: 1.5 });
    assert!(brdf.specular_core(DVec3::Z) > 0.035);
    sound("haze", &of_table(&brdf, &quick()));
}

/// A tilted plane: every facet in one cell.
#[test]
fn a_table_of_one_filled_cell_is_sound() {
    let grid = synth::Grid { width: 64, height: 64, pitch: [1e-6; 2] };
    let raw = synth::ramp(grid, [0.05, -0.02]).unwrap();
    let brdf = table(&level::keep_tilt(&raw, Edges::Open), Symmetry::Anisotropic, Material::Mirror);
    let filled = brdf.alias(0).unwrap().probabilities().iter().filter(|&&p| p > 0.0).count();
    assert!(filled <= 4, "{filled}");
    // What it reflects lies within a cell a hundred thousandth wide: reciprocity is that of its corners.
    let found = of_table(&brdf, &quick());
    let others: Vec<_> = found.findings.iter().filter(|f| f.statement != Statement::Reciprocity).collect();
    assert!(others.is_empty(), "{others:#?}");
}

#[test]
fn the_diffuse_floor_is_drawn_as_the_pdf_says() {
    let text = "lambert:rho=0.5";
    let lambert = model::parse(text, 550e-9).unwrap();
    let found = audit(&Reciprocal(lambert.as_ref()), None, &quick());
    sound(text, &found);
    assert!(found.rows.iter().all(|r| r.asymmetry < 1e-12));
}

/// What is wrong with it.
#[derive(Clone, Copy)]
enum Fault {
    /// The pdf sways by a tenth round the azimuth; it still integrates to one.
    Pdf,
    /// f_r with the cosine.
    CosineInValue,
    /// The weight with another cosine.
    CosineInWeight,
    /// Draws turned by half a degree.
    TurnedDraws,
    /// Everything for a source two degrees lower.
    TiltedSource,
}

struct Faulty<'a> {
    brdf: &'a dyn Brdf,
    fault: Fault,
}

fn turned(w: DVec3, angle: f64) -> DVec3 {
    let (s, c) = angle.sin_cos();
    DVec3::new(c * w.x - s * w.y, s * w.x + c * w.y, w.z)
}

impl Faulty<'_> {
    fn source(&self, wi: DVec3) -> DVec3 {
        if !matches!(self.fault, Fault::TiltedSource) {
            return wi;
        }
        let (s, c) = 2f64.to_radians().sin_cos();
        DVec3::new(c * wi.x + s * wi.z, wi.y, c * wi.z - s * wi.x)
    }
}

impl Brdf for Faulty<'_> {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let f = self.brdf.eval(self.source(wi), wo);
        if matches!(self.fault, Fault::CosineInValue) { f * wo.z } else { f }
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let mut s = self.brdf.sample(self.source(wi), u)?;
        match self.fault {
            Fault::CosineInWeight => s.weight *= s.wo.z,
            Fault::TurnedDraws => {
                s.wo = turned(s.wo, 0.5f64.to_radians());
                s.pdf = self.pdf(wi, s.wo);
                s.weight = self.eval(wi, s.wo) * s.wo.z / s.pdf;
            }
            _ => {}
        }
        Some(s)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let pdf = self.brdf.pdf(self.source(wi), wo);
        if matches!(self.fault, Fault::Pdf) { pdf * (1.0 + 0.1 * (3.0 * wo.y.atan2(wo.x)).sin()) } else { pdf }
    }

    fn albedo(&self, theta_i: f64) -> f64 {
        self.brdf.albedo(theta_i)
    }
}

/// Broken pdf, doubled cosine, shifted frame: each is found, and for the right reason.
#[test]
fn planted_faults_are_found() {
    let brdf = table(&gaussian(0.2e-6, [1e-6; 2]), Symmetry::Isotropic, Material::Mirror);
    let beckmann = model::parse("beckmann:alpha=0.05,n=1.5", 550e-9).unwrap();
    let cases = [
        (Fault::Pdf, Statement::ChiSquare),
        (Fault::Pdf, Statement::Weight),
        (Fault::CosineInValue, Statement::Energy),
        (Fault::CosineInValue, Statement::Weight),
        (Fault::CosineInWeight, Statement::Weight),
        (Fault::CosineInWeight, Statement::MeanWeight),
        (Fault::TurnedDraws, Statement::ChiSquare),
        (Fault::TiltedSource, Statement::Reciprocity),
    ];
    let sources: [&dyn Brdf; 2] = [&brdf, beckmann.as_ref()];
    for (k, source) in sources.into_iter().enumerate() {
        for (fault, statement) in cases {
            let found = audit(&Faulty { brdf: source, fault }, None, &quick());
            assert!(!found.passed);
            assert!(
                found.findings.iter().any(|f| f.statement == statement),
                "source {k}, {statement:?}: {:#?}",
                found.findings
            );
        }
    }
}
