//! `asperity render fig7`: the built-in pictures of the paper.

use super::print_json;
use super::progress::Bar;
use crate::figure::{Figure, Noise, Settings, noise};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Renders a figure into every file.
pub fn run(name: &str, settings: &Settings, outputs: &[PathBuf], json: bool) -> anyhow::Result<()> {
    let figure = prepare(name)?;
    let start = Instant::now();
    let bar = Bar::new("render", 1);
    let picture = figure.render(settings, &|share| bar.set(0, share))?;
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    let mut written = Vec::new();
    for path in outputs {
        written.extend(picture.save(path)?);
    }
    let samples: u64 = picture.films().iter().flat_map(|(_, f)| f.pixels()).map(|p| u64::from(p.samples)).sum();
    let files: Vec<_> = written.iter().map(|p| p.display().to_string()).collect();
    if json {
        return print_json(&json!({
            "figure": name, "outputs": files, "seconds": seconds, "samples": samples,
            "exposure": picture.sheet().exposure(), "captions": figure.captions(),
        }));
    }
    for lines in figure.captions() {
        println!("{}", lines.join(", "));
    }
    println!("{samples} paths in {seconds:.1} s ({:.2} million/s)", samples as f64 / seconds.max(1e-9) / 1e6);
    files.iter().for_each(|f| println!("wrote {f}"));
    Ok(())
}

/// Root-mean-square errors of the ways of sampling in fig7 against a reference of `reference` paths a pixel.
pub fn run_noise(name: &str, settings: &Settings, reference: u32, json: bool) -> anyhow::Result<()> {
    let figure = prepare(name)?;
    let bar = Bar::new("reference", 1);
    let list = noise(&figure, settings, reference, &|share| bar.set(0, share))?;
    bar.finish();
    let gain = list[0].mean_square / list[1].mean_square;
    let gains = [0, 1, 2, 3].map(|k| list[0].of_sphere[k] / list[1].of_sphere[k]);
    if json {
        let row = |n: &Noise| {
            json!({
                "estimator": n.estimator.name(), "rms_w_per_m2_sr": n.rms(), "mean_w_per_m2_sr": n.mean,
                "rms_per_sphere": n.of_sphere.map(f64::sqrt),
            })
        };
        let rows: Vec<_> = list.iter().map(row).collect();
        return print_json(&json!({
            "figure": name, "reference_samples": reference, "modes": rows, "mean_square_gain": gain, "gain_per_sphere": gains,
        }));
    }
    for n in &list {
        let spheres: Vec<String> = n.of_sphere.iter().map(|m| format!("{:.5}", m.sqrt())).collect();
        println!(
            "{:<8} RMS error {:.5} W/(m2 sr) = {:.2} % of the mean on the spheres; sphere by sphere {}",
            n.estimator.name(),
            n.rms(),
            100.0 * n.rms() / n.mean,
            spheres.join(", "),
        );
    }
    let spheres: Vec<String> = gains.iter().map(|g| format!("{g:.0}")).collect();
    println!("mean squared error uniform / alias {gain:.0}; sphere by sphere {}", spheres.join(", "));
    Ok(())
}

fn prepare(name: &str) -> crate::Result<Figure> {
    let bar = Bar::new("surfaces", 1);
    let figure = Figure::prepare(name, &|share| bar.set(0, share))?;
    bar.finish();
    Ok(figure)
}
