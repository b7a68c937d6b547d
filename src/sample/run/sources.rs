//! What a run knows of its incident directions.

use super::super::grid::piece as piece_f64;
use super::super::sources::{BUCKETS, COSINES, Sources};
use super::super::table_brdf::HORIZON;
use super::{Lanes, RUN, piece};
use crate::scatter::axis::at_least;
use crate::table::BALANCE_STEPS;
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use glam::DVec3;

/// [`Sources`] in f32, for lanes.
#[derive(Debug, Clone)]
pub(in super::super) struct SourceTables {
    /// Tangent of the second node of every interval, infinite for the last; of its first node, and one over the gap.
    ends: Vec<f32>,
    gaps: Vec<[f32; 2]>,
    pub(super) masking: Box<[[f32; 2]; 2 * COSINES]>,
    balance: Vec<[f32; 2]>,
}

impl SourceTables {
    pub fn new(sources: &Sources) -> SourceTables {
        let narrow = |x: &[f64; 2]| x.map(|x| x as f32);
        SourceTables {
            ends: sources.gaps.iter().map(|gap| gap.end2.sqrt() as f32).collect(),
            gaps: sources.gaps.iter().map(|gap| [gap.from as f32, gap.per_gap as f32]).collect(),
            masking: Box::new(std::array::from_fn(|k| narrow(&sources.masking[k]))),
            balance: sources.balance.iter().map(narrow).collect(),
        }
    }
}

/// The incident directions of a run.
pub(super) struct SourceLanes {
    pub z: Lanes<f64>,
    pub sine: Lanes<f64>,
    /// Of phi_i.
    pub cos: Lanes<f64>,
    pub sin: Lanes<f64>,
    /// Interval of theta_i and the share of its second node.
    pub theta: Lanes<u32>,
    pub upper: Lanes<f32>,
    pub balance: Lanes<f32>,
    pub masked: Lanes<f32>,
}

impl Default for SourceLanes {
    #[inline(always)]
    fn default() -> Self {
        let (wide, narrow) = ([0.0; RUN], [0.0; RUN]);
        SourceLanes {
            z: wide,
            sine: wide,
            cos: wide,
            sin: wide,
            theta: [0; RUN],
            upper: narrow,
            balance: narrow,
            masked: narrow,
        }
    }
}

impl SourceLanes {
    /// Finds `wi`; those below the horizon are taken as on it.
    #[simd]
    pub fn find<S: Simd>(&mut self, _: S, sources: &Sources, tables: &SourceTables, wi: &Lanes<DVec3>) {
        let s = self;
        let narrow = [0.0f32; RUN];
        let (mut tangent, mut bucket) = (narrow, [0u32; RUN]);
        for j in 0..RUN {
            // Too little to matter, but for light from above.
            let (x, y, z) = (wi[j].x + 1e-150, wi[j].y, at_least(wi[j].z, HORIZON));
            let r2 = x * x + y * y;
            s.z[j] = z;
            s.sine[j] = r2.sqrt();
            let inverse = 1.0 / (s.sine[j] * z);
            s.cos[j] = x * (inverse * z);
            s.sin[j] = y * (inverse * z);
            tangent[j] = (r2 * inverse) as f32;
            bucket[j] = piece_f64(z * BUCKETS as f64 + 0.5).0 as u32;
        }
        let mut gap = [[0.0f32; 2]; RUN];
        for j in 0..RUN {
            let mut theta = usize::from(sources.first[bucket[j] as usize & (2 * BUCKETS - 1)]);
            while tangent[j] >= tables.ends[theta] {
                theta += 1;
            }
            s.theta[j] = theta as u32;
            gap[j] = tables.gaps[theta];
        }
        let (mut step, mut along) = ([0u32; RUN], narrow);
        let (mut cosine, mut above) = ([0u32; RUN], narrow);
        for j in 0..RUN {
            let u = (tangent[j] - gap[j][0]) * gap[j][1];
            let u = if u > 0.0 { u } else { 0.0 };
            s.upper[j] = if u < 1.0 { u } else { 1.0 };
            let within = piece(BALANCE_STEPS as f32 * s.upper[j] + 0.5);
            step[j] = BALANCE_STEPS as u32 * s.theta[j] + within.0;
            along[j] = within.1;
            let z = s.z[j] as f32;
            (cosine[j], above[j]) = piece(z * COSINES as f32 + 0.5);
        }
        let (mut balance, mut masked) = ([[0.0f32; 2]; RUN], [[0.0f32; 2]; RUN]);
        for j in 0..RUN {
            // Beyond the last node it ends at zero: few draws, and none for f32.
            balance[j] = if f64::from(tangent[j]) > sources.last.tangent {
                [sources.balance_beyond(s.z[j]) as f32, 0.0]
            } else {
                tables.balance[step[j] as usize]
            };
            masked[j] = tables.masking[cosine[j] as usize & (2 * COSINES - 1)];
        }
        for j in 0..RUN {
            s.balance[j] = balance[j][0] + along[j] * balance[j][1];
            s.masked[j] = masked[j][0] + above[j] * masked[j][1];
        }
    }
}
