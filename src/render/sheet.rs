//! Films on paper: panels in rows under a heading, captions below each, a note at the foot.

use super::caption::Lettering;
use super::film::Film;
use super::picture::{Picture, exr_bytes};
use crate::error::{Error, Result};
use crate::output;
use std::path::Path;

/// Lines below a panel, centred under a place of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Caption {
    /// Middle of the lines and their greatest width, as shares of the panel's width.
    pub centre: f64,
    pub width: f64,
    /// The first line is set in bold.
    pub lines: Vec<String>,
}

/// A film and what stands below it.
pub struct Panel {
    pub film: Film,
    pub captions: Vec<Caption>,
}

/// What goes around the panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Left out if empty.
    pub heading: String,
    /// Small print at the foot.
    pub note: String,
    pub panels_per_row: usize,
    /// Display value = sRGB(exposure x radiance) \[m2 sr/W\].
    pub exposure: f64,
    /// Goes into the header of an `.exr` file, after the note.
    pub comment: String,
}

/// A composition: radiance, and the same pixels exposed and labelled.
pub struct Sheet {
    film: Film,
    picture: Picture,
    exposure: f64,
    comment: String,
}

impl Sheet {
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

    /// Writes the labelled picture as `.png`, or the radiance as `.exr`, pixel for pixel the same layout without text.
    ///
    /// # Errors
    /// `Error::Io` naming `path`; `Error::Content` for another ending.
    pub fn save(&self, path: &Path) -> Result<()> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("png") => self.picture.save_png(path),
            Some("exr") => {
                let bytes = exr_bytes(&self.film, &self.comment).map_err(|e| Error::io(path, "write", e))?;
                output::write_bytes(path, &bytes)
            }
            _ => Err(Error::content(path, "this kind of picture cannot be written", "name it .png or .exr")),
        }
    }

    /// Lays panels of one size out in rows.
    ///
    /// # Errors
    /// `Error::Parameter` if there is no panel, the panels differ in size or the whole is too large.
    pub fn compose(panels: &[Panel], layout: &Layout) -> Result<Sheet> {
        let (width, height) = match panels.first() {
            Some(panel) => (panel.film.width(), panel.film.height()),
            None => return Err(Error::parameter("there is no panel to show", "render at least one")),
        };
        if panels.iter().any(|p| (p.film.width(), p.film.height()) != (width, height)) || layout.panels_per_row == 0 {
            return Err(Error::parameter(
                "the panels do not fit into rows",
                "give panels of one size, 1 or more a row",
            ));
        }
        let columns = panels.len().min(layout.panels_per_row);
        let inner = columns * width + (columns - 1) * GAP;
        let heading = if layout.heading.is_empty() { vec![] } else { Lettering::Heading.wrap(&layout.heading, inner) };
        let note = if layout.note.is_empty() { vec![] } else { Lettering::Small.wrap(&layout.note, inner) };
        let texts: Vec<Vec<Text>> = panels.iter().map(|p| Text::all(&p.captions, width)).collect();
        let top =
            MARGIN + if heading.is_empty() { 0 } else { heading.len() * Lettering::Heading.line_height() + GAP / 2 };
        // A row is as high as its highest caption asks.
        let mut bottom = top;
        let tops: Vec<usize> = texts
            .chunks(columns)
            .map(|row| {
                let start = bottom;
                let caption = row.iter().flatten().map(Text::height).max().unwrap_or(0);
                bottom += height + GAP + if caption > 0 { caption + GAP / 2 } else { 0 };
                start
            })
            .collect();
        let foot = if note.is_empty() { 0 } else { note.len() * Lettering::Small.line_height() };
        let mut film = Film::new(inner + 2 * MARGIN, bottom + foot + MARGIN - 8)?;
        let mut picture = Picture::filled(film.width(), film.height(), PAPER);
        write_lines(&mut picture, [MARGIN, MARGIN], &heading, Lettering::Heading, INK);
        write_lines(&mut picture, [MARGIN, bottom], &note, Lettering::Small, FAINT_INK);
        for (i, (panel, texts)) in panels.iter().zip(&texts).enumerate() {
            let (x, y) = (MARGIN + (i % columns) * (width + GAP), tops[i / columns]);
            film.paste(&panel.film, x, y);
            picture.draw_film(&panel.film, x, y, layout.exposure);
            picture.draw_frame(x, y, width, height, INK);
            texts.iter().for_each(|text| text.write(&mut picture, x, width, y + height + GAP / 2));
        }
        let comment = format!("{}. {} Radiance in W/(m2 sr). {}", layout.heading, layout.note, layout.comment);
        Ok(Sheet { film, picture, exposure: layout.exposure, comment })
    }
}

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [24, 26, 30];
const FAINT_INK: [u8; 3] = [96, 100, 108];
const MARGIN: usize = 28;
const GAP: usize = 14;

/// A caption broken into lines.
struct Text {
    /// From the left edge of the panel.
    centre: usize,
    lines: Vec<(Lettering, String)>,
}

impl Text {
    /// The captions of a panel, in small letters if one of their lines is too long: small letters before broken lines.
    fn all(captions: &[Caption], panel: usize) -> Vec<Text> {
        let room = |c: &Caption| (c.width * panel as f64).round().max(1.0) as usize;
        let fits = |c: &Caption| c.lines.iter().enumerate().all(|(i, l)| Self::style(i, true).text_width(l) <= room(c));
        let large = captions.iter().all(fits);
        captions
            .iter()
            .map(|caption| {
                let lines = caption.lines.iter().enumerate().flat_map(|(i, line)| {
                    let style = Self::style(i, large);
                    style.wrap(line, room(caption)).into_iter().map(move |l| (style, l))
                });
                Text { centre: (caption.centre * panel as f64).round().max(0.0) as usize, lines: lines.collect() }
            })
            .collect()
    }

    fn style(line: usize, large: bool) -> Lettering {
        match (line, large) {
            (0, _) => Lettering::Strong,
            (_, true) => Lettering::Medium,
            (_, false) => Lettering::Small,
        }
    }

    fn height(&self) -> usize {
        self.lines.iter().map(|(style, _)| style.line_height()).sum()
    }

    fn write(&self, picture: &mut Picture, left: usize, panel: usize, mut y: usize) {
        for (style, line) in &self.lines {
            let width = style.text_width(line);
            // Kept inside the panel.
            let start = self.centre.saturating_sub(width / 2).min(panel.saturating_sub(width));
            picture.write_text(left + start, y, line, *style, INK);
            y += style.line_height();
        }
    }
}

fn write_lines(picture: &mut Picture, [x, mut y]: [usize; 2], lines: &[String], lettering: Lettering, ink: [u8; 3]) {
    for line in lines {
        picture.write_text(x, y, line, lettering, ink);
        y += lettering.line_height();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(width: usize, lines: &[&str]) -> Panel {
        let lines = lines.iter().map(|l| (*l).to_owned()).collect();
        Panel { film: Film::new(width, 20).unwrap(), captions: vec![Caption { centre: 0.5, width: 1.0, lines }] }
    }

    fn layout() -> Layout {
        Layout { heading: String::new(), note: String::new(), panels_per_row: 2, exposure: 1.0, comment: String::new() }
    }

    #[test]
    fn panels_wrap_and_captions_stay_inside() {
        let sheet = Sheet::compose(&[panel(90, &["a"]), panel(90, &["b", "c"]), panel(90, &[])], &layout()).unwrap();
        assert_eq!(sheet.film().width(), 2 * 90 + GAP + 2 * MARGIN);
        // A row is as high as its highest caption.
        let lines = Lettering::Strong.line_height() + Lettering::Medium.line_height();
        assert_eq!(sheet.film().height(), 2 * (20 + GAP) + lines + GAP / 2 + 2 * MARGIN - 8);
        assert_eq!((sheet.picture().width(), sheet.picture().height()), (sheet.film().width(), sheet.film().height()));
        // A caption at the very edge is moved inside: nothing but paper outside of the panel.
        let mut edge = panel(90, &[]);
        edge.captions = vec![Caption { centre: 1.0, width: 1.0, lines: vec!["wwwwww".into()] }];
        let sheet = Sheet::compose(&[edge], &layout()).unwrap();
        let white = |x: usize, y: usize| sheet.picture().rgb()[3 * (y * sheet.picture().width() + x)] == 255;
        assert!((0..sheet.film().height()).all(|y| (MARGIN + 91..sheet.film().width()).all(|x| white(x, y))));
        assert!((MARGIN + 21..MARGIN + 50).any(|y| (MARGIN..MARGIN + 90).any(|x| !white(x, y))));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(Sheet::compose(&[], &layout()).is_err());
        assert!(Sheet::compose(&[panel(90, &[]), panel(91, &[])], &layout()).is_err());
        let sheet = Sheet::compose(&[panel(90, &[])], &layout()).unwrap();
        assert!(sheet.save(Path::new("picture.gif")).unwrap_err().to_string().contains(".png or .exr"));
    }
}
