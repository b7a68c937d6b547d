//! `asperity tiles`: roughness comparison picture.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use crate::error::{Error, Result};
use crate::math::Estimate;
use crate::render::{Tile, TilesOptions, render_tiles};
use crate::report::Prediction;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// Height maps, tables or models
    #[arg(required = true, value_name = "SOURCE")]
    sources: Vec<String>,
    /// Picture to write: .png (labelled), .exr (radiance)
    #[arg(short, long, required = true, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
    #[command(flatten)]
    look: Look,
}

/// Flags of the picture.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct Look {
    /// Paths per pixel of the picture
    #[arg(long, default_value_t = TilesOptions::default().samples_per_pixel, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Width of one tile in pixels, 64 to 2048
    #[arg(long, default_value_t = 240, value_parser = clap::value_parser!(u16).range(64..=2048))]
    tile_width: u16,
    /// Display = sRGB(exposure x radiance) [default: exposes for the brightest tile]
    #[arg(long)]
    exposure: Option<f64>,
}

impl Look {
    /// The renderer's options.
    pub fn options(&self) -> Result<TilesOptions> {
        if self.exposure.is_some_and(|e| !(e > 0.0 && e.is_finite())) {
            return Err(Error::parameter("the exposure is not above zero", "give --exposure such as 2.0"));
        }
        Ok(TilesOptions {
            samples_per_pixel: self.spp,
            panel_width: usize::from(self.tile_width),
            exposure: self.exposure,
            ..TilesOptions::default()
        })
    }
}

/// Lines below a tile: roughness (or name) in bold, then the gloss at three angles.
pub fn caption(name: &str, sq: Option<f64>, gloss: [Estimate; 3]) -> Vec<String> {
    let title = match sq {
        Some(sq) => format!("Sq {} nm", significant(sq * 1e9)),
        None => name.to_owned(),
    };
    let angles = [20, 60, 85];
    let mut lines = vec![title];
    lines.extend((0..3).map(|k| format!("{}\u{b0} {:>5.1} GU", angles[k], gloss[k].value)));
    if sq.is_some() {
        lines.push(name.to_owned());
    }
    lines
}

/// Three significant digits.
fn significant(value: f64) -> String {
    let digits = if value >= 100.0 || value == 0.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$}")
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let options = a.look.options()?;
    for path in &a.output {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("png" | "exr") => {}
            _ => {
                return Err(
                    Error::content(path, "this kind of picture cannot be written", "name it .png or .exr").into()
                );
            }
        }
    }
    let bar = Bar::new("tables", a.sources.len());
    let sources: Vec<Source> = a
        .sources
        .iter()
        .enumerate()
        .map(|(k, text)| Source::open(text, &a.map, &a.scatter, &|share| bar.set(k, share)))
        .collect::<Result<_>>()?;
    bar.finish();
    sources.iter().for_each(Source::print_preparation);
    let tiles: Vec<Tile> = sources
        .iter()
        .map(|s| Tile { caption: caption(s.name(), s.surface().map(|p: &Prediction| p.sq), s.gloss()), brdf: s.brdf() })
        .collect();
    let bar = Bar::new("tiles", 1);
    let picture = render_tiles(&tiles, &options, &|share| bar.set(0, share))?;
    bar.finish();
    for path in &a.output {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            picture.save_exr(path)?;
        } else {
            picture.save_png(path)?;
        }
    }
    if json {
        let files: Vec<_> = a.output.iter().map(|p| p.display().to_string()).collect();
        return print_json(&json!({ "outputs": files, "exposure": picture.exposure() }));
    }
    for path in &a.output {
        println!("wrote {}", path.display());
    }
    Ok(())
}
