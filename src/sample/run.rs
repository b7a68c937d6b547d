//! Draws by the run: what one draw does after the other, many do side by side.
//!
//! A single draw waits for itself: root, division, lookup, root, lookup, division. In runs of 32 every step is a
//! loop of its own, arithmetic in lanes and lookups one after the other without waiting.

use super::hats::LEAST_SQUARE;
use super::table_brdf::{HORIZON, TableBrdf};
use crate::optics::{Brdf, BrdfSample, Material};
use crate::scatter::axis::{at_least, at_most};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

const RUN: usize = 32;

/// 2^52: added to a small number it leaves the whole part in the last bits.
const TWO_52: f64 = 4_503_599_627_370_496.0;

/// [`Brdf::sample_many`] of a table.
pub(super) fn sample(brdf: &TableBrdf, wi: &[DVec3], u: &[[f64; 2]], out: &mut [Option<BrdfSample>]) {
    assert!(wi.len() == u.len() && u.len() == out.len(), "as many numbers and places as directions");
    let level = Level::new();
    let together = if brdf.runs() { wi.len() / RUN * RUN } else { 0 };
    let runs = wi[..together].as_chunks().0.iter().zip(u[..together].as_chunks().0);
    for ((wi, u), out) in runs.zip(out[..together].as_chunks_mut().0) {
        dispatch!(level, simd => run(simd, brdf, wi, u, out));
    }
    for k in together..wi.len() {
        out[k] = brdf.sample(wi[k], u[k]);
    }
}

type Lanes<T> = [T; RUN];

/// What is known of the incident directions.
struct Sources {
    x: Lanes<f64>,
    y: Lanes<f64>,
    z: Lanes<f64>,
    sine: Lanes<f64>,
    per_sine: Lanes<f64>,
    theta: Lanes<usize>,
    /// Share of the second node, of the balance, and `L` of the masking.
    upper: Lanes<f64>,
    balance: Lanes<f64>,
    masked: Lanes<f64>,
}

#[simd]
fn run<S: Simd>(
    simd: S,
    brdf: &TableBrdf,
    wi: &Lanes<DVec3>,
    u: &Lanes<[f64; 2]>,
    out: &mut Lanes<Option<BrdfSample>>,
) {
    let sources = sources(simd, brdf, wi);
    let (cells, along, across) = cells(simd, brdf, &sources, u);
    let mut below = [0u32; RUN];
    let x = places(simd, brdf, 0, &cells, &across, &mut below);
    let y = places(simd, brdf, 1, &cells, &along, &mut below);
    let (mut density, mut draws) = ([0.0f32; RUN], [0.0f32; RUN]);
    for j in 0..RUN {
        let found =
            brdf.slabs.of_interval(sources.theta[j], sources.upper[j] as f32, below[j] as usize, [x.1[j], y.1[j]]);
        (density[j], draws[j]) = (found.density, found.draws);
    }
    reflect(simd, brdf, &sources, [&x.0, &y.0], [&density, &draws], out);
}

#[simd]
fn sources<S: Simd>(_: S, brdf: &TableBrdf, wi: &Lanes<DVec3>) -> Sources {
    let zero = [0.0; RUN];
    let mut s = Sources {
        x: zero,
        y: zero,
        z: zero,
        sine: zero,
        per_sine: zero,
        theta: [0; RUN],
        upper: zero,
        balance: zero,
        masked: zero,
    };
    for j in 0..RUN {
        // Too little to matter, but for light from above.
        s.x[j] = wi[j].x + 1e-150;
        s.y[j] = wi[j].y;
        s.z[j] = at_least(wi[j].z, HORIZON);
    }
    let (mut r2, mut tangent) = (zero, zero);
    for j in 0..RUN {
        r2[j] = s.x[j] * s.x[j] + s.y[j] * s.y[j];
        s.sine[j] = r2[j].sqrt();
        let inverse = 1.0 / (s.sine[j] * s.z[j]);
        s.per_sine[j] = inverse * s.z[j];
        tangent[j] = r2[j] * inverse;
    }
    let table = &brdf.table;
    for j in 0..RUN {
        s.theta[j] = table.finder.interval(s.z[j], r2[j]);
        s.upper[j] = table.finder.share(s.theta[j], tangent[j]);
        s.balance[j] = table.balance.of_isotropic(s.theta[j], s.upper[j], tangent[j], s.z[j]);
        s.masked[j] = table.masking.times_cosine(s.z[j]);
    }
    s
}

/// Node and cell of every draw: the cells as row and column in one word, and what is left of both numbers.
#[simd]
fn cells<S: Simd>(
    _: S,
    brdf: &TableBrdf,
    sources: &Sources,
    u: &Lanes<[f64; 2]>,
) -> (Lanes<u32>, Lanes<f32>, Lanes<f32>) {
    let (mut along, mut across) = ([0.0f32; RUN], [0.0f32; RUN]);
    let mut second = [0u32; RUN];
    for j in 0..RUN {
        let share = sources.upper[j];
        let from = 1.0 - share;
        let take = u[j][1] >= from;
        let (before, width) = if take { (from, share) } else { (0.0, from) };
        second[j] = u32::from(take);
        along[j] = ((u[j][1] - before) / width) as f32;
    }
    let last = brdf.slots.nodes.len() - 1;
    let (mut slot, mut count) = ([0u32; RUN], [0.0f64; RUN]);
    for j in 0..RUN {
        let range = &brdf.slots.nodes[(sources.theta[j] + second[j] as usize).min(last)];
        (slot[j], count[j]) = (range.first, range.count);
    }
    let mut rest = [0.0f64; RUN];
    for j in 0..RUN {
        let place = u[j][0] * count[j];
        let shifted = at_least(place - 0.5, 0.0) + TWO_52;
        rest[j] = at_least(place - (shifted - TWO_52), 0.0);
        slot[j] += shifted.to_bits() as u32;
    }
    let (mut threshold, mut alias, mut own) = ([0.0f64; RUN], [0u32; RUN], [0u32; RUN]);
    let word = |cell: [u16; 2]| u32::from(cell[0]) | u32::from(cell[1]) << 16;
    for j in 0..RUN {
        let slot = &brdf.slots.slots[slot[j] as usize];
        threshold[j] = slot.threshold();
        (alias[j], own[j]) = (word(slot.cells[0]), word(slot.cells[1]));
    }
    let mut cells = [0u32; RUN];
    for j in 0..RUN {
        let keep = rest[j] < threshold[j];
        let (before, width) = if keep { (0.0, threshold[j]) } else { (threshold[j], 1.0 - threshold[j]) };
        across[j] = (rest[j] - before) as f32 / width as f32;
        cells[j] = if keep { own[j] } else { alias[j] };
    }
    (cells, along, across)
}

/// Places under the tents of one axis, in core cells, and the share of the upper of the two cells each lies between; the
/// lower one is added to `below`.
#[simd]
fn places<S: Simd>(
    _: S,
    brdf: &TableBrdf,
    axis: usize,
    cells: &Lanes<u32>,
    u: &Lanes<f32>,
    below: &mut Lanes<u32>,
) -> (Lanes<f64>, Lanes<f32>) {
    let tents = &brdf.hats.tents[axis][..];
    let stride = if axis == 0 { 1 } else { brdf.slabs.row() as u32 };
    let number = |j: usize| cells[j] >> (16 * axis) & 0xffff;
    let (mut left, mut outer) = ([0.0f32; RUN], [[0.0f32; RUN]; 2]);
    for j in 0..RUN {
        let tent = &tents[number(j) as usize];
        (left[j], outer[0][j], outer[1][j]) = (tent.left, tent.outer[0], tent.outer[1]);
    }
    let (mut piece, mut share, mut one) = ([0u32; RUN], [0.0f32; RUN], [0.0f32; RUN]);
    for j in 0..RUN {
        let beyond = u[j] >= left[j];
        one[j] = if beyond { 1.0 } else { 0.0 };
        share[j] = (one[j] - u[j]).abs();
        let foot = if beyond { outer[1][j] } else { outer[0][j] };
        piece[j] = if beyond { 2 } else { 0 } + u32::from(share[j] >= foot);
        below[j] += stride * (number(j) - u32::from(!beyond));
    }
    let (mut x, mut slope) = ([0.0f64; RUN], [0.0f32; RUN]);
    let (mut from, mut square, mut rise) = ([0.0f32; RUN], [0.0f32; RUN], [0.0f32; RUN]);
    for j in 0..RUN {
        let p = &tents[number(j) as usize].pieces[(piece[j] & 3) as usize];
        (x[j], slope[j], from[j], square[j], rise[j]) = (p.place, p.slope, p.from, p.square, p.rise);
    }
    let mut upper = [0.0f32; RUN];
    for j in 0..RUN {
        let square = square[j] + (share[j] - from[j]) * rise[j];
        let square = if square > LEAST_SQUARE { square } else { LEAST_SQUARE };
        let height = (if square < 1.0 { square } else { 1.0 }).sqrt();
        x[j] += f64::from(slope[j] * height);
        upper[j] = (one[j] - height).abs();
    }
    (x, upper)
}

#[simd]
fn reflect<S: Simd>(
    _: S,
    brdf: &TableBrdf,
    s: &Sources,
    place: [&Lanes<f64>; 2],
    [density, draws]: [&Lanes<f32>; 2],
    out: &mut Lanes<Option<BrdfSample>>,
) {
    let table = &brdf.table;
    let zero = [0.0f64; RUN];
    let (mut x, mut y, mut z, mut pdf) = (zero, zero, zero, zero);
    let (mut leaning, mut cos_beta) = (zero, zero);
    for j in 0..RUN {
        let (p, q) = table.cells.slope_of([place[0][j], place[1][j]]);
        // In the frame of the source, which is that of the cells.
        let lean = s.z[j] - p * s.sine[j];
        let steepness = 1.0 + p * p + q * q;
        let inverse = 1.0 / (steepness * lean);
        let scale = 2.0 * lean * lean * inverse;
        let (cos, sin) = (s.x[j] * s.per_sine[j], s.y[j] * s.per_sine[j]);
        let v = [-p * scale - s.sine[j], -q * scale];
        x[j] = cos * v[0] - sin * v[1];
        y[j] = cos * v[1] + sin * v[0];
        z[j] = scale - s.z[j];
        pdf[j] = f64::from(draws[j]) * 0.25 * steepness * steepness * steepness * inverse;
        cos_beta[j] = at_most(at_least(0.5 * lean * scale, 0.0), 1.0).sqrt();
        leaning[j] = lean;
    }
    let mut reflectance = [1.0f64; RUN];
    match table.material {
        Material::Mirror => {}
        Material::Dielectric { n } => {
            let n = n as f32;
            for j in 0..RUN {
                let c = cos_beta[j] as f32;
                let ct = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
                let (s, p) = (c + n * ct, n * c + ct);
                let (a, b) = ((c - n * ct) * p, (n * c - ct) * s);
                reflectance[j] = f64::from(0.5 * (a * a + b * b) / (s * p * s * p));
            }
        }
        Material::Conductor { .. } => {
            for j in 0..RUN {
                reflectance[j] = table.material.reflectance(cos_beta[j]);
            }
        }
    }
    let mut masked = zero;
    for j in 0..RUN {
        masked[j] = table.masking.times_cosine(z[j]);
    }
    let mut weight = zero;
    for j in 0..RUN {
        let cosines = (s.z[j] + s.masked[j]) * z[j] + s.z[j] * masked[j];
        let bright = s.balance[j] * reflectance[j] * f64::from(density[j]) * leaning[j] * z[j];
        weight[j] = bright / (cosines * f64::from(draws[j]));
    }
    for j in 0..RUN {
        let lands = leaning[j] > 0.0 && z[j] > HORIZON && s.z[j] > HORIZON;
        let wo = DVec3::new(x[j], y[j], z[j]);
        out[j] = lands.then_some(BrdfSample { wo, weight: weight[j], pdf: pdf[j], specular: false });
    }
}
