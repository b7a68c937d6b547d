//! The random numbers of one path: a scrambled Sobol point, taken two coordinates at a time.

/// Coordinates `0, 1, 2, ...` of point `index` of the pixel's own Owen-scrambled Sobol sequence
/// (Burley, J. Computer Graphics Techniques 9(4), 2020).
///
/// The tables behind it hold 2^16 points of 256 coordinates in 23 bits. Beyond either limit the sequence goes on
/// under another seed, and the missing low bits are filled at random: a narrow lobe needs them.
pub(super) struct PathStream {
    seed: u64,
    index: u32,
    set: u32,
    buffer: [f64; 4],
    used: usize,
}

const POINTS: u32 = 1 << 16;

impl PathStream {
    /// Point `index` of the sequence of pixel number `pixel` under `seed`.
    #[inline]
    pub(super) fn new(seed: u64, pixel: u64, index: u32) -> Self {
        let block = u64::from(index / POINTS);
        let seed = mix(mix(mix(seed) ^ pixel) ^ block);
        PathStream { seed, index: index % POINTS, set: 0, buffer: [0.0; 4], used: 4 }
    }

    /// The next two coordinates, in `[0, 1)`.
    #[inline]
    pub(super) fn pair(&mut self) -> [f64; 2] {
        if self.used == 4 {
            self.refill();
        }
        let pair = [self.buffer[self.used], self.buffer[self.used + 1]];
        self.used += 2;
        pair
    }

    /// An independent number in `[0, 1)` that belongs to no coordinate.
    #[inline]
    pub(super) fn lonely(&self) -> f64 {
        let bits = mix(self.seed ^ u64::from(self.index) << 32 ^ u64::from(self.set) << 8 ^ self.used as u64);
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    #[inline]
    fn refill(&mut self) {
        let (lap, set) =
            (self.set / sobol_burley::NUM_DIMENSION_SETS_4D, self.set % sobol_burley::NUM_DIMENSION_SETS_4D);
        let seed = (self.seed >> 32) as u32 ^ lap.wrapping_mul(0x9E37_79B9);
        let high = sobol_burley::sample_4d(self.index, set, seed);
        let mut low = mix(self.seed ^ u64::from(self.index) << 32 ^ u64::from(self.set));
        for (number, high) in self.buffer.iter_mut().zip(high) {
            *number = f64::from(high) + (low & 0xFFFF) as f64 * LOW_BIT;
            low >>= 16;
        }
        self.set += 1;
        self.used = 0;
    }
}

/// The 16 random bits below the 23 bits of the table.
const LOW_BIT: f64 = 1.0 / (1u64 << 39) as f64;

/// Bijective scrambling of 64 bits: the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#[inline]
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 256 points fall once into each of 16 x 16 cells: a (0, 8, 2)-net in base 2 in the first two coordinates.
    #[test]
    fn the_first_two_coordinates_are_stratified() {
        let mut counts = [0; 256];
        for index in 0..256 {
            let [x, y] = PathStream::new(3, 77, index).pair();
            counts[(x * 16.0) as usize + 16 * (y * 16.0) as usize] += 1;
        }
        assert!(counts.iter().all(|&c| c == 1));
    }

    #[test]
    fn pixels_seeds_and_blocks_differ_and_repeat() {
        let first = |seed, pixel, index| PathStream::new(seed, pixel, index).pair();
        assert_eq!(first(1, 2, 3), first(1, 2, 3));
        let all = [first(1, 2, 3), first(2, 2, 3), first(1, 3, 3), first(1, 2, 4), first(1, 2, 3 + POINTS)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b));
        }
    }

    #[test]
    fn long_paths_go_on_beyond_the_table() {
        let mut stream = PathStream::new(0, 0, 5);
        let numbers: Vec<f64> = (0..400).flat_map(|_| stream.pair()).collect();
        assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)));
        assert_ne!(numbers[..256], numbers[256..512]);
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / 800f64).sqrt());
        assert!((0.0..1.0).contains(&stream.lonely()));
    }
}
