//! Figures 8, 11 and 12: tiles in a row that mirror a lit chart and a lamp.

use super::epoxy::{Map, table};
use super::finish::Finish;
use super::meters::{Solved, ward_of_gloss, ward_of_haze};
use crate::error::Result;
use crate::meter::{Geometry, Options, gloss};
use crate::optics::Material;
use crate::render::stage::{Backdrop, Stage};
use crate::render::{Coat, Scene};
use rayon::prelude::*;

/// Black glass under clear epoxy: both have nearly this index.
const EPOXY: Material = Material::Dielectric { n: 1.5 };
/// The maps of the epoxy series whose roughness the paper names.
const MAPS: [Map; 2] = [Map { sq: 201e-9, seed: 5 }, Map { sq: 805e-9, seed: 7 }];
const GLOSS: [f64; 4] = [80.0, 60.0, 40.0, 20.0];
const HAZE: [f64; 4] = [10.0, 60.0, 110.0, 160.0];
/// Gloss of the tiles of rising haze.
const HAZE_GLOSS: f64 = 100.0;

/// The stage for a number of tiles.
pub fn stage(count: usize) -> Result<Stage> {
    Stage::new(count, Backdrop::Chart)
}

/// The tiles on their stage.
pub fn scene(finishes: &[Finish]) -> Result<Scene<'_>> {
    let coats: Vec<Coat> = finishes.iter().map(Finish::coat).collect();
    stage(finishes.len())?.scene(&coats)
}

/// Two maps, tabulated.
pub fn epoxy(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let mut list = Vec::new();
    for (k, map) in MAPS.into_iter().enumerate() {
        let part = |done: f64| progress((k as f64 + done) / MAPS.len() as f64);
        let brdf = table(map, EPOXY, &part)?;
        let readings = Geometry::standard_three().map(|g| gloss(&brdf, &g, &Options::default()).value);
        let lines = vec![
            format!("Sq {:.0} nm", map.sq * 1e9),
            format!("gloss 20\u{b0} {:.1}  60\u{b0} {:.1}  85\u{b0} {:.1}", readings[0], readings[1], readings[2]),
        ];
        list.push((Finish::Grey(Box::new(brdf)), lines));
    }
    Ok(list)
}

/// Ward tiles of falling gloss.
pub fn gloss_series(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let solved = GLOSS.par_iter().map(|&g| ward_of_gloss(g)).collect::<Result<Vec<_>>>()?;
    progress(1.0);
    let lines =
        |s: &Solved| vec![format!("20\u{b0} gloss {:.1}", s.gloss.value), format!("Ward, alpha {:.4}", s.alpha)];
    Ok(solved.into_iter().map(|s| (lines(&s), s)).map(|(lines, s)| (Finish::Grey(s.brdf), lines)).collect())
}

/// Ward tiles of rising haze at one gloss.
pub fn haze_series(progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<(Finish, Vec<String>)>> {
    let solved = HAZE.par_iter().map(|&h| ward_of_haze(HAZE_GLOSS, h)).collect::<Result<Vec<_>>>()?;
    progress(1.0);
    let lines = |s: &Solved| {
        vec![
            format!("2\u{b0} haze {:.1}", s.haze.value),
            format!("20\u{b0} gloss {:.1}", s.gloss.value),
            format!("Ward, alpha {:.4}", s.alpha),
            format!("rho_s {:.4}", s.rho_s),
        ]
    };
    Ok(solved.into_iter().map(|s| (lines(&s), s)).map(|(lines, s)| (Finish::Grey(s.brdf), lines)).collect())
}
