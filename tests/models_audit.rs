//! Every model, every form, at random parameters over its usual range: reciprocity as documented, samples against the
//! pdf, weights, and the albedo against the model's own draws.

use asperity::math::quadrature::gauss_legendre;
use asperity::math::statistics::chi_square_test;
use asperity::math::{direction, random::CounterRng};
use asperity::model::{Absent, Definition, Entry, MODELS, Parameter, Scale};
use asperity::optics::Brdf;
use asperity::sample::audit;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

const WAVELENGTH: f64 = 550e-9;

/// From where values of the parameters are drawn.
#[derive(Clone, Copy, PartialEq)]
enum Range {
    Usual,
    /// All that is allowed; by ratios from a thousandth of the usual where 0 is.
    Whole,
}

impl Range {
    fn value(self, p: &Parameter, u: f64) -> f64 {
        let low = if p.scale == Scale::Logarithmic { p.min.max(1e-3 * p.usual[0]) } else { p.min };
        match (self, p.scale) {
            (Range::Usual, _) => p.usual_at(u),
            (Range::Whole, Scale::Linear) => low + u * (p.max - low),
            (Range::Whole, Scale::Logarithmic) => (low * (p.max / low).powf(u)).clamp(low, p.max),
        }
    }
}

/// `trials` definitions of every form of `entry` with random parameters; every third of a model that can be brushed is.
fn definitions(entry: &'static Entry, trials: u64, range: Range) -> Vec<Definition> {
    // Free text, such as a measured scan, as the example has it.
    let free =
        |pair: &&str| entry.words.iter().any(|w| w.options.is_empty() && pair.starts_with(&format!("{}=", w.name)));
    let given: Vec<&str> = entry.example.split_once(':').map_or("", |(_, rest)| rest).split(',').filter(free).collect();
    let mark = if given.is_empty() { "" } else { ":" };
    let mut forms = vec![format!("{}{mark}{}", entry.name, given.join(","))];
    for word in entry.words.iter().filter(|w| !w.options.is_empty()) {
        let extend = |start: &String| {
            let mark = if start.contains(':') { ',' } else { ':' };
            word.options.iter().map(move |option| format!("{start}{mark}{}={option}", word.name)).collect::<Vec<_>>()
        };
        forms = forms.iter().flat_map(extend).collect();
    }
    let mut all = Vec::new();
    for (number, form) in forms.iter().enumerate() {
        // The later forms differ in one factor only.
        for trial in 0..if number == 0 { trials } else { trials.min(2) } {
            let name = entry.name.bytes().fold(number as u64, |h, b| h.wrapping_mul(31).wrapping_add(u64::from(b)));
            let mut rng = CounterRng::new(3, name as u32, trial);
            let brushed = trial % 3 == 2;
            let replaced: Vec<&str> = entry
                .parameters
                .iter()
                .filter_map(|p| if let Absent::Said(name) = p.absent { Some(name) } else { None })
                .collect();
            let mut definition = Definition::parse(form).unwrap();
            for p in entry.parameters {
                // Further lobes and absorption on every second trial.
                let wanted = match p.absent {
                    Absent::Refused | Absent::Is(_) => !(brushed && replaced.contains(&p.name)),
                    Absent::Said(name) => {
                        brushed && entry.parameters.iter().any(|q| q.name == name && q.absent == Absent::Refused)
                    }
                    Absent::Fine => trial % 2 == 1 && p.name != "rho_s",
                };
                let value = range.value(p, rng.uniform());
                if wanted {
                    // A floor and a lobe share what there is.
                    let value = if ["rho_d", "rho_s"].contains(&p.name) { 0.5 * value } else { value };
                    definition.set(p.name, value).unwrap();
                }
            }
            all.push(definition);
        }
    }
    all
}

fn every_definition(trials: u64) -> impl Iterator<Item = (Definition, Box<dyn Brdf>)> {
    MODELS.iter().flat_map(move |entry| definitions(entry, trials, Range::Usual)).filter_map(|definition| {
        match definition.build(WAVELENGTH) {
            Ok(brdf) => Some((definition, brdf)),
            // A form that needs a file is none of this test's.
            Err(e) if definition.entry().words.iter().any(|w| w.options.is_empty()) => {
                println!("left out: {definition}: {e}");
                None
            }
            Err(e) => panic!("{definition}: {e}"),
        }
    })
}

#[test]
fn reciprocal_as_documented_non_negative_and_dark_below_the_horizon() {
    for (definition, brdf) in every_definition(6) {
        let mut rng = CounterRng::new(11, 0, 0);
        let mut asymmetry = 0.0f64;
        for _ in 0..500 {
            let mut draw = || direction(1.57 * rng.uniform(), TAU * rng.uniform());
            let (i, o) = (draw(), draw());
            let (f, g) = (brdf.eval(i, o), brdf.eval(o, i));
            assert!(f >= 0.0 && f.is_finite(), "{definition}: {f}");
            if f.max(g) > 1e-250 {
                asymmetry = asymmetry.max((f - g).abs() / f.max(g));
            }
            let below = DVec3::new(o.x, o.y, -o.z);
            assert_eq!((brdf.eval(i, below), brdf.eval(below, i)), (0.0, 0.0), "{definition}");
            assert_eq!((brdf.pdf(i, below), brdf.pdf(below, i)), (0.0, 0.0), "{definition}");
            assert!(brdf.sample(below, [rng.uniform(), rng.uniform()]).is_none(), "{definition}");
        }
        for edge in [DVec3::X, DVec3::Y] {
            assert_eq!(brdf.eval(edge, DVec3::Z) + brdf.eval(DVec3::Z, edge), 0.0, "{definition}");
        }
        if definition.is_reciprocal() {
            assert!(asymmetry < 1e-8, "{definition}: {asymmetry:e}");
        } else {
            // A documented offender that does not offend is documented wrongly.
            assert!(asymmetry > 1e-3, "{definition}: {asymmetry:e}");
        }
    }
}

/// Cos theta from-to, phi from-to.
type Cell = [f64; 4];

fn quarters([z0, z1, p0, p1]: Cell) -> [Cell; 4] {
    let (z, p) = (0.5 * (z0 + z1), 0.5 * (p0 + p1));
    [[z0, z, p0, p], [z0, z, p, p1], [z, z1, p0, p], [z, z1, p, p1]]
}

/// Cells of about equal shares of the points, each with its points: a quadtree over cos theta and phi.
fn cells(cell: Cell, points: Vec<[f64; 2]>, most: usize, depth: usize, leaves: &mut Vec<(Cell, Vec<[f64; 2]>)>) {
    // Two levels everywhere, so that the empty part of the hemisphere is tested too.
    if depth >= 2 && (points.len() <= most || depth > 24) {
        leaves.push((cell, points));
        return;
    }
    for quarter in quarters(cell) {
        let within = points.iter().copied().filter(|q| inside(quarter, *q)).collect();
        cells(quarter, within, most, depth + 1, leaves);
    }
}

fn inside([z0, z1, p0, p1]: Cell, [z, p]: [f64; 2]) -> bool {
    z >= z0 && (z < z1 || z1 == 1.0) && p >= p0 && p < p1
}

/// Integral of the pdf over a cell: quartered while many points are in it, so that no lobe falls between the nodes, and
/// then until two orders agree.
fn mass(
    brdf: &dyn Brdf,
    wi: DVec3,
    cell: Cell,
    points: &[[f64; 2]],
    rules: &[Vec<(f64, f64)>; 2],
    depth: usize,
) -> f64 {
    let [z0, z1, p0, p1] = cell;
    let integrate = |rule: &[(f64, f64)]| {
        let mut sum = 0.0;
        for &(a, wa) in rule {
            let z = z0 + 0.5 * (a + 1.0) * (z1 - z0);
            let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
            for &(b, wb) in rule {
                let p = p0 + 0.5 * (b + 1.0) * (p1 - p0);
                sum += wa * wb * brdf.pdf(wi, DVec3::new(r * p.cos(), r * p.sin(), z));
            }
        }
        0.25 * sum * (z1 - z0) * (p1 - p0)
    };
    if points.len() <= 16 || depth == 0 {
        let (coarse, fine) = (integrate(&rules[0]), integrate(&rules[1]));
        if (coarse - fine).abs() < 2e-6 + 1e-3 * fine || depth == 0 {
            return fine;
        }
    }
    let within = |q: Cell| points.iter().copied().filter(|p| inside(q, *p)).collect::<Vec<_>>();
    quarters(cell).iter().map(|&q| mass(brdf, wi, q, &within(q), rules, depth - 1)).sum()
}

/// Half of the draws shape the cells, the other half are counted in them; draws that are lost and draws of the specular
/// core are cells of their own.
#[test]
fn samplers_draw_what_their_pdfs_say() {
    const DRAWS: usize = 5_000;
    let rules = [gauss_legendre(5), gauss_legendre(7)];
    let all: Vec<_> = every_definition(3).enumerate().collect();
    all.par_iter().for_each(|(number, (definition, brdf))| {
        for (theta, phi) in [(0.0, 0.0), (40.0f64, 25.0f64), (77.0, 200.0)] {
            let wi = direction(theta.to_radians(), phi.to_radians());
            let mut rng = CounterRng::new(5, *number as u32, theta as u64);
            let (mut shaping, mut counted) = (Vec::new(), Vec::new());
            let (mut sum, mut squares, mut core, mut lost) = (0.0, 0.0, 0.0, 0.0);
            for k in 0..2 * DRAWS {
                let Some(s) = brdf.sample(wi, [rng.uniform(), rng.uniform()]) else {
                    lost += f64::from(u8::from(k >= DRAWS));
                    continue;
                };
                sum += s.weight;
                squares += s.weight * s.weight;
                if s.specular {
                    assert!(s.pdf.is_infinite() && s.weight >= 0.0);
                    core += f64::from(u8::from(k >= DRAWS));
                    continue;
                }
                assert!(s.wo.z > 0.0 && (s.wo.length() - 1.0).abs() < 1e-12, "{definition}");
                if k < 1000 {
                    let (pdf, f) = (brdf.pdf(wi, s.wo), brdf.eval(wi, s.wo));
                    assert!((s.pdf / pdf - 1.0).abs() < 1e-6, "{definition} at {theta}: pdf {} {pdf}", s.pdf);
                    let energy = f * s.wo.z;
                    let error = (s.weight * pdf - energy).abs();
                    assert!(error <= 1e-6 * energy + 1e-12, "{definition} at {theta}: {} {energy}", s.weight * pdf);
                }
                let point = [s.wo.z, asperity::math::frame::phi(s.wo)];
                if k < DRAWS { shaping.push(point) } else { counted.push(point) }
            }
            let mut leaves = Vec::new();
            cells([0.0, 1.0, 0.0, TAU], shaping, DRAWS / 60, 0, &mut leaves);
            let mut counts = vec![0.0; leaves.len()];
            for point in &counted {
                let leaf = leaves.iter().position(|(cell, _)| inside(*cell, *point));
                counts[leaf.expect("the cells tile the hemisphere")] += 1.0;
            }
            let masses: Vec<f64> =
                leaves.iter().map(|(cell, points)| mass(brdf.as_ref(), wi, *cell, points, &rules, 12)).collect();
            let kept: f64 = masses.iter().sum();
            assert!(kept <= 1.0 + 1e-3, "{definition} at {theta}: the pdf integrates to {kept}");
            let mut expected: Vec<f64> = masses.iter().map(|m| m * DRAWS as f64).collect();
            counts.push(core + lost);
            expected.push((1.0 - kept).max(0.0) * DRAWS as f64);
            let (chi2, dof, p) = chi_square_test(&counts, &expected, 20.0);
            assert!(p > 1e-4, "{definition} at {theta} deg: chi2 {chi2:.1}, {dof} degrees of freedom, p {p:.1e}");
            // The albedo of a brushed surface is a mean over azimuth.
            let brushed = entry_is_brushed(definition);
            if !brushed {
                let n = 2.0 * DRAWS as f64;
                let mean = sum / n;
                let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
                let albedo = brdf.albedo(theta.to_radians());
                let allowed = 4.0 * error + 1e-3 * (1.0 + albedo);
                assert!((mean - albedo).abs() < allowed, "{definition} at {theta}: {mean} +- {error}, albedo {albedo}");
            }
        }
    });
}

fn entry_is_brushed(definition: &Definition) -> bool {
    ["alpha_x", "c_x"].iter().any(|key| definition.get(key).is_some()) || definition.entry().name == "poulin-fournier"
}

/// Parameters from end to end of what is allowed: whatever is not refused in words is non-negative, finite, reciprocal as
/// documented, and its draws carry `f_r cos_theta_r / pdf` with the pdf they claim, which integrates to no more than 1.
#[test]
fn the_whole_range_of_every_parameter() {
    let all: Vec<Definition> = MODELS.iter().flat_map(|entry| definitions(entry, 24, Range::Whole)).collect();
    let built = all.par_iter().enumerate().filter(|(number, definition)| {
        let brdf = match definition.build(WAVELENGTH) {
            Ok(brdf) => brdf,
            Err(e) => {
                let text = e.to_string();
                assert!(text.contains(definition.entry().name) && text.contains('`'), "{definition}: {text}");
                return false;
            }
        };
        let mut rng = CounterRng::new(29, 0, 0);
        for theta in [0.0, 0.3, 0.9, 1.3, 1.5, 1.57] {
            let i = direction(theta, TAU * rng.uniform());
            for k in 0..60 {
                let o = direction(1.57 * rng.uniform(), TAU * rng.uniform());
                let o =
                    if k % 2 == 0 { o } else { DVec3::new(-i.x, -i.y, i.z).lerp(o, 0.1 * rng.uniform()).normalize() };
                let (f, g) = (brdf.eval(i, o), brdf.eval(o, i));
                assert!(f.is_finite() && f >= 0.0, "{definition}: {f}");
                let same = (f - g).abs() <= 1e-7 * f.max(g) || f.max(g) < 1e-250;
                assert!(same || !definition.is_reciprocal(), "{definition}: {f} {g}");
                let Some(s) = brdf.sample(i, [rng.uniform(), rng.uniform()]) else { continue };
                assert!(s.weight.is_finite() && s.weight >= 0.0 && s.wo.z > 0.0, "{definition}: {s:?}");
                if !s.specular {
                    let (pdf, energy) = (brdf.pdf(i, s.wo), brdf.eval(i, s.wo) * s.wo.z);
                    // Lobes of a thousandth of a degree lose digits where both vectors meet their half.
                    assert!((s.pdf / pdf - 1.0).abs() < 1e-4, "{definition} at {theta}: pdf {} {pdf}", s.pdf);
                    assert!((s.weight * pdf - energy).abs() <= 1e-4 * energy + 1e-12, "{definition} at {theta}: {s:?}");
                }
            }
        }
        // Its table is most of the work.
        let albedo = if number % 8 == 0 { brdf.albedo(1.0) } else { 0.0 };
        assert!(albedo.is_finite() && albedo >= 0.0, "{definition}: {albedo}");
        true
    });
    let count = built.count();
    println!("{count} of {} built", all.len());
    assert!(10 * count > 7 * all.len(), "{count} of {}", all.len());
}

/// `asperity check` of every model, brushed ones at every azimuth: a statement fails only where the page of the model says
/// so, and every offender that was met is one that the documentation names.
#[test]
fn every_model_passes_the_check_of_the_command_line() {
    let degrees = |list: &[f64]| list.iter().map(|d| d.to_radians()).collect::<Vec<f64>>();
    let options = audit::Options {
        theta_i: degrees(&[0.0, 33.0, 60.0, 80.0]),
        phi_i: degrees(&[0.0, 37.0]),
        draws: 20_000,
        ..audit::Options::default()
    };
    let examples = MODELS.iter().map(|entry| Definition::parse(entry.example).unwrap());
    let drawn = MODELS.iter().flat_map(|entry| definitions(entry, 3, Range::Usual));
    let all: Vec<Definition> = examples.chain(drawn).collect();
    all.par_iter().enumerate().for_each(|(number, definition)| {
        let brdf = definition.build(WAVELENGTH).unwrap();
        for fault in audit::audit(brdf.as_ref(), None, &options).findings {
            let documented = match fault.statement {
                audit::Statement::Energy => definition.entry().exceeds_one && fault.what.contains("of the light"),
                audit::Statement::Reciprocity => !definition.is_reciprocal(),
                _ => false,
            };
            let (theta, phi) = (fault.theta_i_deg, fault.phi_i_deg);
            assert!(documented, "{definition} at {theta:.0}, {phi:.0}: {}", fault.what);
            assert!(number >= MODELS.len(), "an example is no offender: {definition} at {theta:.0}: {}", fault.what);
        }
    });
}

/// The corners of the unit square and grazing light give numbers, never NaN; weights of visible normals never exceed R.
#[test]
fn extreme_draws() {
    let sharp = [
        "beckmann:alpha=0.0001,n=1.5",
        "ggx:alpha=0.0001,n=1.5",
        "ggx:alpha=2,material=mirror",
        "beckmann:alpha=2,material=mirror",
        "cook-torrance:alpha=0.0001,n=1.5",
        "phong:rho_s=1,exponent=1e6",
        "ward:rho_s=1,alpha=0.0001",
        "lafortune:c_xy=-1,c_z=1,exponent=10000",
        "lafortune:c_xy=0,c_z=-1,exponent=2.5",
        "blinn-dusty:w=1,g=0.95",
        "blinn-dusty:w=1,g=-0.95,tau=0",
        "oren-nayar:rho=1,sigma=60deg",
        "minnaert:rho=1,k=10",
        "poulin-fournier:d=0.1,h=0,rho_s=1,exponent=10000",
        "poulin-fournier:d=20,h=1,rho_s=0.5,rho_d=0.5",
        "he-torrance:sigma=10um,tau=20um,n=1.5",
        "he-torrance:sigma=1nm,tau=10mm,material=al",
        "metallic:x15=100,x45=0.1,x110=0",
    ];
    let sharp = sharp.map(|text| Definition::parse(text).unwrap());
    let sharp = sharp.into_iter().map(|definition| (definition.clone(), definition.build(WAVELENGTH).unwrap()));
    for (definition, brdf) in every_definition(3).chain(sharp) {
        for theta in [0.0, 1e-9, 45.0, 89.9, 89.9999999f64, 90.0 - 1e-13] {
            let wi = direction(theta.to_radians(), 0.6);
            for u in [0.0, 1e-300, 0.25, 0.5, 1.0 - 1e-10, 1.0 - f64::EPSILON / 2.0] {
                for v in [0.0, 0.5, 1.0 - f64::EPSILON / 2.0] {
                    let Some(s) = brdf.sample(wi, [u, v]) else { continue };
                    let fine = s.weight.is_finite() && s.weight >= 0.0 && s.pdf > 0.0;
                    assert!(fine, "{definition} {theta} {u} {v}: {s:?}");
                    let visible = ["beckmann", "ggx"].contains(&definition.entry().name);
                    let hidden =
                        !definition.to_string().contains("shadowing") || definition.to_string().contains("=correlated");
                    assert!(!(visible && hidden) || s.weight <= 1.0 + 1e-12, "{definition} {theta} {u} {v}: {s:?}");
                }
            }
            for o in [0.0, 30.0, 89.9999999f64, 90.0 - 1e-13] {
                for phi in [0.6, 2.0, 0.6 + TAU / 2.0] {
                    let wo = direction(o.to_radians(), phi);
                    let (f, pdf) = (brdf.eval(wi, wo), brdf.pdf(wi, wo));
                    assert!(
                        f.is_finite() && f >= 0.0 && pdf.is_finite() && pdf >= 0.0,
                        "{definition} {theta} {o} {phi}: {f} {pdf}"
                    );
                }
            }
        }
    }
}

/// Whatever the parameters, `bounded=true` keeps the albedo at or below 1; models that say they conserve energy do so on
/// their own.
#[test]
fn energy_as_documented_and_bounded_on_request() {
    let all: Vec<_> = every_definition(3).collect();
    all.into_par_iter().for_each(|(mut definition, brdf)| {
        let angles = [0.0, 30.0, 60.0, 75.0, 85.0, 88.0, 89.5f64];
        let largest = angles.iter().map(|a| brdf.albedo(a.to_radians())).fold(0.0, f64::max);
        assert!(largest.is_finite(), "{definition}");
        assert!(definition.entry().exceeds_one || largest <= 1.0 + 5e-4, "{definition}: {largest}");
        if largest > 1.0 && !entry_is_brushed(&definition) {
            definition.set_bounded(true);
            let bounded = definition.build(WAVELENGTH).unwrap();
            let mut rng = CounterRng::new(23, 0, 0);
            for a in angles {
                // `f / max(1, E_i, E_o)` to the letter: the albedo is then at most `E_i / max(1, E_i)`.
                let i = direction(a.to_radians(), 0.3);
                for _ in 0..50 {
                    let theta = 1.55 * rng.uniform();
                    let o = direction(theta, TAU * rng.uniform());
                    let (f, free) = (bounded.eval(i, o), brdf.eval(i, o));
                    let divisor = brdf.albedo(a.to_radians()).max(brdf.albedo(theta)).max(1.0);
                    assert!((f * divisor - free).abs() <= 1e-4 * free, "{definition} at {a}: {f} {free} {divisor}");
                    assert!((f - bounded.eval(o, i)).abs() <= 1e-9 * f || !definition.is_reciprocal());
                }
                let e = bounded.albedo(a.to_radians());
                assert!(e <= 1.0 && e <= brdf.albedo(a.to_radians()), "{definition} at {a}: {e}");
            }
        }
    });
}
