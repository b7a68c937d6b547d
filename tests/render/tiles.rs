//! The comparison picture and its files.

use crate::materials::Beckmann;
use asperity::render::{Tile, TilesOptions, TilesPicture, render_tiles};
use std::path::Path;

fn glass(alphas: &[f64]) -> Vec<Beckmann> {
    alphas.iter().map(|&alpha| Beckmann { alpha, n: 1.5 }).collect()
}

fn compare(materials: &[Beckmann], options: &TilesOptions) -> TilesPicture {
    let tiles: Vec<Tile> = materials
        .iter()
        .map(|m| Tile {
            caption: vec![
                format!("alpha {}", m.alpha),
                "20\u{b0} 26.2".into(),
                "60\u{b0} 73.4".into(),
                "85\u{b0} 77.0 GU".into(),
            ],
            brdf: m,
        })
        .collect();
    render_tiles(&tiles, options, &|_| {}).unwrap()
}

/// `cargo test --release --test render -- --ignored --nocapture sample_picture` writes under `target/tmp`.
#[test]
#[ignore = "a picture to look at"]
fn sample_picture() {
    let start = std::time::Instant::now();
    let picture = compare(&glass(&[0.0003, 0.005, 0.01, 0.015, 0.02, 0.04, 0.08]), &TilesOptions::default());
    println!("{:.1} s, exposure {}", start.elapsed().as_secs_f64(), picture.exposure());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    picture.save_png(&folder.join("tiles.png")).unwrap();
    picture.save_exr(&folder.join("tiles.exr")).unwrap();
    println!("{}", folder.join("tiles.png").display());
}
