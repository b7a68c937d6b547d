//! `asperity tiles`: roughness comparison picture.

use super::map_options::MapOptions;
use super::print_json;
use super::progress::Bar;
use super::scatter_options::ScatterOptions;
use super::source::Source;
use crate::error::{Error, Result};
use crate::math::Estimate;
use crate::render::stage::Backdrop;
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
    #[arg(short, long, required = true, value_name = "FILE", value_parser = super::written::picture)]
    output: Vec<PathBuf>,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    scatter: ScatterOptions,
    #[command(flatten)]
    look: Look,
    /// Show every height map twice, side by side: as rays and as waves predict it
    #[arg(long, help_heading = "Picture")]
    compare: bool,
}

/// Flags of the picture.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct Look {
    /// Most paths per pixel of the picture
    #[arg(long, default_value_t = TilesOptions::default().samples_per_pixel, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Stop each block of pixels when its error is this share of its radiance; 0% gives every pixel all paths
    #[arg(long, default_value = "2%", value_parser = super::quantity::error_share, value_name = "SHARE")]
    error: f64,
    /// Width of one tile in pixels, 64 to 2048
    #[arg(long, default_value_t = 240, value_parser = clap::value_parser!(u16).range(64..=2048))]
    tile_width: u16,
    /// Tiles in a row before the next row begins
    #[arg(long, default_value_t = TilesOptions::default().tiles_per_row as u16, value_parser = clap::value_parser!(u16).range(1..=64))]
    per_row: u16,
    /// What the tiles mirror: a chart with a lamp, lamps, a lit grid or lit text
    #[arg(long, default_value = "chart", value_parser = ["chart", "lamp", "grid", "text"])]
    pattern: String,
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
            error: (self.error > 0.0).then_some(self.error),
            panel_width: usize::from(self.tile_width),
            tiles_per_row: usize::from(self.per_row),
            backdrop: Backdrop::NAMES.iter().find(|(n, _)| *n == self.pattern).map_or(Backdrop::Chart, |(_, b)| *b),
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

/// A source and the word that tells its two predictions apart.
type Shown = (Source, Option<&'static str>);

/// Opens the sources; with `compare` each twice.
fn open(a: &Arguments) -> Result<Vec<Shown>> {
    let ways: Vec<(ScatterOptions, Option<&'static str>)> = if a.compare {
        vec![(a.scatter.by_rays(), Some("rays")), (a.scatter.by_waves(), Some("waves"))]
    } else {
        vec![(a.scatter.clone(), None)]
    };
    let bar = Bar::new("tables", a.sources.len() * ways.len());
    let mut shown = Vec::new();
    for text in &a.sources {
        for (scatter, word) in &ways {
            let part = shown.len();
            let source = Source::open(text, &a.map, scatter, &|share| bar.set(part, share))?;
            if a.compare && source.preparation().is_none() {
                return Err(Error::parameter(
                    format!("`{text}` is not a height map, so there are no two ways to predict it"),
                    "give --compare height maps only",
                ));
            }
            shown.push((source, *word));
        }
    }
    bar.finish();
    Ok(shown)
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    let mut options = a.look.options()?;
    if a.compare {
        options.heading = "What rays and what waves predict".to_owned();
        // Pairs stay in one row.
        options.tiles_per_row = options.tiles_per_row.next_multiple_of(2);
    }
    let shown = open(a)?;
    // A pair was prepared in the same way.
    shown.iter().filter(|(_, word)| *word != Some("waves")).for_each(|(source, _)| source.print_preparation());
    let tiles: Vec<Tile> = shown
        .iter()
        .map(|(s, word)| {
            let mut caption = caption(s.name(), s.surface().map(|p: &Prediction| p.sq), s.gloss());
            if let (Some(word), Some(title)) = (word, caption.first_mut()) {
                title.push_str(&format!(", {word}"));
            }
            Tile { caption, brdf: s.brdf() }
        })
        .collect();
    let bar = Bar::new("tiles", 1);
    let picture = render_tiles(&tiles, &options, &|share| bar.set(0, share))?;
    bar.finish();
    a.output.iter().try_for_each(|path| picture.save(path))?;
    if json {
        let files: Vec<_> = a.output.iter().map(|p| p.display().to_string()).collect();
        let captions: Vec<_> = tiles.iter().map(|t| &t.caption).collect();
        return print_json(&json!({ "outputs": files, "exposure": picture.exposure(), "captions": captions }));
    }
    for path in &a.output {
        println!("wrote {}", path.display());
    }
    Ok(())
}
