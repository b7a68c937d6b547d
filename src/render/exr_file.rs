//! Radiance back from `.exr` files.

use super::film::{Film, Pixel};
use crate::error::{Error, Result};
use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, ReadChannels, ReadLayers, read};
use std::path::Path;

/// What an `.exr` file says beside its pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExrNotes {
    /// The program that wrote it.
    pub software: Option<String>,
    pub comment: Option<String>,
}

impl Film {
    /// Reads the channels `R G B` [W/(m2 sr)], and `standard_error.R G B` and `samples` if they are there, of the first
    /// layer that has them.
    ///
    /// # Errors
    /// `Error::Io`, or `Error::Content` naming the file if it is no `.exr` file or has no colours.
    pub fn load_exr(path: &Path) -> Result<(Film, ExrNotes)> {
        // The library's own errors about a missing file do not name it.
        std::fs::File::open(path).map_err(|e| Error::io(path, "read", e))?;
        let bad = |what: String| Error::content(path, what, "name an .exr file with channels R, G and B");
        let image: Image<exr::prelude::SmallVec<[Layer<AnyChannels<FlatSamples>>; 2]>> = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .from_file(path)
            .map_err(|e| bad(format!("the picture cannot be read: {e}")))?;
        let find = |layer: &Layer<AnyChannels<FlatSamples>>, name: &str| -> Option<Vec<f32>> {
            let channel = layer.channel_data.list.iter().find(|c| c.name.eq(name))?;
            Some(match &channel.sample_data {
                FlatSamples::F32(v) => v.clone(),
                FlatSamples::F16(v) => v.iter().map(|x| x.to_f32()).collect(),
                FlatSamples::U32(v) => v.iter().map(|&x| x as f32).collect(),
            })
        };
        let coloured = |l: &&Layer<AnyChannels<FlatSamples>>| ["R", "G", "B"].iter().all(|c| find(l, c).is_some());
        let layer = image
            .layer_data
            .iter()
            .find(coloured)
            .ok_or_else(|| bad("the picture has no channels R, G and B".to_owned()))?;
        let mut film = Film::new(layer.size.width(), layer.size.height())?;
        let mut fill = |name: &str, set: &dyn Fn(&mut Pixel, f32)| {
            if let Some(values) = find(layer, name) {
                film.pixels_mut().iter_mut().zip(values).for_each(|(pixel, value)| set(pixel, value));
            }
        };
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            fill(name, &|pixel, value| pixel.radiance[k] = value);
            fill(&format!("standard_error.{name}"), &|pixel, value| pixel.standard_error[k] = value);
        }
        fill("samples", &|pixel, value| pixel.samples = value as u32);
        let text = |t: &Option<exr::prelude::Text>| t.as_ref().map(ToString::to_string);
        let notes =
            ExrNotes { software: text(&layer.attributes.software_name), comment: text(&layer.attributes.comments) };
        Ok((film, notes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::save_exr;

    #[test]
    fn a_film_survives_the_way_through_a_file() {
        let mut film = Film::new(5, 3).unwrap();
        for (k, pixel) in film.pixels_mut().iter_mut().enumerate() {
            let x = k as f32;
            *pixel = Pixel { radiance: [x, 1e6 + x, 1e-9], standard_error: [0.5, x, 0.0], samples: 7 + k as u32 };
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f.exr");
        save_exr(&film, "seed 3", &path).unwrap();
        let (back, notes) = Film::load_exr(&path).unwrap();
        assert_eq!(back, film);
        assert!(notes.software.unwrap().starts_with("asperity") && notes.comment.unwrap() == "seed 3");
        std::fs::write(&path, b"no picture").unwrap();
        assert!(Film::load_exr(&path).unwrap_err().to_string().contains("f.exr"));
        assert!(Film::load_exr(&folder.path().join("g.exr")).unwrap_err().to_string().contains("g.exr"));
    }
}
