//! `asperity render`: a picture of a scene file; radiance read back from a picture.

use super::figure;
use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use super::written;
use crate::error::{Error, Result};
use crate::figure::{Figure, Settings};
use crate::optics::Brdf;
use crate::render::description::{PAGE, Picturing, Wanted};
use crate::render::{Description, Estimator, Film, Picture, RenderWarning, render_with_report, save_exr};
use clap::{Args, Parser};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub struct Arguments {
    /// A figure of the paper (fig7, fig8, fig9, fig11, fig12, fig13, fig14) or a scene file (.toml); --explain prints what
    /// may be in a scene file
    #[arg(required_unless_present_any = ["read", "explain"], conflicts_with_all = ["read", "explain"], value_name = "FIGURE|SCENE.toml")]
    scene: Option<PathBuf>,
    /// Picture to write, may be repeated: .exr (radiance with standard errors and sample counts), .png (exposed, sRGB)
    #[arg(short, long, required_unless_present_any = ["read", "explain", "reference"], value_name = "FILE", value_parser = written::picture)]
    output: Vec<PathBuf>,
    /// Print the page that explains scene files
    #[arg(long, conflicts_with = "read")]
    explain: bool,
    /// Read radiances [W/(m2 sr)] back from an .exr picture instead
    #[arg(long, value_name = "FILE.exr")]
    read: Option<PathBuf>,
    /// Of fig7, instead of a picture: root-mean-square errors of uniform and of alias sampling on the spheres, against a
    /// reference of this many paths a pixel
    #[arg(long, requires = "scene", conflicts_with = "output", value_name = "PATHS")]
    reference: Option<u32>,
    /// Pixel to read, column and row from the top left; may be repeated [default: the mean of all]
    #[arg(long, requires = "read", value_name = "X,Y", value_parser = pixel)]
    pixel: Vec<[usize; 2]>,
    #[command(flatten)]
    quality: Quality,
}

/// Flags that win over the [image] of a scene.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct Quality {
    /// Pixels across
    #[arg(long)]
    width: Option<usize>,
    /// Pixels down
    #[arg(long)]
    height: Option<usize>,
    /// Paths per pixel, or the most of them with --error
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stop each block of pixels when its error is this share of its radiance, such as 2%; 0% gives every pixel all paths
    #[arg(long, value_parser = super::quantity::error_share, value_name = "SHARE")]
    error: Option<f64>,
    /// Longest path in straight pieces: 1 shows lamps only, 2 direct light, 3 one reflection of it
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    depth: Option<u32>,
    /// Same seed, same bytes
    #[arg(long)]
    seed: Option<u64>,
    /// Display = sRGB(exposure x radiance) [default: exposes for the brightest 2 % of the pixels]
    #[arg(long)]
    exposure: Option<f64>,
    /// How light is found: mis, brdf, lights, uniform (directions), direct (no light by way of other surfaces)
    #[arg(long, value_parser = |name: &str| Estimator::parse(name).map_err(|e| e.to_string()))]
    estimator: Option<Estimator>,
}

impl Quality {
    /// What the file says, overruled by the flags.
    pub fn over(&self, file: Picturing) -> Result<Picturing> {
        if self.exposure.is_some_and(|e| !(e > 0.0 && e.is_finite())) {
            return Err(Error::parameter("the exposure is not above zero", "give --exposure such as 2.0"));
        }
        Ok(Picturing {
            width: self.width.or(file.width),
            height: self.height.or(file.height),
            samples: self.spp.or(file.samples),
            error: self.error.or(file.error).filter(|e| *e > 0.0),
            depth: self.depth.or(file.depth),
            seed: self.seed.or(file.seed),
            exposure: self.exposure.or(file.exposure),
            estimator: self.estimator.or(file.estimator),
        })
    }
}

fn pixel(text: &str) -> std::result::Result<[usize; 2], String> {
    let parts: Vec<&str> = text.split(',').collect();
    match parts[..] {
        [x, y] => match (x.trim().parse(), y.trim().parse()) {
            (Ok(x), Ok(y)) => Ok([x, y]),
            _ => Err("write column,row such as 320,240".to_owned()),
        },
        _ => Err("write column,row such as 320,240".to_owned()),
    }
}

/// The flags of `brdf` that a material of a scene may set.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct SourceFlags {
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
}

/// Opens a SOURCE of a scene file; names in it are looked for beside the file.
fn open(wanted: &Wanted, folder: &Path) -> Result<Box<dyn Brdf>> {
    let mut flags = vec![format!("--wavelength={}nm", wanted.wavelength * 1e9)];
    flags.extend(wanted.method.map(|m| format!("--method={m}")));
    flags.extend(wanted.surface.map(|m| format!("--material={m}")));
    flags.extend(wanted.flags.iter().cloned());
    let flags = SourceFlags::try_parse_from(flags).map_err(|e| {
        let text = e.to_string();
        let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        Error::parameter(first, "`asperity gloss --help` lists what may be said of a height map")
    })?;
    let beside = folder.join(wanted.source);
    let source = if beside.exists() { beside.to_string_lossy().into_owned() } else { wanted.source.to_owned() };
    match Source::open(&source, &flags.map, &flags.scatter, &|_| ())? {
        Source::Surface { prediction, .. } => Ok(Box::new(prediction.brdf)),
        Source::Model { brdf, .. } => Ok(brdf),
    }
}

/// Writes a film to every file; `comment` goes into the head of `.exr` files.
pub fn write_outputs(film: &Film, comment: &str, exposure: f64, outputs: &[PathBuf]) -> Result<()> {
    for path in outputs {
        if written::ending(path) == "exr" {
            save_exr(film, comment, path)?;
        } else {
            Picture::from_film(film, exposure).save_png(path)?;
        }
    }
    Ok(())
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    if a.explain {
        if json {
            return print_json(&json!({ "explains": "scene files (.toml)", "markdown": PAGE }));
        }
        print!("{PAGE}");
        return Ok(());
    }
    match (&a.read, &a.scene) {
        (Some(path), _) => read_back(path, &a.pixel, json),
        (None, Some(scene)) => match scene.to_str().filter(|name| Figure::names().contains(name)) {
            Some(name) => built_in(a, name, json),
            None if !scene.exists() => {
                let advice = format!("name a scene file, or one of the figures {}", Figure::names().join(", "));
                Err(Error::content(scene, "there is no such file, and no figure of that name", advice).into())
            }
            None => picture(a, scene, json),
        },
        (None, None) => Ok(()),
    }
}

/// A figure of the paper.
fn built_in(a: &Arguments, name: &str, json: bool) -> anyhow::Result<()> {
    let q = &a.quality;
    let fixed =
        [("--height", q.height.is_some()), ("--depth", q.depth.is_some()), ("--estimator", q.estimator.is_some())];
    if let Some((flag, _)) = fixed.iter().find(|(_, given)| *given) {
        let advice = "figures take --width, --spp, --error, --seed and --exposure";
        return Err(Error::parameter(format!("{flag} cannot change {name}, which has its own"), advice).into());
    }
    let settings = Settings {
        width: q.width,
        samples: q.spp,
        error: q.error.filter(|e| *e > 0.0),
        seed: q.seed,
        exposure: q.exposure,
    };
    if settings.width.is_some_and(|w| !(16..=16384).contains(&w)) {
        return Err(Error::parameter("a figure is from 16 to 16384 pixels wide", "try --width 960").into());
    }
    match a.reference {
        Some(reference) => figure::run_noise(name, &settings, reference, json),
        None => figure::run(name, &settings, &a.output, json),
    }
}

fn picture(a: &Arguments, path: &Path, json: bool) -> anyhow::Result<()> {
    let description = Description::load(path)?;
    let picturing = a.quality.over(description.picturing()?)?;
    let options = picturing.options();
    let camera = description.camera(options.width as f64 / options.height as f64)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let bar = Bar::new("materials", 1);
    let materials = description.materials(&|wanted| open(wanted, folder), &|share| bar.set(0, share))?;
    bar.finish();
    let built = description.build(&materials)?;
    let mut warnings: Vec<String> = built.notes;
    warnings.extend(RenderWarning::of_scene(&built.scene, &camera).iter().map(ToString::to_string));
    let start = Instant::now();
    let bar = Bar::new("render", 1);
    let rendering = render_with_report(&built.scene, &camera, &options, &|share| bar.set(0, share))?;
    let (film, report) = (rendering.film, rendering.report);
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    warnings.extend(RenderWarning::of_film(&film, &built.scene).map(|w| w.to_string()));
    let exposure = picturing.exposure.unwrap_or_else(|| film.natural_exposure());
    let comment = format!(
        "asperity render {} --width {} --height {} --spp {} --depth {} --seed {} --estimator {}{}. Linear sRGB primaries, \
         radiance and standard error in W/(m2 sr), samples in paths per pixel.",
        path.file_name().unwrap_or_default().to_string_lossy(),
        options.width,
        options.height,
        options.samples_per_pixel,
        options.max_reflections + 1,
        options.seed,
        options.estimator.name(),
        options.error.map_or(String::new(), |e| format!(" --error {}%", 100.0 * e)),
    );
    write_outputs(&film, &comment, exposure, &a.output)?;
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    if json {
        let files: Vec<_> = a.output.iter().map(|p| p.display().to_string()).collect();
        return print_json(&json!({
            "outputs": files, "width": options.width, "height": options.height, "seconds": seconds,
            "samples": report.samples, "samples_saved": report.saved, "blocks_unfinished": report.unfinished,
            "worst_error": report.worst_error, "longest_path": report.longest_path, "exposure": exposure,
            "warnings": warnings,
        }));
    }
    println!(
        "{} x {} pixels, {} paths in {seconds:.1} s ({:.2} million/s), exposure {}",
        options.width,
        options.height,
        report.samples,
        report.samples as f64 / seconds.max(1e-9) / 1e6,
        // Rounded to digits that a person would write.
        exposure as f32,
    );
    println!("longest path {} of {} pieces", report.longest_path, options.max_reflections + 1);
    if let Some(error) = options.error {
        println!(
            "error {:.3} %: {:.1} % of the paths saved, {:.1} % of the blocks above it after all paths, the worst at {:.2} %",
            100.0 * error,
            100.0 * report.saved,
            100.0 * report.unfinished,
            100.0 * report.worst_error,
        );
    }
    for path in &a.output {
        println!("wrote {}", path.display());
    }
    Ok(())
}

fn read_back(path: &Path, pixels: &[[usize; 2]], json: bool) -> anyhow::Result<()> {
    let (film, notes) = Film::load_exr(path)?;
    let mut rows = Vec::new();
    for &[x, y] in pixels {
        let pixel = film.pixel(x, y).ok_or_else(|| {
            let what = format!("there is no pixel {x},{y} in a picture of {} x {}", film.width(), film.height());
            Error::content(path, what, "columns and rows count from 0 at the top left")
        })?;
        rows.push((Some([x, y]), *pixel));
    }
    if rows.is_empty() {
        rows.push((None, film.mean()));
    }
    if json {
        let rows: Vec<_> = rows
            .iter()
            .map(|(at, p)| {
                json!({ "pixel": at, "radiance_w_per_m2_sr": p.radiance, "standard_error": p.standard_error, "samples": p.samples })
            })
            .collect();
        return print_json(&json!({
            "width": film.width(), "height": film.height(), "comment": notes.comment, "pixels": rows,
        }));
    }
    for (at, p) in &rows {
        let place = at.map_or("mean".to_owned(), |[x, y]| format!("{x},{y}"));
        let [r, g, b] = p.radiance;
        let [er, eg, eb] = p.standard_error;
        println!(
            "{place}  R {r:.6} +- {er:.2e}  G {g:.6} +- {eg:.2e}  B {b:.6} +- {eb:.2e}  W/(m2 sr), {} paths",
            p.samples
        );
    }
    Ok(())
}
