//! The comparison picture and its files.

use crate::materials::{Beckmann, Mirror};
use asperity::optics::brdf::Brdf;
use asperity::render::stage::Backdrop;
use asperity::render::{Film, Tile, TilesOptions, TilesPicture, exr_bytes, render_tiles};
use std::sync::Mutex;

fn glass(alphas: &[f64]) -> Vec<Beckmann> {
    alphas.iter().map(|&alpha| Beckmann { alpha, n: 1.5 }).collect()
}

fn tile(brdf: &dyn Brdf) -> Tile<'_> {
    let caption = ["Sq 201 nm", "20\u{b0} 26.2", "60\u{b0} 73.4", "85\u{b0} 77.0 GU"].map(String::from).to_vec();
    Tile { caption, brdf }
}

fn compare(materials: &[Beckmann], options: &TilesOptions) -> TilesPicture {
    let tiles: Vec<Tile> = materials.iter().map(|m| tile(m)).collect();
    render_tiles(&tiles, options, &|_| {}).unwrap()
}

fn quick() -> TilesOptions {
    TilesOptions { panel_width: 64, samples_per_pixel: 16, ..TilesOptions::default() }
}

/// Standard deviation of neighbouring differences along a row of a panel: how much pattern is left.
fn contrast(film: &Film, x: std::ops::Range<usize>, y: usize) -> f64 {
    let row: Vec<f64> = x.map(|x| f64::from(film.pixel(x, y).unwrap().radiance[1])).collect();
    row.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn one_and_two_threads_write_the_same_bytes() {
    let materials = glass(&[0.005, 0.05]);
    let files = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("t.png"), folder.path().join("t.exr"));
        pool.install(|| {
            let picture = compare(&materials, &quick());
            picture.save(&png).unwrap();
            picture.save(&exr).unwrap();
        });
        (std::fs::read(png).unwrap(), std::fs::read(exr).unwrap())
    });
    assert!(files[0] == files[1], "the files depend on the number of threads");
    let other = compare(&materials, &TilesOptions { seed: 2, ..quick() });
    assert!(other.picture().png_bytes().unwrap() != files[0].0, "the seed changes nothing");
}

#[test]
fn the_exr_file_holds_the_film() {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
    let picture = compare(&glass(&[0.02]), &quick());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiles.exr");
    picture.save(&path).unwrap();
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let layer = image.from_file(&path).unwrap().layer_data;
    let film = picture.film();
    assert_eq!((layer.size.x(), layer.size.y()), (film.width(), film.height()));
    let floats = |name: &str| match &layer.channel_data.list.iter().find(|c| c.name == *name).unwrap().sample_data {
        FlatSamples::F32(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    };
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected: Vec<f32> = film.pixels().iter().map(|p| p.radiance[i]).collect();
        assert_eq!(floats(name), expected);
        let expected: Vec<f32> = film.pixels().iter().map(|p| p.standard_error[i]).collect();
        assert_eq!(floats(&format!("standard_error.{name}")), expected);
    }
    let samples = layer.channel_data.list.iter().find(|c| c.name == *"samples").unwrap();
    match &samples.sample_data {
        FlatSamples::U32(values) => assert!(values.iter().eq(film.pixels().iter().map(|p| &p.samples))),
        other => panic!("{other:?}"),
    }
    let comment = layer.attributes.comments.unwrap().to_string();
    assert!(comment.contains("W/(m2 sr)") && comment.contains("Sq 201 nm"), "{comment}");
    // A comment beyond Latin-1 does not stop the file.
    assert!(exr_bytes(film, "\u{4e2d}\u{6587}").is_ok());
}

#[test]
fn the_png_file_holds_the_picture() {
    let picture = compare(&glass(&[0.02]), &quick());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiles.png");
    picture.save(&path).unwrap();
    let decoded = image::open(&path).unwrap().into_rgb8();
    assert_eq!(decoded.as_raw(), picture.picture().rgb());
    assert_eq!(picture.picture().width(), picture.film().width());
    assert_eq!(picture.picture().height(), picture.film().height());
    let nowhere = folder.path().join("missing").join("tiles.png");
    assert!(picture.save(&nowhere).unwrap_err().to_string().contains("tiles.png"));
}

#[test]
fn the_pattern_fades_as_roughness_grows() {
    let options = TilesOptions { samples_per_pixel: 64, ..quick() };
    let picture = compare(&glass(&[0.001, 0.02, 0.08]), &options);
    let film = picture.film();
    let first = film.pixels().iter().position(|p| p.samples > 0).unwrap();
    let (left_edge, top) = (first % film.width(), first / film.width());
    let begins = |&x: &usize| sampled(film, x, top) && !sampled(film, x - 1, top);
    let starts: Vec<usize> = (left_edge..film.width()).filter(begins).collect();
    assert_eq!(starts.len(), 3);
    // Along the bars, two fifths of the way down the panel.
    let left: Vec<f64> = starts.iter().map(|&x| contrast(film, x + 14..x + 50, top + 28)).collect();
    assert!(left[0] > 1.2 * left[1] && left[1] > 2.0 * left[2], "{left:?}");
}

fn sampled(film: &Film, x: usize, y: usize) -> bool {
    film.pixel(x, y).unwrap().samples > 0
}

#[test]
fn tiles_wrap_into_rows_and_progress_reaches_one() {
    let materials = glass(&[0.01, 0.02, 0.03]);
    let tiles: Vec<Tile> = materials.iter().map(|m| tile(m)).collect();
    let options = TilesOptions { tiles_per_row: 2, samples_per_pixel: 1, ..quick() };
    let farthest = Mutex::new(0.0f64);
    let wrapped = render_tiles(&tiles, &options, &|done| {
        let mut farthest = farthest.lock().unwrap();
        *farthest = farthest.max(done);
    });
    let wrapped = wrapped.unwrap();
    assert!((*farthest.lock().unwrap() - 1.0).abs() < 1e-12);
    let single = compare(&materials[..1], &options);
    let added = wrapped.film().width() - single.film().width();
    assert!((64..2 * 64).contains(&added), "{added}");
    let rows = |p: &TilesPicture| (0..p.film().height()).filter(|&y| (0..99).any(|x| sampled(p.film(), x, y))).count();
    assert_eq!(rows(&wrapped), 2 * rows(&single));
    let samples = |p: &TilesPicture| p.film().pixels().iter().filter(|p| p.samples > 0).count();
    assert_eq!(samples(&wrapped), 3 * samples(&single));
}

/// Every backdrop lights the mirror of a polished tile in part, and the exposure shows it.
#[test]
fn every_pattern_is_seen_in_the_mirror() {
    let polished = Beckmann { alpha: 0.001, n: 1.5 };
    let mut pictures = Vec::new();
    for (name, backdrop) in Backdrop::NAMES {
        let options = TilesOptions { backdrop, panel_width: 96, samples_per_pixel: 8, ..quick() };
        let picture = render_tiles(&[tile(&polished)], &options, &|_| {}).unwrap();
        let radiances: Vec<f64> =
            picture.film().pixels().iter().filter(|p| p.samples > 0).map(|p| f64::from(p.radiance[1])).collect();
        let shown = radiances.iter().filter(|&&r| r * picture.exposure() > 0.5).count() as f64 / radiances.len() as f64;
        assert!((0.004..0.6).contains(&shown), "{name}: {shown}");
        let dark = radiances.iter().filter(|&&r| r * picture.exposure() < 0.1).count() as f64 / radiances.len() as f64;
        assert!(dark > 0.2, "{name}: {dark}");
        pictures.push(picture.picture().clone());
    }
    assert!((1..4).all(|k| pictures[k] != pictures[0]));
}

/// All tiles share one exposure, chosen for the most reflecting: glass beside a mirror is dark.
#[test]
fn the_exposure_is_common_and_follows_the_brightest_tile() {
    let smooth = Beckmann { alpha: 0.001, n: 1.5 };
    let alone = render_tiles(&[tile(&smooth)], &quick(), &|_| {}).unwrap();
    let beside = render_tiles(&[tile(&smooth), tile(&Mirror)], &quick(), &|_| {}).unwrap();
    // Reflectance of glass at 55 deg is about 0.07: the mirror needs about a fourteenth of the exposure.
    let ratio = alone.exposure() / beside.exposure();
    assert!((10.0..20.0).contains(&ratio), "{ratio}");
    let fixed = render_tiles(&[tile(&Mirror)], &TilesOptions { exposure: Some(0.5), ..quick() }, &|_| {}).unwrap();
    assert_eq!(fixed.exposure(), 0.5);
}

#[test]
fn impossible_comparisons_are_refused() {
    let refused =
        |tiles: &[Tile], options: TilesOptions| render_tiles(tiles, &options, &|_| {}).err().unwrap().to_string();
    assert!(refused(&[], quick()).contains("no tiles"));
    let mirror = [tile(&Mirror)];
    assert!(refused(&mirror, TilesOptions { panel_width: 3, ..quick() }).contains("3 pixels"));
    assert!(refused(&mirror, TilesOptions { tiles_per_row: 0, ..quick() }).contains("row"));
    assert!(refused(&mirror, TilesOptions { exposure: Some(f64::NAN), ..quick() }).contains("exposure"));
    assert!(refused(&mirror, TilesOptions { samples_per_pixel: 0, ..quick() }).contains("sample"));
}
