//! Draws and lookups by the run: what one does after the other, many do side by side.
//!
//! A single draw waits for itself: root, division, lookup, root, lookup, division. So does a lookup. In runs of 64, and of 16 for
//! what is left, every step is a loop of its own: arithmetic in lanes, and lookups one after the other without waiting, each one
//! load of a whole record.

mod azimuths;
mod cells;
mod lookup;
mod mirror;
mod sources;

use super::table_brdf::{HORIZON, TableBrdf};
use crate::optics::{Brdf, BrdfSample};
use cells::Places;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;
use lookup::Lookups;
use mirror::Draws;
use sources::SourceLanes;
pub(super) use sources::SourceTables;

const RUN: usize = 64;

/// What is left over goes in short runs.
const SHORT: usize = 16;

/// So many of them are worth a short run.
const WORTH: usize = 4;

type Lanes<T, const N: usize> = [T; N];

/// [`Brdf::sample_many`] of a table.
pub(super) fn sample(brdf: &TableBrdf, wi: &[DVec3], u: &[[f64; 2]], out: &mut [Option<BrdfSample>]) {
    assert!(wi.len() == u.len() && u.len() == out.len(), "as many numbers and places as directions");
    let level = Level::new();
    let together = if brdf.runs() { wi.len() / RUN * RUN } else { 0 };
    let runs = wi[..together].as_chunks().0.iter().zip(u[..together].as_chunks().0);
    for ((wi, u), out) in runs.zip(out[..together].as_chunks_mut().0) {
        dispatch!(level, simd => run::<_, RUN>(simd, brdf, wi, u, out));
    }
    let rest = wi[together..].chunks(SHORT).zip(u[together..].chunks(SHORT));
    for ((wi, u), out) in rest.zip(out[together..].chunks_mut(SHORT)) {
        if brdf.runs() && wi.len() >= WORTH {
            let mut drawn = [None; SHORT];
            let (wi, u) = (padded(wi, DVec3::Z), padded(u, [0.5; 2]));
            dispatch!(level, simd => run::<_, SHORT>(simd, brdf, &wi, &u, &mut drawn));
            out.copy_from_slice(&drawn[..out.len()]);
        } else {
            for ((wi, u), out) in wi.iter().zip(u).zip(out) {
                *out = brdf.sample(*wi, *u);
            }
        }
    }
}

/// The values of a short run and others behind them that count for nothing.
fn padded<T: Copy>(values: &[T], others: T) -> [T; SHORT] {
    let mut all = [others; SHORT];
    all[..values.len()].copy_from_slice(values);
    all
}

#[simd]
fn run<S: Simd, const N: usize>(
    simd: S,
    brdf: &TableBrdf,
    wi: &Lanes<DVec3, N>,
    u: &Lanes<[f64; 2], N>,
    out: &mut Lanes<Option<BrdfSample>, N>,
) {
    let mut sources = SourceLanes::default();
    sources.find(simd, brdf, wi);
    let mut places = Places::default();
    places.draw(simd, brdf, &sources, u);
    let mut found = [[0.0f32; 2]; N];
    read(simd, brdf, &sources, &places.from, &places.shares, &mut found);
    let mut draws = Draws::default();
    draws.reflect(simd, brdf, &sources, &places, &found);
    for j in 0..N {
        let lands = draws.lean[j] > 0.0 && draws.z[j] > HORIZON && sources.z[j] > HORIZON;
        let wo = DVec3::new(draws.x[j], draws.y[j], draws.z[j]);
        out[j] = lands.then_some(BrdfSample { wo, weight: draws.weight[j], pdf: draws.pdf[j], specular: false });
    }
    if !brdf.glossy {
        for j in 0..N {
            if places.core[j] > 0 {
                let (mirrored, blend) = (DVec3::new(-wi[j].x, -wi[j].y, wi[j].z), places.blend[j]);
                let weight = brdf.table.core(wi[j]) / f64::from(blend.x);
                let draw = BrdfSample { wo: mirrored, weight, pdf: f64::INFINITY, specular: true };
                out[j] = (wi[j].z > HORIZON).then_some(draw);
            }
        }
    }
}

/// Density and density of draws between the cells and nodes.
#[simd]
fn read<S: Simd, const N: usize>(
    _: S,
    brdf: &TableBrdf,
    sources: &SourceLanes<N>,
    from: &Lanes<u32, N>,
    shares: &[Lanes<f32, N>; 2],
    found: &mut Lanes<[f32; 2], N>,
) {
    let slabs = &brdf.slabs;
    if brdf.table.phi_i().len() == 1 {
        for j in 0..N {
            let at = [shares[0][j], shares[1][j]];
            let here = slabs.of_interval(sources.theta[j] as usize, sources.upper[j], from[j] as usize, at);
            found[j] = [here.density, here.draws];
        }
    } else {
        for j in 0..N {
            let at = [shares[0][j], shares[1][j]];
            let phi = [sources.phi[0][j] as usize, sources.phi[1][j] as usize];
            let between = [sources.upper[j], sources.turned[j]];
            let here = slabs.of_azimuths(sources.theta[j] as usize, phi, between, from[j] as usize, at);
            found[j] = [here.density, here.draws];
        }
    }
}

/// [`Brdf::eval_and_pdf_many`] of a table.
pub(super) fn eval_and_pdf(brdf: &TableBrdf, wi: &[DVec3], wo: &[DVec3], out: &mut [(f64, f64)]) {
    assert!(wi.len() == wo.len() && wo.len() == out.len(), "as many places and directions out as directions in");
    let level = Level::new();
    let together = wi.len() / RUN * RUN;
    let runs = wi[..together].as_chunks().0.iter().zip(wo[..together].as_chunks().0);
    for ((wi, wo), out) in runs.zip(out[..together].as_chunks_mut().0) {
        dispatch!(level, simd => look_up::<_, RUN>(simd, brdf, wi, wo, out));
    }
    let rest = wi[together..].chunks(SHORT).zip(wo[together..].chunks(SHORT));
    for ((wi, wo), out) in rest.zip(out[together..].chunks_mut(SHORT)) {
        if wi.len() >= WORTH {
            let mut found = [(0.0, 0.0); SHORT];
            let (wi, wo) = (padded(wi, DVec3::Z), padded(wo, DVec3::Z));
            dispatch!(level, simd => look_up::<_, SHORT>(simd, brdf, &wi, &wo, &mut found));
            out.copy_from_slice(&found[..out.len()]);
        } else {
            for ((wi, wo), out) in wi.iter().zip(wo).zip(out) {
                *out = brdf.eval_and_pdf(*wi, *wo);
            }
        }
    }
}

#[simd]
fn look_up<S: Simd, const N: usize>(
    simd: S,
    brdf: &TableBrdf,
    wi: &Lanes<DVec3, N>,
    wo: &Lanes<DVec3, N>,
    out: &mut Lanes<(f64, f64), N>,
) {
    let mut sources = SourceLanes::default();
    sources.find(simd, brdf, wi);
    let mut lookups = Lookups::default();
    lookups.find(simd, brdf, &sources, wi, wo);
    let mut found = [[0.0f32; 2]; N];
    read(simd, brdf, &sources, &lookups.from, &lookups.shares, &mut found);
    lookups.value(simd, brdf, &sources, &found);
    for j in 0..N {
        let lit = wi[j].z > HORIZON && wo[j].z > HORIZON;
        out[j] = if lit { (lookups.value[j], lookups.pdf[j]) } else { (0.0, 0.0) };
    }
}

/// As [`super::grid::piece`] for lanes of f32, below 2^22.
#[inline(always)]
fn piece(x_and_half: f32) -> (u32, f32) {
    const TWO_23: f32 = 8_388_608.0;
    let shifted = x_and_half + TWO_23;
    (shifted.to_bits() & 0x007f_ffff, x_and_half - (shifted - TWO_23))
}
