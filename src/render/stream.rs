//! The random numbers of one path: a scrambled Sobol point, taken two coordinates at a time.

use sobol_burley::NUM_DIMENSIONS;
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev};

/// Coordinates that are tabulated: the pixel and five reflections.
const TABLED: usize = 24;
/// Longest sequence of the direction numbers; it goes on under another scramble.
const POINTS: u32 = 1 << 16;
/// Points of all tables together, so that they stay in the second-level cache.
const TABULATED: u32 = 1 << 13;
/// More tables than this look no better.
const MOST_TABLES: u32 = 64;

/// Owen-scrambled Sobol points for the first coordinates, under several scrambles.
///
/// A pixel takes one table and flips random bits in it, which is one more scramble of the same kind: its points are as
/// well spread and as independent of its neighbours' as under a scramble of its own, and cost a load and an exclusive or.
pub(super) struct SobolTable {
    points: Vec<[u32; TABLED]>,
    /// Points per table.
    length: u32,
    tables: u32,
}

impl SobolTable {
    /// The tables for `samples` paths per pixel.
    pub(super) fn new(samples: u32) -> Self {
        let length = samples.clamp(1, POINTS);
        let tables = (TABULATED / length).clamp(1, MOST_TABLES);
        let mut points = Vec::with_capacity((length * tables) as usize);
        for table in 0..tables {
            let scrambles: [u32; TABLED] = std::array::from_fn(|d| scramble_of(hash(!table), d as u32));
            for index in 0..length {
                let coordinate = |d: usize| {
                    owen_scramble_rev(sobol_rev(index.reverse_bits(), d as u32), scrambles[d]).reverse_bits()
                };
                points.push(std::array::from_fn(coordinate));
            }
        }
        SobolTable { points, length, tables }
    }
}

/// The scrambles of one pixel, for the points of one lap of the sequence.
pub(super) struct PixelStream<'a> {
    table: &'a SobolTable,
    seed: u64,
    scramble: u32,
    /// First point of the pixel's table.
    start: usize,
    flips: [u32; TABLED],
}

impl<'a> PixelStream<'a> {
    /// An Owen-scrambled Sobol sequence (Burley, J. Computer Graphics Techniques 9(4), 2020) for pixel number `pixel`, in the
    /// [`lap`] of the paths that will be asked for.
    pub(super) fn new(table: &'a SobolTable, seed: u64, pixel: u64, lap: u32) -> Self {
        let seed = mix(mix(mix(seed) ^ pixel) ^ u64::from(lap));
        let scramble = (seed >> 32) as u32;
        let start = ((seed as u32 % table.tables) * table.length) as usize;
        PixelStream { table, seed, scramble, start, flips: std::array::from_fn(|d| scramble_of(scramble, d as u32)) }
    }

    /// Point `index` of the sequence: the numbers of one path.
    #[inline(always)]
    pub(super) fn path(&self, index: u32) -> PathStream<'_> {
        let index = index % POINTS;
        let at = self.start + (index % self.table.length) as usize;
        PathStream { pixel: self, index, tabled: &self.table.points[at], used: 0 }
    }
}

/// Which run through the sequence a path is in, and the first path of the next.
pub(super) fn lap(index: u32) -> (u32, u32) {
    let lap = index / POINTS;
    (lap, (lap + 1).saturating_mul(POINTS))
}

/// The coordinates of one point, in order.
pub(super) struct PathStream<'a> {
    pixel: &'a PixelStream<'a>,
    index: u32,
    tabled: &'a [u32; TABLED],
    used: usize,
}

impl PathStream<'_> {
    /// The next two coordinates, in `[0, 1)` with 32 bits.
    #[inline(always)]
    pub(super) fn pair(&mut self) -> [f64; 2] {
        let first = self.used;
        self.used += 2;
        if first + 1 < TABLED {
            let coordinate = |d: usize| f64::from(self.tabled[d] ^ self.pixel.flips[d]) * UNIT;
            [coordinate(first), coordinate(first + 1)]
        } else {
            [self.far(first as u32), self.far(first as u32 + 1)]
        }
    }

    /// A coordinate beyond the tables; beyond the last dimension the points are shuffled and used again.
    #[inline(never)]
    fn far(&self, d: u32) -> f64 {
        let (lap, dimension) = (d / NUM_DIMENSIONS, d % NUM_DIMENSIONS);
        let mut index = self.index.reverse_bits();
        if lap > 0 {
            index = owen_scramble_rev(index, scramble_of(!self.pixel.scramble, lap));
        }
        unit(owen_scramble_rev(sobol_rev(index, dimension), scramble_of(self.pixel.scramble, d)))
    }

    /// An independent number in `[0, 1)` that belongs to no coordinate.
    #[inline]
    pub(super) fn lonely(&self) -> f64 {
        let key = u64::from(self.index) << 32 ^ self.used as u64;
        (mix(self.pixel.seed ^ key) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The scramble of a coordinate; the odd factor keeps structured seeds from cancelling the coordinate.
fn scramble_of(seed: u32, d: u32) -> u32 {
    hash(seed.wrapping_mul(0x9C8F_2D3B) ^ hash(d))
}

/// One step of 32 bits.
const UNIT: f64 = 1.0 / (1u64 << 32) as f64;

/// Reversed bits as a fraction of 1.
#[inline]
fn unit(reversed: u32) -> f64 {
    f64::from(reversed.reverse_bits()) * UNIT
}

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

    /// 256 points fall once into each cell of every division into 256 equal boxes: a (0, 8, 2)-net in base 2.
    #[test]
    fn the_first_two_coordinates_are_stratified() {
        let table = SobolTable::new(256);
        for pixel in 0..20 {
            let stream = PixelStream::new(&table, 3, pixel, 0);
            let points: Vec<[f64; 2]> = (0..256).map(|i| stream.path(i).pair()).collect();
            for columns in [1, 2, 16, 64, 256] {
                let rows = 256 / columns;
                let mut counts = vec![0; 256];
                for [x, y] in &points {
                    counts[(x * columns as f64) as usize + columns * (y * rows as f64) as usize] += 1;
                }
                assert!(counts.iter().all(|&c| c == 1), "{columns} columns");
            }
        }
    }

    #[test]
    fn pixels_seeds_and_laps_differ_and_repeat() {
        let table = SobolTable::new(POINTS + 9);
        let first = |seed, pixel, index| PixelStream::new(&table, seed, pixel, lap(index).0).path(index).pair();
        assert_eq!(first(1, 2, 3), first(1, 2, 3));
        let all = [first(1, 2, 3), first(2, 2, 3), first(1, 3, 3), first(1, 2, 4), first(1, 2, 3 + POINTS)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b));
        }
    }

    #[test]
    fn long_paths_go_on_beyond_the_table_and_the_dimensions() {
        let table = SobolTable::new(64);
        let stream = PixelStream::new(&table, 0, 0, 0);
        // Neither neighbours nor a coordinate and its second lap may be correlated over the points.
        let mut numbers = vec![Vec::new(); 600];
        for index in 0..64 {
            let mut path = stream.path(index);
            for pair in numbers.chunks_mut(2) {
                let [a, b] = path.pair();
                pair[0].push(a);
                pair[1].push(b);
            }
            assert!((0.0..1.0).contains(&path.lonely()));
        }
        for (i, j) in [(14, 15), (15, 16), (0, 256), (3, 259), (255, 256), (40, 552)] {
            let product: f64 = numbers[i].iter().zip(&numbers[j]).map(|(a, b)| (a - 0.5) * (b - 0.5)).sum();
            assert!(numbers[i].iter().chain(&numbers[j]).all(|u| (0.0..1.0).contains(u)));
            // Standard error of a correlation of 64 points: 1 / 8.
            assert!((12.0 * product / 64.0).abs() < 4.0 / 8.0, "{i} and {j}: {product}");
        }
    }
}
