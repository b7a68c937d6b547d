//! Tiles of several materials side by side, in identical scenes under one exposure, with captions.

use super::film::Film;
use super::integrator::{RenderOptions, render};
use super::material::{Coat, Reflector};
use super::picture::Picture;
use super::sheet::{Caption, Layout, Panel, Sheet};
use super::stage::{Backdrop, Stage, VIEW_ANGLE_DEG};
use crate::error::{Error, Result};
use crate::optics::brdf::Brdf;
use glam::DVec3;
use std::path::Path;

/// A material to show and the lines below it, such as "Sq 201 nm", "60\u{b0} 73.4 GU".
pub struct Tile<'a> {
    /// The first line is set in bold.
    pub caption: Vec<String>,
    pub brdf: &'a dyn Brdf,
}

/// Size, effort and words of a comparison picture.
#[derive(Debug, Clone, PartialEq)]
pub struct TilesOptions {
    pub heading: String,
    /// Width of a tile's panel \[pixels\], 64 to 2048; it is a little higher than wide.
    pub panel_width: usize,
    pub tiles_per_row: usize,
    /// What the tiles mirror.
    pub backdrop: Backdrop,
    /// Most paths per pixel.
    pub samples_per_pixel: u32,
    /// Share of its radiance at which a block of pixels stops earlier, see [`RenderOptions::error`].
    pub error: Option<f64>,
    pub seed: u64,
    /// Display value = sRGB(exposure x radiance), in m2 sr/W; `None` exposes for the brightest tile.
    pub exposure: Option<f64>,
}

impl Default for TilesOptions {
    fn default() -> Self {
        TilesOptions {
            heading: "Gloss and surface roughness".into(),
            panel_width: 240,
            tiles_per_row: 8,
            backdrop: Backdrop::Chart,
            samples_per_pixel: 128,
            error: Some(0.02),
            seed: 1,
            exposure: None,
        }
    }
}

/// A finished comparison: radiance, and the same pixels exposed and labelled.
pub struct TilesPicture {
    sheet: Sheet,
}

impl TilesPicture {
    /// Radiance of the composition [W/(m2 sr)], 0 with 0 samples where the picture has paper and text.
    pub fn film(&self) -> &Film {
        self.sheet.film()
    }

    /// The labelled picture.
    pub fn picture(&self) -> &Picture {
        self.sheet.picture()
    }

    /// Display value = sRGB(exposure x radiance) \[m2 sr/W\].
    pub fn exposure(&self) -> f64 {
        self.sheet.exposure()
    }

    /// Writes the labelled picture as `.png`, or the radiance as `.exr`.
    ///
    /// # Errors
    /// As [`Sheet::save`].
    pub fn save(&self, path: &Path) -> Result<()> {
        self.sheet.save(path)
    }
}

/// Path-traces every tile in the same scene, with the same random numbers, and composes them left to right.
///
/// `progress` is called from any thread with the finished fraction.
///
/// # Errors
/// `Error::Parameter` if there are no tiles, an option is out of range or a BRDF returned a non-finite number.
pub fn render_tiles(tiles: &[Tile], options: &TilesOptions, progress: &(dyn Fn(f64) + Sync)) -> Result<TilesPicture> {
    check(tiles, options)?;
    let (width, height) = (options.panel_width, panel_height(options.panel_width));
    let stage = Stage::new(1, options.backdrop)?;
    let camera = stage.camera(width as f64 / height as f64)?;
    let settings = RenderOptions {
        width,
        height,
        samples_per_pixel: options.samples_per_pixel,
        error: options.error,
        seed: options.seed,
        ..RenderOptions::default()
    };
    let share = 1.0 / tiles.len() as f64;
    let mut panels = Vec::new();
    for (i, tile) in tiles.iter().enumerate() {
        let scene = stage.scene(&[Coat::new(Reflector::Grey(tile.brdf), DVec3::ONE)])?;
        let film = render(&scene, &camera, &settings, &|done| progress(share * (i as f64 + done)))?;
        panels.push(Panel { film, captions: vec![Caption { centre: 0.5, width: 1.0, lines: tile.caption.clone() }] });
    }
    let exposure = match options.exposure {
        Some(exposure) => exposure,
        None => automatic_exposure(&stage, &panels)?,
    };
    let names: Vec<String> = tiles.iter().map(|t| t.caption.join(", ")).collect();
    let layout = Layout {
        heading: options.heading.clone(),
        note: format!(
            "Same {} and exposure for every tile, seen {VIEW_ANGLE_DEG:.0}\u{b0} from the normal. Path traced, {} paths a \
             pixel{}; display = sRGB({} m\u{b2} sr/W \u{d7} radiance).",
            options.backdrop.words(),
            options.samples_per_pixel,
            options.error.map_or(String::new(), |e| format!(" or an error of {} %", 100.0 * e)),
            short(exposure),
        ),
        panels_per_row: options.tiles_per_row,
        exposure,
        comment: format!("Tiles, left to right, row by row: {}. Seed {}.", names.join("; "), options.seed),
    };
    Ok(TilesPicture { sheet: Sheet::compose(&panels, &layout)? })
}

fn check(tiles: &[Tile], options: &TilesOptions) -> Result<()> {
    if tiles.is_empty() {
        return Err(Error::parameter("there are no tiles to compare", "give at least one material"));
    }
    if !(64..=2048).contains(&options.panel_width) {
        let what = format!("a panel of {} pixels is not possible", options.panel_width);
        return Err(Error::parameter(what, "choose a panel width from 64 to 2048 pixels"));
    }
    if options.tiles_per_row == 0 {
        return Err(Error::parameter("a row needs at least one tile", "try 8 tiles per row"));
    }
    match options.exposure {
        Some(e) if !(e > 0.0 && e.is_finite()) => {
            Err(Error::parameter(format!("the exposure {e} shows nothing"), "give an exposure above 0, or none"))
        }
        _ => Ok(()),
    }
}

fn panel_height(width: usize) -> usize {
    width * 21 / 20
}

/// The exposure that shows the bright parts in the mirror of the most reflecting tile at 75 % of white, to two digits.
fn automatic_exposure(stage: &Stage, panels: &[Panel]) -> Result<f64> {
    let mut brightest = 0.0f32;
    for Panel { film, .. } in panels {
        let (width, height) = (film.width(), film.height());
        let camera = stage.camera(width as f64 / height as f64)?;
        let top = stage.top(0)?;
        let on_tile = |i: usize| {
            let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            top.intersect(&camera.ray(x / width as f64, y / height as f64), f64::INFINITY).is_some()
        };
        let mut seen: Vec<f32> =
            film.pixels().iter().enumerate().filter(|(i, _)| on_tile(*i)).map(|(_, p)| p.radiance[1]).collect();
        seen.sort_by(f32::total_cmp);
        let rank = (stage.backdrop().dark_share() * seen.len() as f64) as usize;
        if let Some(&bright) = seen.get(rank) {
            brightest = brightest.max(bright);
        }
    }
    if brightest <= 0.0 {
        return Ok(1.0);
    }
    let exact = 0.75 / f64::from(brightest);
    let step = 10f64.powf(exact.log10().floor() - 1.0);
    Ok((exact / step).round() * step)
}

/// Two significant digits.
pub fn short(x: f64) -> String {
    let decimals = (1.0 - x.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{x:.decimals$}")
}
