//! Text on a picture, in the letters of Noto Sans Mono.

use super::picture::Picture;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// The sizes of letters that captions are set in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lettering {
    /// 16 pixels high.
    Small,
    /// 20 pixels high.
    Medium,
    /// 20 pixels high, bold.
    Strong,
    /// 24 pixels high, bold.
    Heading,
}

impl Lettering {
    fn font(self) -> (FontWeight, RasterHeight) {
        match self {
            Lettering::Small => (FontWeight::Regular, RasterHeight::Size16),
            Lettering::Medium => (FontWeight::Regular, RasterHeight::Size20),
            Lettering::Strong => (FontWeight::Bold, RasterHeight::Size20),
            Lettering::Heading => (FontWeight::Bold, RasterHeight::Size24),
        }
    }

    /// Width of every letter \[pixels\].
    pub fn letter_width(self) -> usize {
        let (weight, size) = self.font();
        get_raster_width(weight, size)
    }

    /// Height of a line \[pixels\].
    pub fn line_height(self) -> usize {
        self.font().1.val() + 4
    }

    /// Width of a text \[pixels\].
    pub fn text_width(self, text: &str) -> usize {
        text.chars().count() * self.letter_width()
    }

    /// Breaks a text into lines of at most `width` pixels, between words where it can.
    pub fn wrap(self, text: &str, width: usize) -> Vec<String> {
        let limit = (width / self.letter_width()).max(1);
        let mut lines = vec![String::new()];
        let mut filled = 0;
        for word in text.split_whitespace() {
            let letters: Vec<char> = word.chars().collect();
            if filled > 0 && filled + 1 + letters.len() <= limit {
                lines.last_mut().unwrap_or(&mut String::new()).push(' ');
                filled += 1;
            } else if filled > 0 {
                lines.push(String::new());
                filled = 0;
            }
            // A word longer than a line is cut: a broken word can be read, a clipped one cannot.
            for letter in letters {
                if filled == limit {
                    lines.push(String::new());
                    filled = 0;
                }
                if let Some(line) = lines.last_mut() {
                    line.push(letter);
                }
                filled += 1;
            }
        }
        lines
    }
}

impl Picture {
    /// Writes one line with its top left corner at `(x, y)` in `ink` (sRGB bytes), blended over what is there.
    ///
    /// Letters outside Latin-1 appear as `?`, except the Greek mu, which is set as the micro sign.
    pub fn write_text(&mut self, x: usize, y: usize, text: &str, lettering: Lettering, ink: [u8; 3]) {
        let (weight, size) = lettering.font();
        for (i, letter) in text.chars().enumerate() {
            let letter = if letter == '\u{3bc}' { '\u{b5}' } else { letter };
            let Some(glyph) = get_raster(letter, weight, size).or_else(|| get_raster('?', weight, size)) else {
                continue;
            };
            let left = x + i * lettering.letter_width();
            for (row, coverage) in glyph.rows().enumerate() {
                for (column, &cover) in coverage.iter().enumerate() {
                    if let Some(bytes) = self.pixel_mut(left + column, y + row) {
                        for (byte, ink) in bytes.iter_mut().zip(ink) {
                            *byte = blend(*byte, ink, cover);
                        }
                    }
                }
            }
        }
    }
}

/// `paper + (ink - paper) cover / 255`, rounded.
fn blend(paper: u8, ink: u8, cover: u8) -> u8 {
    let (paper, ink, cover) = (u32::from(paper), u32::from(ink), u32::from(cover));
    ((paper * (255 - cover) + ink * cover + 127) / 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_letters_of_a_caption_exist() {
        let all = [Lettering::Small, Lettering::Medium, Lettering::Strong, Lettering::Heading];
        for lettering in all {
            let (weight, size) = lettering.font();
            for letter in "Sq 0.8 \u{b5}m, 20\u{b0} 26.2 \u{b1} 0.3 GU, W/(m\u{b2} sr) \u{d7} 1".chars() {
                assert!(get_raster(letter, weight, size).is_some(), "{letter}");
            }
        }
    }

    #[test]
    fn lines_are_broken_between_words_and_never_too_long() {
        let width = 10 * Lettering::Small.letter_width();
        assert_eq!(
            Lettering::Small.wrap("60\u{b0} 73.4 85\u{b0} 77.0 GU", width),
            ["60\u{b0} 73.4", "85\u{b0} 77.0", "GU"]
        );
        assert_eq!(Lettering::Small.wrap("a abcdefghijklm n", width), ["a", "abcdefghij", "klm n"]);
        assert_eq!(Lettering::Small.wrap("", width), [""]);
        assert_eq!(Lettering::Small.wrap("ab", 0), ["a", "b"]);
    }

    #[test]
    fn ink_covers_paper_inside_the_picture_only() {
        let mut picture = Picture::filled(30, 30, [255; 3]);
        picture.write_text(2, 2, "\u{b5}", Lettering::Strong, [0; 3]);
        let mut greek = Picture::filled(30, 30, [255; 3]);
        greek.write_text(2, 2, "\u{3bc}", Lettering::Strong, [0; 3]);
        assert_eq!(picture, greek);
        assert!(picture.rgb().iter().any(|&b| b < 64));
        // Far outside, and letters the font lacks: nothing to fear.
        picture.write_text(1000, 1000, "abc", Lettering::Small, [0; 3]);
        picture.write_text(0, 20, "\u{4e2d}\u{6587}\n", Lettering::Small, [0; 3]);
        assert_eq!((blend(255, 0, 255), blend(255, 0, 0), blend(200, 100, 128)), (0, 255, 150));
    }
}
