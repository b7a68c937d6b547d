//! Blocks of pixels: exposed in passes until they are good enough.

use super::camera::Camera;
use super::film::{Film, Pixel, Tally};
use super::integrator::RenderOptions;
use super::rays::WAVE;
use super::scene::Scene;
use super::stream::{PixelStream, SobolTable, lap};
use super::wave::Wave;
use crate::error::{Error, Result};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Side of a block \[pixels\].
const SIDE: usize = 16;
/// Paths per pixel before the first judgement: enough for a standard error from 256 pixels.
const FIRST: u32 = 16;
/// Share of the mean radiance of the picture below which a block need not be judged by its own.
const DIM: f64 = 0.01;

/// A picture and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    pub film: Film,
    pub report: Report,
}

/// What a picture took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Paths of all pixels.
    pub samples: u64,
    /// Share of the paths allowed that the asked error made needless.
    pub saved: f64,
    /// Share of the blocks of pixels that did not reach the asked error with all paths allowed; 0 if none was asked.
    pub unfinished: f64,
    /// Largest error of a block that is left, as a share of its radiance: root of the mean squared standard error of its
    /// pixels over their mean radiance, or over 1 % of the picture's if that is more.
    pub worst_error: f64,
    /// Straight pieces of the longest path.
    pub longest_path: u32,
}

/// A block of pixels with what it has seen so far.
struct Block {
    x: usize,
    y: usize,
    width: usize,
    tallies: Vec<Tally>,
    longest: u32,
    samples: u32,
    done: bool,
}

impl Block {
    /// Mean radiance and root mean square of the standard errors, channels averaged.
    fn state(&self) -> (f64, f64) {
        let n = self.tallies.len() as f64;
        let (mut mean, mut variance) = (0.0, 0.0);
        for tally in &self.tallies {
            let pixel = tally.pixel();
            mean += pixel.radiance.iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0;
            variance += pixel.standard_error.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / 3.0;
        }
        (mean / n, (variance / n).sqrt())
    }
}

/// As [`render`](super::render), with a report of what it took.
///
/// With `options.error` every block of 16 x 16 pixels is judged after 16, 32, 64, ... paths and stops when the root mean
/// square of its pixels' standard errors is below that share of its mean radiance (of 1 % of the picture's mean radiance if
/// that is more) and no block beside it is worse than twice that: a block that saw nothing of a rare light is held open by
/// neighbours that did. Standard errors are those of independent paths, which scrambled Sobol points stay below.
///
/// # Errors
/// As [`render`](super::render).
pub fn render_with_report(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Rendering> {
    if options.samples_per_pixel == 0 {
        return Err(Error::parameter("a picture needs at least one sample per pixel", "try 256"));
    }
    if options.error.is_some_and(|e| !(e > 0.0 && e < 1.0)) {
        return Err(Error::parameter("the error of a picture is not between 0 and 1", "ask for example for 0.02"));
    }
    let mut film = Film::new(options.width, options.height)?;
    let table = SobolTable::new(options.samples_per_pixel);
    let level = Level::new();
    let mut blocks = cut(options.width, options.height);
    let all = options.samples_per_pixel as u64 * (options.width * options.height) as u64;
    let settled = AtomicU64::new(0);
    let mut from = 0;
    while from < options.samples_per_pixel {
        let to = match options.error {
            Some(_) => (2 * from).max(FIRST).min(options.samples_per_pixel),
            None => options.samples_per_pixel,
        };
        blocks.par_iter_mut().filter(|b| !b.done).for_each(|block| {
            // The whole walk is compiled for the vector units of the machine.
            dispatch!(level, simd => expose(simd, scene, camera, options, &table, from..to, block));
            let paths = u64::from(to - from) * block.tallies.len() as u64;
            progress((settled.fetch_add(paths, Ordering::Relaxed) + paths) as f64 / all as f64);
        });
        from = to;
        if let Some(error) = options.error {
            judge(&mut blocks, error, options.width.div_ceil(SIDE));
            let needless = |b: &&Block| b.done;
            let saved: u64 = blocks.iter().filter(needless).map(|b| remaining(b, options)).sum();
            let taken: u64 = blocks.iter().map(|b| u64::from(b.samples) * b.tallies.len() as u64).sum();
            settled.store(taken + saved, Ordering::Relaxed);
        }
    }
    let report = report(&blocks, options, all);
    for block in &blocks {
        for (k, tally) in block.tallies.iter().enumerate() {
            let at = (block.y + k / block.width) * options.width + block.x + k % block.width;
            film.pixels_mut()[at] = tally.pixel();
        }
    }
    let finite = |p: &Pixel| p.radiance.iter().chain(&p.standard_error).all(|v| v.is_finite());
    if let Some(i) = film.pixels().iter().position(|p| !finite(p)) {
        return Err(Error::parameter(
            format!("the radiance of pixel ({}, {}) is not a finite number", i % options.width, i / options.width),
            "check that the BRDF of every material is finite and its sampling weights are bounded",
        ));
    }
    progress(1.0);
    Ok(Rendering { film, report })
}

/// Paths that a block was allowed but did not take.
fn remaining(block: &Block, options: &RenderOptions) -> u64 {
    u64::from(options.samples_per_pixel - block.samples) * block.tallies.len() as u64
}

/// The blocks of a picture, row by row.
fn cut(width: usize, height: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    for y in (0..height).step_by(SIDE) {
        for x in (0..width).step_by(SIDE) {
            let (across, down) = (SIDE.min(width - x), SIDE.min(height - y));
            let tallies = std::iter::repeat_with(Tally::default).take(across * down).collect();
            blocks.push(Block { x, y, width: across, tallies, longest: 0, samples: 0, done: false });
        }
    }
    blocks
}

/// Error of each block as a share of its radiance.
fn errors(blocks: &[Block]) -> Vec<f64> {
    let states: Vec<(f64, f64)> = blocks.iter().map(Block::state).collect();
    let pixels: usize = blocks.iter().map(|b| b.tallies.len()).sum();
    let mean = states.iter().zip(blocks).map(|(s, b)| s.0 * b.tallies.len() as f64).sum::<f64>() / pixels as f64;
    let share = |(own, error): &(f64, f64)| if *error > 0.0 { error / own.max(DIM * mean) } else { 0.0 };
    states.iter().map(share).collect()
}

/// Closes the blocks that are good enough.
fn judge(blocks: &mut [Block], error: f64, columns: usize) {
    let errors = errors(blocks);
    for k in 0..blocks.len() {
        let column = k % columns;
        let beside = [
            (column > 0).then(|| k - 1),
            (column + 1 < columns).then_some(k + 1),
            k.checked_sub(columns),
            Some(k + columns).filter(|&below| below < blocks.len()),
        ];
        let calm = beside.into_iter().flatten().all(|other| errors[other] <= 2.0 * error);
        blocks[k].done |= errors[k] <= error && calm;
    }
}

fn report(blocks: &[Block], options: &RenderOptions, all: u64) -> Report {
    let samples: u64 = blocks.iter().map(|b| u64::from(b.samples) * b.tallies.len() as u64).sum();
    let errors = errors(blocks);
    let late = options.error.map_or(0, |error| errors.iter().filter(|e| **e > error).count());
    Report {
        samples,
        saved: 1.0 - samples as f64 / all as f64,
        unfinished: late as f64 / blocks.len() as f64,
        worst_error: errors.into_iter().fold(0.0, f64::max),
        longest_path: blocks.iter().map(|b| b.longest).max().unwrap_or(0),
    }
}

/// Paths number `range` of every pixel of a block.
#[inline(always)]
fn expose<S: Simd>(
    simd: S,
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    table: &SobolTable,
    range: std::ops::Range<u32>,
    block: &mut Block,
) {
    let (step_x, step_y) = (1.0 / options.width as f64, 1.0 / options.height as f64);
    let place = |k: usize| (block.x + k % block.width, block.y + k / block.width);
    let mut from = range.start;
    while from < range.end {
        let (lap, next) = lap(from);
        let to = range.end.min(next);
        let number = |k: usize| (place(k).1 * options.width + place(k).0) as u64;
        let numbers: Vec<PixelStream> =
            (0..block.tallies.len()).map(|k| PixelStream::new(table, options.seed, number(k), lap)).collect();
        let mut wave = Wave::new(scene, options);
        let mut pixels = Vec::with_capacity(WAVE);
        let count = numbers.len();
        for k in 0..count {
            let (column, row) = (place(k).0 as f64, place(k).1 as f64);
            for index in from..to {
                let mut stream = numbers[k].path(index);
                let [dx, dy] = stream.pair();
                let ray = camera.line((column + dx) * step_x, (row + dy) * step_y);
                pixels.push(k);
                let full = wave.push(&ray, stream);
                if full || (k + 1 == count && index + 1 == to) {
                    for (k, radiance) in pixels.drain(..).zip(wave.run(simd)) {
                        block.tallies[k].add(*radiance);
                    }
                }
            }
        }
        block.longest = block.longest.max(wave.longest);
        from = to;
    }
    block.samples = range.end;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::DVec3;

    #[test]
    fn blocks_cover_every_pixel_once() {
        let mut seen = vec![0; 37 * 21];
        for block in cut(37, 21) {
            for k in 0..block.tallies.len() {
                seen[(block.y + k / block.width) * 37 + block.x + k % block.width] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn a_calm_block_is_held_open_by_a_noisy_neighbour() {
        let mut blocks = cut(48, 16);
        for (block, spread) in blocks.iter_mut().zip([0.0, 0.0, 0.9]) {
            for tally in &mut block.tallies {
                (0..16).for_each(|k| tally.add(DVec3::splat(1.0 + if k % 2 == 0 { spread } else { -spread })));
            }
        }
        judge(&mut blocks, 0.05, 3);
        assert_eq!(blocks.iter().map(|b| b.done).collect::<Vec<_>>(), [true, false, false]);
    }
}
