//! Tiles of several materials side by side, in identical scenes under one exposure, with captions.

use super::caption::Lettering;
use super::film::Film;
use super::integrator::{RenderOptions, render};
use super::picture::{Picture, exr_bytes};
use super::stage;
use crate::error::{Error, Result};
use crate::optics::brdf::Brdf;
use crate::output;
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
    /// Paths per pixel.
    pub samples_per_pixel: u32,
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
            samples_per_pixel: 128,
            seed: 1,
            exposure: None,
        }
    }
}

/// A finished comparison: radiance, and the same pixels exposed and labelled.
pub struct TilesPicture {
    film: Film,
    picture: Picture,
    exposure: f64,
    comment: String,
}

impl TilesPicture {
    /// Radiance of the composition [W/(m2 sr)], 0 with 0 samples where the picture has paper and text.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// The labelled picture.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Display value = sRGB(exposure x radiance) \[m2 sr/W\].
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    /// Writes the labelled picture as `.png`.
    ///
    /// # Errors
    /// `Error::Io` naming `path`.
    pub fn save_png(&self, path: &Path) -> Result<()> {
        self.picture.save_png(path)
    }

    /// Writes the radiance as `.exr`, pixel for pixel the layout of the `.png`, without text.
    ///
    /// # Errors
    /// `Error::Io` naming `path`.
    pub fn save_exr(&self, path: &Path) -> Result<()> {
        let bytes = exr_bytes(&self.film, &self.comment).map_err(|e| Error::io(path, "write", e))?;
        output::write_bytes(path, &bytes)
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
    let camera = stage::camera(width as f64 / height as f64)?;
    let settings = RenderOptions {
        width,
        height,
        samples_per_pixel: options.samples_per_pixel,
        seed: options.seed,
        ..RenderOptions::default()
    };
    let share = 1.0 / tiles.len() as f64;
    let mut films = Vec::new();
    for (i, tile) in tiles.iter().enumerate() {
        let scene = stage::scene(tile.brdf)?;
        films.push(render(&scene, &camera, &settings, &|done| progress(share * (i as f64 + done)))?);
    }
    let exposure = match options.exposure {
        Some(exposure) => exposure,
        None => automatic_exposure(&films)?,
    };
    compose(tiles, &films, options, exposure)
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

/// The exposure that shows the bright cells in the mirror of the most reflecting tile at 75 % of white, to two digits.
fn automatic_exposure(films: &[Film]) -> Result<f64> {
    let mut brightest = 0.0f32;
    for film in films {
        let (width, height) = (film.width(), film.height());
        let camera = stage::camera(width as f64 / height as f64)?;
        let top = stage::tile_top()?;
        let on_tile = |i: usize| {
            let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            top.intersect(&camera.ray(x / width as f64, y / height as f64), f64::INFINITY).is_some()
        };
        let mut seen: Vec<f32> =
            film.pixels().iter().enumerate().filter(|(i, _)| on_tile(*i)).map(|(_, p)| p.radiance[1]).collect();
        seen.sort_by(f32::total_cmp);
        // About a third of the mirror image is bright cells, a few percent are the lamp.
        if let Some(&bright) = seen.get(seen.len() * 85 / 100) {
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

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [24, 26, 30];
const FAINT_INK: [u8; 3] = [96, 100, 108];
const MARGIN: usize = 28;
const GAP: usize = 14;

fn compose(tiles: &[Tile], films: &[Film], options: &TilesOptions, exposure: f64) -> Result<TilesPicture> {
    let (width, height) = (options.panel_width, panel_height(options.panel_width));
    let columns = tiles.len().min(options.tiles_per_row);
    let inner = columns * width + (columns - 1) * GAP;
    let heading = Lettering::Heading.wrap(&options.heading, inner);
    let note = format!(
        "Same lamp, pattern and exposure for every tile, seen {:.0}\u{b0} from the normal. Path traced, {} paths a \
         pixel; display = sRGB({} m\u{b2} sr/W \u{d7} radiance).",
        stage::VIEW_ANGLE_DEG,
        options.samples_per_pixel,
        short(exposure),
    );
    let note_lines = Lettering::Small.wrap(&note, inner);
    let captions: Vec<Vec<(Lettering, String)>> = tiles.iter().map(|t| caption_lines(&t.caption, width)).collect();
    let caption_height = |lines: &Vec<(Lettering, String)>| lines.iter().map(|l| l.0.line_height()).sum::<usize>();
    let below = captions.iter().map(caption_height).max().unwrap_or(0) + GAP;
    let top = MARGIN + heading.len() * Lettering::Heading.line_height() + GAP / 2;
    let rows = tiles.len().div_ceil(columns);
    let pitch = height + GAP / 2 + below;
    let bottom = top + rows * pitch;
    let mut film =
        Film::new(inner + 2 * MARGIN, bottom + note_lines.len() * Lettering::Small.line_height() + MARGIN - 8)?;
    let mut picture = Picture::filled(film.width(), film.height(), PAPER);
    write_lines(&mut picture, MARGIN, MARGIN, &heading, Lettering::Heading, INK);
    write_lines(&mut picture, MARGIN, bottom, &note_lines, Lettering::Small, FAINT_INK);
    for (i, (panel, lines)) in films.iter().zip(&captions).enumerate() {
        let (x, y) = (MARGIN + (i % columns) * (width + GAP), top + (i / columns) * pitch);
        film.paste(panel, x, y);
        picture.draw_film(panel, x, y, exposure);
        picture.draw_frame(x, y, width, height, INK);
        let mut line_top = y + height + GAP / 2;
        for (lettering, line) in lines {
            let centred = x + (width - lettering.text_width(line).min(width)) / 2;
            picture.write_text(centred, line_top, line, *lettering, INK);
            line_top += lettering.line_height();
        }
    }
    let names: Vec<String> = tiles.iter().map(|t| t.caption.join(", ")).collect();
    let comment = format!(
        "{}. Tiles, left to right, row by row: {}. Radiance in W/(m2 sr). {note} Seed {}.",
        options.heading,
        names.join("; "),
        options.seed,
    );
    Ok(TilesPicture { film, picture, exposure, comment })
}

fn caption_lines(caption: &[String], width: usize) -> Vec<(Lettering, String)> {
    let styled =
        caption.iter().enumerate().map(|(i, line)| (if i == 0 { Lettering::Strong } else { Lettering::Medium }, line));
    styled.flat_map(|(style, line)| style.wrap(line, width).into_iter().map(move |l| (style, l))).collect()
}

fn write_lines(picture: &mut Picture, x: usize, mut y: usize, lines: &[String], lettering: Lettering, ink: [u8; 3]) {
    for line in lines {
        picture.write_text(x, y, line, lettering, ink);
        y += lettering.line_height();
    }
}

/// Two significant digits.
fn short(x: f64) -> String {
    let decimals = (1.0 - x.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{x:.decimals$}")
}
