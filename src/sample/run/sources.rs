//! What a run knows of its incident directions.

use super::super::grid::piece as piece_f64;
use super::super::sources::{COSINES, Sources};
use super::super::table_brdf::{HORIZON, TableBrdf};
use super::azimuths::Azimuths;
use super::{Lanes, piece};
use crate::scatter::axis::{at_least, at_most};
use crate::table::{BALANCE_STEPS, BUCKETS, Nodes, Table};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use glam::{DVec3, Vec4};

/// [`Sources`] for lanes, most of it in f32.
#[derive(Debug, Clone)]
pub(in super::super) struct SourceTables {
    /// Tangent of the second node of every interval, infinite for the last; of its first node, and one over the gap.
    ends: Vec<f64>,
    gaps: Vec<[f64; 2]>,
    pub(super) masking: Box<[[f32; 2]; 2 * COSINES]>,
    balance: Vec<[f32; 2]>,
    azimuths: Azimuths,
}

impl SourceTables {
    pub fn new(table: &Table, sources: &Sources) -> SourceTables {
        let narrow = |x: &[f64; 2]| x.map(|x| x as f32);
        SourceTables {
            ends: table.finder.gaps.iter().map(|gap| gap.end2.sqrt()).collect(),
            gaps: table.finder.gaps.iter().map(|gap| [gap.tangents[0], gap.per_gap]).collect(),
            masking: Box::new(std::array::from_fn(|k| narrow(&sources.masking[k]))),
            balance: sources.balance.iter().map(narrow).collect(),
            azimuths: Azimuths::new(table),
        }
    }
}

/// The incident directions of a run.
pub(super) struct SourceLanes<const N: usize> {
    pub z: Lanes<f64, N>,
    /// The horizontal part in the frame of the cells.
    pub x: Lanes<f64, N>,
    pub y: Lanes<f64, N>,
    /// Cosine and sine of the turn into that frame: of phi_i if isotropic.
    pub cos: Lanes<f64, N>,
    pub sin: Lanes<f64, N>,
    /// Interval of theta_i and the share of its second node, to choose by and to interpolate with.
    pub theta: Lanes<u32, N>,
    pub second: Lanes<f64, N>,
    pub upper: Lanes<f32, N>,
    /// The two azimuths around phi_i and the share of the second, likewise; 0 of an isotropic table.
    pub phi: [Lanes<u32, N>; 2],
    pub second_azimuth: Lanes<f64, N>,
    pub turned: Lanes<f32, N>,
    pub balance: Lanes<f32, N>,
    pub masked: Lanes<f32, N>,
    tangent: Lanes<f64, N>,
}

impl<const N: usize> Default for SourceLanes<N> {
    #[inline(always)]
    fn default() -> Self {
        let (wide, narrow) = ([0.0; N], [0.0; N]);
        SourceLanes {
            z: wide,
            x: wide,
            y: wide,
            cos: wide,
            sin: wide,
            theta: [0; N],
            second: wide,
            upper: narrow,
            phi: [[0; N]; 2],
            second_azimuth: wide,
            turned: narrow,
            balance: narrow,
            masked: narrow,
            tangent: wide,
        }
    }
}

impl<const N: usize> SourceLanes<N> {
    /// Finds `wi`; those below the horizon are taken as on it.
    #[simd]
    pub fn find<S: Simd>(&mut self, simd: S, brdf: &TableBrdf, wi: &Lanes<DVec3, N>) {
        let (sources, tables) = (&brdf.sources, &brdf.source_tables);
        self.polar(simd, &brdf.table.finder, tables, wi);
        if brdf.table.is_isotropic() {
            self.balance(simd, sources, tables);
        } else {
            self.around(simd, &tables.azimuths, wi);
            self.balance_around(simd, sources, &tables.azimuths, wi);
        }
    }

    /// Intervals of theta_i and what is hidden, in the frame of the source.
    #[simd]
    fn polar<S: Simd>(&mut self, _: S, nodes: &Nodes, tables: &SourceTables, wi: &Lanes<DVec3, N>) {
        let s = self;
        let narrow = [0.0f32; N];
        let mut bucket = [0u32; N];
        for j in 0..N {
            // Too little to matter, but for light from above.
            let (x, y, z) = (wi[j].x + 1e-150, wi[j].y, at_least(wi[j].z, HORIZON));
            let r2 = x * x + y * y;
            s.z[j] = z;
            s.x[j] = r2.sqrt();
            let inverse = 1.0 / (s.x[j] * z);
            s.cos[j] = x * (inverse * z);
            s.sin[j] = y * (inverse * z);
            s.tangent[j] = r2 * inverse;
            bucket[j] = piece_f64(z * BUCKETS as f64 + 0.5).0 as u32;
        }
        let mut gap = [[0.0f64; 2]; N];
        for j in 0..N {
            let mut theta = usize::from(nodes.first[bucket[j] as usize & (2 * BUCKETS - 1)]);
            while s.tangent[j] >= tables.ends[theta] {
                theta += 1;
            }
            s.theta[j] = theta as u32;
            gap[j] = tables.gaps[theta];
        }
        let (mut cosine, mut above) = ([0u32; N], narrow);
        for j in 0..N {
            let u = (s.tangent[j] - gap[j][0]) * gap[j][1];
            s.second[j] = at_most(at_least(u, 0.0), 1.0);
            s.upper[j] = s.second[j] as f32;
            let z = s.z[j] as f32;
            (cosine[j], above[j]) = piece(z * COSINES as f32 + 0.5);
        }
        let mut masked = [[0.0f32; 2]; N];
        for j in 0..N {
            masked[j] = tables.masking[cosine[j] as usize & (2 * COSINES - 1)];
        }
        for j in 0..N {
            s.masked[j] = masked[j][0] + above[j] * masked[j][1];
        }
    }

    /// `b` of an isotropic table.
    #[simd]
    fn balance<S: Simd>(&mut self, _: S, sources: &Sources, tables: &SourceTables) {
        let s = self;
        let (mut step, mut along) = ([0u32; N], [0.0f32; N]);
        for j in 0..N {
            let within = piece(BALANCE_STEPS as f32 * s.upper[j] + 0.5);
            step[j] = BALANCE_STEPS as u32 * s.theta[j] + within.0;
            along[j] = within.1;
        }
        let mut balance = [[0.0f32; 2]; N];
        for j in 0..N {
            // Beyond the last node it ends at zero: few draws, and none for f32.
            balance[j] = if s.tangent[j] > sources.last.tangent {
                [sources.balance_beyond(s.z[j]) as f32, 0.0]
            } else {
                tables.balance[step[j] as usize]
            };
        }
        for j in 0..N {
            s.balance[j] = balance[j][0] + along[j] * balance[j][1];
        }
    }

    /// Into the frame of the map, and between which azimuths.
    #[simd]
    fn around<S: Simd>(&mut self, _: S, azimuths: &Azimuths, wi: &Lanes<DVec3, N>) {
        let s = self;
        for j in 0..N {
            (s.x[j], s.y[j]) = (wi[j].x, wi[j].y);
            (s.cos[j], s.sin[j]) = (1.0, 0.0);
        }
        if azimuths.turns.len() > 1 {
            let (mut turn, mut passed) = ([0.0f64; N], [0.0f64; N]);
            for j in 0..N {
                turn[j] = crate::table::turn(wi[j].x, wi[j].y);
            }
            for &node in &azimuths.turns {
                for j in 0..N {
                    passed[j] += if node <= turn[j] { 1.0 } else { 0.0 };
                }
            }
            let last = azimuths.gaps.len() - 1;
            for j in 0..N {
                let gap = &azimuths.gaps[(passed[j] as usize).min(last)];
                (s.phi[0][j], s.phi[1][j]) = (gap.nodes[0], gap.nodes[1]);
                let beyond = turn[j] - gap.from;
                s.second_azimuth[j] = (if beyond < 0.0 { beyond + 4.0 } else { beyond }) * gap.per_gap;
                s.turned[j] = s.second_azimuth[j] as f32;
            }
        }
    }

    /// `b` of a table with a grain.
    #[simd]
    fn balance_around<S: Simd>(&mut self, _: S, sources: &Sources, azimuths: &Azimuths, wi: &Lanes<DVec3, N>) {
        let s = self;
        let last = &sources.last;
        // In f64: towards the horizon it ends at zero.
        let (mut row, mut along, mut around) = ([0u32; N], [0.0f64; N], [0.0f32; N]);
        let per_turn = azimuths.steps as f64 / 4.0;
        for j in 0..N {
            let beyond = at_most(at_least(1.0 - s.z[j] * last.per_cosine, 0.0), 1.0);
            let outside = last.before + beyond * last.behind;
            let inside = (f64::from(s.theta[j] as i32) + s.second[j]) * BALANCE_STEPS as f64;
            let x = if s.tangent[j] > last.tangent { outside } else { inside };
            let end = last.before + last.behind;
            let (step, x) = piece_f64(at_most(at_least(x, 1e-9), end - 1e-9) + 0.5);
            let turn = crate::table::turn(wi[j].x, wi[j].y) * per_turn;
            let (azimuth, y) = piece_f64(at_least(turn, 1e-9) + 0.5);
            row[j] = (step as u32 - 1) * azimuths.steps as u32 + (azimuth as u32 - 1);
            (along[j], around[j]) = (x + 0.5, y as f32 + 0.5);
        }
        for j in 0..N {
            let at = row[j] as usize;
            let (low, high) = (azimuths.balance[at], azimuths.balance[at + azimuths.steps]);
            let [low, high] = [low, high].map(|[value, rise]| f64::from(value + around[j] * rise));
            s.balance[j] = (low + along[j] * (high - low)) as f32;
        }
    }

    /// What the nodes around every source say about core and floor, blended: the numbers of [`TableBrdf::facts`].
    #[simd]
    pub fn blend<S: Simd>(&self, _: S, brdf: &TableBrdf, blended: &mut Lanes<Vec4, N>) {
        let s = self;
        let phis = brdf.table.phi_i().len();
        let next = if brdf.table.theta_i().len() > 1 { phis } else { 0 };
        let azimuths = if phis > 1 { 2 } else { 1 };
        for around in 0..azimuths {
            for j in 0..N {
                let at = s.theta[j] as usize * phis + s.phi[around][j] as usize;
                let (a, b) = (brdf.facts[at], brdf.facts[at + next]);
                let here = a + s.upper[j] * (b - a);
                let share = if around == 0 { 1.0 } else { s.turned[j] };
                blended[j] += share * (here - blended[j]);
            }
        }
    }
}
