//! Counter-based random numbers: any item's stream can be had without drawing the others', so results
//! do not depend on how work is cut over threads.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rand::TryRng;
use std::convert::Infallible;

/// Philox4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3, SC 2011).
///
/// Key = seed, counter = (block, stream, item): one stream per ray, facet or pixel.
#[derive(Debug, Clone)]
pub struct CounterRng {
    key: [u32; 2],
    counter: [u32; 4],
    buffer: [u32; 4],
    used: usize,
}

impl CounterRng {
    /// Stream number `stream` of item `item` under `seed`.
    pub fn new(seed: u64, stream: u32, item: u64) -> Self {
        CounterRng {
            key: [seed as u32, (seed >> 32) as u32],
            counter: [0, stream, item as u32, (item >> 32) as u32],
            buffer: [0; 4],
            used: 4,
        }
    }

    /// Four uniform numbers inside (0, 1), with 32 bits each: the first block of a stream, for the price of two draws.
    #[inline]
    pub fn four(seed: u64, stream: u32, item: u64) -> [f64; 4] {
        let words = philox([0, stream, item as u32, (item >> 32) as u32], [seed as u32, (seed >> 32) as u32]);
        words.map(inside)
    }

    /// [`CounterRng::four`] of the items from `first` on, side by side: their first numbers, their second ones, and so on.
    pub fn fours(seed: u64, stream: u32, first: u64) -> [[f64; LANES]; 4] {
        let mut numbers = [[0.0; LANES]; 4];
        dispatch!(Level::new(), simd => fours(simd, seed, stream, first, &mut numbers));
        numbers
    }

    /// Uniform f64 in `[0, 1)` with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        let bits = self.word64() >> 11;
        bits as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Two independent standard normal numbers (Box and Muller 1958).
    pub fn normal_pair(&mut self) -> [f64; 2] {
        // 1 - u is in (0, 1], so the logarithm is finite.
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (s, c) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        [radius * c, radius * s]
    }

    fn word32(&mut self) -> u32 {
        if self.used == 4 {
            self.buffer = philox(self.counter, self.key);
            self.counter[0] = self.counter[0].wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.buffer[self.used - 1]
    }

    fn word64(&mut self) -> u64 {
        let low = u64::from(self.word32());
        low | u64::from(self.word32()) << 32
    }
}

impl TryRng for CounterRng {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.word32())
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.word64())
    }

    fn try_fill_bytes(&mut self, dst: &mut [u8]) -> Result<(), Infallible> {
        for chunk in dst.chunks_mut(4) {
            chunk.copy_from_slice(&self.word32().to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

/// Items whose numbers are drawn side by side.
pub const LANES: usize = 64;

#[simd]
fn fours<S: Simd>(_: S, seed: u64, stream: u32, first: u64, numbers: &mut [[f64; LANES]; 4]) {
    let key = [seed as u32, (seed >> 32) as u32];
    let mut words = [[0; LANES]; 4];
    for k in 0..LANES {
        let item = first.wrapping_add(k as u64);
        let [a, b, c, d] = philox([0, stream, item as u32, (item >> 32) as u32], key);
        words[0][k] = a;
        words[1][k] = b;
        words[2][k] = c;
        words[3][k] = d;
    }
    for (numbers, words) in numbers.iter_mut().zip(&words) {
        for k in 0..LANES {
            numbers[k] = inside(words[k]);
        }
    }
}

/// The middle of one of 2^32 pieces of (0, 1).
#[inline]
fn inside(word: u32) -> f64 {
    (f64::from(word) + 0.5) * (1.0 / (1u64 << 32) as f64)
}

#[inline(always)]
fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let a = u64::from(counter[0]) * 0xD251_1F53;
        let b = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [(b >> 32) as u32 ^ counter[1] ^ key[0], b as u32, (a >> 32) as u32 ^ counter[3] ^ key[1], a as u32];
        key[0] = key[0].wrapping_add(0x9E37_79B9);
        key[1] = key[1].wrapping_add(0xBB67_AE85);
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers published with Random123.
    #[test]
    fn philox_known_answers() {
        assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(
            philox([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn items_side_by_side_have_the_numbers_of_single_items() {
        // Across a carry into the upper half of the item.
        let first = (7 << 32) - 5;
        let numbers = CounterRng::fours(99 << 31, 3, first);
        for k in 0..LANES {
            assert_eq!(numbers.map(|some| some[k]), CounterRng::four(99 << 31, 3, first + k as u64));
        }
    }

    #[test]
    fn normal_pairs_have_unit_variance() {
        let mut rng = CounterRng::new(7, 0, 0);
        let n = 100_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n {
            for x in rng.normal_pair() {
                sum += x;
                squares += x * x;
            }
        }
        let m = 2.0 * f64::from(n);
        // Standard errors: 1/sqrt(m) for the mean, sqrt(2/m) for the variance.
        assert!((sum / m).abs() < 4.0 / m.sqrt());
        assert!((squares / m - 1.0).abs() < 4.0 * (2.0 / m).sqrt());
    }
}
