//! The deterministic facet sum: every facet is a beam.

use super::accumulator::{Accumulator, at_desks};
use super::bounce::Walk;
use super::detectors::Detectors;
use super::doubts::{Doubts, Run};
use super::facing::facing;
use super::lanes::{Ground, Lanes, Light};
use super::quick_sums::QuickSums;
use super::selection::{Footprint, Selection};
use crate::facets::blocks::SIDE;
use crate::facets::row_sight::{self, RUN, RowSight};
use crate::facets::slopes;
use crate::facets::visibility::quadrant;
use crate::math::direction;
use fearless_simd::Level;
use glam::DVec3;

/// Fractional part of the golden ratio: its multiples fill a circle as evenly as any number of points can.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Fractional part of the plastic number: chooses runs evenly and unrelated to their azimuth.
const PLASTIC: f64 = 0.754_877_666_246_692_7;

/// The azimuth of the source: one, or all of them averaged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Azimuth {
    /// `phi_i` \[rad\].
    Fixed(f64),
    /// Isotropic average: every run of facets and every ray has its own, all evenly spread; cells then lie in the frame of the
    /// source (`phi_i = 0`).
    Averaged,
}

impl Azimuth {
    /// Azimuth for an item at place `u` of a turn when averaging, and the turn into the frame of the cells.
    #[inline]
    pub fn of(self, u: f64) -> (f64, f64) {
        match self {
            Azimuth::Fixed(phi) => (phi, 0.0),
            Azimuth::Averaged => (std::f64::consts::TAU * u, std::f64::consts::TAU * u),
        }
    }
}

/// `v` turned by `-angle` about z.
#[inline]
pub fn turned_back(v: DVec3, angle: f64) -> DVec3 {
    if angle == 0.0 {
        return v;
    }
    let (s, c) = angle.sin_cos();
    DVec3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z)
}

/// `E_k = sum over facets of w V R(beta) [o in k] / sum w V`, with `w = max(0, 1 - tan(theta_i) (p cos phi_i + q sin phi_i))`
/// and V = 1 where the way from the facet's centroid to the source is free; a blocked exit goes on as a ray.
///
/// Runs of [`RUN`] cells of a row share one azimuth. What they weigh and reflect, and whether they see the source, is worked
/// out side by side in f32; beams that do not climb above all that could stand in their way are asked one by one in f64.
/// `selection` says which facets are lit. Deterministic: same map, same sums, for any number of threads or parts.
pub fn facet_sum<D: Detectors + ?Sized>(
    walk: &Walk,
    detectors: &D,
    theta_i: f64,
    azimuth: Azimuth,
    selection: &Selection,
) -> Accumulator {
    let sum = FacetSum { walk, detectors, theta_i, azimuth, share: selection.share, level: Level::new() };
    let lit = selection.lit(walk.field.cells());
    let bands = (lit.rows[0] / SIDE..lit.rows[1].div_ceil(SIDE)).filter(|&band| selection.part.has(band as u64));
    let bands: Vec<usize> = bands.collect();
    let new = || (Accumulator::new(detectors.len()), QuickSums::new(detectors), Doubts::new(walk, detectors));
    let desks = at_desks(&bands, new, |(slow, fast, doubts), &band| {
        sum.add_band(band, lit, slow, fast, doubts);
        doubts.answer(slow, fast);
    });
    let sums = desks.into_iter().map(|(slow, fast, _)| slow.merged(fast.sums()));
    sums.reduce(Accumulator::merged).unwrap_or_else(|| Accumulator::new(detectors.len()))
}

struct FacetSum<'a, D: Detectors + ?Sized> {
    walk: &'a Walk<'a>,
    detectors: &'a D,
    theta_i: f64,
    azimuth: Azimuth,
    share: f64,
    level: Level,
}

impl<D: Detectors + ?Sized> FacetSum<'_, D> {
    /// The facets of one row of blocks.
    fn add_band(
        &self,
        band: usize,
        lit: Footprint,
        slow: &mut Accumulator,
        fast: &mut QuickSums,
        doubts: &mut Doubts<D>,
    ) {
        let field = self.walk.field;
        let map = field.map();
        let runs = field.cells()[0].div_ceil(RUN);
        let clear = clear_sines(self.walk, band, runs * RUN);
        let (mut top, mut bottom) = (Vec::new(), Vec::new());
        let mut lanes = Lanes::default();
        let mut sights = None;
        let rows = (band * SIDE).max(lit.rows[0])..((band + 1) * SIDE).min(lit.rows[1]);
        let (passes, share) = self.passes();
        for (pass, row) in (0..passes).flat_map(|pass| rows.clone().map(move |row| (pass, row))) {
            for (line, row) in [(&mut top, row), (&mut bottom, row + 1)] {
                slopes::vertices(map, row, line);
                // What is not lit is as good as missing.
                line[..lit.columns[0]].fill(f32::NAN);
                line.truncate(lit.columns[1] + 1);
                line.resize(runs * RUN + 1, f32::NAN);
            }
            for run in lit.columns[0] / RUN..lit.columns[1].div_ceil(RUN) {
                let id = ((pass * field.cells()[1] + row) * runs + run) as f64;
                if (id * PLASTIC).fract() >= share {
                    continue;
                }
                let (phi, turn) = self.azimuth.of((id * GOLDEN).fract());
                let column = run * RUN;
                let local = direction(self.theta_i, phi - turn);
                let turned = [turn.cos() as f32, turn.sin() as f32];
                let run = Run { row, column, turn, wi: direction(self.theta_i, phi), local, turned };
                if turn != 0.0 {
                    sights = None;
                }
                let light = Light::new(run.wi, turn, [map.pitch_x, map.pitch_y]);
                let sides = [&top[column..], &bottom[column..]];
                for upper in [false, true] {
                    let seen = if self.source_is_clear(&run) {
                        [row_sight::YES; RUN]
                    } else {
                        let sights =
                            sights.get_or_insert_with(|| [false, true].map(|u| RowSight::new(field, run.wi, u)));
                        sights[usize::from(upper)].seen(self.level, field, [column, row], sides)
                    };
                    let ground = Ground {
                        top: sides[0],
                        bottom: sides[1],
                        clear: clear.each_ref().map(|line| &line[column..column + RUN]),
                        seen: &seen,
                    };
                    lanes.shine(self.level, &light, &ground, &self.walk.material, upper);
                    self.find_detectors(&run, &mut lanes);
                    doubts.take(&run, upper, &mut lanes, slow, fast);
                    fast.add(&lanes);
                }
            }
        }
    }

    /// How often the facets are gone through, and the share that is lit each time: every pass has azimuths of its own.
    fn passes(&self) -> (usize, f64) {
        let passes = if self.azimuth == Azimuth::Averaged { self.share.ceil().max(1.0) } else { 1.0 };
        (passes as usize, self.share / passes)
    }

    /// Whether no block of the run can be hidden from the source.
    fn source_is_clear(&self, run: &Run) -> bool {
        let field = self.walk.field;
        let from = quadrant(run.wi);
        (run.column..(run.column + RUN).min(field.cells()[0]))
            .step_by(SIDE)
            .all(|column| run.wi.z > f64::from(field.clear_sines([column, run.row])[from]))
    }

    /// The detector of each facet's own reflection.
    fn find_detectors(&self, run: &Run, lanes: &mut Lanes) {
        if let Some(cells) = self.detectors.slope_cells() {
            lanes.locate(self.level, cells);
            return;
        }
        let wi = run.local;
        for k in 0..RUN {
            if lanes.weight[k] > 0 {
                let beam = facing(f64::from(lanes.p[k]), f64::from(lanes.q[k]), wi);
                lanes.slot[k] = beam.map_or(0, |beam| self.detectors.index(wi, beam.wo)) as u32;
            }
        }
    }
}

/// Sines of the elevation above which beams escape from the cells of one row of blocks, per quadrant.
fn clear_sines(walk: &Walk, band: usize, columns: usize) -> [Vec<f32>; 4] {
    [0, 1, 2, 3].map(|quadrant| {
        let mut line = vec![2.0; columns];
        for column in (0..walk.field.cells()[0]).step_by(SIDE) {
            line[column..column + SIDE].fill(walk.field.clear_sines([column, band * SIDE])[quadrant]);
        }
        line
    })
}
